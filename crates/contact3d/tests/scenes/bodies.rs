//! Two elastic bodies that touch each other: fields that both meshes hold exactly, forces in balance, and one body in the place of two.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    adaptation::{AdaptiveStatus, adapted},
    post::ContactReport,
    scene::{
        AdaptSettings, Body, Clamp, Component, Contact, ElementOrder, FirstMesh, Friction,
        Material, Pressure, Scene, Traction,
    },
    solver::{Solution, Status},
};

const MODULUS: f64 = 1e9;
const POISSON: f64 = 0.3;
const PRESSURE: f64 = 1e6;

/// Two unit blocks of so many cells along each edge, one on the other, the lower one on rollers.
fn stack([lower, upper]: [usize; 2], element: ElementOrder) -> Scene {
    let block = |cells: usize| Body::brick([1.0; 3], [cells; 3]).with_element(element);
    Scene::new(
        block(lower).named("lower"),
        Material::isotropic(MODULUS, POISSON),
    )
    .with_body(block(upper).named("upper").at([0.0, 0.0, 1.0]))
    .with_clamp(Clamp::face("lower.z_min").along(&[Component::Z]))
    .with_clamp(Clamp::face("lower.x_min").along(&[Component::X]))
    .with_clamp(Clamp::face("lower.y_min").along(&[Component::Y]))
    .with_pressure(Pressure::on("upper.z_max", PRESSURE))
    .with_contact(Contact::between("lower.z_max", "upper.z_min"))
}

fn solved(scene: &Scene) -> (AssembledProblem, Solution, ContactReport) {
    let problem = Problem::new(scene.clone()).unwrap_or_else(|error| panic!("{error}"));
    let problem = problem.assemble().expect("a discrete problem");
    let solution = problem.solve(&scene.solve).expect("S is dense");
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    let report = problem.report(&solution).expect("finite loads");
    (problem, solution, report)
}

/// Uniform compression is a field of both meshes, wherever their nodes are and whichever side has the panes; with friction it holds
/// a block that nothing else does.
#[test]
fn uniform_stress_passes_between_meshes_that_do_not_match() {
    for element in [ElementOrder::P1, ElementOrder::P2] {
        // As many panes of one quadratic cell as of 2 x 2 linear ones.
        let per_pane = element.cells_per_pane();
        for cells in [[2, 3], [3, 2], [1, 3]].map(|cells| cells.map(|n| per_pane * n)) {
            for side in ["lower.z_max", "upper.z_min"] {
                let mut scene = stack(cells, element).with_friction(Friction::coulomb(0.3));
                scene.contacts[0].panes_on = Some(side.into());
                let (problem, solution, report) = solved(&scene);
                let (normal, tangential) = problem
                    .system
                    .contact
                    .as_ref()
                    .expect("contact")
                    .coupling
                    .layout
                    .split(&solution.multiplier);
                // Rounding of a hundred panes, 5e-13 measured; quadrature on one side alone leaves 1e-3.
                let pressures = normal.iter().map(|p| (p / PRESSURE - 1.0).abs());
                assert!(pressures.fold(0.0, f64::max) < 1e-10, "{cells:?} {side}");
                let shears = tangential.as_flattened().iter().map(|t| t.abs() / PRESSURE);
                assert!(shears.fold(0.0, f64::max) < 1e-10, "{cells:?} {side}");
                // One pane leaves the upper block a hinge.
                if normal.len() == 1 {
                    continue;
                }
                // Tractions on both faces balance it, so nothing is left to estimate.
                let estimated = report.discretisation_error.relative();
                assert!(estimated < 1e-6, "{cells:?} {side}: {estimated}");
                let strain = PRESSURE / MODULUS;
                let exact =
                    |[x, y, z]: [f64; 3]| [POISSON * x, POISSON * y, -z].map(|u| u * strain);
                let nodes = problem.mesh().coordinates.iter().zip(&report.displacement);
                let off = nodes.flat_map(|(x, u)| {
                    let exact = exact(*x);
                    [0, 1, 2].map(|c| (u[c] - exact[c]).abs() / strain)
                });
                assert!(off.fold(0.0, f64::max) < 1e-10, "{cells:?} {side}");
            }
        }
    }
}

