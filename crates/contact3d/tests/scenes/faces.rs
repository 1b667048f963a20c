//! Several contact faces: closed forms that equilibrium alone gives, and one face described in two ways.

use std::path::Path;

use crate::smallest_eigenvalue;
use contact3d::{
    AssembledProblem, Problem,
    contact::{MultiplierLayout, transferred},
    mesh::{Mesh, RefinableBody},
    post::{ContactReport, FaceResultants, Zone},
    scene::{
        Body, Clamp, Component, Contact, DualOperatorKind, ElementOrder, Friction, InnerSolver,
        Material, Method, Pressure, Scene, SolveSettings, Traction,
    },
    solver::Solution,
};

const STEEL: (f64, f64) = (21.19e10, 0.277);

fn brick(size: [f64; 3], cells: [usize; 3]) -> Scene {
    let (young, poisson) = STEEL;
    let mut scene = Scene::new(
        Body::brick(size, cells),
        Material::isotropic(young, poisson),
    );
    scene.assemble.dual_operator = DualOperatorKind::Explicit;
    scene
}

fn solved(scene: &Scene) -> (AssembledProblem, Solution, ContactReport) {
    let problem = Problem::new(scene.clone()).unwrap_or_else(|error| panic!("{error}"));
    let problem = problem.assemble().expect("a discrete problem");
    let solution = problem.solve(&scene.solve).expect("S is dense");
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    let report = problem.report(&solution).expect("finite loads");
    // A solve to 1e-12; the figures are sums over some hundred panes of differences that cancel.
    assert!(
        report.certificate.worst() < 1e-8,
        "{:?}",
        report.certificate
    );
    (problem, solution, report)
}

/// Every pane of the face slides.
fn slides(face: &FaceResultants) -> bool {
    face.zone_counts[0] == 0 && face.zone_counts[1] == 0
}

/// A block between two plates, in plane strain along y, pushed along −x against a clamp.
fn between_plates(lower: Friction, upper: Friction) -> Scene {
    brick([2.0, 1.0, 1.0], [8, 4, 4])
        .with_clamp(Clamp::face("x_min").along(&[Component::X]))
        .with_clamp(Clamp::face("y_min").along(&[Component::Y]))
        .with_clamp(Clamp::face("y_max").along(&[Component::Y]))
        .with_clamp(Clamp::inside([[0.0, 0.0, 0.5], [0.0, 1.0, 0.5]]).along(&[Component::Z]))
        .with_pressure(Pressure::on("x_max", 1e8))
        .with_contact(Contact::on("z_min").named("lower").with_friction(lower))
        .with_contact(Contact::on("z_max").named("upper").with_friction(upper))
}

/// Without friction the block between plates has one stress: σ_x = −p and, with ε_y = ε_z = 0, σ_z = −p ν/(1 − ν), which linear
/// displacements hold exactly.
#[test]
fn a_block_between_smooth_plates_presses_them_by_poissons_ratio() {
    let mut scene = between_plates(Friction::default(), Friction::default());
    for contact in &mut scene.contacts {
        contact.friction = None;
    }
    let (problem, solution, report) = solved(&scene);
    let expected = 1e8 * STEEL.1 / (1.0 - STEEL.1);
    assert_eq!(solution.multiplier.len(), problem.n_panes());
    for pressure in &solution.multiplier {
        // The condition of S times rounding.
        assert!((pressure / expected - 1.0).abs() < 1e-10, "{pressure}");
    }
    let [lower, upper] = report.faces[..] else {
        panic!("two faces")
    };
    for (face, sign) in [(lower, 1.0), (upper, -1.0)] {
        assert_eq!(face.contact.tangential_force, None);
        let [x, y, z] = face.contact.contact_force;
        assert!((z / (sign * expected * 2.0) - 1.0).abs() < 1e-10, "{z}");
        assert!(x.abs().max(y.abs()) < 1e-9 * z.abs());
    }
}

