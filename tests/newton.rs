//! The semismooth Newton method on the explicit dual operator.
//!
//! Goal: the fixed point of HKL's mapping Ψ to rounding, for the published laws and for hard ones,
//! in a number of steps that does not depend on units.

mod support;

use contact3d_pipe::{
    contact::nodal_slip,
    dual::{Assembly, DualOperator, ExplicitDual, ExplicitOperator, ImplicitOperator},
    post::Zone,
    scene::{Body, Coefficient, Friction, Material, PrecisionControl::Fixed, Ramp, Scene},
    solver::{
        ContactState, Inner, NewtonSettings, NewtonSolution, NewtonStatus, Solution, Status,
        evaluate_mapping, newton, successive_approximations,
    },
};
use support::{Problem, hkl_scene};

struct Dense {
    scene: Scene,
    problem: Problem,
    dual: ExplicitDual,
}

impl Dense {
    fn new(scene: Scene) -> Self {
        let problem = Problem::new(&scene);
        let frame = scene.contact.frame();
        let dual = ExplicitDual::new(&problem.assembly, &problem.mesh.contact, &frame);
        Self {
            scene,
            problem,
            dual,
        }
    }

    fn with_contact<T>(&self, law: &Friction, run: impl FnOnce(&ContactState<'_>) -> T) -> T {
        let frame = self.scene.contact.frame();
        run(&ContactState {
            surface: &self.problem.mesh.contact,
            frame: &frame,
            law,
        })
    }

    fn solve(&self, law: &Friction) -> NewtonSolution {
        self.with_contact(law, |contact| {
            newton(
                &self.dual,
                contact,
                None,
                &NewtonSettings::default(),
                |_, _| {},
            )
        })
    }

    /// Algorithm 4.1 on the explicit operator with the settings of the scene.
    fn approximate(&self, inner: Inner<'_>) -> Solution {
        self.with_contact(&self.scene.friction, |contact| {
            successive_approximations(
                inner,
                &mut ExplicitOperator::new(&self.dual, &self.problem.assembly),
                &self.problem.assembly,
                contact,
                &self.scene.solve,
                |_, _| {},
            )
        })
    }

    /// ‖Ψ(λ) − λ‖ / ‖λ‖.
    fn distance_to_image(&self, law: &Friction, multiplier: &[f64]) -> f64 {
        self.with_contact(law, |contact| {
            evaluate_mapping(&self.dual, contact, multiplier).relative_change
        })
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    let difference: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(y)
}

fn isotropic(coefficient: Coefficient) -> Friction {
    Friction {
        coefficient_1: coefficient,
        coefficient_2: coefficient,
    }
}

/// From `initial` to `residual` over `width` metres from `onset`.
fn ramp(initial: f64, residual: f64, onset: f64, width: f64) -> Coefficient {
    Coefficient::Ramp(Ramp {
        initial,
        residual,
        onset,
        rate: (initial - residual).abs() / width,
    })
}

fn hard_laws() -> Vec<(&'static str, Friction)> {
    use Coefficient::Constant;
    let mut laws: Vec<_> = [
        ("F = 1", Constant(1.0)),
        ("F = 3", Constant(3.0)),
        ("F = 10", Constant(10.0)),
        ("F = 1e6", Constant(1e6)),
        ("a fall within 1e-9 m", ramp(0.3, 0.2, 1e-5, 1e-9)),
        ("weakening 2 to 0.1", ramp(2.0, 0.1, 0.0, 1e-4)),
        ("weakening 5 to 0.01", ramp(5.0, 0.01, 0.0, 1e-5)),
        ("hardening 0.1 to 2", ramp(0.1, 2.0, 0.0, 1e-4)),
    ]
    .map(|(name, coefficient)| (name, isotropic(coefficient)))
    .into();
    laws.push((
        "F1 / F2 = 1e6",
        Friction {
            coefficient_1: Constant(0.3),
            coefficient_2: Constant(0.3e-6),
        },
    ));
    laws
}

#[test]
fn published_laws_converge_to_a_fixed_point_of_the_mapping() {
    for n_div in [4, 8] {
        for table in [1, 2] {
            let case = Dense::new(hkl_scene(table, n_div));
            let law = case.scene.friction.clone();
            let solution = case.solve(&law);
            let name = format!("table {table}, n_div {n_div}");
            assert_eq!(solution.status, NewtonStatus::Converged, "{name}");
            assert!(solution.history.len() <= 16, "{name}");
            assert!(solution.history.iter().all(|step| !step.fallback), "{name}");
            // A residual of 1e-12 times the conditioning of the frozen problem, some tens.
            let image = case.distance_to_image(&law, &solution.multiplier);
            assert!(image < 1e-10, "{name}: {image:e}");
        }
    }
}

#[test]
fn hard_laws_converge() {
    let case = Dense::new(hkl_scene(1, 4));
    for (name, law) in hard_laws() {
        let solution = case.solve(&law);
        assert_eq!(solution.status, NewtonStatus::Converged, "{name}");
        assert!(
            solution.history.len() <= 16,
            "{name}: {} steps",
            solution.history.len()
        );
        let image = case.distance_to_image(&law, &solution.multiplier);
        // As above; steep laws multiply rounding by dF/du.
        assert!(image < 1e-9, "{name}: {image:e}");
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
            assert_eq!(paper.status, Status::Converged);
            let solution = case.solve(&case.scene.friction);
            // KPRGP stops at a gradient of 0.1 ε ‖h‖, which leaves an error of λ larger by the
            // condition number of S.
            let error = distance(&paper.multiplier, &solution.multiplier);
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
    let newton = case.solve(&case.scene.friction);
    let solution = case.approximate(Inner::Newton(&case.dual));
    assert_eq!(solution.status, Status::Converged);
    // Both end within 1e-12 of the same fixed point, up to the conditioning of the problem.
    assert!(distance(&newton.multiplier, &solution.multiplier) < 1e-11);
    let mut of_newton = solution.clone();
    of_newton.multiplier.clone_from(&newton.multiplier);
    of_newton.displacement =
        ImplicitOperator::new(&case.problem.assembly).to_primal(&newton.multiplier);
    of_newton.friction.clone_from(&newton.friction);
    of_newton.slip.clone_from(&newton.slip);
    for solution in [solution, of_newton] {
        let report = case.problem.report(&case.scene, &solution);
        let r = &report.resultants;
        let [ux, uy, uz] = r.largest_displacement;
        // Half a unit of the last printed digit.
        let expected = [
            ("normal force", r.normal_force, 5.883_717_33e7, 0.5e-1),
            ("tangential force", r.tangential_force[0], 9.328_88e6, 5.0),
            (
                "largest pressure",
                r.largest_pressure,
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
        assert!(r.tangential_force[1].abs() < 1e-10 * r.tangential_force[0]);
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
    let Body::Brick(brick) = &mut scene.body;
    brick.size = brick.size.map(|l| 1e3 * l);
    let Material::Isotropic(steel) = &mut scene.material;
    steel.young_modulus *= 1e-6;
    for traction in &mut scene.tractions {
        traction.value = traction.value.map(|p| 1e-6 * p);
    }
    scene.contact.gap *= 1e3;
    for coefficient in [
        &mut scene.friction.coefficient_1,
        &mut scene.friction.coefficient_2,
    ] {
        if let Coefficient::Ramp(ramp) = coefficient {
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
        scene.friction = law;
        scenes.push(scene);
    }
    for scene in scenes {
        let metres = Dense::new(scene.clone());
        let millimetres = Dense::new(in_millimetres(scene));
        let in_metres = metres.solve(&metres.scene.friction);
        let in_millimetres = millimetres.solve(&millimetres.scene.friction);
        assert_eq!(in_metres.history.len(), in_millimetres.history.len());
        let pascals: Vec<f64> = in_millimetres.multiplier.iter().map(|l| 1e6 * l).collect();
        // Both residuals are below 1e-12.
        assert!(distance(&pascals, &in_metres.multiplier) < 1e-9);
    }
}

#[test]
fn no_load_and_lift_off_need_no_step() {
    let mut unloaded = hkl_scene(1, 4);
    unloaded.tractions.clear();
    let mut lifted = hkl_scene(1, 4);
    lifted.tractions.retain_mut(|traction| {
        traction.value = [0.0, 0.0, 1e7];
        true
    });
    for scene in [unloaded, lifted] {
        let case = Dense::new(scene);
        let solution = case.solve(&case.scene.friction);
        assert_eq!(solution.status, NewtonStatus::Converged);
        assert_eq!(solution.history.len(), 0);
        assert!(solution.multiplier.iter().all(|l| *l == 0.0));
        assert_eq!(
            case.distance_to_image(&case.scene.friction, &solution.multiplier),
            0.0
        );
    }
}

#[test]
fn a_warm_start_at_the_answer_ends_at_once() {
    let case = Dense::new(hkl_scene(2, 4));
    let law = case.scene.friction.clone();
    let cold = case.solve(&law);
    let settings = NewtonSettings::default();
    let warm = case.with_contact(&law, |contact| {
        newton(
            &case.dual,
            contact,
            Some(&cold.multiplier),
            &settings,
            |_, _| {},
        )
    });
    assert_eq!(
        (warm.status, warm.history.len()),
        (NewtonStatus::Converged, 0)
    );
}

#[test]
fn running_out_of_steps_and_bad_starts_are_reported() {
    let case = Dense::new(hkl_scene(1, 4));
    let run = |start: Option<&[f64]>, tolerance: f64, max_steps: usize| {
        let settings = NewtonSettings {
            tolerance,
            max_steps,
        };
        case.with_contact(&case.scene.friction, |contact| {
            newton(&case.dual, contact, start, &settings, |_, _| {})
        })
    };
    assert_eq!(run(None, 1e-12, 3).status, NewtonStatus::MaxSteps);
    let nan = vec![f64::NAN; case.dual.dimension()];
    assert_eq!(
        run(Some(&nan), 1e-12, 30).status,
        NewtonStatus::NumericalError
    );
    // No residual is exactly zero in floating point: the attainable accuracy is reported.
    let limit = run(None, 1e-18, 100);
    assert_eq!(limit.status, NewtonStatus::RoundingLimit);
    assert!(limit.residual < 1e-13);
}

/// Multipliers of many sizes and signs, the same on every machine.
fn probes(n: usize) -> Vec<Vec<f64>> {
    (1..5)
        .map(|k| {
            (0..n)
                .map(|i| 1e7 * ((i * 7919 * k + 13 * k) as f64 * 0.618_033_988_75).fract() - 3e6)
                .collect()
        })
        .collect()
}

#[test]
fn both_operators_agree() {
    for (n_div, gap, axis_1) in [
        (2, 0.0, None),
        (4, 1e-5, None),
        (4, 0.0, Some([0.6, 0.8, 0.0])),
        (6, 2e-6, Some([1.0, -2.0, 0.0])),
    ] {
        let mut scene = hkl_scene(1, n_div);
        scene.contact.gap = gap;
        scene.contact.axis_1 = axis_1;
        let case = Dense::new(scene);
        let assembly: &Assembly = &case.problem.assembly;
        let mut implicit = ImplicitOperator::new(assembly);
        let mut explicit = ExplicitOperator::new(&case.dual, assembly);
        assert_eq!(implicit.rhs(), explicit.rhs());
        assert_eq!(implicit.tangential_displacement(&[]), None);
        for multiplier in probes(case.dual.dimension()) {
            // The same factor in another order of operations: rounding only.
            assert!(distance(&explicit.apply(&multiplier), &implicit.apply(&multiplier)) < 1e-12);
            let displacement = implicit.to_primal(&multiplier);
            assert_eq!(explicit.to_primal(&multiplier), displacement);
            let expected = nodal_slip(
                &case.problem.mesh.contact,
                &case.scene.contact.frame(),
                &assembly.primal.dofs,
                &displacement,
            );
            let found = explicit
                .tangential_displacement(&multiplier)
                .expect("explicit");
            for (&node, u) in case.problem.mesh.contact.nodes.iter().zip(&found) {
                if assembly.primal.dofs.dof[node] == [None; 3] {
                    assert_eq!(*u, [0.0; 2]);
                }
            }
            let found: Vec<f64> = found.iter().flatten().map(|u| u.abs()).collect();
            assert!(distance(&found, &expected.concat()) < 1e-12);
        }
        assert_eq!(explicit.actions(), implicit.actions());
    }
}

/// Successive approximations with KPRGP take the same steps on both operators, and the explicit one
/// spares every solve over the body but the last.
#[test]
fn successive_approximations_on_both_operators() {
    let mut scene = hkl_scene(1, 4);
    scene.solve.precision = Fixed;
    let case = Dense::new(scene);
    let paper = case.problem.solve(&case.scene);
    let explicit = case.approximate(Inner::Kprgp);
    assert_eq!(explicit.history.len(), paper.history.len());
    // Each stops within ε = 1e-4 r_tol of its inner minimisers; equal paths differ by rounding only.
    assert!(distance(&explicit.multiplier, &paper.multiplier) < 1e-6);
    assert!(distance(&explicit.displacement, &paper.displacement) < 1e-6);
    assert!(
        explicit
            .slip
            .iter()
            .flatten()
            .zip(paper.slip.iter().flatten())
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
}

/// A loose inner tolerance may be met by the warm start, so that λ does not change at all; that
/// must not pass for convergence (constant F = 0.1 did after two outer steps).
#[test]
fn an_idle_inner_solver_is_no_convergence() {
    for value in [1e-9, 1e-3, 0.1] {
        let mut scene = hkl_scene(1, 4);
        let law = Coefficient::Constant(value);
        scene.friction = Friction {
            coefficient_1: law,
            coefficient_2: law,
        };
        scene.solve.epsilon = Some(1e-6);
        let dense = Dense::new(scene.clone());
        let newton = dense.solve(&scene.friction);
        let solution = dense.problem.solve(&scene);
        assert_eq!(solution.status, Status::Converged);
        let difference: f64 = solution
            .multiplier
            .iter()
            .zip(&newton.multiplier)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt();
        let size = newton.multiplier.iter().map(|l| l * l).sum::<f64>().sqrt();
        // ε = 1e-6, its inner tolerance amplified by the condition number of S, near 1e3.
        assert!(
            difference < 1e-4 * size,
            "F = {value}: {}",
            difference / size
        );
    }
}
