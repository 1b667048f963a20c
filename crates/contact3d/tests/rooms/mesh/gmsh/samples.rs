//! Files made by Gmsh, against what Gmsh itself measures.

use std::{fs, path::Path};

use contact3d::{
    mesh::{
        GmshError, Mesh, MeshError, RawMesh, digest_of, parse_gmsh as parse, tetrahedron_volume,
        triangle_area,
    },
    scene::{GmshFile, Material, Scene},
};

use super::{BRACKET_22, BRACKET_41, FOOT_22, FOOT_41, FOOT_41_BINARY, PAIR_22, PAIR_41};

/// Sums differ by roundings of a thousand terms.
const SUM: f64 = 1e-13;

fn volume_of(mesh: &RawMesh, group: &str) -> f64 {
    let group = mesh.group_names.iter().position(|n| n == group).unwrap();
    let members = mesh.tetrahedra.iter().zip(&mesh.tetrahedron_group);
    members
        .filter(|(_, g)| **g == group)
        .map(|(t, _)| tetrahedron_volume(&t.map(|n| mesh.coordinates[n])))
        .sum()
}

fn area_of(mesh: &RawMesh, face: &str) -> f64 {
    let face = mesh.face_names.iter().position(|n| n == face).unwrap();
    let members = mesh.facets.iter().zip(&mesh.facet_face);
    members
        .filter(|(_, f)| **f == face)
        .map(|(t, _)| triangle_area(&t.map(|n| mesh.coordinates[n])))
        .sum()
}

/// The mesh of a scene with a body from a file.
fn read(file: &GmshFile, folder: &Path) -> Result<Mesh, GmshError> {
    let body = file.clone().into();
    let scene = Scene::new(body, Material::isotropic(1.0, 0.3));
    Mesh::of_scene(&scene, folder).map_err(|error| match error {
        MeshError::Gmsh(error) => error,
        MeshError::Scene(invalid) => panic!("{invalid:?}"),
    })
}

fn assert_close(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < SUM, "{found} {expected}");
}

#[test]
fn foot_measures_what_gmsh_says() {
    let mesh = parse(FOOT_41).unwrap();
    assert_eq!((mesh.coordinates.len(), mesh.tetrahedra.len()), (204, 573));
    assert_eq!(mesh.group_names, ["rubber", "steel"]);
    assert_eq!(mesh.face_names, ["contact", "held end", "unnamed"]);
    // Sums of getElementQualities(…, "volume") over physical groups, Gmsh 4.15.2.
    assert_close(volume_of(&mesh, "rubber"), 12429.107698192567);
    assert_close(volume_of(&mesh, "steel"), 2858.06505872225);
    assert_close(area_of(&mesh, "contact"), 1237.9717325257977);
    assert_close(area_of(&mesh, "held end"), 185.12283158972332);
}

#[test]
fn bracket_measures_what_gmsh_says() {
    let mesh = parse(BRACKET_41).unwrap();
    assert_eq!((mesh.coordinates.len(), mesh.tetrahedra.len()), (238, 680));
    assert_eq!(mesh.group_names, ["body"]);
    let faces = ["contact", "hole", "40", "41", "unnamed"];
    assert_eq!(mesh.face_names, faces);
    assert_close(volume_of(&mesh, "body"), 2.8244475116101557);
    assert_close(area_of(&mesh, "hole"), 1.5321154343934111);
    for (face, area) in [("contact", 3.0), ("40", 1.0), ("41", 1.0)] {
        assert_close(area_of(&mesh, face), area);
    }
}

/// Asserts that two meshes are the same but for the 16 digits that Gmsh writes into text.
fn assert_same(mut found: RawMesh, expected: &RawMesh) {
    let pairs = found.coordinates.as_flattened_mut().iter_mut();
    for (x, y) in pairs.zip(expected.coordinates.as_flattened()) {
        // One unit of the 16th digit is at most 1e-15 of the number.
        assert!((*x - y).abs() <= 1e-15 * y.abs(), "{x} {y}");
        *x = *y;
    }
    assert!(found == *expected);
}

#[test]
fn all_formats_say_the_same() {
    let foot = parse(FOOT_41).unwrap();
    assert_same(parse(FOOT_41_BINARY).unwrap(), &foot);
    assert_same(parse(FOOT_22).unwrap(), &foot);
    assert_same(parse(BRACKET_22).unwrap(), &parse(BRACKET_41).unwrap());
}

#[test]
fn facets_enclose_the_body() {
    for sample in [FOOT_41, BRACKET_41] {
        let mesh = parse(sample).unwrap();
        let volume = |t: &[usize; 4]| tetrahedron_volume(&t.map(|n| mesh.coordinates[n]));
        let inside: f64 = mesh.tetrahedra.iter().map(volume).sum();
        // Divergence theorem: cones from the origin over the boundary.
        let cone = |f: &[usize; 3]| {
            let [a, b, c] = f.map(|n| nalgebra::Vector3::from(mesh.coordinates[n]));
            a.cross(&b).dot(&c) / 6.0
        };
        assert_close(mesh.facets.iter().map(cone).sum(), inside);
    }
}

#[test]
fn files_are_read_in_metres_and_by_digest() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let mut file = GmshFile {
        volume: None,
        file: "foot_41.msh".into(),
        unit: 1e-3,
        digest: Some(digest_of(&folder.join("foot_41.msh")).unwrap()),
    };
    let metres = read(&file, &folder).unwrap();
    let millimetres = parse(FOOT_41).unwrap();
    let expected = millimetres.coordinates.iter().map(|x| x.map(|x| x * 1e-3));
    assert!(expected.eq(metres.coordinates.iter().copied()));
    for unit in [0.0, -1.0, f64::NAN, 1e308] {
        file.unit = unit;
        assert!(matches!(read(&file, &folder), Err(GmshError::Unit { .. })));
    }
    file.digest = Some("00".repeat(32));
    assert!(matches!(
        read(&file, &folder),
        Err(GmshError::Digest { .. })
    ));
    file.file = "none.msh".into();
    assert!(matches!(read(&file, &folder), Err(GmshError::Read { .. })));
}

#[test]
fn flaws_of_a_file_keep_path_and_help() {
    use miette::Diagnostic;
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("part.msh"), "$MeshFormat\n4 0 8\n").unwrap();
    let file = GmshFile {
        volume: None,
        file: "part.msh".into(),
        unit: 1.0,
        digest: None,
    };
    let error = read(&file, folder.path()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.ends_with("part.msh: line 2: expected MSH format 4.1 or 2.2, found \"4\""),
        "{text}"
    );
    assert!(error.help().unwrap().to_string().contains("-format msh41"));
}

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
    // Other programs write the group 0, which is none, to entities of MSH 4.1.
    let volume = "1 0 0 -1 1 1 1 1 7 2 1 -2";
    let free = PAIR_41.replace(volume, &volume.replace("1 7", "1 0"));
    let mesh = parse(free.as_bytes()).unwrap();
    assert!(mesh.tetrahedron_group.is_empty() && mesh.group_names.is_empty());
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
