//! Bodies that only contact holds, against closed forms of statics: where a block begins to slide, to tip over, to lift off.

use contact3d::{
    AssembledProblem, Problem,
    elasticity::BodyMotion,
    scene::{Method, Scene, SolveSettings},
    solver::{Solution, Status},
};

/// Share of the limit by which loads stay below or go beyond it.
const NEAR: f64 = 1e-6;

/// A block 2 × 1 × h m of steel on its face z_min; `rest` says how it is loaded and slides.
fn block(size: [f64; 3], cells: [usize; 3], rest: &str) -> AssembledProblem {
    let text = format!(
        "title = 'block'
        [body.brick]
        size = {size:?}
        cells = {cells:?}
        [material.isotropic]
        young_modulus = 2.1e11
        poisson_ratio = 0.3
        {rest}"
    );
    let scene = Scene::parse("floating", &text).unwrap_or_else(|error| panic!("{error}"));
    Problem::new(scene)
        .and_then(|problem| problem.assemble())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn solved(problem: &AssembledProblem) -> Solution {
    problem.solve(&SolveSettings::default()).expect("a solve")
}

/// Weight of 77 kN/m³ on a slope of tangent `slope` that falls towards x turned by `angle` towards y.
fn weight(slope: f64, angle: f64) -> String {
    let normal = 7.7e4 / slope.hypot(1.0);
    let (sin, cos) = angle.sin_cos();
    let along = normal * slope;
    format!(
        "[body_force]
        value = [{:e}, {:e}, {:e}]",
        along * cos,
        along * sin,
        -normal
    )
}

fn contact(multipliers: &str, friction: &str) -> String {
    format!(
        "[contact]
        face = 'z_min'
        multipliers = '{multipliers}'
        [friction]
        {friction}"
    )
}

/// The mechanism.
fn motion(problem: &AssembledProblem, solution: &Solution) -> BodyMotion {
    let rigid = solution.rigid.as_ref().expect("a floating body");
    let mechanism = rigid.mechanism.as_ref().expect("a motion");
    BodyMotion::fitted(&problem.mesh().coordinates, mechanism)
}

/// What a body in equilibrium must show, whatever it does.
fn assert_balanced(problem: &AssembledProblem, solution: &Solution) {
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    let report = problem.report(solution).expect("a report");
    let resultants = &report.resultants;
    // Sums of some thousand forces, each with its rounding.
    assert!(resultants.force_imbalance < 1e-11, "{resultants:?}");
    assert!(resultants.moment_imbalance < 1e-11, "{resultants:?}");
    assert_eq!(resultants.clamp_force, [0.0; 3]);
    // The displacement of a face that sticks, against the compliance of a pane.
    assert!(
        report.certificate.worst() < 1e-7,
        "{:?}",
        report.certificate
    );
}

#[test]
fn a_low_block_slides_at_the_angle_of_friction() {
    for multipliers in ["panes", "nodal"] {
        for (angle, along) in [(0.0_f64, [1.0, 0.0]), (2.2, [2.2_f64.cos(), 2.2_f64.sin()])] {
            let at = |share: f64| {
                let contact = contact(multipliers, "coefficient.constant = 0.3");
                let problem = block(
                    [2.0, 1.0, 0.5],
                    [8, 4, 2],
                    &[weight(0.3 * share, angle), contact].join("\n"),
                );
                let solution = solved(&problem);
                (problem, solution)
            };
            let (problem, solution) = at(1.0 - NEAR);
            assert_balanced(&problem, &solution);
            let report = problem.report(&solution).expect("a report");
            let force = report.resultants.contact.expect("contact");
            let [along_1, along_2] = force.tangential_force.expect("friction");
            let ratio = along_1.hypot(along_2) / force.normal_force;
            // RigidEquilibrium to rounding.
            assert!((ratio / 0.3 - (1.0 - NEAR)).abs() < 1e-10, "{ratio}");
            let (problem, solution) = at(1.0 + NEAR);
            assert_eq!(
                solution.status,
                Status::NoEquilibrium,
                "{multipliers} {angle}"
            );
            assert!(solution.displacement.iter().all(|u| *u == 0.0));
            let motion = motion(&problem, &solution);
            let [x, y, _] = motion.translation;
            let size = x.hypot(y);
            // A cone of motions as narrow as the excess, of which any may be found.
            assert!(
                (x / size - along[0]).abs() + (y / size - along[1]).abs() < 1e-2,
                "{motion:?}"
            );
        }
    }
}

#[test]
fn a_block_on_many_panes_slides_at_the_angle_of_friction() {
    for cells in [[32, 16, 1], [64, 32, 1]] {
        let contact = contact("panes", "coefficient.constant = 0.3");
        let loads = weight(0.3 * (1.0 + 0.1 * NEAR), 0.7);
        let problem = block([2.0, 1.0, 0.5], cells, &[loads, contact].join("\n"));
        assert_eq!(solved(&problem).status, Status::NoEquilibrium, "{cells:?}");
    }
}

#[test]
fn orthotropic_friction_gives_way_on_its_ellipse() {
    // (T₁/F₁)² + (T₂/F₂)² = N² in any direction.
    for angle in [0.3_f64, 1.2, 2.5] {
        let limit = ((angle.cos() / 0.2).powi(2) + (angle.sin() / 0.5).powi(2))
            .sqrt()
            .recip();
        for (share, holds) in [(1.0 - NEAR, true), (1.0 + NEAR, false)] {
            let friction = "coefficient_1.constant = 0.2\ncoefficient_2.constant = 0.5";
            let problem = block(
                [2.0, 2.0, 0.5],
                [8, 8, 2],
                &[weight(limit * share, angle), contact("panes", friction)].join("\n"),
            );
            let solution = solved(&problem);
            if holds {
                assert_balanced(&problem, &solution);
            } else {
                assert_eq!(solution.status, Status::NoEquilibrium, "{angle}");
            }
        }
    }
}

#[test]
fn a_high_block_tips_over_where_its_forces_end() {
    // Height 4, base 1 along x: with stresses constant on panes of a quarter the last force acts an eighth from the edge, with
    // nodal ones at the edge; the weight acts at half the height.
    for (multipliers, arm) in [("panes", 0.5 - 0.125), ("nodal", 0.5)] {
        let limit = arm / 2.0;
        for (share, holds) in [(1.0 - NEAR, true), (1.0 + NEAR, false)] {
            let problem = block(
                [1.0, 1.0, 4.0],
                [8, 4, 8],
                &[
                    weight(limit * share, 0.0),
                    contact(multipliers, "coefficient.constant = 0.9"),
                ]
                .join("\n"),
            );
            let solution = solved(&problem);
            if holds {
                assert_balanced(&problem, &solution);
                continue;
            }
            assert_eq!(solution.status, Status::NoEquilibrium, "{multipliers}");
            let motion = motion(&problem, &solution);
            let size = motion.rotation.iter().map(|w| w * w).sum::<f64>().sqrt();
            assert!((motion.rotation[1] / size - 1.0).abs() < 1e-3, "{motion:?}");
            assert!((motion.point[0] - 0.5 - arm).abs() < 1e-2, "{motion:?}");
        }
    }
}

#[test]
fn nothing_holds_a_body_that_is_pulled_off() {
    let pulled = "[[traction]]
        face = 'z_max'
        value = [0.0, 0.0, 1.0]";
    let problem = block(
        [1.0, 1.0, 1.0],
        [4, 4, 2],
        &[pulled, &contact("panes", "coefficient.constant = 0.5")].join("\n"),
    );
    let solution = solved(&problem);
    assert_eq!(solution.status, Status::NoEquilibrium);
    let motion = motion(&problem, &solution);
    assert!(motion.translation[2] > 0.0, "{motion:?}");
}

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
            let moved = report.resultants.largest_displacement[0];
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
    assert!(report.resultants.largest_displacement[2] < 1e-6);
    // Pins move by nothing but what the body strains.
    assert!(report.resultants.largest_displacement[0] < 1e-6);
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

/// Whether a block of 2 × 1 × 0.5 m under a pressure of 1e5 Pa holds against a push along x, on top, in Pa.
fn holds(friction: &str, push: f64, more: &str) -> bool {
    let rest = format!(
        "[[traction]]
        face = 'z_max'
        value = [{push:e}, 0.0, -1e5]
        {more}
        {}",
        contact("panes", friction)
    );
    let problem = block([2.0, 1.0, 0.5], [8, 4, 2], &rest);
    let solution = solved(&problem);
    let holds = solution.status != Status::NoEquilibrium;
    if holds {
        assert!(solution.status.is_solved(), "{:?}", solution.status);
    }
    holds
}

#[test]
fn a_given_slip_bound_and_a_cap_limit_the_push() {
    // T = g |Γ_c|, and T = F p_cap |Γ_c| where the pressure is above the cap: the push on top acts on an area as large.
    for (friction, limit) in [
        ("slip_bound = 2e4", 2e4),
        ("coefficient.constant = 0.3\npressure_cap = 2e4", 0.3 * 2e4),
    ] {
        assert!(holds(friction, limit * (1.0 - 1e-3), ""), "{friction}");
        assert!(!holds(friction, limit * (1.0 + NEAR), ""), "{friction}");
    }
    // The convex case to the end.
    assert!(holds("slip_bound = 2e4", 2e4 * (1.0 - NEAR), ""));
}

#[test]
fn rollers_leave_three_motions_to_contact() {
    let rollers = "[[clamp]]
        face = 'y_min'
        components = ['y']";
    let friction = "coefficient.constant = 0.3";
    assert!(holds(friction, 0.3e5 * (1.0 - NEAR), rollers));
    assert!(!holds(friction, 0.3e5 * (1.0 + NEAR), rollers));
    let rest = [rollers, &contact("panes", friction)].join("\n");
    let problem = block([2.0, 1.0, 0.5], [8, 4, 2], &rest);
    let floating = problem.system.assembly.primal.floating.as_ref();
    assert_eq!(floating.expect("floats").n_modes(), 3);
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
    assert!((report.resultants.largest_displacement[2] - 1e-3).abs() < 1e-6);
    // A foundation that falls off along x: the body turns with it, about y by the slope.
    let problem = block([1.0, 1.0, 0.5], [4, 4, 2], &text("1e-4*x"));
    let solution = solved(&problem);
    assert_balanced(&problem, &solution);
    let report = problem.report(&solution).expect("a report");
    let motion = BodyMotion::fitted(&problem.mesh().coordinates, &report.displacement);
    assert!((motion.rotation[1] - 1e-4).abs() < 1e-6, "{motion:?}");
}

#[test]
fn quadratic_tetrahedra_give_the_same_verdicts() {
    for (share, expected) in [(1.0 - NEAR, true), (1.0 + NEAR, false)] {
        let text = format!(
            "title = 'quadratic'
            [body]
            element = 'P2'
            [body.brick]
            size = [2.0, 1.0, 0.5]
            cells = [4, 2, 1]
            [material.isotropic]
            young_modulus = 2.1e11
            poisson_ratio = 0.3
            {}
            {}",
            weight(0.3 * share, 0.7),
            contact("panes", "coefficient.constant = 0.3")
        );
        let scene = Scene::parse("floating", &text).expect("a scene");
        let problem = Problem::new(scene)
            .and_then(|p| p.assemble())
            .expect("a problem");
        let solution = solved(&problem);
        if expected {
            assert_balanced(&problem, &solution);
        } else {
            assert_eq!(solution.status, Status::NoEquilibrium);
        }
    }
}

#[test]
fn a_block_in_a_corner_slides_along_it() {
    // Weight W towards the edge between floor and wall presses both with W/√2, and friction along the edge is F times either:
    // T = √2 F W. Hardly any friction across the edge, so that the faces cannot press each other.
    let at = |share: f64| {
        let push = 2.0_f64.sqrt() * 0.3 * 7.7e4 * share;
        let down = -7.7e4 / 2.0_f64.sqrt();
        let faces = ["z_min", "y_min"].map(|face| {
            format!(
                "[[contact]]
                face = '{face}'
                friction.coefficient_1.constant = 0.3
                friction.coefficient_2.constant = 1e-9"
            )
        });
        let force = format!("[body_force]\nvalue = [{push:e}, {down:e}, {down:e}]");
        let problem = block(
            [2.0, 1.0, 1.0],
            [8, 4, 4],
            &[force, faces.join("\n")].join("\n"),
        );
        let solution = solved(&problem);
        (problem, solution)
    };
    let (problem, solution) = at(1.0 - NEAR);
    assert_balanced(&problem, &solution);
    let (_, solution) = at(1.0 + NEAR);
    assert_eq!(solution.status, Status::NoEquilibrium);
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
        assert!(problem.system.assembly.primal.floating.is_none());
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