/// All of the block slides towards the clamp, so that the foundation's forces are known from the normal ones: what the clamp
/// bears is the push less μ N of the lower plate and g times the area of the upper one, on any mesh.
#[test]
fn a_block_between_rough_plates_is_held_by_the_friction_of_both() {
    for (lower, upper, strength) in [
        (Friction::coulomb(0.2), Friction::coulomb(0.05), [0.2, 0.05]),
        (
            Friction::coulomb(0.1),
            Friction::tresca(2e6),
            [0.1, f64::NAN],
        ),
        (
            Friction::tresca(1e6),
            Friction::coulomb(0.15),
            [f64::NAN, 0.15],
        ),
    ] {
        let (_, _, report) = solved(&between_plates(lower.clone(), upper.clone()));
        let mut friction = 0.0;
        for (face, (law, coefficient)) in
            report.faces.iter().zip([lower, upper].iter().zip(strength))
        {
            assert!(slides(face), "{:?}", face.zone_counts);
            friction += match law.slip_bound.as_ref().and_then(|g| g.constant()) {
                Some(bound) => 2.0 * bound,
                None => coefficient * face.contact.normal_force,
            };
        }
        let clamp = report.resultants.clamp_force[0];
        // Sums of some hundred forces of a solve to 1e-12.
        assert!(
            (clamp / (1e8 - friction) - 1.0).abs() < 1e-9,
            "{clamp} {friction}"
        );
    }
}

/// A slab in plane strain along y on a foundation of which one half is dry and the other greased, pulled from a clamp by more
/// than friction holds.
fn halves(dry: Option<Friction>, greased: Option<Friction>) -> Scene {
    let contact = |name: &str, from: f64, to: f64, law: Option<Friction>| Contact {
        friction: law,
        ..Contact::on("z_min")
            .named(name)
            .inside([[from, 0.0, 0.0], [to, 1.0, 0.0]])
    };
    brick([3.0, 1.0, 0.5], [12, 4, 2])
        .with_clamp(Clamp::face("x_min").along(&[Component::X]))
        .with_clamp(Clamp::face("y_min").along(&[Component::Y]))
        .with_clamp(Clamp::face("y_max").along(&[Component::Y]))
        .with_clamp(Clamp::inside([[0.0, 0.0, 0.25], [0.0, 1.0, 0.25]]).along(&[Component::Z]))
        .with_pressure(Pressure::on("z_max", 1e7))
        .with_traction(Traction::on("x_max", [5e7, 0.0, 0.0]))
        .with_contact(contact("dry", 0.0, 1.5, dry))
        .with_contact(contact("greased", 1.5, 3.0, greased))
}

#[test]
fn a_dry_and_a_greased_half_resist_by_their_own_coefficients() {
    let scene = halves(Some(Friction::coulomb(0.6)), Some(Friction::coulomb(0.05)));
    let (_, _, report) = solved(&scene);
    let mut resisted = 0.0;
    for (face, coefficient) in report.faces.iter().zip([0.6, 0.05]) {
        assert_eq!(face.zone_counts[1], 0, "no pane sticks");
        let [first, second] = face.contact.tangential_force.expect("friction");
        let friction = coefficient * face.contact.normal_force;
        // Sums of some ten forces of a solve to 1e-12.
        assert!((first / friction - 1.0).abs() < 1e-9, "{first} {friction}");
        assert!(second.abs() < 1e-9 * first);
        resisted += friction;
    }
    let clamp = report.resultants.clamp_force[0];
    assert!(
        (clamp / (resisted - 2.5e7) - 1.0).abs() < 1e-9,
        "{clamp} {resisted}"
    );
}

/// Two halves with one law are one face: the same multipliers, in another order, whatever the law and its method.
#[test]
fn halves_with_one_law_are_the_whole_face() {
    for (law, element) in [
        (Friction::coulomb(0.3), ElementOrder::P1),
        (Friction::coulomb(0.3).capped(8e6), ElementOrder::P1),
        (Friction::tresca(3e6), ElementOrder::P1),
        (Friction::coulomb(0.3), ElementOrder::P2),
    ] {
        let with = |scene: Scene| Scene {
            bodies: vec![scene.bodies[0].clone().with_element(element)],
            ..scene
        };
        let split = with(halves(Some(law.clone()), Some(law.clone())));
        let mut whole = split.clone();
        whole.contacts = vec![Contact::on("z_min").with_friction(law)];
        let ((_, in_parts, _), (problem, together, _)) = (solved(&split), solved(&whole));
        let surface = problem.mesh().contact.as_ref().expect("contact");
        let n = surface.n_panes();
        // Panes are numbered along x, then y: each row has its dry half first.
        let row = 12 / element.cells_per_pane();
        let moved = |pane: usize| {
            let (along, across) = (pane % row, pane / row);
            let half = row / 2;
            along / half * (n / 2) + across * half + along % half
        };
        let layout = MultiplierLayout::new(n, n);
        let size = together
            .multiplier
            .iter()
            .fold(0.0, |m: f64, l| m.max(l.abs()));
        for pane in 0..n {
            let pair = layout.pair(&together.multiplier, pane);
            let other = layout.pair(&in_parts.multiplier, moved(pane));
            let normal = together.multiplier[pane] - in_parts.multiplier[moved(pane)];
            for difference in [normal, pair[0] - other[0], pair[1] - other[1]] {
                // Both are solved to 1e-12.
                assert!(difference.abs() < 1e-9 * size, "{difference} of {size}");
            }
        }
    }
}

