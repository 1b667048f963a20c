//! The study of mesh files and of several bodies, whose tetrahedra are cut.

use std::{fmt::Write, fs, path::Path};

use contact3d::{Problem, mesh::Mesh, scene::Scene};
use studies::accuracy::{AccuracySettings, DiscretisationStudy};

/// Meshes of the library's own tests.
fn meshes() -> &'static Path {
    Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../contact3d/tests/meshes"
    ))
}

fn parsed(text: &str) -> Scene {
    Scene::parse("scene.toml", text).unwrap_or_else(|error| panic!("{error}"))
}

fn study(scene: &Scene, folder: &Path, unknowns: usize) -> DiscretisationStudy {
    let settings = AccuracySettings {
        unknowns: Some(unknowns),
        ..AccuracySettings::default()
    };
    DiscretisationStudy::measure(scene, folder, &settings, &mut |_| {}).expect("solves")
}

/// Without contact ‖u_h − u_f‖² = 2 (J_h − J_f) = (J_f − J_h)/J_f ‖u_f‖² (Galerkin), if the finest mesh can be what the coarse one is: the
/// energies know nothing of the interpolation from one to the other. Linear and quadratic, curved sides, two materials, two bodies.
#[test]
fn fields_of_cut_meshes_are_as_far_apart_as_their_energies() {
    let steel = "title = 't'\nmaterial.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }\n";
    let file = |file: &str, element: &str| {
        format!("{steel}[body]\nelement = '{element}'\ngmsh = {{ file = '{file}', unit = 1.0 }}\n")
    };
    let foot = "region = [{ part = { group = 'rubber' }, material = { isotropic = { young_modulus = 5e9, poisson_ratio = 0.4 } } }]\n\
        clamp = [{ face = 'held end' }]\nbody_force = { value = [1e6, 0.0, -4e6] }\n";
    let post = "clamp = [{ face = 'foot' }]\ntraction = [{ face = 'side', value = [1e5, '2e5*z', 0.0] }]\n";
    let foot = format!("{foot}{}", file("foot_41.msh", "P1"));
    let brick = |name: &str, origin: f64| {
        format!(
            "[[body]]\nname = '{name}'\norigin = [{origin:?}, 0.0, 0.0]\nbrick = {{ size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }}\n"
        )
    };
    let pair = format!(
        "clamp = [{{ face = 'left.x_min' }}, {{ face = 'right.x_max' }}]\n\
         traction = [{{ face = 'left.x_max', value = [1e5, 0.0, 3e5] }}, {{ face = 'right.z_max', value = [0.0, 0.0, 2e5] }}]\n{steel}{}{}",
        brick("left", 0.0),
        brick("right", 3.0)
    );
    let post = format!("{post}{}", file("post_order2_41.msh", "P2"));
    let quadratic = pair
        .replace("origin", "element = 'P2'\norigin")
        .replace("[2, 2, 2]", "[1, 1, 1]");
    // On straight sides energies agree to rounding, some 1e-12 of them. On curved ones the points of integration are not exact for the
    // rational functions there, more so in the larger tetrahedra; they leave 5e-6.
    for (text, unknowns, n_levels, tolerance) in [
        (foot.clone(), 0, 1, 1e-8),
        (foot, 5_000, 2, 1e-8),
        (post, 10_000, 2, 2e-5),
        (pair, 10_000, 3, 1e-8),
        (quadratic, 1_000, 2, 1e-8),
    ] {
        let study = study(&parsed(&text), meshes(), unknowns);
        let levels = &study.levels;
        assert_eq!((levels.len(), study.scene_level), (n_levels, 0), "{text}");
        let finest = levels[n_levels - 1].potential_energy;
        for level in &levels[..n_levels - 1] {
            let by_energies = (finest - level.potential_energy) / finest;
            let by_distance = level.energy_difference.powi(2);
            assert!(
                (by_energies / by_distance - 1.0).abs() < tolerance,
                "{text}: {by_energies:e} {by_distance:e}"
            );
            assert!(by_distance > 1e-3, "{by_distance:e}");
        }
    }
}

