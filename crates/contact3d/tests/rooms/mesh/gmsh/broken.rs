//! Files with one flaw each, and the error that must name it.

use contact3d::mesh::{
    FilePosition::{Byte, Line},
    GmshError::{self, *},
    parse_gmsh as parse,
};

use super::{FOOT_22_BINARY, FOOT_41_BINARY, PAIR_22, PAIR_41};

type IsExpected = fn(&GmshError) -> bool;

/// Replacements of text and the error they must lead to.
type Case<'a> = (&'a [(&'a str, &'a str)], IsExpected);

macro_rules! is {
    ($pattern:pat $(if $guard:expr)?) => {
        |error| matches!(error, $pattern $(if $guard)?)
    };
}

fn assert_refused(sample: &str, cases: &[Case]) {
    for (changes, is_expected) in cases {
        let mut text = sample.to_owned();
        for (old, new) in *changes {
            assert!(text.contains(old), "{old:?} is not in the sample");
            text = text.replace(old, new);
        }
        match parse(text.as_bytes()) {
            Ok(_) => panic!("{changes:?}: accepted"),
            Err(error) => assert!(is_expected(&error), "{changes:?}: {error:?}"),
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
                is!(Syntax { place: Line(1), .. }),
            ),
            (&[("2.2 0 8", "2.2 0")], is!(Syntax { place: Line(2), .. })),
            (
                &[("2.2 0 8", "4.0 0 8")],
                is!(Version { place: Line(2), .. }),
            ),
            (&[("2.2 0 8", "nan 0 8")], is!(Version { .. })),
            (&[("2.2 0 8", "2.2 1 4")], is!(Encoding { .. })),
            (&[("2.2 0 8", "4.1 1 4")], is!(Encoding { .. })),
            (&[("2.2 0 8", "2.2 2 8")], is!(Encoding { .. })),
            (
                &[("2 1 \"bottom\"", "2 1 bottom")],
                is!(Syntax { place: Line(6), .. }),
            ),
            (
                &[("2 1 \"bottom\"", "2 1 \"\"")],
                is!(Syntax { place: Line(6), .. }),
            ),
            (
                &[("$PhysicalNames\n3", "$PhysicalNames\n2")],
                is!(Syntax { place: Line(8), .. }),
            ),
            (
                &[("$PhysicalNames\n3", "$PhysicalNames\n4")],
                is!(Syntax { place: Line(9), .. }),
            ),
            (
                &[("$EndNodes\n", "")],
                is!(Syntax {
                    place: Line(18),
                    ..
                }),
            ),
            (
                &[("$Nodes", "$nodes"), ("$EndNodes", "$Endnodes")],
                is!(MissingSection { section: "Nodes" }),
            ),
            (&[("$Elements", "$Other")], is!(Syntax { .. })),
            (
                &[("$EndElements", "$EndElements\n$Nodes\n0\n$EndNodes")],
                is!(RepeatedSection {
                    section: "Nodes",
                    ..
                }),
            ),
            (
                &[("2 2 \"side\"", "2 2 \"bottom\"")],
                is!(RepeatedName {
                    kind: "surfaces",
                    ..
                }),
            ),
            (
                &[("2 2 \"side\"", "2 2 \"unnamed\"")],
                is!(RepeatedName { .. }),
            ),
        ],
    );
    assert!(matches!(parse(b""), Err(Syntax { .. })));
}