/// A frictionless half has no tangential unknowns, and answers as one with a slip bound of zero, which has them.
#[test]
fn a_frictionless_half_is_one_with_no_slip_bound() {
    let without = halves(None, Some(Friction::coulomb(0.3)));
    let zero = halves(Some(Friction::tresca(0.0)), Some(Friction::coulomb(0.3)));
    let ((problem, without, report), (_, zero, other)) = (solved(&without), solved(&zero));
    let n = problem.n_panes();
    assert_eq!(without.multiplier.len(), n + n);
    assert_eq!(zero.multiplier.len(), 3 * n);
    assert_eq!(
        report
            .panes
            .iter()
            .filter(|pane| pane.friction.is_none())
            .count(),
        n / 2
    );
    // Faces with friction come first.
    for (a, b) in [(0, 1), (1, 0)] {
        let (a, b) = (report.faces[a].contact, other.faces[b].contact);
        assert!((a.normal_force / b.normal_force - 1.0).abs() < 1e-10);
    }
    assert_eq!(other.faces[0].contact.tangential_force, Some([0.0; 2]));
}

/// A law capped at a pressure that all panes exceed is a given slip bound.
#[test]
fn a_cap_below_all_pressures_is_a_given_slip_bound() {
    let pressed = |law: Friction| Scene {
        pressures: vec![Pressure::on("z_max", 5e7)],
        ..halves(Some(law), Some(Friction::coulomb(0.1)))
    };
    let capped = pressed(Friction::coulomb(1.0).capped(1e5));
    let given = pressed(Friction::tresca(1e5));
    let ((_, capped, report), (_, given, _)) = (solved(&capped), solved(&given));
    let least = report.panes.iter().map(|pane| -pane.normal_stress);
    assert!(
        least.fold(f64::INFINITY, f64::min) > 1e5,
        "every pane is pressed by more than the cap"
    );
    let size = given
        .multiplier
        .iter()
        .fold(0.0, |m: f64, l| m.max(l.abs()));
    for (a, b) in capped.multiplier.iter().zip(&given.multiplier) {
        assert!((a - b).abs() < 1e-9 * size, "{a} {b}");
    }
}

