//! Published and hard laws, units, limits.

use contact3d::{
    dual::{ContactOperator, PrimalOperator},
    post::Zone,
    scene::{Coefficient, Material, PrecisionControl::Fixed, Quantity, Scene},
    solver::{Inner, NewtonSettings, StopReason, newton},
};

use super::{dense::*, support::hkl_scene};

#[test]
fn published_laws_converge_to_a_fixed_point_of_the_mapping() {
    for n_div in [4, 8] {
        for table in [1, 2] {
            let case = Dense::new(hkl_scene(table, n_div));
            let law = case.law();
            let solution = case.solve(&law);
            let name = format!("table {table}, n_div {n_div}");
            assert_eq!(solution.stop, StopReason::Converged, "{name}");
            assert!(solution.history.len() <= 8, "{name}");
            assert!(
                solution.history.iter().all(|step| !step.safeguard),
                "{name}"
            );
            // A residual of 1e-12 times the conditioning of the frozen problem, some tens.
            let image = case.distance_to_image(&law, &solution.unknowns);
            assert!(image < 1e-10, "{name}: {image:e}");
        }
    }
}

#[test]
fn agrees_with_the_paper_s_algorithm() {
    for table in [1, 2] {
        for (epsilon, bound) in [(1e-8, 1e-6), (1e-10, 1e-7)] {
            let mut scene = hkl_scene(table, 4);
            scene.solve.precision = Fixed;
            scene.solve.epsilon = Some(epsilon);
            let case = Dense::new(scene);
            let paper = case.approximate(Inner::Kprgp);
            assert_eq!(paper.stop, StopReason::Converged);
            let solution = case.solve(&case.law());
            // KPRGP stops at a gradient of 0.1 ε ‖h‖, which leaves an error of λ larger by the
            // condition number of S.
            let error = distance(&paper.solution.multiplier, &solution.unknowns);
            assert!(
                error < bound,
                "table {table}, epsilon {epsilon:e}: {error:e}"
            );
        }
    }
}

/// The converged values of an independent implementation at n_div = 8 (Table 1), all digits.
#[test]
fn reproduces_the_converged_values() {
    let mut scene = hkl_scene(1, 8);
    scene.solve.precision = Fixed;
    scene.solve.epsilon = Some(1e-12);
    let case = Dense::new(scene);
    let newton = case.solve(&case.law());
    let found = case.approximate(Inner::Newton(&case.dual, &case.local));
    assert_eq!(found.stop, StopReason::Converged);
    let solution = found.solution;
    // Both end within 1e-12 of the same fixed point, up to the conditioning of the problem.
    assert!(distance(&newton.unknowns, &solution.multiplier) < 1e-11);
    let mut of_newton = solution.clone();
    of_newton.multiplier.clone_from(&newton.unknowns);
    of_newton.displacement =
        ContactOperator::implicit(case.problem.assembly(), case.problem.contact())
            .to_primal(&newton.unknowns);
    let m = case.dual.n_panes();
    if let Some(friction) = &mut of_newton.friction {
        friction.coulomb.slip_bound = newton.unknowns[..m].to_vec();
    }
    for solution in [solution, of_newton] {
        let report = case.problem.report(&case.scene, &solution);
        let r = &report.resultants;
        let contact = r.contact.expect("contact");
        let tangential = contact.tangential_force.expect("friction");
        let [ux, uy, uz] = r.largest_displacement_along;
        // Half a unit of the last printed digit.
        let expected = [
            ("normal force", contact.normal_force, 5.883_717_33e7, 0.5e-1),
            ("tangential force", tangential[0], 9.328_88e6, 5.0),
            (
                "largest pressure",
                contact.largest_pressure,
                3.750_408_53e7,
                0.5e-1,
            ),
            ("strain energy", r.strain_energy, 7_150.207_88, 0.5e-5),
            ("max |u_x|", ux, 3.568_228e-4, 0.5e-10),
            ("max |u_y|", uy, 3.586_18e-5, 0.5e-10),
            ("max |u_z|", uz, 2.932_476e-4, 0.5e-10),
        ];
        for (name, found, value, half_digit) in expected {
            assert!(
                (found - value).abs() <= 1.01 * half_digit,
                "{name}: {found} against {value}"
            );
        }
        assert!(tangential[1].abs() < 1e-10 * tangential[0]);
        let zones = [Zone::Open, Zone::Slip, Zone::Stick].map(|zone| report.count(zone));
        assert_eq!(zones, [12, 30, 6]);
        // The certificate's figures are rounding: 1e-12 leaves a thousandfold of it.
        assert!(
            report.certificate.worst() < 1e-11,
            "{:?}",
            report.certificate
        );
    }
}

