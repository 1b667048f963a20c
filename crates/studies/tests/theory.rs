//! The theory against closed forms, bounds that must hold, and other descriptions of the same problem.

use std::{
    path::{Path, PathBuf},
    sync::LazyLock,
};

use contact3d::{
    Problem, ProblemError,
    linalg::{difference, norm},
    mesh::Mesh,
    scene::{
        Body, Clamp, Coefficient, Contact, DualOperatorKind, ElementOrder, Friction, GmshFile,
        InnerSolver, Material, Method, MultiplierSpace, Obstacle, Pressure, Scene, Shape, Side,
        SlipInterpolation, SolveSettings, Sphere, Traction,
    },
};
use studies::{
    stability::{Transformation, UnitChange},
    theory::{Theory, TheoryLevel, TheorySettings},
};

/// The published problem on 3 n × n × n cells with Table 1's law times a factor.
fn published(n: usize, factor: f64) -> Scene {
    let ramp = |rate: f64| Coefficient::ramp(0.3 * factor, 0.2 * factor, 1e-5, rate * factor);
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [3 * n, n, n]),
        Material::isotropic(21.19e10, 0.277),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
    .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::orthotropic(ramp(3000.0), ramp(1000.0)))
}

/// A block on one pane of 2 × 2 cells, pulled along x so that it slides.
fn one_pane(coefficient: f64) -> Scene {
    Scene::new(
        Body::brick([1.0; 3], [2, 2, 2]),
        Material::isotropic(2e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 1e7))
    .with_traction(Traction::on("x_max", [3e7, 0.0, 0.0]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::coulomb(coefficient))
}

fn measure(scene: &Scene) -> Theory {
    measured(scene, Path::new(""), Vec::new()).expect("covered")
}

fn measured(scene: &Scene, folder: &Path, meshes: Vec<GmshFile>) -> Result<Theory, ProblemError> {
    let settings = TheorySettings {
        coarsest: 2,
        finest: None,
        meshes,
    };
    Theory::measure(scene, folder, &settings, &mut |_| {})
}

/// The theory of the published problem at n_div = 2 and 4, measured once for the tests that read it.
static PUBLISHED: LazyLock<Theory> = LazyLock::new(|| measure(&published(4, 1.0)));

/// With the pane sliding along −t₁ or t₁, λ_ν = (h_ν ± F S_νt g)/S_νν, so Ψ′ = ± F S_νt/S_νν.
#[test]
fn one_sliding_pane_contracts_as_its_closed_form() {
    let scene = one_pane(0.1);
    let problem = Problem::new(scene.clone().with_dual_operator(DualOperatorKind::Explicit));
    let assembled = problem.and_then(Problem::assemble).expect("a problem");
    let solution = assembled.solve(&SolveSettings::default()).expect("solved");
    let [normal, pulled, across] = solution.multiplier[..] else {
        panic!("one pane")
    };
    // The pane slides: its ellipse, a circle, is reached, along x by symmetry.
    assert!(normal > 0.0 && (pulled.abs() / (0.1 * normal) - 1.0).abs() < 1e-12);
    assert!(across.abs() < 1e-9 * normal);
    let dual = assembled
        .system()
        .contact
        .as_ref()
        .and_then(|c| c.explicit());
    let s = |i: usize, j: usize| dual.expect("dense").column(j)[i];
    let expected = 0.1 * s(0, 1).abs() / s(0, 0);
    let level = &measure(&scene).levels[0];
    let local = level.local.as_ref().expect("a regular solution");
    // One by one systems and their eigenvalues.
    assert!(
        (local.spectral_radius / expected - 1.0).abs() < 1e-10,
        "{local:?} {expected}"
    );
    assert!((local.parts[1].pressure_by_pressure / expected - 1.0).abs() < 1e-10);
    assert_eq!(
        (local.parts[1].slip_by_slip, local.parts[1].pressure_by_slip),
        (0.0, 0.0)
    );
    // A disturbance of 1e-8 shrinks by a factor that rounding changes by some 1e-8, over the factor itself, 0.02.
    let change = level.observed.rate / expected - 1.0;
    assert!(change.abs() < 1e-6, "{change:e} {expected}");
    // F L = 0: the bound is that of F_max alone.
    assert_eq!(level.norms[1].bound.by_coefficient, 1.0);
}

#[test]
fn rates_are_spectral_radii_and_nothing_contradicts_the_theory() {
    let steep = measure(&published(4, 5.6));
    for theory in [&*PUBLISHED, &steep] {
        assert_eq!(theory.levels.len(), 2);
        let findings = theory.findings();
        assert_eq!(findings.rates_agree(), Some(true), "{findings}");
        assert!(!findings.lemma_fails);
        for level in &theory.levels {
            let local = level.local.as_ref().expect("a regular solution");
            assert_eq!(local.index, level.determinant, "n_div {}", level.n_div);
            for (norm, (parts, paper)) in level.norms.iter().zip(
                local
                    .parts
                    .iter()
                    .zip(local.paper.as_ref().expect("asked for")),
            ) {
                // The spectral radius is below every norm, a norm below its bound; a hundred roundings.
                let order = [
                    local.spectral_radius,
                    parts.weighted(),
                    norm.bound.sharp,
                    norm.bound.weighted,
                    norm.bound.averaged,
                ];
                assert!(
                    order.is_sorted_by(|a, b| *a <= b * (1.0 + 1e-13)),
                    "{order:?}"
                );
                assert!(local.spectral_radius <= *paper && *paper <= norm.bound.paper);
                assert!(norm.bound.weighted <= norm.bound.paper);
            }
            for quotient in &level.observed.quotient {
                assert!(*quotient > 0.0 && *quotient <= level.norms[0].bound.weighted);
            }
        }
    }
}

/// Newton's method and successive approximations know the derivative and the value of φ apart; the theory uses both.
#[test]
fn clement_interpolation_is_solved_by_both_methods_and_contracts_as_its_derivative_says() {
    let mut scene = published(4, 1.0);
    scene.contacts[0].slip_interpolation = SlipInterpolation::Clement;
    let solve = |scene: Scene, method| {
        let assembled = Problem::new(scene)
            .and_then(Problem::assemble)
            .expect("a problem");
        let settings = SolveSettings {
            method,
            inner: InnerSolver::Newton,
            epsilon: Some(1e-12),
            ..SolveSettings::default()
        };
        let solution = assembled.solve(&settings).expect("a dense operator");
        assert!(solution.status.is_solved(), "{:?}", solution.status);
        solution.multiplier
    };
    let newton = solve(scene.clone(), Method::Newton);
    let approximated = solve(scene.clone(), Method::FixedPoint);
    let distance = |other: &[f64]| norm(&difference(&newton, other)) / norm(&newton);
    // Both to 1e-12; a contraction of a fifth leaves little more.
    assert!(distance(&approximated) < 1e-10);
    let lagrange = solve(published(4, 1.0), Method::Newton);
    assert!(distance(&lagrange) > 1e-4, "{}", distance(&lagrange));
    let theory = measure(&scene);
    assert_eq!(
        theory.findings().rates_agree(),
        Some(true),
        "{}",
        theory.findings()
    );
    assert!(!theory.findings().lemma_fails);
}

#[test]
fn traces_and_inverse_inequalities_bound_each_other() {
    let theory = &*PUBLISHED;
    for level in &theory.levels {
        for norm in &level.norms {
            let trace = &norm.trace;
            // Hölder's inequality on a face of area 3, and between L², L⁴ and L^∞.
            assert!(trace.second <= trace.fourth * 3f64.powf(0.25));
            assert!(trace.fourth <= (trace.second * trace.pointwise).sqrt());
            // The same number but for the error of Lanczos' method where a tangential trace is the largest.
            assert!(trace.tangential <= trace.second * (1.0 + 1e-9));
            assert!(trace.tangential <= trace.interpolated);
            let product =
                level.face.inverse_fourth / level.face.triangle_size.sqrt() * trace.fourth;
            assert!(trace.pointwise <= product);
        }
        // Means of more functions are worse, and settle for Clément's interpolation only.
        let [lagrange, clement] = [level.face.lagrange_finer, level.face.clement_finer];
        assert!(lagrange.is_sorted() && clement.is_sorted());
        assert!(lagrange[2] - lagrange[1] > 10.0 * (clement[2] - clement[1]));
        assert_eq!(level.face.axes, 1.0);
    }
    let coarse = &theory.levels[0].inf_sup;
    assert!(
        coarse
            .iter()
            .all(|row| row.inf_sup.is_some_and(|beta| 0.0 < beta && beta <= 1.0))
    );
    assert!(
        theory.levels[1]
            .inf_sup
            .iter()
            .all(|row| row.inf_sup.is_none())
    );
}

/// Other units leave what has no unit as it is.
#[test]
fn what_has_no_unit_does_not_depend_on_units() {
    let scene = published(2, 1.0);
    let scaling = Transformation::Units(UnitChange {
        length: 1e3,
        displacement: 40.0,
        stress: 1e-6,
    });
    let scaled = scaling
        .apply(&scene)
        .expect("no steps")
        .expect("no obstacle");
    let [one, other] = [scene, scaled].map(|scene| measure(&scene).levels.remove(0));
    let [one, other] = [one, other].map(|level| {
        let local = level.local.expect("regular");
        [
            local.spectral_radius,
            local.parts[1].weighted(),
            level.norms[1].bound.weighted,
            level.norms[1].bound.sharp,
            level.face.inverse_fourth,
            level.thresholds.norm[1].unwrap_or(1.0),
        ]
    });
    for (a, b) in one.into_iter().zip(other) {
        // Iterations end at relative tolerances of 1e-6, whose squares are errors.
        assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
    }
}

#[test]
fn scenes_that_the_theory_does_not_cover_are_refused_by_their_key() {
    let refused = |scene: Scene| match measured(&scene, Path::new(""), Vec::new()) {
        Err(ProblemError::Invalid(invalid)) => invalid.key,
        other => panic!("{other:?}"),
    };
    let mut frictionless = published(2, 1.0);
    frictionless.friction = None;
    assert_eq!(refused(frictionless), "friction");
    let tresca = published(2, 1.0).with_friction(Friction::tresca(1e6));
    assert_eq!(refused(tresca), "friction");
    let mut gap = published(2, 1.0);
    gap.contacts[0].gap = 1e-5.into();
    assert_eq!(refused(gap), "contact.gap");
    let sphere = Obstacle::Sphere(Sphere {
        centre: [1.5, 0.5, -9.0],
        radius: 9.0,
        side: Side::Outside,
    });
    let mut obstacle = published(2, 1.0);
    obstacle.contacts[0].obstacle = Some(sphere);
    assert_eq!(refused(obstacle), "contact.obstacle");
    let mut quadratic = published(2, 1.0);
    quadratic.body = Body::brick([3.0, 1.0, 1.0], [6, 2, 2]).with_element(ElementOrder::P2);
    assert_eq!(refused(quadratic), "body.element");
}

/// Two nodes at F = 3 have several solutions: the one found without following is not the one to which those of small scales lead.
#[test]
fn findings_tell_apart_the_solution_followed_and_the_one_found() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    let text = std::fs::read_to_string(folder.join("two_nodes.toml")).expect("a pipeline");
    let scene = Scene::parse("two nodes", &text).expect("a scene");
    let theory = measured(&scene, &folder, Vec::new()).expect("covered");
    let findings = theory.findings();
    let [radius, _] = findings.rates.expect("a regular solution");
    assert!(radius > 1.0 && findings.contracts.is_none());
    let followed = findings.other_followed().expect("another solution");
    assert!(followed < 1.0, "{findings}");
    assert!(findings.to_string().contains("another solution"));
}

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
    scene.contacts[0].multipliers = MultiplierSpace::Nodal;
    let expected = measure(&scene);
    let folder = tempfile::tempdir().expect("a folder");
    let meshes = [4, 2].map(|n| {
        let mut brick = scene.clone();
        brick.body = published(n, 1.0).body;
        let mesh = Mesh::of_scene(&brick, folder.path()).expect("a mesh");
        let file = PathBuf::from(format!("{n}.msh"));
        std::fs::write(folder.path().join(&file), gmsh(&mesh)).expect("a file");
        GmshFile {
            file,
            unit: 1.0,
            digest: None,
        }
    });
    let refused = measured(&scene, folder.path(), meshes.to_vec());
    assert!(matches!(refused, Err(ProblemError::Invalid(_))));
    scene.body.shape = Shape::Gmsh(meshes[0].clone());
    let found = measured(&scene, folder.path(), meshes.to_vec()).expect("covered");
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
