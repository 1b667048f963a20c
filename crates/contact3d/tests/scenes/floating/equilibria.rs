//! Bodies in equilibrium: how they rest, and that all methods find the same.

use contact3d::{
    elasticity::BodyMotion,
    scene::{Method, SolveSettings},
    solver::Status,
};

use super::{assert_balanced, block, contact, motion, solved, weight};

#[test]
fn a_body_without_loads_rests() {
    let problem = block(
        [1.0, 1.0, 1.0],
        [4, 4, 2],
        &contact("panes", "coefficient.constant = 0.5"),
    );
    let solution = solved(&problem);
    assert_eq!(solution.status, Status::Converged);
    assert!(
        solution
            .multiplier
            .iter()
            .chain(&solution.displacement)
            .all(|v| *v == 0.0)
    );
}

/// Nothing presses the block, so that it floats as low as it can, and springs alone carry the load: u_x = f L/k.
#[test]
fn a_load_that_works_in_no_free_motion_proves_nothing() {
    for cells in [[2, 2, 2], [2, 4, 2], [6, 6, 4]] {
        for (push, law) in [
            (10.0, ""),
            (-10.0, ""),
            (10.0, "[friction]\ncoefficient.constant = 0.3"),
        ] {
            let rest = format!(
                "[[spring]]
                face = 'x_min'
                normal = 1e5
                [body_force]
                value = [{push:?}, 0.0, 0.0]
                [contact]
                face = 'z_min'
                {law}"
            );
            let problem = block([1.0; 3], cells, &rest);
            let solution = solved(&problem);
            assert_eq!(solution.status, Status::Converged, "{cells:?}, {push}");
            assert!(
                solution.multiplier.iter().all(|l| *l == 0.0),
                "{cells:?}, {push}"
            );
            let report = problem.report(&solution).expect("a report");
            let moved = report.resultants.largest_displacement_along[0];
            // Strains of steel are a share of 1e5/2e11 of that.
            assert!((moved - 1e-4).abs() < 1e-9, "{cells:?}: {moved:e}");
        }
    }
}

/// Tresca's friction on open panes of a block that soft springs let go: their slips are known to rounding of the way, and the stated accuracy says so.
#[test]
fn a_long_way_takes_digits_that_the_accuracy_tells_of() {
    let lifted = |k: f64| {
        let rest = format!(
            "[[spring]]
            face = 'z_max'
            normal = {k:e}
            tangential = {k:e}
            [body_force]
            value = [0.0, 0.0, 1e5]
            [contact]
            face = 'z_min'
            [friction]
            coefficient.constant = 1.0
            slip_bound = 1e5"
        );
        let problem = block([1.46, 0.72, 0.69], [4, 2, 2], &rest);
        let solution = solved(&problem);
        (solution.status, solution.accuracy, solution.multiplier)
    };
    // A share of 1e-6 of the stiffness of steel: their own effect is no more.
    let (status, accuracy, stiff) = lifted(1e5);
    assert!(
        status.is_solved() && accuracy < 1e-8,
        "{status:?} {accuracy:e}"
    );
    // Softer ones are refused: 1e3 N/m³ carry 5e-10 of the body's own stiffness.
    for k in [1e4, 3e3] {
        let (status, accuracy, soft) = lifted(k);
        let off = stiff
            .iter()
            .zip(&soft)
            .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        assert!(status.is_solved(), "{k:e}: {status:?}");
        // Relative to the bound; ten times for the other norm.
        assert!(
            off / 1e5 <= 10.0 * accuracy + 1e-5,
            "{k:e}: {off:e} {accuracy:e}"
        );
        assert!(accuracy < 1e-3, "{k:e}: {accuracy:e}");
    }
}