/// The scene in millimetres and megapascals (forces in N).
fn in_millimetres(mut scene: Scene) -> Scene {
    if let Some(brick) = scene.as_brick_mut() {
        brick.size = brick.size.map(|l| 1e3 * l);
    }
    if let Some(Material::Isotropic(steel)) = &mut scene.material {
        steel.young_modulus *= 1e-6;
    }
    for value in scene.tractions.iter_mut().flat_map(|t| &mut t.value) {
        *value = Quantity::Constant(1e-6 * value.constant().expect("a constant load"));
    }
    let friction = scene.friction.as_mut().expect("friction");
    for coefficient in [&mut friction.coefficient_1, &mut friction.coefficient_2] {
        if let Some(Coefficient::Ramp(ramp)) = coefficient {
            ramp.onset *= 1e3;
            ramp.rate *= 1e-3;
        }
    }
    scene
}

#[test]
fn units_do_not_matter() {
    let mut scenes = vec![hkl_scene(1, 4), hkl_scene(2, 6)];
    for (_, law) in hard_laws() {
        let mut scene = hkl_scene(1, 4);
        scene.friction = Some(law);
        scenes.push(scene);
    }
    for scene in scenes {
        let metres = Dense::new(scene.clone());
        let millimetres = Dense::new(in_millimetres(scene));
        let in_metres = metres.solve(&metres.law());
        let in_millimetres = millimetres.solve(&millimetres.law());
        assert_eq!(in_metres.history.len(), in_millimetres.history.len());
        let pascals: Vec<f64> = in_millimetres.unknowns.iter().map(|l| 1e6 * l).collect();
        // Both residuals are below 1e-12.
        assert!(distance(&pascals, &in_metres.unknowns) < 1e-9);
    }
}

#[test]
fn no_load_and_lift_off_need_no_step() {
    let mut unloaded = hkl_scene(1, 4);
    unloaded.tractions.clear();
    let mut lifted = hkl_scene(1, 4);
    lifted.tractions.retain_mut(|traction| {
        traction.value = [0.0, 0.0, 1e7].map(Quantity::Constant);
        true
    });
    for scene in [unloaded, lifted] {
        let case = Dense::new(scene);
        let solution = case.solve(&case.law());
        assert_eq!(solution.stop, StopReason::Converged);
        assert_eq!(solution.history.len(), 0);
        assert!(solution.unknowns.iter().all(|l| *l == 0.0));
        assert_eq!(case.distance_to_image(&case.law(), &solution.unknowns), 0.0);
    }
}

#[test]
fn a_warm_start_at_the_answer_ends_at_once() {
    let case = Dense::new(hkl_scene(2, 4));
    let law = case.law();
    let cold = case.solve(&law);
    let settings = NewtonSettings::default();
    let warm = case.with_contact(&law, |laws, law| {
        newton(
            &case.dual,
            laws,
            law,
            Some(&cold.unknowns),
            &settings,
            |_, _| {},
        )
    });
    assert_eq!((warm.stop, warm.history.len()), (StopReason::Converged, 0));
}

#[test]
fn running_out_of_steps_and_bad_starts_are_reported() {
    let case = Dense::new(hkl_scene(1, 4));
    let run = |start: Option<&[f64]>, tolerance: f64, max_steps: usize| {
        let settings = NewtonSettings {
            tolerance,
            max_steps,
            ..NewtonSettings::default()
        };
        case.with_contact(&case.law(), |laws, law| {
            newton(&case.dual, laws, law, start, &settings, |_, _| {})
        })
    };
    assert_eq!(run(None, 1e-12, 3).stop, StopReason::MaxSteps);
    let nan = vec![f64::NAN; case.dual.dimension()];
    assert_eq!(run(Some(&nan), 1e-12, 30).stop, StopReason::NumericalError);
    // No residual is exactly zero in floating point: the attainable accuracy is reported.
    let limit = run(None, 1e-18, 100);
    assert_eq!(limit.stop, StopReason::RoundingLimit);
    assert!(limit.residual < 1e-13);
}
