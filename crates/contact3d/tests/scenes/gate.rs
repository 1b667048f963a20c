//! The gate that every answer passes: what a certificate contradicts is no success, and right answers pass it.

use contact3d::solver::Status;

use super::strategies::solved;

/// A block that only vertical springs and friction hold, pushed at three times what friction can bear: nothing holds it, and
/// multipliers that fit each other to 1e-14 are no answer while the body flies.
#[test]
fn a_block_pushed_beyond_friction_is_no_success() {
    let (solution, _) = solved(
        "title = 'pushed off'
        body.brick = { size = [1.0, 1.0, 0.5], cells = [4, 4, 2] }
        material.isotropic = { young_modulus = 1e9, poisson_ratio = 0.3 }
        body_force.value = [-3000.0, -400.0, -1e4]
        spring = [{ face = 'z_max', normal = 2.4e7 }]
        contact = { face = 'z_min', multipliers = 'nodal' }
        friction.coefficient.constant = 0.1",
    );
    assert!(!solution.status.is_solved(), "{:?}", solution.status);
}

/// Pressed straight down nothing slides: slips of rounding are none, and do not cry wolf.
#[test]
fn slips_of_rounding_are_none() {
    let (solution, report) = solved(
        "title = 'pressed'
        body.brick = { size = [3.0, 1.0, 1.0], cells = [2, 2, 2] }
        material.isotropic = { young_modulus = 2.119e11, poisson_ratio = 0.277 }
        clamp = [{ face = 'z_max', value = [0.0, 0.0, -1e-5] }]
        contact.face = 'z_min'
        friction.coefficient.constant = 0.3",
    );
    assert_eq!(solution.status, Status::Converged);
    // Rounding of some tens of terms.
    assert!(
        report.certificate.worst() < 1e-13,
        "{:?}",
        report.certificate
    );
}

/// A frictional face that nothing touches has no slip bound to exceed; what rounding leaves there is measured by the stress that
/// rounding of the displacement would make.
#[test]
fn unloaded_frictional_faces_do_not_cry_wolf() {
    let (solution, report) = solved(
        "title = 'lifted'
        body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
        material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
        clamp = [{ face = 'z_max', value = [1e-5, 0.0, 1e-4] }]
        contact.face = 'z_min'
        friction.coefficient.constant = 0.3",
    );
    assert_eq!(solution.status, Status::Converged);
    // √ε by which the yardstick is above rounding.
    assert!(
        report.certificate.worst() < 1e-7,
        "{:?}",
        report.certificate
    );
    // The body moves as a whole: rounding over rounding is no estimate.
    assert_eq!(report.discretisation_error.displacement, 0.0);
    assert_eq!(report.discretisation_error.relative(), 0.0);
}

/// Contact forces without a net force are rounding of the load: no digit of theirs counts, and the answer is none the worse.
#[test]
fn forces_that_vanish_are_measured_by_the_load() {
    let supports = [
        "spring = [{ face = 'z_max', normal = 1e6, tangential = 1e6 }]\nbody_force.value = [10.0, 0.0, 0.0]",
        "spring = [{ face = 'x_min', normal = 1e7, tangential = 1e7 }]\nbody_force.value = [0.0, 10.0, 0.0]",
        "clamp = [{ face = 'x_min', components = ['x'] }]\ntraction = [{ face = 'x_max', value = [-10.0, 0.0, 0.0] }]",
    ];
    for support in supports {
        let (solution, _) = solved(&format!(
            "title = 'no net force'
            body.brick = {{ size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }}
            material.isotropic = {{ young_modulus = 1e9, poisson_ratio = 0.3 }}
            contact.face = 'z_min'
            {support}"
        ));
        assert_eq!(solution.status, Status::Converged, "{support}");
        // Sums of some hundred numbers of the size of the load.
        let largest = solution
            .multiplier
            .iter()
            .fold(0.0, |m: f64, l| m.max(l.abs()));
        assert!(largest < 1e-11, "{largest:e}");
    }
}

/// Springs of 5 kN/m³ beside such of 15 N/m³, hardly above those that are refused: of the softer ones' stiffness few digits are left, and of the balance of forces.
#[test]
fn what_is_out_of_balance_is_no_success() {
    let (solution, report) = solved(
        "title = 'hard and soft springs'
        body.brick = { size = [1.35, 0.888, 0.66], cells = [2, 4, 1] }
        material.isotropic = { young_modulus = 2.06e8, poisson_ratio = 0.43 }
        spring = [{ face = 'x_max', normal = 15.0, tangential = 15.0 }, { face = 'y_min', normal = 5490.0 }]
        traction = [{ face = 'z_max', value = [0.0, 0.0, '4987.2*(0.5 - x/1.35)'] }]
        contact.face = 'z_min'",
    );
    let balance = report.certificate.equilibrium;
    assert!(
        balance < 1e-6 || !solution.status.is_solved(),
        "{balance:e}"
    );
}