/// The mesh of a brick as a Gmsh file of format 2.2.
fn write_gmsh(mesh: &Mesh, path: &Path) {
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n",
        mesh.face_names.len() + 1
    );
    for (k, name) in (1..).zip(&mesh.face_names) {
        writeln!(text, "2 {k} \"{name}\"").unwrap();
    }
    write!(
        text,
        "3 7 \"all\"\n$EndPhysicalNames\n$Nodes\n{}\n",
        mesh.coordinates.len()
    )
    .unwrap();
    for (k, [x, y, z]) in (1..).zip(&mesh.coordinates) {
        writeln!(text, "{k} {x} {y} {z}").unwrap();
    }
    let n_elements = mesh.facets.len() + mesh.tetrahedra.len();
    write!(text, "$EndNodes\n$Elements\n{n_elements}\n").unwrap();
    for (k, ([a, b, c], face)) in (1..).zip(mesh.facets.iter().zip(&mesh.facet_face)) {
        let face = face + 1;
        writeln!(text, "{k} 2 2 {face} {face} {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    for (k, [a, b, c, d]) in (mesh.facets.len() + 1..).zip(&mesh.tetrahedra) {
        writeln!(text, "{k} 4 2 7 7 {} {} {} {}", a + 1, b + 1, c + 1, d + 1).unwrap();
    }
    text += "$EndElements\n";
    fs::write(path, text).unwrap();
}

/// A smooth solution on quadratic tetrahedra, whose energy the cells of the brick and the cuts of a file of the same mesh approach on different ways.
#[test]
fn a_brick_and_a_file_of_its_mesh_have_one_limit() {
    let text = "title = 'smooth'
        material.isotropic = { young_modulus = 1e9, poisson_ratio = 0.3 }
        clamp = [
            { face = 'x_min', components = ['x'] }, { face = 'y_min', components = ['y'] }, { face = 'z_min', components = ['z'] },
        ]
        traction = [{ face = 'x_max', value = [0.0, 0.0, '1e5*z*y'] }, { face = 'z_max', value = ['1e5*x', 0.0, 0.0] }]
        body.element = 'ELEMENT'
        BODY";
    let scene =
        |element: &str, body: &str| parsed(&text.replace("ELEMENT", element).replace("BODY", body));
    let brick = "body.brick = { size = [2.0, 1.0, 1.0], cells = [2, 1, 1] }";
    let folder = tempfile::tempdir().unwrap();
    let mesh = Mesh::of_scene(&scene("P1", brick), folder.path()).unwrap();
    write_gmsh(&mesh, &folder.path().join("brick.msh"));
    let file = study(
        &scene("P2", "body.gmsh.file = 'brick.msh'"),
        folder.path(),
        50_000,
    );
    let settings = AccuracySettings {
        coarsest: Some(1),
        finest: Some(4),
        ..AccuracySettings::default()
    };
    let cells =
        DiscretisationStudy::measure(&scene("P2", brick), Path::new(""), &settings, &mut |_| {});
    let cells = cells.unwrap();
    let [first, other] = [&file, &cells].map(|study| study.levels[0].potential_energy);
    // The same mesh, solved to 1e-12.
    assert!((first / other - 1.0).abs() < 1e-10);
    let limit = |study: &DiscretisationStudy| {
        let limit = study.potential_energy.limit.expect("an order");
        (
            limit,
            (limit - study.levels.last().unwrap().potential_energy).abs(),
        )
    };
    let ((one, beyond), (two, beyond_cells)) = (limit(&file), limit(&cells));
    // An extrapolation is known to some part of what it adds to the finest mesh; 0.14 here.
    assert!(
        (one - two).abs() < 0.3 * beyond.min(beyond_cells),
        "{one} {two} {beyond} {beyond_cells}"
    );
}

/// What the levels say of a scene with friction is what its own report says, and areas have no value where the report has none.
#[test]
fn quantities_of_the_first_level_are_those_of_a_run() {
    let text = include_str!("../../../../pipelines/gmsh_foot.toml");
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines"));
    let scene = parsed(text);
    let study = study(&scene, folder, 5_000);
    assert_eq!(study.levels.len(), 2);
    let assembled = Problem::in_folder(scene.clone(), folder).and_then(Problem::assemble);
    let assembled = assembled.expect("a problem");
    let (_, report) = assembled.solve_and_report(&scene.solve).expect("a solve");
    let names: Vec<&str> = study.quantities.iter().map(|(of, _)| of.word()).collect();
    let expected = [
        "normal_force",
        "largest_pressure",
        "largest_von_mises",
        "contact_area",
        "stick_area",
    ];
    assert_eq!(names, expected);
    let contact = report.resultants.contact.as_ref().expect("contact");
    let values = &study.levels[0].quantities;
    let known = [
        contact.normal_force,
        contact.largest_pressure,
        report.largest_von_mises.value,
    ];
    for (value, known) in values.iter().zip(known) {
        assert_eq!(value.to_bits(), known.to_bits());
    }
    // The first mesh is off by half of the solution; the next tells areas.
    assert!(values[3..].iter().all(|area| area.is_nan()));
    assert!(study.levels[1].quantities.iter().all(|value| *value > 0.0));
}
