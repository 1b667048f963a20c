//! Whatever happens to a file, parsing it gives a sound mesh or an error.

use std::collections::HashMap;

use contact3d::mesh::parse_gmsh as parse;
use proptest::{prelude::*, sample::Index};

use super::{FOOT_41_BINARY, PAIR_22, PAIR_41};

/// One change of a file: where, and what.
#[derive(Debug, Clone)]
enum Change {
    Delete(Index),
    Double(Index),
    Swap(Index, Index),
    Replace(Index, String),
    Cut(Index),
}

fn any_change() -> impl Strategy<Value = Change> {
    let word = prop_oneof![
        any::<i64>().prop_map(|n| n.to_string()),
        (-9..99_i64).prop_map(|n| n.to_string()),
        any::<f64>().prop_map(|x| x.to_string()),
        "\\PC{0,6}",
        Just("$Nodes".to_owned()),
        Just("$EndElements".to_owned()),
    ];
    prop_oneof![
        any::<Index>().prop_map(Change::Delete),
        any::<Index>().prop_map(Change::Double),
        (any::<Index>(), any::<Index>()).prop_map(|(a, b)| Change::Swap(a, b)),
        (any::<Index>(), word).prop_map(|(at, word)| Change::Replace(at, word)),
        any::<Index>().prop_map(Change::Cut),
    ]
}

/// Changes a row of words, lines or bytes.
fn apply<T: Clone>(items: &mut Vec<T>, change: &Change, convert: impl Fn(&str) -> T) {
    if items.is_empty() {
        return;
    }
    let n = items.len();
    match change {
        Change::Delete(at) => drop(items.remove(at.index(n))),
        Change::Double(at) => items.insert(at.index(n), items[at.index(n)].clone()),
        Change::Swap(a, b) => items.swap(a.index(n), b.index(n)),
        Change::Replace(at, word) => items[at.index(n)] = convert(word),
        Change::Cut(at) => items.truncate(at.index(n)),
    }
}

/// Parses, and checks what every accepted mesh has.
fn parse_soundly(bytes: &[u8]) {
    let Ok(mesh) = parse(bytes) else { return };
    let n_nodes = mesh.coordinates.len();
    assert!(
        mesh.coordinates
            .as_flattened()
            .iter()
            .all(|x| x.is_finite())
    );
    assert!(mesh.tetrahedra.as_flattened().iter().all(|&n| n < n_nodes));
    assert!(mesh.facets.as_flattened().iter().all(|&n| n < n_nodes));
    assert_eq!(mesh.facet_face.len(), mesh.facets.len());
    assert!(mesh.facet_face.iter().all(|&f| f < mesh.face_names.len()));
    assert!(
        mesh.tetrahedron_group
            .iter()
            .all(|&g| g < mesh.group_names.len())
    );
    // The boundary of a body is closed: each edge is passed as often one way as the other.
    let mut passed: HashMap<[usize; 2], i64> = HashMap::new();
    for &[a, b, c] in &mesh.facets {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *passed.entry([p.min(q), p.max(q)]).or_default() += if p < q { 1 } else { -1 };
        }
    }
    assert!(passed.values().all(|&n| n == 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn words_may_change(four in any::<bool>(), changes in prop::collection::vec(any_change(), 1..4)) {
        let sample = if four { PAIR_41 } else { PAIR_22 };
        let mut words: Vec<String> = sample.split_inclusive([' ', '\n']).map(str::to_owned).collect();
        for change in &changes {
            apply(&mut words, change, |word| format!("{word} "));
        }
        parse_soundly(words.concat().as_bytes());
    }

    #[test]
    fn numbers_may_change(four in any::<bool>(), at in any::<Index>(), number in -9..99_i64) {
        let sample = if four { PAIR_41 } else { PAIR_22 };
        let mut words: Vec<&str> = sample.split_inclusive([' ', '\n']).collect();
        let at = at.index(words.len());
        let replaced = format!("{number}{}", if words[at].ends_with('\n') { '\n' } else { ' ' });
        words[at] = &replaced;
        parse_soundly(words.concat().as_bytes());
    }

    #[test]
    fn lines_may_change(four in any::<bool>(), changes in prop::collection::vec(any_change(), 1..4)) {
        let sample = if four { PAIR_41 } else { PAIR_22 };
        let mut lines: Vec<String> = sample.split_inclusive('\n').map(str::to_owned).collect();
        for change in &changes {
            apply(&mut lines, change, |word| format!("{word}\n"));
        }
        parse_soundly(lines.concat().as_bytes());
    }

    #[test]
    fn bytes_may_change(four in any::<bool>(), changes in prop::collection::vec(any_change(), 1..6)) {
        let mut bytes = if four { PAIR_41 } else { PAIR_22 }.as_bytes().to_vec();
        for change in &changes {
            apply(&mut bytes, change, |word| word.bytes().next().unwrap_or(0));
        }
        parse_soundly(&bytes);
    }

    #[test]
    fn random_text_is_no_mesh(text in "(\\PC|\\s){0,200}", bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(parse(text.as_bytes()).is_err());
        prop_assert!(parse(&bytes).is_err());
        parse_soundly(&[PAIR_22.as_bytes(), text.as_bytes()].concat());
        parse_soundly(&[&FOOT_41_BINARY[..29], &bytes].concat());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn binary_may_change(changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..4), cut in any::<Option<Index>>()) {
        let mut bytes = FOOT_41_BINARY.to_vec();
        for (at, byte) in changes {
            let n = bytes.len();
            bytes[at.index(n)] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        parse_soundly(&bytes);
    }
}