#[test]
fn broken_nodes_are_refused() {
    assert_refused(
        PAIR_22,
        &[
            (
                &[("$Nodes\n6", "$Nodes\n5")],
                is!(Syntax {
                    place: Line(17),
                    ..
                }),
            ),
            (
                &[("$Nodes\n6", "$Nodes\n7")],
                is!(Syntax {
                    place: Line(18),
                    ..
                }),
            ),
            (
                &[("$Nodes\n6", "$Nodes\nsix")],
                is!(Syntax {
                    place: Line(11),
                    ..
                }),
            ),
            (
                &[("$Nodes\n6", "$Nodes\n-6")],
                is!(Syntax {
                    place: Line(11),
                    ..
                }),
            ),
            (
                &[("$Nodes\n6", "$Nodes\n99999999999999999999")],
                is!(Syntax {
                    place: Line(11),
                    ..
                }),
            ),
            (
                &[("$Nodes\n6", "$Nodes\n9999999999999999999")],
                is!(Count {
                    place: Line(11),
                    ..
                }),
            ),
            (
                &[("20 1 0 0", "20 1 0")],
                is!(Syntax {
                    place: Line(14),
                    ..
                }),
            ),
            (
                &[("20 1 0 0", "20 1 0 0 0")],
                is!(Syntax {
                    place: Line(14),
                    ..
                }),
            ),
            (
                &[("20 1 0 0", "20 1 0 x")],
                is!(Syntax {
                    place: Line(14),
                    ..
                }),
            ),
            (
                &[("20 1 0 0", "20 1 0 inf")],
                is!(NotFinite {
                    place: Line(14),
                    node: 20,
                    ..
                }),
            ),
            (&[("20 1 0 0", "20 1e999 0 0")], is!(NotFinite { .. })),
            (
                &[("99 7 7 7", "4 7 7 7")],
                is!(RepeatedTag {
                    place: Line(17),
                    node: 4
                }),
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("2 6 1 99", "2 5 1 99")],
                is!(Syntax { expected, .. } if expected == "5 nodes in all blocks"),
            ),
            (&[("2 6 1 99", "1 6 1 99")], is!(Syntax { .. })),
            (&[("2 6 1 99", "3 6 1 99")], is!(Syntax { .. })),
            (&[("2 2 1 3", "2 2 0 3")], is!(Syntax { .. })),
            (
                &[("2 2 1 3", "2 2 1 300")],
                is!(Count {
                    what: "nodes of the block",
                    ..
                }),
            ),
            (
                &[("2 6 1 99", "18446744073709551615 6 1 99")],
                is!(Syntax { .. }),
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
                is!(Count {
                    what: "elements",
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 20")],
                is!(Syntax {
                    place: Line(25),
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 20 51")],
                is!(UnknownNode {
                    element: 5,
                    node: 51,
                    ..
                }),
            ),
            (
                &[("1 1 30 50", "1 1 30 51")],
                is!(UnknownNode {
                    element: 2,
                    node: 51,
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 20 30")],
                is!(RepeatedNode {
                    element: 5,
                    node: 30,
                    ..
                }),
            ),
            (
                &[("2 2 2 1 1 1 30 50", "2 3 2 1 1 1 30 50 4")],
                is!(ElementType {
                    name: "quadrangles",
                    ..
                }),
            ),
            (
                &[("5 4 2 7", "5 5 2 7")],
                is!(ElementType {
                    place: Line(25),
                    code: 5,
                    ..
                }),
            ),
            (
                &[("5 4 2 7", "5 5 2 7")],
                is!(ElementType {
                    name: "hexahedra",
                    ..
                }),
            ),
            (&[("5 4 2 7", "5 -4 2 7")], is!(ElementType { .. })),
            (
                &[("5 4 2 7", "5 4 99999999999 7")],
                is!(Syntax {
                    place: Line(25),
                    ..
                }),
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("3 1 4 2", "3 2 4 2")],
                is!(UnknownEntity {
                    place: Line(42),
                    dimension: 3,
                    entity: 2
                }),
            ),
            (
                &[("3 1 4 2", "3 1 5 2")],
                is!(ElementType {
                    place: Line(42),
                    code: 5,
                    ..
                }),
            ),
            (
                &[("4 5 1 5", "4 6 1 5")],
                is!(Syntax { expected, .. } if expected == "6 elements in all blocks"),
            ),
            (
                &[("1 7 2 1 -2", "1 7 200000 1 -2")],
                is!(Count {
                    what: "bounding entities",
                    ..
                }),
            ),
        ],
    );
}

#[test]
fn broken_binary_is_refused() {
    for sample in [FOOT_41_BINARY, FOOT_22_BINARY] {
        let mut big_endian = sample.to_vec();
        let mark = b"$MeshFormat\n4.1 1 8\n".len();
        big_endian[mark..mark + 4].reverse();
        assert!(matches!(parse(&big_endian), Err(Encoding { .. })));
        // Half of the file ends among the elements.
        let refused = parse(&sample[..sample.len() / 2]).unwrap_err();
        let ended = matches!(
            refused,
            Count { place: Byte(_), .. } | Syntax { place: Byte(_), .. }
        );
        assert!(ended, "{refused}");
    }
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
                is!(NoTetrahedra),
            ),
            (
                &[("50 0 0 -1", "50 .3 .3 1e-17")],
                is!(Degenerate {
                    element: 5,
                    place: Line(25),
                    ..
                }),
            ),
            (
                &[("50 0 0 -1", "50 1e300 1e300 -1e300")],
                is!(Degenerate { element: 5, .. }),
            ),
            (
                &[("1 30 20 50", "1 20 30 50")],
                is!(Inverted {
                    element: 5,
                    inverted: 1,
                    total: 2,
                    ..
                }),
            ),
            (
                &[("50 0 0 -1", "50 0 0 2")],
                is!(Inverted { element: 5, .. }),
            ),
            (
                &[("1 30 20 50", "1 20 30 4")],
                is!(DuplicateTetrahedron {
                    first: 4,
                    second: 5,
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 20 30 99"), (SPARE, "99 .1 .1 2")],
                is!(Overlap {
                    first: 4,
                    second: 5,
                    triangle: [1, 20, 30],
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 1 0 1e-9")],
                is!(CoincidentNodes {
                    first: 20,
                    second: 99,
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 .3 .3 0")],
                is!(HangingNode {
                    node: 99,
                    element: 4,
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 30 99 50"), (SPARE, "99 .5 .5 0")],
                is!(HangingNode {
                    node: 99,
                    element: 4,
                    ..
                }),
            ),
            (
                &[("1 30 20 50", "1 99 30 50"), (SPARE, "99 -1 0 0")],
                is!(Pieces {
                    pieces: 2,
                    first: 4,
                    other: 5,
                    smallest: 1,
                    total: 2
                }),
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
                is!(TwoVolumes { element: 5, first, second, .. } if first == "body" && second == "8"),
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 30 50")],
                is!(TwoSurfaces { element: 3, first, second, .. } if first == "bottom" && second == "side"),
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 20 30")],
                is!(NotOnBoundary { name, triangles: 1, element: 3, .. } if name == "side"),
            ),
            (
                &[("3 2 2 2 1 1 4 30", "3 2 2 2 1 1 4 99")],
                is!(NotOnBoundary { .. }),
            ),
        ],
    );
    assert_refused(
        PAIR_41,
        &[
            (
                &[("1 1 1 -2 0", "1 1 2 1 2 0")],
                is!(TwoSurfaces { element: 3, first, second, .. } if first == "bottom" && second == "side"),
            ),
            (
                &[("1 1 1 7 2 1 -2", "1 1 2 7 8 2 1 -2")],
                is!(TwoVolumes { element: 4, first, second, .. } if first == "body" && second == "8"),
            ),
        ],
    );
}
