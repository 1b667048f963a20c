use std::path::PathBuf;

use super::{
    Theory, TheoryLevel, TheorySettings,
    tests::{measure, published},
};
use crate::accuracy::with_brick;
use contact3d::{
    ProblemError,
    mesh::Mesh,
    scene::{Contact, GmshFile, Shape},
};

/// A mesh as a Gmsh file of format 2.2, its faces as physical groups.
fn gmsh(mesh: &Mesh) -> String {
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n".to_owned();
    text += &format!("{}\n", mesh.face_names.len() + 1);
    for (k, name) in mesh.face_names.iter().enumerate() {
        text += &format!("2 {} \"{name}\"\n", k + 1);
    }
    text += &format!(
        "3 {} \"body\"\n$EndPhysicalNames\n",
        mesh.face_names.len() + 1
    );
    text += &format!("$Nodes\n{}\n", mesh.coordinates.len());
    for (k, [x, y, z]) in mesh.coordinates.iter().enumerate() {
        text += &format!("{} {x} {y} {z}\n", k + 1);
    }
    let elements = mesh.facets.len() + mesh.tetrahedra.len();
    text += &format!("$EndNodes\n$Elements\n{elements}\n");
    for (k, (nodes, face)) in mesh.facets.iter().zip(&mesh.facet_face).enumerate() {
        let [a, b, c] = nodes.map(|n| n + 1);
        text += &format!("{} 2 2 {} {} {a} {b} {c}\n", k + 1, face + 1, face + 1);
    }
    for (k, nodes) in mesh.tetrahedra.iter().enumerate() {
        let [a, b, c, d] = nodes.map(|n| n + 1);
        let (number, group) = (mesh.facets.len() + k + 1, mesh.face_names.len() + 1);
        text += &format!("{number} 4 2 {group} 1 {a} {b} {c} {d}\n");
    }
    text + "$EndElements\n"
}

/// A family of mesh files takes the place of nested meshes: with the meshes of a brick, in any order, it has the figures of that brick.
#[test]
fn mesh_files_serve_like_the_meshes_of_a_brick() {
    let mut scene = published(4, 1.0);
    scene.contacts[0] = Contact::on("z_min").nodal();
    let expected = measure(&scene);
    let folder = tempfile::tempdir().expect("a folder");
    let meshes = [4, 2].map(|n| {
        let bricks = with_brick(&scene, published(n, 1.0).body.as_brick().expect("a brick"));
        let mesh = Mesh::of_scene(&bricks, folder.path()).expect("a mesh");
        let file = PathBuf::from(format!("{n}.msh"));
        std::fs::write(folder.path().join(&file), gmsh(&mesh)).expect("a file");
        GmshFile {
            file,
            unit: 1.0,
            digest: None,
        }
    });
    let settings = TheorySettings {
        coarsest: 2,
        finest: None,
        meshes: meshes.to_vec(),
    };
    let refused = Theory::measure(&scene, folder.path(), &settings, &mut |_| {});
    assert!(matches!(refused, Err(ProblemError::Invalid(_))));
    scene.body.shape = Shape::Gmsh(meshes[0].clone());
    let found = Theory::measure(&scene, folder.path(), &settings, &mut |_| {}).expect("covered");
    assert_eq!(found.levels.len(), expected.levels.len());
    for (file, brick) in found.levels.iter().zip(&expected.levels) {
        assert_eq!((file.n_free, file.n_panes), (brick.n_free, brick.n_panes));
        let figures = |level: &TheoryLevel| {
            let local = level.local.as_ref().expect("a solution");
            let norms = level
                .norms
                .iter()
                .flat_map(|n| [n.ellipticity, n.load, n.inverse_half, n.bound.paper]);
            let own = [
                level.face.pane_size,
                level.face.inverse_first,
                local.spectral_radius,
                level.observed.rate,
            ];
            norms.chain(own).collect::<Vec<f64>>()
        };
        for (one, two) in figures(file).into_iter().zip(figures(brick)) {
            // Eigenvalues settle to 1e-8 or so; the order of nodes and tetrahedra differs, and squarings end near one.
            assert!((one / two - 1.0).abs() < 1e-6, "{one} {two}");
        }
    }
}
