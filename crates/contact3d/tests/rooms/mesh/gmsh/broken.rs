//! Files with one flaw each, and the message that must name it.

use contact3d::mesh::parse_gmsh as parse;

use super::{FOOT_41_BINARY, PAIR_22, PAIR_41};

/// Replacements of text, and what the message about the result must say.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a [&'a str]);

/// Why a file is refused, and what to do about it.
fn words(bytes: &[u8]) -> String {
    let flaw = parse(bytes).expect_err("a broken file");
    format!("{flaw}; {}", flaw.help)
}

fn assert_refused(sample: &str, cases: &[Case]) {
    for (changes, expected) in cases {
        let mut text = sample.to_owned();
        for (old, new) in *changes {
            assert!(text.contains(old), "{old:?} is not in the sample");
            text = text.replace(old, new);
        }
        let found = words(text.as_bytes());
        for expected in *expected {
            assert!(found.contains(expected), "{changes:?}: {found}");
        }
    }
}

#[test]
fn broken_headers_are_refused() {
    assert_refused(
        PAIR_22,
        &[
            (
                &[("$MeshFormat\n2.2 0 8", "$NOD\n4")],
                &["line 1: ", "damaged or not an MSH file"],
            ),
            (
                &[("2.2 0 8", "2.2 0")],
                &["line 2: ", "damaged or not an MSH file"],
            ),
            (
                &[("2.2 0 8", "4.0 0 8")],
                &["line 2: ", "expected MSH format 4.1 or 2.2"],
            ),
            (
                &[("2.2 0 8", "nan 0 8")],
                &["expected MSH format 4.1 or 2.2"],
            ),
            (
                &[("2.2 0 8", "2.2 1 4")],
                &["expected text or little-endian binary"],
            ),
            (
                &[("2.2 0 8", "4.1 1 4")],
                &["expected text or little-endian binary"],
            ),
            (
                &[("2.2 0 8", "2.2 2 8")],
                &["expected text or little-endian binary"],
            ),
            (
                &[("2 1 \"bottom\"", "2 1 bottom")],
                &["line 6: ", "damaged or not an MSH file"],
            ),
            (
                &[("2 1 \"bottom\"", "2 1 \"\"")],
                &["line 6: ", "damaged or not an MSH file"],
            ),
            (
                &[("$PhysicalNames\n3", "$PhysicalNames\n2")],
                &["line 8: ", "damaged or not an MSH file"],
            ),
            (
                &[("$PhysicalNames\n3", "$PhysicalNames\n4")],
                &["line 9: ", "damaged or not an MSH file"],
            ),
            (
                &[("$EndNodes\n", "")],
                &["line 18: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes", "$nodes"), ("$EndNodes", "$Endnodes")],
                &["expected a section $Nodes, found none"],
            ),
            (
                &[
                    ("$Nodes", "$ParametricNodes"),
                    ("$EndNodes", "$EndParametricNodes"),
                ],
                &[
                    "expected a section $Nodes, found none",
                    "Mesh.SaveParametric 0",
                ],
            ),
            // As Mesh.SaveAll = 1 writes them.
            (
                &[
                    ("2 1 1 1 30 50", "2 0 1 1 30 50"),
                    ("2 2 1 1 4 30", "2 0 1 1 4 30"),
                    ("2 7 1 1", "2 0 1 1"),
                ],
                &[
                    "elements in the physical group \"bottom\", found none in any group",
                    "Mesh.SaveAll = 1",
                ],
            ),
            (&[("$Elements", "$Other")], &["damaged or not an MSH file"]),
            (
                &[("$EndElements", "$EndElements\n$Nodes\n0\n$EndNodes")],
                &["expected one section $Nodes, found a second one"],
            ),
            (
                &[("2 2 \"side\"", "2 2 \"bottom\"")],
                &["different names of the physical surfaces"],
            ),
            (
                &[("2 2 \"side\"", "2 2 \"unnamed\"")],
                &["different names of the physical surfaces"],
            ),
        ],
    );
    assert!(words(b"").contains("damaged or not an MSH file"));
}

