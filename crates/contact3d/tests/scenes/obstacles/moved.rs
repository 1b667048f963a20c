//! Bodies of any pose and shape: bricks whose nodes are moved, written as Gmsh files.

use std::{fmt::Write, path::Path};

use contact3d::{mesh::Mesh, scene::Scene};
use nalgebra::{Rotation3, Unit, Vector3};
use tempfile::TempDir;

use super::solved::{Solved, distance, list};

/// A mesh of linear or quadratic tetrahedra in the format MSH 2.2, with its nodes moved by a map.
fn msh(mesh: &Mesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    let names = mesh.face_names.iter().enumerate();
    let _ = writeln!(text, "{}\n3 100 \"body\"", mesh.face_names.len() + 1);
    for (i, name) in names {
        let _ = writeln!(text, "2 {} \"{name}\"", i + 1);
    }
    let _ = writeln!(
        text,
        "$EndPhysicalNames\n$Nodes\n{}",
        mesh.coordinates.len()
    );
    for (n, at) in mesh.coordinates.iter().enumerate() {
        let [x, y, z] = map(*at);
        let _ = writeln!(text, "{} {x:e} {y:e} {z:e}", n + 1);
    }
    let count = mesh.facets.len() + mesh.tetrahedra.len();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{count}");
    let quadratic = mesh.mid_edges.is_some();
    let mut tag = 0;
    let mut element = |kind: [usize; 2], group: usize, nodes: Vec<usize>| {
        tag += 1;
        let nodes: Vec<String> = nodes.iter().map(|n| (n + 1).to_string()).collect();
        let kind = kind[usize::from(quadratic)];
        let _ = writeln!(text, "{tag} {kind} 2 {group} {group} {}", nodes.join(" "));
    };
    for facet in 0..mesh.facets.len() {
        element(
            [2, 9],
            mesh.facet_face[facet] + 1,
            mesh.facet_nodes(facet).collect(),
        );
    }
    for tetrahedron in 0..mesh.tetrahedra.len() {
        let mut nodes: Vec<usize> = mesh.tetrahedron_nodes(tetrahedron).collect();
        if quadratic {
            nodes.swap(8, 9);
        }
        element([4, 11], 100, nodes);
    }
    text + "$EndElements\n"
}

/// A scene on the mesh of a brick whose nodes are moved; `scene` holds all but the body and its material.
pub(crate) fn moved(
    brick: &str,
    element: &str,
    map: impl Fn([f64; 3]) -> [f64; 3],
    scene: &str,
) -> Result<Solved, String> {
    let (folder, text) = written(brick, element, map, scene);
    Solved::in_folder(&text, folder.path())
}

/// The folder with the mesh file, and the text of the scene.
pub(crate) fn written(
    brick: &str,
    element: &str,
    map: impl Fn([f64; 3]) -> [f64; 3],
    scene: &str,
) -> (TempDir, String) {
    let body = format!("title = 'moved'\n[body]\nelement = '{element}'\n");
    let plain = format!("{body}[body.brick]\n{brick}\n{MATERIAL}[[clamp]]\nface = 'z_max'\n");
    let plain = Scene::parse("brick", &plain).unwrap_or_else(|e| panic!("{e}\n{plain}"));
    let mesh = Mesh::of_scene(&plain, Path::new("")).expect("a brick");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("moved.msh"), msh(&mesh, map)).expect("a file");
    let text = format!("{body}[body.gmsh]\nfile = 'moved.msh'\n{MATERIAL}{scene}");
    (folder, text)
}

/// E = 1, ν = 0.3.
pub(crate) const MATERIAL: &str =
    "[material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n";

/// A brick turned with its loads, axes and half-space is the flat scene in other coordinates.
#[test]
fn a_half_space_in_any_pose_is_the_flat_foundation() {
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5)), 0.9);
    let shift = Vector3::new(0.3, -1.1, 2.0);
    let (axis, load, side) = ([2.0, 1.0, 0.0], [0.02, 0.01, -0.06], [0.01, 0.0, 0.0]);
    let turned = |v: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(v)).into() };
    let scene = |obstacle: &str, seen: &dyn Fn([f64; 3]) -> [f64; 3]| {
        format!(
            "[[clamp]]\nface = 'x_min'\n[[traction]]\nface = 'z_max'\nvalue = {}\n[[traction]]\nface = 'x_max'\nvalue = {}\n\
             [contact]\nface = 'z_min'\nmultipliers = 'nodal'\naxis_1 = {}\n{obstacle}\n\
             [friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.15\n",
            list(seen(load)),
            list(seen(side)),
            list(seen(axis)),
        )
    };
    let brick = "size = [2.0, 1.0, 0.5]\ncells = [8, 4, 2]";
    for element in ["P1", "P2"] {
        let flat = moved(brick, element, |x| x, &scene("", &|v| v)).unwrap();
        let half_space = format!(
            "obstacle.half_space = {{ point = {}, normal = {} }}",
            list(shift.into()),
            list(turned([0.0, 0.0, 3.0])),
        );
        let map = |x: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(x) + shift).into() };
        let tilted = moved(brick, element, map, &scene(&half_space, &turned)).unwrap();
        let surface = tilted.surface();
        assert_eq!(
            (surface.normals.len(), surface.clearance.len()),
            (1, surface.nodes.len())
        );
        // Roundings of coordinates through a problem of condition below 1e5.
        let difference = distance(&tilted.multiplier, &flat.multiplier);
        assert!(difference < 1e-10, "{element}: {difference:e}");
        let [a, b] = [&tilted, &flat].map(Solved::force);
        assert!(distance(&a, &turned(b)) < 1e-10);
        assert!(
            b[0].abs() > 1e-3 && b[1].abs() > 1e-4,
            "friction acts: {b:?}"
        );
    }
}
