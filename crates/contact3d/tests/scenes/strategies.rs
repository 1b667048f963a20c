//! Problems to which only one start strategy leads, each of a kind that once had no solution here.

use contact3d::{
    Problem,
    post::ContactReport,
    scene::{Scene, SolveSettings},
    solver::Solution,
};

pub(super) fn solved(text: &str) -> (Solution, ContactReport) {
    let scene = Scene::parse("strategy", text).unwrap_or_else(|error| panic!("{error}"));
    let problem = Problem::new(scene).and_then(Problem::assemble);
    let problem = problem.unwrap_or_else(|error| panic!("{error}"));
    let settings = SolveSettings::default();
    problem.solve_and_report(&settings).expect("a solve")
}

/// The rigid motion along a rough wall that opens is free, and so is that along a face of two panes without slip: Newton's method alone
/// lets both run away. The weight rests on the floor, to the digits that λ has.
#[test]
fn bodies_whose_panes_leave_a_motion_free_rest_by_the_proximal_point_method() {
    let block = |cells, rest: &str| {
        format!(
            "title = 'free motion'
            body.brick = {{ size = [1.0, 1.0, 1.0], cells = {cells} }}
            {rest}"
        )
    };
    let beside_wall = block(
        "[3, 3, 2]",
        "body.element = 'P2'
        material.isotropic = { young_modulus = 1.8e7, poisson_ratio = 0.3 }
        body_force.value = [0.0, 0.0, -22.0]
        clamp = [{ face = 'x_min', components = ['x'] }]
        [[contact]]
        face = 'z_min'
        [[contact]]
        face = 'y_max'
        friction.coefficient.constant = 0.1",
    );
    let two_panes = block(
        "[2, 4, 4]",
        "material.isotropic = { young_modulus = 1e6, poisson_ratio = 0.3 }
        body_force.value = [0.0, 0.0, -100.0]
        contact.face = 'z_min'
        friction.coefficient.constant = 0.1",
    );
    for (text, weight) in [(beside_wall, 22.0), (two_panes, 100.0)] {
        let (solution, report) = solved(&text);
        assert!(solution.status.is_solved(), "{}", solution.status.word());
        let force = report.resultants.contact.expect("contact").contact_force;
        // Statics, to what refinement leaves of λ: 1e-10 or better.
        assert!((force[2] - weight).abs() < 1e-8 * weight, "{force:?}");
        assert!(report.certificate.worst() < 1e-8);
    }
}

/// Coefficients that rise within 2e-7 m of slips up to a millimetre, and within 3e-10 m of slips of 4 mm, less than 1e-7 of them: some node
/// lies on the rise, and to the second solution only ever narrower rises lead, which λ alone then loses.
#[test]
fn a_steep_rise_of_friction_is_met_with_coefficients_as_unknowns() {
    let steep = "title = 'steep rise'
        body.brick = { size = [3.0, 1.0, 1.0], cells = [4, 4, 2] }
        material.isotropic = { young_modulus = 1e9, poisson_ratio = 0.3 }
        clamp = [{ face = 'x_min' }]
        pressure = [{ face = 'z_max', value = 1.26879e+06 }]
        traction = [{ face = 'x_max', value = [184925, -131829, 127579] }]
        contact = { face = 'z_min', angle = 25.3 }
        friction.coefficient.ramp = { initial = 0.000367475, residual = 0.168468, onset = 0.00157207, rate = 1e6 }";
    let steepest = "title = 'a step'
        body.element = 'P2'
        body.brick = { size = [3.0, 1.0, 1.0], cells = [5, 2, 2] }
        material.isotropic = { young_modulus = 1e9, poisson_ratio = 0.0 }
        clamp = [{ face = 'z_max', value = [0.00372844, -0.000811602, -0.00393667] }]
        traction = [{ face = 'x_max', value = [-219227, 368276, 261594] }]
        contact = { face = 'z_min', multipliers = 'panes', angle = 61.43 }
        friction.coefficient.ramp = { initial = 0.00796839, residual = 7.37826, onset = 0.00017807, rate = 2.37548e+10 }";
    for text in [steep, steepest] {
        let (solution, report) = solved(text);
        // Converged, or as near as rounding lets a rise this steep.
        assert!(solution.status.is_solved(), "{}", solution.status.word());
        // Successive approximations, which solve with frozen friction, stay where they are: the certificate of any method. A rise of 1e6/m
        // turns a rounding of 1e-16 m of slips of 1e-3 m into 1e-7 of the coefficient 1e-3, one of 2.4e10/m that of slips of 4e-3 m,
        // 9e-19 m, into 2e-7 of the coefficient 0.12.
        let friction = solution.friction.expect("Coulomb's law");
        let change = friction.mapping_change.expect("a solution");
        assert!(change < 1e-6, "{change:e}");
        assert!(report.certificate.worst() < 1e-6);
    }
}

/// A strip 500 thicknesses long, whose tip would sink by 9 m if a floor that is wavy by a micrometre did not hold it: S has a condition of
/// 1e11, and h is known to 150 times the gap. By an active set method on [A Bᵀ; B 0] the floor carries 64.9 N.
#[test]
fn gaps_of_a_slender_strip_keep_their_digits() {
    let strip = |along: f64, friction: &str| {
        format!(
            "title = 'strip'
            body.element = 'P2'
            body.brick = {{ size = [100.0, 1.0, 0.2], cells = [20, 2, 1] }}
            material.isotropic = {{ young_modulus = 8.0594e8, poisson_ratio = 0.3 }}
            clamp = [{{ face = 'x_min' }}]
            body_force.value = [{along}, 0.0, -3.3991]
            contact = {{ face = 'z_min', multipliers = 'nodal', gap = '7.267469359152741e-07*(1 + cos(0.03084214042701261*x))' }}
            {friction}"
        )
    };
    for text in [
        strip(0.0, ""),
        strip(0.5, "friction.coefficient.constant = 0.3"),
    ] {
        let (solution, report) = solved(&text);
        assert!(solution.status.is_solved(), "{}", solution.status.word());
        assert!(solution.accuracy < 1e-9, "{}", solution.accuracy);
        let force = report.resultants.contact.expect("contact").contact_force;
        assert!((force[2] - 64.9).abs() < 0.1, "{force:?}");
    }
}
