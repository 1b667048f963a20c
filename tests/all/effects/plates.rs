//! A block between two plates that nothing else holds.

use contact3d::{
    AssembledProblem, Problem,
    scene::Scene,
    solver::{Solution, Status},
};

const YOUNG: f64 = 2e11;
const POISSON: f64 = 0.3;
/// Pressure on the two ends in Pa, which widens the block against the plates.
const ENDS: f64 = 1e8;

/// A block 2 × 1 × 1 m pressed along x, between plates below and above; its six rigid motions are left to them.
fn between(multipliers: &str, element: &str, law: &str, more: &str) -> AssembledProblem {
    let plates = ["z_min", "z_max"].map(|face| {
        format!("[[contact]]\nface = '{face}'\nmultipliers = '{multipliers}'\n{law}\n")
    });
    let ends =
        ["x_min", "x_max"].map(|face| format!("[[pressure]]\nface = '{face}'\nvalue = {ENDS:e}\n"));
    scene(
        element,
        [8, 4, 4],
        1.0,
        &[more, &ends.concat(), &plates.concat()].concat(),
    )
}

fn scene(element: &str, cells: [usize; 3], height: f64, rest: &str) -> AssembledProblem {
    let cells = match element {
        "P1" => cells,
        _ => cells.map(|n| n / 2),
    };
    let text = format!(
        "title = 'plates'
        [body]
        element = '{element}'
        [body.brick]
        size = [2.0, 1.0, {height:?}]
        cells = {cells:?}
        [material.isotropic]
        young_modulus = {YOUNG:e}
        poisson_ratio = {POISSON}
        {rest}"
    );
    let scene = Scene::parse("plates", &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let problem = Problem::new(scene).and_then(|problem| problem.assemble());
    problem.unwrap_or_else(|error| panic!("{error}"))
}

fn solved(problem: &AssembledProblem) -> Solution {
    problem.solve(&problem.scene().solve).expect("S is dense")
}

/// Smooth plates: σ_x = −p, σ_y = 0 and u_z = 0 at both, so that σ_z = −ν p everywhere.
#[test]
fn smooth_plates_bear_poissons_ratio_of_the_pressure() {
    for (multipliers, element) in [
        ("panes", "P1"),
        ("nodal", "P1"),
        ("panes", "P2"),
        ("nodal", "P2"),
    ] {
        let problem = between(multipliers, element, "", "");
        let floating = problem.system.assembly.primal.rigid_modes.as_ref();
        assert_eq!(floating.map(|body| body.n_modes()), Some(6));
        let solution = solved(&problem);
        assert_eq!(
            solution.status,
            Status::Converged,
            "{multipliers} {element}"
        );
        for pressure in &solution.multiplier {
            // The displacement is linear; the condition of S times rounding.
            assert!(
                (pressure / (POISSON * ENDS) - 1.0).abs() < 1e-10,
                "{pressure:e}"
            );
        }
        let report = problem.report(&solution).expect("finite loads");
        assert!(
            report.certificate.worst() < 1e-9,
            "{:?}",
            report.certificate
        );
        // The whole is shorter by p (1 − ν²) L / E and wider across.
        let ends = |face: f64| {
            let nodes = problem.mesh().coordinates.iter().zip(&report.displacement);
            nodes
                .filter(|(x, _)| x[0] == face)
                .map(|(_, u)| u[0])
                .collect::<Vec<_>>()
        };
        let shorter = ends(0.0)[0] - ends(2.0)[0];
        let expected = ENDS * (1.0 - POISSON * POISSON) * 2.0 / YOUNG;
        assert!(
            (shorter / expected - 1.0).abs() < 1e-9,
            "{shorter:e} {expected:e}"
        );
    }
}

/// Rough plates, without weight: the upper half mirrors the lower one, which is a block of half the height on rollers along its middle.
#[test]
fn rough_plates_are_one_plate_and_a_plane_of_symmetry() {
    let law = "friction.coefficient.constant = 0.2";
    let whole = between("panes", "P1", law, "");
    let rollers = format!(
        "[[pressure]]\nface = 'x_min'\nvalue = {ENDS:e}\n[[pressure]]\nface = 'x_max'\nvalue = {ENDS:e}\n\
         [[clamp]]\nface = 'z_max'\ncomponents = ['z']\n[contact]\nface = 'z_min'\n[friction]\ncoefficient.constant = 0.2"
    );
    let half = scene("P1", [8, 4, 2], 0.5, &rollers);
    let [both, one] = [&whole, &half].map(solved);
    assert!(both.status.is_solved() && one.status.is_solved());
    let panes = half.n_panes();
    for pane in 0..panes {
        let [lower, alone] = [both.multiplier[pane], one.multiplier[pane]];
        let upper = both.multiplier[panes + pane];
        // Two solves to rounding of bodies that slide on one third of their panes.
        assert!(
            (lower - alone).abs() < 1e-9 * POISSON * ENDS,
            "{lower:e} {alone:e}"
        );
        assert!(upper > 0.0);
    }
    let report = whole.report(&both).expect("finite loads");
    let [lower, upper] = report.faces[..] else {
        panic!("two faces")
    };
    let balance = lower.contact.normal_force / upper.contact.normal_force - 1.0;
    assert!(balance.abs() < 1e-10, "{balance:e}");
    assert!(
        lower.zone_counts[2] > 0,
        "the ends slide: {:?}",
        lower.zone_counts
    );
}

/// Given slip bounds g on both plates hold a push of 2 g A and no more, in any direction.
#[test]
fn two_plates_hold_twice_what_one_does() {
    let bound = 1e5;
    for share in [1.0 - 1e-6, 1.0 + 1e-6] {
        // On the volume of 2 m³ for two plates of 2 m² each.
        let push = 2.0 * bound * share;
        let along = [0.8 * push, 0.6 * push];
        let force = format!(
            "[body_force]\nvalue = [{:e}, {:e}, 0.0]\n",
            along[0], along[1]
        );
        let problem = between(
            "panes",
            "P1",
            &format!("friction.slip_bound = {bound:e}"),
            &force,
        );
        let solution = solved(&problem);
        if share > 1.0 {
            assert_eq!(solution.status, Status::NoEquilibrium);
            continue;
        }
        assert!(solution.status.is_solved(), "{:?}", solution.status);
        let report = problem.report(&solution).expect("finite loads");
        let mut sum = [0.0; 3];
        for face in &report.faces {
            sum = std::array::from_fn(|c| sum[c] + face.contact.contact_force[c]);
        }
        for (force, along) in sum.iter().zip(along) {
            // Sums of 64 forces of size 1e5 N; the volume is 2 m³.
            assert!((force / (-2.0 * along) - 1.0).abs() < 1e-9, "{force:e}");
        }
    }
}