#[test]
fn without_friction_a_block_keeps_its_place_unless_it_is_pushed() {
    let at = |push: f64| {
        let rest = format!(
            "[[traction]]
            face = 'z_max'
            value = [{push:e}, 0.0, -1e5]
            [contact]
            face = 'z_min'"
        );
        let problem = block([1.0, 1.0, 1.0], [4, 4, 4], &rest);
        let solution = solved(&problem);
        (problem, solution)
    };
    let (problem, solution) = at(0.0);
    assert_balanced(&problem, &solution);
    // p/E = 4.8e-7 of the height.
    let report = problem.report(&solution).expect("a report");
    assert!(report.resultants.largest_displacement_along[2] < 1e-6);
    // Pins move by nothing but what the body strains.
    assert!(report.resultants.largest_displacement_along[0] < 1e-6);
    let (problem, solution) = at(1e-3);
    assert_eq!(solution.status, Status::NoEquilibrium);
    let motion = motion(&problem, &solution);
    assert_eq!(motion.rotation, [0.0; 3]);
    // Along x but for rounding of the modes.
    assert!((motion.translation[0] - 1.0).abs() < 1e-6, "{motion:?}");
}

#[test]
fn all_methods_find_the_same_equilibrium() {
    let rest = [
        weight(0.2, 0.4),
        contact("panes", "coefficient_1.ramp = { initial = 0.3, residual = 0.25, onset = 1e-9, rate = 1e7 }\ncoefficient_2.constant = 0.4"),
    ]
    .join("\n");
    let problem = block([2.0, 1.0, 1.0], [8, 4, 4], &rest);
    let reference = solved(&problem);
    assert_balanced(&problem, &reference);
    let size = reference
        .multiplier
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let moved = reference
        .displacement
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    for (operator, inner) in [
        ("explicit", "kprgp"),
        ("explicit", "gpcg"),
        ("explicit", "newton"),
        ("implicit", "gpcg"),
    ] {
        let settings = format!(
            "[assemble]
            dual_operator = '{operator}'
            [solve]
            method = 'fixed-point'
            inner = '{inner}'
            epsilon = 1e-8
            max_operator_applications = 200000"
        );
        let problem = block(
            [2.0, 1.0, 1.0],
            [8, 4, 4],
            &[rest.clone(), settings].join("\n"),
        );
        let solve = problem.scene().solve.clone();
        let solution = problem.solve(&solve).expect("a solve");
        assert!(
            solution.status.is_solved(),
            "{operator} {inner}: {:?}",
            solution.status
        );
        let pairs = solution.multiplier.iter().zip(&reference.multiplier);
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // ε times what KPRGP's stopping rule leaves of it.
        assert!(
            apart < 1e-5 * size,
            "{operator} {inner}: {:e}",
            apart / size
        );
        let pairs = solution.displacement.iter().zip(&reference.displacement);
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(
            apart < 1e-4 * moved,
            "{operator} {inner}: {:e}",
            apart / moved
        );
    }
}

#[test]
fn a_block_comes_down_on_its_foundation() {
    let text = |gap: &str| {
        format!(
            "{}
            [contact]
            face = 'z_min'
            gap = '{gap}'
            [friction]
            coefficient.constant = 0.5",
            weight(0.0, 0.0)
        )
    };
    let problem = block([1.0, 1.0, 0.5], [4, 4, 2], &text("1e-3"));
    let solution = solved(&problem);
    assert_balanced(&problem, &solution);
    let report = problem.report(&solution).expect("a report");
    // Weight compresses the block by less than 1e-6 m.
    assert!((report.resultants.largest_displacement_along[2] - 1e-3).abs() < 1e-6);
    // A foundation that falls off along x: the body turns with it, about y by the slope.
    let problem = block([1.0, 1.0, 0.5], [4, 4, 2], &text("1e-4*x"));
    let solution = solved(&problem);
    assert_balanced(&problem, &solution);
    let report = problem.report(&solution).expect("a report");
    let mesh = problem.mesh();
    let volumes = mesh.corner_volumes();
    let motion = BodyMotion::fitted(&mesh.coordinates, &volumes, &report.displacement);
    assert!((motion.rotation[1] - 1e-4).abs() < 1e-6, "{motion:?}");
}