#[test]
fn broken_nodes_are_refused() {
    assert_refused(
        PAIR_22,
        &[
            (
                &[("$Nodes\n6", "$Nodes\n5")],
                &["line 17: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes\n6", "$Nodes\n7")],
                &["line 18: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes\n6", "$Nodes\nsix")],
                &["line 11: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes\n6", "$Nodes\n-6")],
                &["line 11: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes\n6", "$Nodes\n99999999999999999999")],
                &["line 11: ", "damaged or not an MSH file"],
            ),
            (
                &[("$Nodes\n6", "$Nodes\n9999999999999999999")],
                &["line 11: ", "its counts are wrong"],
            ),
            (
                &[("20 1 0 0", "20 1 0")],
                &["line 14: ", "damaged or not an MSH file"],
            ),
            (
                &[("20 1 0 0", "20 1 0 0 0")],
                &["line 14: ", "damaged or not an MSH file"],
            ),
            (
                &[("20 1 0 0", "20 1 0 x")],
                &["line 14: ", "damaged or not an MSH file"],
            ),
            (
                &[("20 1 0 0", "20 1 0 inf")],
                &["line 14: ", "node 20: expected finite coordinates"],
            ),
            (
                &[("20 1 0 0", "20 1e999 0 0")],
                &["expected finite coordinates"],
            ),
            (
                &[("99 7 7 7", "4 7 7 7")],
                &["line 17: ", "expected every node once, found node 4 again"],
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("2 6 1 99", "2 5 1 99")],
                &[
                    "expected 5 nodes in all blocks, ",
                    "damaged or not an MSH file",
                ],
            ),
            (&[("2 6 1 99", "1 6 1 99")], &["damaged or not an MSH file"]),
            (&[("2 6 1 99", "3 6 1 99")], &["damaged or not an MSH file"]),
            (&[("2 2 1 3", "2 2 0 3")], &["damaged or not an MSH file"]),
            (
                &[("2 2 1 3", "2 2 1 300")],
                &[
                    " nodes of the block in the rest of the file",
                    "its counts are wrong",
                ],
            ),
            (
                &[("2 6 1 99", "18446744073709551615 6 1 99")],
                &["damaged or not an MSH file"],
            ),
        ],
    );
}

#[test]
fn broken_elements_are_refused() {
    assert_refused(
        PAIR_22,
        &[
            (
                &[("$Elements\n5", "$Elements\n6000")],
                &[" elements in the rest of the file", "its counts are wrong"],
            ),
            (
                &[("1 30 20 50", "1 30 20")],
                &["line 25: ", "damaged or not an MSH file"],
            ),
            (
                &[("1 30 20 50", "1 30 20 51")],
                &["element 5: expected nodes of $Nodes, found node 51"],
            ),
            (
                &[("1 1 30 50", "1 1 30 51")],
                &["element 2: expected nodes of $Nodes, found node 51"],
            ),
            (
                &[("1 30 20 50", "1 30 20 30")],
                &["element 5: expected different nodes, found node 30 twice"],
            ),
            (
                &[("2 2 2 1 1 1 30 50", "2 3 2 1 1 1 30 50 4")],
                &["expected linear or quadratic tetrahedra and triangles, found quadrangles"],
            ),
            (
                &[("5 4 2 7", "5 5 2 7")],
                &[
                    "line 25: ",
                    "expected linear or quadratic tetrahedra and triangles, found ",
                    "(element type 5)",
                ],
            ),
            (
                &[("5 4 2 7", "5 5 2 7")],
                &["expected linear or quadratic tetrahedra and triangles, found hexahedra"],
            ),
            (
                &[("5 4 2 7", "5 -4 2 7")],
                &["expected linear or quadratic tetrahedra and triangles, found "],
            ),
            (
                &[("5 4 2 7", "5 4 99999999999 7")],
                &["line 25: ", "damaged or not an MSH file"],
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("3 1 4 2", "3 2 4 2")],
                &["line 42: ", "found entity 2 of dimension 3"],
            ),
            (
                &[("3 1 4 2", "3 1 5 2")],
                &[
                    "line 42: ",
                    "expected linear or quadratic tetrahedra and triangles, found ",
                    "(element type 5)",
                ],
            ),
            (
                &[("4 5 1 5", "4 6 1 5")],
                &[
                    "expected 6 elements in all blocks, ",
                    "damaged or not an MSH file",
                ],
            ),
            (
                &[("1 7 2 1 -2", "1 7 200000 1 -2")],
                &[
                    " bounding entities in the rest of the file",
                    "its counts are wrong",
                ],
            ),
        ],
    );
}

