//! Where contact no longer holds a body: closed forms of sliding, tipping over and lifting off.

use contact3d::{Problem, scene::Scene, solver::Status};

use super::{NEAR, assert_balanced, block, contact, motion, solved, weight};

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
    let floating = problem.system.assembly.primal.rigid_modes.as_ref();
    assert_eq!(floating.expect("floats").n_modes(), 3);
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