#[test]
fn a_clamped_face_holds_a_body_of_any_length() {
    for (element, length) in [("P1", 1e6), ("P1", 1e8), ("P2", 1e8)] {
        let rest = format!(
            "[body]
            element = '{element}'
            [[clamp]]
            face = 'x_min'
            [[traction]]
            face = 'z_max'
            value = [0.0, 0.0, -3e7]
            {}",
            contact("panes", "coefficient.constant = 0.3")
        );
        let problem = block([3.0, length, 1.0], [4, 2, 2], &rest);
        assert!(problem.system.assembly.primal.rigid_modes.is_none());
        let solution = solved(&problem);
        let report = problem.report(&solution).expect("a report");
        // Sums of some hundred forces, each with its rounding.
        assert!(report.resultants.force_imbalance < 1e-11, "{length}");
        assert!(report.resultants.moment_imbalance < 1e-11, "{length}");
        assert!(report.discretisation_error.relative().is_finite());
    }
}

/// Frictionless faces on a plane feel no motion along it, single panes no rotation at all.
#[test]
fn null_space_motions_are_named_and_zero() {
    let weight = weight(0.0, 0.0);
    let sizes = [[1.17, 2.78, 2.9], [1.0, 1.0, 1.0]];
    for size in sizes {
        let frictionless = format!("{weight}\n[contact]\nface = 'z_min'");
        let rough = [&weight[..], &contact("panes", "coefficient.constant = 0.3")].join("\n");
        for (cells, rest) in [([4, 4, 4], frictionless), ([2, 2, 2], rough)] {
            let problem = block(size, cells, &rest);
            let solution = solved(&problem);
            assert_balanced(&problem, &solution);
            let u = problem.report(&solution).expect("a report").displacement;
            let null_space = solution.rigid.expect("a floating body").null_space;
            assert_eq!(null_space.len(), 3);
            for motion in &null_space {
                let pairs = motion.as_flattened().iter().zip(u.as_flattened());
                let along: f64 = pairs.map(|(q, u)| q * u).sum();
                let size: f64 = u.as_flattened().iter().map(|u| u.abs()).sum();
                // Rounding of one projection.
                assert!(along.abs() < 1e-12 * size, "{along:e} of {size:e}");
            }
        }
    }
}

/// Faces that first touch along an edge circle: what softer and softer springs lead to is found without them.
#[test]
fn blocks_in_shallow_cups_are_held() {
    let cups = [
        (
            [1.0, 1.0, 1.0],
            [4, 4, 4],
            5.0,
            5.049_752_469_181_6,
            0.3,
            "[1e5, 0.0, -1e6]",
        ),
        (
            [1.65, 0.874, 1.04],
            [4, 2, 3],
            33.0,
            33.013_203_328_368_746,
            0.154_735,
            "[7.36927e5, -3.83056e5, -1.50366e7]",
        ),
    ];
    for ([x, y, z], cells, height, radius, friction, force) in cups {
        let rest = format!(
            "[body]
            element = 'P2'
            [body_force]
            value = {force}
            [contact]
            face = 'z_min'
            multipliers = 'nodal'
            obstacle.sphere = {{ centre = [{}, {}, {height:?}], radius = {radius:?}, side = 'inside' }}
            [friction]
            coefficient.constant = {friction:?}",
            x / 2.0,
            y / 2.0
        );
        let problem = block([x, y, z], cells, &rest);
        assert_balanced(&problem, &solved(&problem));
    }
}

/// Successive approximations on a body whose motions all rest on weak springs have no motion left to balance, and a face without
/// friction may feel none at all: both once ended in a panic.
#[test]
fn bodies_without_a_free_or_felt_motion_end_with_a_status() {
    let springs = block(
        [1.0; 3],
        [2, 2, 2],
        "[contact]
        face = 'z_min'
        [friction]
        coefficient.constant = 0.04
        [[spring]]
        face = 'x_max'
        normal = 1e5
        tangential = 1e5
        [[traction]]
        face = 'z_max'
        value = [1e3, 0.0, -1e4]",
    );
    let settings = SolveSettings {
        method: Method::FixedPoint,
        ..SolveSettings::default()
    };
    assert!(springs.solve(&settings).is_ok());
    let rollers = block(
        [1.0; 3],
        [2, 2, 2],
        "[contact]
        face = 'z_min'
        [[clamp]]
        face = 'z_max'
        components = ['y', 'z']
        [[clamp]]
        face = 'x_max'
        components = ['y']
        [[pressure]]
        face = 'z_max'
        value = 1e3",
    );
    assert_eq!(solved(&rollers).status, Status::Converged);
}