#[test]
fn broken_binary_is_refused() {
    let mut big_endian = FOOT_41_BINARY.to_vec();
    let mark = b"$MeshFormat\n4.1 1 8\n".len();
    big_endian[mark..mark + 4].reverse();
    assert!(words(&big_endian).contains("found big-endian binary"));
    let of_2_2 = [b"$MeshFormat\n2.2", &FOOT_41_BINARY[15..]].concat();
    assert!(words(&of_2_2).contains("found binary of MSH 2.2"));
    // Half of the file ends among the elements.
    let refused = words(&FOOT_41_BINARY[..FOOT_41_BINARY.len() / 2]);
    let ended = ["its counts are wrong", "damaged or not an MSH file"]
        .iter()
        .any(|end| refused.contains(end));
    assert!(refused.starts_with("byte ") && ended, "{refused}");
}

#[test]
fn tetrahedra_that_make_no_body_are_refused() {
    const LAST: &str = "5 4 2 7 1 1 30 20 50";
    const SPARE: &str = "99 7 7 7";
    assert_refused(
        PAIR_22,
        &[
            (
                &[("4 4 2 7 1 1 20 30 4", "4 15 0 1"), (LAST, "5 15 0 1")],
                &["expected tetrahedra, found none"],
            ),
            (
                &[("50 0 0 -1", "50 .3 .3 1e-17")],
                &["line 25: ", "tetrahedron 5: expected a volume"],
            ),
            (
                &[("50 0 0 -1", "50 1e300 1e300 -1e300")],
                &["tetrahedron 5: expected a volume"],
            ),
            (
                &[("1 30 20 50", "1 20 30 50")],
                &[
                    "tetrahedron 5: expected the orientation of the others",
                    "(1 of 2 are)",
                ],
            ),
            (
                &[("50 0 0 -1", "50 0 0 2")],
                &["tetrahedron 5: expected the orientation of the others"],
            ),
            (
                &[("1 30 20 50", "1 20 30 4")],
                &["tetrahedron 5: expected its own nodes, found those of tetrahedron 4"],
            ),
            (
                &[("1 30 20 50", "1 20 30 99"), (SPARE, "99 .1 .1 2")],
                &[
                    "tetrahedron 5: expected no overlap, found tetrahedron 4 on the same side of triangle [1, 20, 30]",
                ],
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 1 0 1e-9")],
                &["nodes 20 and 99: expected different places"],
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 .3 .3 0")],
                &["node 99: expected a conforming mesh", "of tetrahedron 4"],
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 .5 .5 0")],
                &["node 99: expected a conforming mesh", "of tetrahedron 4"],
            ),
            (
                &[("1 30 20 50", "1 99 30 50"), (SPARE, "99 -1 0 0")],
                &[
                    "found 2 pieces not joined by whole triangles: tetrahedron 4 is in the largest, tetrahedron 5 in the smallest (1 of 2 tetrahedra)",
                ],
            ),
        ],
    );
}

#[test]
fn groups_that_contradict_are_refused() {
    assert_refused(
        PAIR_22,
        &[
            (
                &[("5 4 2 7 1 1 30 20 50", "5 4 2 8 1 1 20 30 4")],
                &["tetrahedron 5: expected one physical volume, found \"body\" and \"8\""],
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 30 50")],
                &["triangle 3: expected one physical surface, found \"bottom\" and \"side\""],
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 20 30")],
                &[
                    "physical surface \"side\": expected triangles on the boundary",
                    "none among its 1 (triangle 3 is the first)",
                ],
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 4 99")],
                &["expected triangles on the boundary of the body"],
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("1 1 1 -2 0", "1 1 2 1 2 0")],
                &["triangle 3: expected one physical surface, found \"bottom\" and \"side\""],
            ),
            (
                &[("1 1 1 7 2 1 -2", "1 1 2 7 8 2 1 -2")],
                &["tetrahedron 4: expected one physical volume, found \"body\" and \"8\""],
            ),
        ],
    );
}
