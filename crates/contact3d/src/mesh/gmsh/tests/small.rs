//! Two tetrahedra written by hand.

use super::{super::parse, PAIR_22, PAIR_41};

#[test]
fn nodes_are_numbered_by_tag_and_unused_ones_dropped() {
    let mesh = parse(PAIR_22.as_bytes()).unwrap();
    assert_eq!(parse(PAIR_41.as_bytes()).unwrap(), mesh);
    let corners = [
        [0., 0., 0.],
        [0., 0., 1.],
        [1., 0., 0.],
        [0., 1., 0.],
        [0., 0., -1.],
    ];
    assert_eq!(mesh.coordinates, corners);
    assert_eq!(mesh.tetrahedra, [[0, 2, 3, 1], [0, 3, 2, 4]]);
    assert_eq!(mesh.face_names, ["bottom", "side", "unnamed"]);
    assert_eq!(mesh.facets.len(), 6);
    let named = mesh
        .facets
        .iter()
        .zip(&mesh.facet_face)
        .filter(|(_, f)| **f < 2);
    assert_eq!(named.count(), 2);
}

#[test]
fn mirrored_meshes_are_turned() {
    let mirrored = PAIR_22
        .replace("1 20 30 4\n", "1 20 4 30\n")
        .replace("1 30 20 50\n", "1 30 50 20\n");
    let (turned, mesh) = (
        parse(mirrored.as_bytes()).unwrap(),
        parse(PAIR_22.as_bytes()).unwrap(),
    );
    assert_eq!(turned.tetrahedra, mesh.tetrahedra);
    assert_eq!(turned.facets, mesh.facets);
}

#[test]
fn bodies_without_physical_volumes_have_no_groups() {
    let free = PAIR_22.replace("4 2 7 1", "4 2 0 1");
    let mesh = parse(free.as_bytes()).unwrap();
    assert!(mesh.tetrahedron_group.is_empty() && mesh.group_names.is_empty());
    let half = PAIR_22.replace("5 4 2 7 1", "5 4 2 0 1");
    let mesh = parse(half.as_bytes()).unwrap();
    assert_eq!(mesh.tetrahedron_group, [0, 1]);
    assert_eq!(mesh.group_names, ["body", "unnamed"]);
}

#[test]
fn line_ends_blank_lines_and_other_sections_do_not_matter() {
    let mesh = parse(PAIR_22.as_bytes()).unwrap();
    let other = PAIR_22
        .replace(
            "$Nodes\n",
            "$Comments\n$Nodes of old\n$EndComments\n\n$Nodes\n",
        )
        .replace('\n', " \r\n");
    assert_eq!(parse(other.as_bytes()).unwrap(), mesh);
    assert_eq!(parse(PAIR_22.trim_end().as_bytes()).unwrap(), mesh);
}