/// A block pressed into a corner.
fn corner(floor: Option<Friction>, wall: Option<Friction>) -> Scene {
    let contact = |face: &str, name: &str, law: Option<Friction>| Contact {
        friction: law,
        ..Contact::on(face).named(name)
    };
    brick([1.0, 1.0, 1.0], [4, 4, 4])
        .with_clamp(Clamp::face("y_min").along(&[Component::Y]))
        .with_clamp(Clamp::face("x_max").along(&[Component::X]))
        .with_clamp(Clamp::inside([[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]).along(&[Component::Z]))
        .with_traction(Traction::on("z_max", [-2e7, 0.0, -3e7]))
        .with_contact(contact("z_min", "floor", floor))
        .with_contact(contact("x_min", "wall", wall))
}

/// Panes of both faces act on the nodes of the edge between them, and S stays definite: each pane has a free node of its own.
#[test]
fn an_edge_in_two_contacts_keeps_its_operator_definite() {
    let apart = halves(Some(Friction::coulomb(0.3)), Some(Friction::coulomb(0.3)));
    let [corner_block, apart] = [
        corner(Some(Friction::coulomb(0.3)), Some(Friction::coulomb(0.4))),
        apart,
    ]
    .map(|scene| {
        let problem = Problem::new(scene)
            .expect("a brick")
            .assemble()
            .expect("a discrete problem");
        let contact = problem.system.contact.as_ref().expect("contact");
        smallest_eigenvalue(contact.explicit().expect("S is dense"))
    });
    // On one plane panes meet at edges as well: as far from singular, within a small factor.
    assert!(corner_block > 0.2 * apart, "{corner_block} {apart}");
    // So rough that both faces stick at the edge.
    let (_, _, report) = solved(&corner(
        Some(Friction::coulomb(2.0)),
        Some(Friction::coulomb(2.0)),
    ));
    assert!(report.count(Zone::Stick) > report.panes.len() / 2);
    let [floor, wall] = report.faces[..] else {
        panic!("two faces")
    };
    let r = &report.resultants;
    for c in 0..3 {
        let sum = floor.contact.contact_force[c] + wall.contact.contact_force[c];
        let forces = sum + r.applied_force[c] + r.clamp_force[c];
        assert!(forces.abs() < 1e-9 * 3e7, "{forces}");
        let of_faces = report
            .forces
            .iter()
            .filter(|force| force.source.starts_with("contact."));
        let moment: f64 = of_faces.map(|force| force.moment[c]).sum();
        assert!((moment - r.moments[0][c]).abs() < 1e-9 * 3e7, "{moment}");
    }
}

/// Every method takes faces of different laws, one of them without tangential unknowns.
#[test]
fn all_methods_agree_on_mixed_laws() {
    let hardening = contact3d::scene::Coefficient::ramp(0.2, 0.4, 1e-6, 3e4);
    let mut scene = corner(
        Some(Friction::coulomb(hardening)),
        Some(Friction::tresca(2e6)),
    );
    scene = scene.with_contact(Contact::on("y_max").named("smooth"));
    let (problem, newton, _) = solved(&scene);
    assert_eq!(newton.multiplier.len(), 7 * problem.n_panes() / 3);
    let size = newton
        .multiplier
        .iter()
        .fold(0.0, |m: f64, l| m.max(l.abs()));
    for inner in [InnerSolver::Kprgp, InnerSolver::Gpcg, InnerSolver::Newton] {
        let settings = SolveSettings {
            method: Method::FixedPoint,
            inner,
            epsilon: Some(1e-10),
            ..SolveSettings::default()
        };
        let other = problem.solve(&settings).expect("S is dense");
        assert!(other.status.is_solved(), "{inner:?}: {:?}", other.status);
        for (a, b) in newton.multiplier.iter().zip(&other.multiplier) {
            // Successive approximations end where a step changes less than 1e-10; they contract by more than a half here.
            assert!((a - b).abs() < 1e-8 * size, "{inner:?}: {a} {b}");
        }
    }
}

/// The key that a scene is refused at.
fn refused(scene: Scene) -> String {
    match Problem::new(scene) {
        Err(contact3d::ProblemError::Invalid(invalid)) => invalid.key,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused"),
    }
}

#[test]
fn contacts_that_cannot_be_are_refused_by_their_keys() {
    let rough = || Some(Friction::coulomb(0.3));
    type Change = fn(&mut Scene);
    let cases: &[(Change, &str)] = &[
        (|s| s.contacts[1].corners = None, "contact.1.face"),
        (
            |s| s.contacts[1].corners = s.contacts[0].corners,
            "contact.1.box",
        ),
        (
            |s| s.contacts[1].corners = Some([[1.6, 0.0, 0.0], [3.0, 1.0, 0.0]]),
            "contact.1.box",
        ),
        // Along cells, but through a pane of 2 x 2 of them.
        (
            |s| s.contacts[1].corners = Some([[1.75, 0.0, 0.0], [3.0, 1.0, 0.0]]),
            "contact.1.box",
        ),
        (
            |s| s.contacts[1].corners = Some([[1.5, 0.0, 0.1], [3.0, 1.0, 0.2]]),
            "contact.1.box",
        ),
        (
            |s| s.contacts[1].corners = Some([[3.0, 0.0, 0.0], [1.5, 1.0, 0.0]]),
            "contact.1.box",
        ),
        (
            |s| {
                s.contacts
                    .iter_mut()
                    .for_each(|contact| contact.name = None)
            },
            "contact.1.name",
        ),
        (
            |s| s.contacts[1].name = Some("two\nlines".into()),
            "contact.1.name",
        ),
        (|s| s.contacts[1].face = "z_middle".into(), "contact.1.face"),
        (|s| s.contacts[1].gap = (-1.0).into(), "contact.1.gap"),
        (
            |s| s.contacts[1].friction = Some(Friction::default()),
            "contact.1.friction",
        ),
        (|s| s.friction = Some(Friction::coulomb(0.2)), "friction"),
        (
            |s| s.contacts.push(Contact::on("z_max").named("third")),
            "pressure.0.face",
        ),
        (
            |s| s.contacts.push(Contact::on("x_min").named("third")),
            "clamp.0.face",
        ),
    ];
    for (change, key) in cases {
        let mut scene = halves(rough(), rough());
        change(&mut scene);
        assert_eq!(refused(scene), *key);
    }
    let odd = Scene {
        bodies: vec![Body::brick([1.0, 1.0, 1.0], [4, 4, 3])],
        ..between_plates(Friction::coulomb(0.3), Friction::coulomb(0.3))
    };
    assert_eq!(refused(odd), "body.brick.cells");
}

/// A node of two frictional nodal faces would carry six conditions on three displacements; frictionless ones carry two.
#[test]
fn nodal_faces_that_meet_are_refused_where_a_node_would_carry_too_much() {
    let nodal = |law: Option<Friction>, both: bool| {
        let mut scene = corner(law, None);
        scene.contacts[0].multipliers = contact3d::scene::MultiplierSpace::Nodal;
        if both {
            scene.contacts[1].multipliers = contact3d::scene::MultiplierSpace::Nodal;
        }
        scene
    };
    assert_eq!(
        refused(nodal(Some(Friction::coulomb(0.3)), true)),
        "contact.1.multipliers"
    );
    for scene in [
        nodal(None, true),
        nodal(Some(Friction::coulomb(0.3)), false),
    ] {
        let (_, _, report) = solved(&scene);
        assert_eq!(report.faces.len(), 2);
    }
}

/// F/G = (tan α + μ)/(1 − μ tan α) holds a block on a slope in the balance; what a push exceeds it by, a soft end bears.
#[test]
fn a_block_is_pushed_up_a_slope_by_the_force_of_its_friction_angle() {
    let (alpha, mu, weight) = (20_f64.to_radians(), 0.3, 1e6);
    let limit = weight * (alpha.tan() + mu) / (1.0 - mu * alpha.tan());
    for excess in [1.02, 1.01] {
        let push = excess * limit;
        let block = |value: f64| {
            let text = format!("if(x < 2, {value:?}, 0)");
            contact3d::scene::Quantity::formula(&text).expect("a formula")
        };
        let scene = brick([3.0, 1.0, 0.5], [12, 4, 2])
            .with_region(
                contact3d::scene::Part::Box([[2.0, 0.0, 0.0], [3.0, 1.0, 0.5]]),
                Material::isotropic(STEEL.0 * 1e-6, 0.0),
            )
            .with_clamp(Clamp::face("x_max"))
            .with_clamp(Clamp::face("y_min").along(&[Component::Y]))
            .with_clamp(Clamp::face("y_max").along(&[Component::Y]))
            .with_body_force([
                block(-weight * alpha.sin()),
                0.0.into(),
                block(-weight * alpha.cos()),
            ])
            .with_traction(Traction::on(
                "x_min",
                [2.0 * push * alpha.cos(), 0.0, -2.0 * push * alpha.sin()],
            ))
            .with_contact(Contact::on("z_min").inside([[0.0, 0.0, 0.0], [2.0, 1.0, 0.0]]))
            .with_friction(Friction::coulomb(mu));
        let (_, _, report) = solved(&scene);
        assert_eq!(report.count(Zone::Stick), 0);
        let expected = (push - limit) * (alpha.cos() - mu * alpha.sin());
        let held = report.resultants.clamp_force[0];
        // The soft end also bears a millionth of what its shear and the block's tilt ask for.
        assert!((held + expected).abs() < 1e-5 * weight, "{held} {expected}");
    }
}

/// On a finer mesh each face starts from its own stresses, in tetrahedra with sides on two faces too.
#[test]
fn stresses_of_each_face_go_to_the_same_face_of_a_finer_mesh() {
    for nodal in [false, true] {
        let mut scene = corner(None, Some(Friction::coulomb(0.3)));
        if nodal {
            scene.contacts[0].multipliers = contact3d::scene::MultiplierSpace::Nodal;
        }
        let mut body = RefinableBody::new(&scene, Path::new("")).expect("a brick");
        let coarse = body.mesh().expect("a mesh");
        body.refine(&vec![1; body.n_tetrahedra()]);
        let fine = body.mesh().expect("a mesh");
        // The wall has friction and comes first.
        let stresses = |mesh: &Mesh| -> Vec<f64> {
            let surface = mesh.contact.as_ref().expect("contact");
            let [wall, floor] = [0, 1].map(|face| surface.faces[face].panes.len());
            let normal = [vec![1.0; wall], vec![2.0; floor]].concat();
            [normal, [10.0, 20.0].repeat(wall)].concat()
        };
        let start = transferred(&coarse, &fine, &body.parents(), &stresses(&coarse));
        for (found, expected) in start.iter().zip(&stresses(&fine)) {
            // Means of equal numbers, weighted by areas.
            assert!(
                (found - expected).abs() < 1e-14 * expected,
                "{found} {expected}"
            );
        }
        assert_eq!(start.len(), stresses(&fine).len());
    }
}
