//! Tables 1 and 2 and the converged values of HKL 2011, section 4.
//!
//! Reference: J. Haslinger, R. Kučera, T. Ligurský, J. Comput. Appl. Math. 235 (2011) 3464–3480.
//! Goal: the same algorithm on the same meshes takes as many steps as published.
//!
//! ```text
//!            p = (0, 0, -3e7)
//!        ┌───────────────────────┐
//!  u = 0 │   3 m × 1 m × 1 m     │ → p = (1e7, 0, 2e7)
//!        └───────────────────────┘
//!         ▒▒▒ rigid foundation ▒▒▒
//! ```

use crate::support::{Implicit, hkl_scene};
use contact3d::{
    post::Zone,
    scene::PrecisionControl::{Adaptive, Fixed},
    solver::StopReason,
};
use rayon::prelude::*;

/// (n_div, 3n, 3m, [(iter, n_A) of control (a)] for Tables 1 and 2).
type Row = (usize, usize, usize, [(usize, usize); 2]);

const PUBLISHED: [Row; 7] = [
    (4, 900, 36, [(6, 779), (7, 720)]),
    (6, 2646, 81, [(8, 1091), (8, 849)]),
    (8, 5832, 144, [(8, 1131), (8, 860)]),
    (10, 10890, 225, [(8, 1134), (8, 911)]),
    (12, 18252, 324, [(8, 1127), (8, 974)]),
    (14, 28350, 441, [(9, 1077), (8, 977)]),
    (16, 41616, 576, [(9, 1088), (10, 1044)]),
];

/// Rows of the tables that take seconds; the finer meshes take most of a minute.
const COARSE: usize = 5;

#[test]
fn tables_1_and_2() {
    compare(&PUBLISHED[..COARSE]);
}

#[test]
#[ignore = "two fine meshes"]
fn tables_1_and_2_on_the_finest_meshes() {
    compare(&PUBLISHED[COARSE..]);
}

fn compare(rows: &[Row]) {
    rows.into_par_iter()
        .for_each(|&(n_div, n_free, n_multipliers, counts)| {
            let problem = Implicit::new(&hkl_scene(1, n_div));
            assert_eq!(problem.assembly().primal.load.len(), n_free);
            assert_eq!(problem.contact().dual_rhs().len(), n_multipliers);
            for (table, (iterations, applications)) in [1, 2].into_iter().zip(counts) {
                let mut scene = hkl_scene(table, n_div);
                scene.solve.precision = Fixed;
                let fixed = problem.solve(&scene);
                scene.solve.precision = Adaptive;
                let adaptive = problem.solve(&scene);
                let case = format!("table {table}, n_div {n_div}");
                assert_eq!(fixed.stop, StopReason::Converged, "{case} (a)");
                assert_eq!(adaptive.stop, StopReason::Converged, "{case} (b)");
                // The paper leaves steplength, Γ and the estimate of ‖S‖ open; an independent
                // implementation differed by up to 2 outer steps and 14 % of the applications.
                assert!(
                    fixed.solution.trace.history.len().abs_diff(iterations) <= 2,
                    "{case}: {} outer steps, published {iterations}",
                    fixed.solution.trace.history.len()
                );
                let ratio = fixed.solution.trace.applications as f64 / applications as f64;
                assert!(
                    (ratio - 1.0).abs() <= 0.25,
                    "{case}: {} applications, published {applications}",
                    fixed.solution.trace.applications
                );
                // The paper's conclusion, which holds in each of its rows: control (b) is cheaper.
                assert!(
                    adaptive.solution.trace.applications < fixed.solution.trace.applications,
                    "{case}: (b) against (a)"
                );
            }
        });
}

/// Converged values of Table 1 at n_div = 8, computed to 1e-12 by an independent implementation.
#[test]
fn converged_values_at_n_div_8() {
    let mut scene = hkl_scene(1, 8);
    scene.solve.precision = Fixed;
    scene.solve.epsilon = Some(1e-8);
    let problem = Implicit::new(&scene);
    let found = problem.solve(&scene);
    assert_eq!(found.stop, StopReason::Converged);
    let solution = found.solution;
    let report = problem.report(&scene, &solution);
    let r = &report.resultants;
    let contact = r.contact.expect("contact");
    let tangential = contact.tangential_force.expect("friction");
    let [ux, uy, uz] = r.largest_displacement_along;
    let expected = [
        ("normal force", contact.normal_force, 5.883_717_33e7),
        ("tangential force", tangential[0], 9.328_88e6),
        ("largest pressure", contact.largest_pressure, 3.750_408_53e7),
        ("strain energy", r.strain_energy, 7_150.207_88),
        ("max |u_x|", ux, 3.568_228e-4),
        ("max |u_y|", uy, 3.586_18e-5),
        ("max |u_z|", uz, 2.932_476e-4),
    ];
    for (name, found, value) in expected {
        // Six digits: ε = 1e-8 leaves an error near 1e-7 (a contraction factor near 0.1), and the
        // last two displacements and the tangential force are printed with six digits only.
        assert!(
            (found / value - 1.0).abs() < 1.5e-6,
            "{name}: {found} against {value}"
        );
    }
    // The second tangential force vanishes by the symmetry y → 1 − y, up to the solve's accuracy.
    assert!(tangential[1].abs() < 1e-7 * tangential[0]);
    let zones = [Zone::Open, Zone::Slip, Zone::Stick].map(|zone| report.count(zone));
    assert_eq!(zones, [12, 30, 6]);
}