/// A block with a modulus of its own that hangs over the edge of another, pushed sideways.
fn overhanging() -> Scene {
    let stiff = Body::brick([1.0, 1.0, 0.5], [5, 5, 3])
        .with_element(ElementOrder::P2)
        .named("upper")
        .at([0.3, 0.1, 1.0])
        .of(Material::isotropic(3.0 * MODULUS, 0.2));
    let base = Body::brick([1.0; 3], [4, 4, 4]).with_element(ElementOrder::P2);
    Scene::new(base.named("lower"), Material::isotropic(MODULUS, POISSON))
        .with_body(stiff)
        .with_clamp(Clamp::face("lower.z_min"))
        .with_pressure(Pressure::on("upper.z_max", PRESSURE))
        .with_traction(Traction::on("upper.x_min", [2e5, 1e5, 0.0]))
        .with_contact(Contact::between("upper.z_min", "lower.z_max"))
        .with_friction(Friction::coulomb(0.4))
}

#[test]
fn what_one_body_bears_the_other_exerts() {
    let (_, _, report) = solved(&overhanging());
    let of_contact = report.forces.iter().filter(|row| row.source == "contact");
    let forces: Vec<[f64; 3]> = of_contact.map(|row| row.force).collect();
    let [one, other] = forces.as_slice() else {
        panic!("{forces:?}");
    };
    // Sums of products in another order.
    assert!(
        (0..3).all(|c| (one[c] + other[c]).abs() < 1e-13 * PRESSURE),
        "{forces:?}"
    );
    // The load on the upper body alone.
    let load = [1e5, 0.5e5, -PRESSURE];
    let borne =
        |force: &[f64; 3]| (0..3).all(|c| (force[c].abs() - load[c].abs()).abs() < 1e-9 * PRESSURE);
    assert!(borne(one) && borne(other), "{forces:?}");
    assert!(report.resultants.force_imbalance < 1e-12);
    assert!(report.resultants.moment_imbalance < 1e-12);
    assert!(
        report.certificate.worst() < 1e-9,
        "{:?}",
        report.certificate
    );
}

/// Panes on the one side or the other are two discretisations of one problem.
#[test]
fn sides_may_be_swapped() {
    let energy = |side: &str| {
        let mut scene = overhanging();
        scene.contacts[0].panes_on = Some(side.into());
        solved(&scene).2.resultants.strain_energy
    };
    let [upper, lower] = ["upper.z_min", "lower.z_max"].map(energy);
    // Some hundred quadratic elements at an edge: 1.1 % measured, and it falls with the mesh.
    assert!((upper / lower - 1.0).abs() < 0.03, "{upper} {lower}");
}

/// Levels cut both bodies until the estimate meets its target, and the finer mesh agrees about the error of the first.
/// A plate whose corner lies on a corner of four panes, but for rounding, touches the one that it covers: none of the others.
#[test]
fn panes_that_rounding_covers_are_none() {
    let mut placements = 0;
    for n in [3, 5, 6, 7] {
        for (i, j) in (1..n).flat_map(|i| (1..n).map(move |j| (i, j))) {
            // Nodes of the lower block lie at k/(2n).
            let at = |k: usize| 0.1 * k as f64 / n as f64 * 10.0;
            let lower = Body::brick([1.0, 1.0, 0.5], [2 * n, 2 * n, 1]).named("lower");
            let plate = Body::brick([1.0, 1.0, 0.5], [1; 3]).named("plate");
            let mut contact = Contact::between("lower.z_max", "plate.z_min");
            contact.panes_on = Some("lower.z_max".into());
            let scene = Scene::new(lower, Material::isotropic(MODULUS, POISSON))
                .with_body(plate.at([at(i), at(j), 0.5]))
                .with_clamp(Clamp::face("lower.z_min"))
                .with_clamp(Clamp::face("plate.z_max"))
                .with_contact(contact);
            let problem = Problem::new(scene).unwrap_or_else(|error| panic!("{error}"));
            let surface = problem.mesh().contact.as_ref().expect("a contact face");
            assert_eq!(surface.n_panes(), (n - i) * (n - j), "{n} {i} {j}");
            placements += 1;
        }
    }
    assert_eq!(placements, 4 + 16 + 25 + 36);
}

/// A plate covers less than a half of some panes: their triangles beyond its edge, whose nodes have no point opposite, are none of contact.
#[test]
fn triangles_of_contact_have_points_opposite() {
    let lower = Body::brick([1.0, 1.0, 0.5], [4, 4, 2]).named("lower");
    let plate = Body::brick([1.0, 1.0, 0.5], [2; 3]).named("plate");
    let mut contact = Contact::between("lower.z_max", "plate.z_min");
    contact.panes_on = Some("lower.z_max".into());
    let pressed = Clamp {
        value: [0.0, 0.0, -1e-3].map(Into::into),
        ..Clamp::face("plate.z_max")
    };
    let scene = Scene::new(lower, Material::isotropic(MODULUS, POISSON))
        .with_body(plate.at([0.3, 0.0, 0.5]))
        .with_clamp(Clamp::face("lower.z_min"))
        .with_clamp(pressed)
        .with_contact(contact)
        .with_friction(Friction::coulomb(0.9));
    let (problem, _, report) = solved(&scene);
    let surface = problem.mesh().contact.as_ref().expect("a contact face");
    assert_eq!((surface.n_panes(), surface.facets.len()), (4, 24));
    let nodes = surface
        .facets
        .iter()
        .flat_map(|&facet| problem.mesh().facet_nodes(facet));
    assert!(nodes.into_iter().all(|node| surface.nodes.contains(&node)));
    let area: f64 = surface.pane_area.iter().sum();
    assert!((area - 0.7).abs() < 1e-12, "{area}");
    assert!(report.certificate.worst() < 1e-9);
}

#[test]
fn both_bodies_are_refined() {
    let mut scene = stack([4, 6], ElementOrder::P1).with_friction(Friction::coulomb(0.9));
    let top = Clamp {
        value: [2e-4, 0.0, -1e-3].map(Into::into),
        ..Clamp::face("upper.z_max")
    };
    scene.clamps = vec![Clamp::face("lower.z_min"), top];
    scene.pressures.clear();
    let (_, _, first) = solved(&scene);
    scene.adapt = Some(AdaptSettings {
        error: 0.06,
        start: FirstMesh::Scene,
        of: None,
    });
    let (answer, levels) = adapted(scene, Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Met);
    let mesh = answer.problem.mesh();
    let counts = mesh.bodies.iter().map(|body| body.tetrahedra.len());
    let counts: Vec<usize> = counts.collect();
    assert!(counts[0] > 2 * 320 && counts[1] > 2 * 1080, "{counts:?}");
    for body in &mesh.bodies {
        let own = mesh.tetrahedra[body.tetrahedra.clone()].as_flattened();
        assert!(own.iter().all(|node| body.nodes.contains(node)));
    }
    let fine = &answer.report;
    assert!(fine.resultants.force_imbalance < 1e-12);
    // Prescribed displacements and sticking panes: ‖u_h − u‖² is the energy that finer meshes lose.
    let [coarse, energy] = [&first, fine].map(|report| report.resultants.strain_energy);
    let error = (1.0 - energy / coarse).sqrt();
    let effectivity = first.discretisation_error.relative() / error;
    assert!((0.8..1.25).contains(&effectivity), "{effectivity}");
}

/// A block pulled off has no equilibrium, and one that nothing touches is refused.
#[test]
fn bodies_that_nothing_holds_are_told() {
    let mut pulled = stack([4, 4], ElementOrder::P1).with_friction(Friction::coulomb(0.3));
    pulled.pressures[0].value = (-PRESSURE).into();
    let problem = Problem::new(pulled)
        .expect("a scene")
        .assemble()
        .expect("a problem");
    let solution = problem.solve(&problem.scene().solve).expect("S is dense");
    assert_eq!(solution.status, Status::NoEquilibrium);
    let alone = Body::brick([1.0; 3], [2, 2, 2])
        .named("alone")
        .at([9.0, 0.0, 0.0]);
    let scene = stack([4, 4], ElementOrder::P1).with_body(alone);
    let refusal = Problem::new(scene)
        .and_then(Problem::assemble)
        .expect_err("free")
        .to_string();
    assert!(
        refusal.contains("of the body alone: free: translation along x"),
        "{refusal}"
    );
}
