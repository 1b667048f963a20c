//! GPCG as inner solver of successive approximations.

use contact3d::{
    dual::{BodyOperator, ContactOperator, DualOperator, PrimalOperator},
    scene::PrecisionControl::{Adaptive, Fixed},
    solver::{
        Gpcg, Inner, MethodResult, NewtonSettings, Start, StopReason, SuccessiveApproximations,
        coulomb_state, minimise_frozen, projected_gradient_steplength,
    },
};

use super::{dense::*, support::hkl_scene};

/// The inner problem of the answer, to rounding: open, sticking and slipping panes, ellipses of
/// all sizes and, in one of the laws, of ratio 1e6.
#[test]
fn gpcg_and_newton_find_the_same_minimisers() {
    for (table, n_div) in [(1, 4), (2, 8)] {
        let case = Dense::new(hkl_scene(table, n_div));
        let published = ("published", case.law());
        for (name, law) in [published].into_iter().chain(hard_laws()) {
            let answer = case.solve(&law);
            let start = vec![0.0; case.dual.dimension()];
            case.with_contact(&law, |laws, coulomb| {
                let state = coulomb_state(&case.dual, laws, coulomb, &answer.unknowns);
                let set = laws.feasible_set(Some(&state));
                let settings = NewtonSettings::default();
                let newton = minimise_frozen(&case.dual, &set, &start, &settings, |_, _| {});
                assert_eq!(newton.stop, StopReason::Converged);
                let mut operator = ContactOperator::explicit(
                    &case.dual,
                    case.problem.assembly(),
                    case.problem.contact(),
                );
                let solver = Gpcg {
                    steplength: projected_gradient_steplength(&mut operator),
                    max_applications: 10_000,
                };
                let mut multiplier = start.clone();
                let tolerance = 1e-11 * norm(&case.dual.rhs);
                let outcome = solver.minimise(&mut operator, &set, &mut multiplier, tolerance);
                let name = format!("{name}, n_div {n_div}");
                assert!(outcome.converged, "{name}");
                // A gradient of 1e-11 ‖h‖ times the condition number of S, some thousands.
                let error = distance(&multiplier, &newton.unknowns);
                assert!(error < 1e-7, "{name}: {error:e}");
            });
        }
    }
}

fn on_implicit(case: &Dense, inner: Inner<'_>) -> MethodResult {
    case.with_contact(&case.law(), |laws, law| {
        let mut operator =
            ContactOperator::implicit(case.problem.assembly(), case.problem.contact());
        let method = SuccessiveApproximations {
            inner,
            body: &case.problem.body(),
            laws,
            law,
            settings: &case.scene.solve,
        };
        let mut held = BodyOperator::Constrained(&mut operator);
        method.solve(&mut held, Start::default(), &mut |_| {})
    })
}

#[test]
fn gpcg_needs_a_tenth_of_the_actions_on_both_operators() {
    for table in [1, 2] {
        let mut scene = hkl_scene(table, 4);
        scene.solve.precision = Fixed;
        scene.solve.epsilon = Some(1e-8);
        let case = Dense::new(scene);
        let newton = case.solve(&case.law());
        let paper = case.approximate(Inner::Kprgp);
        for found in [
            case.approximate(Inner::Gpcg(&case.local.stiffness)),
            on_implicit(&case, Inner::Gpcg(&case.local.stiffness)),
        ] {
            assert_eq!(found.stop, StopReason::Converged);
            // Inner gradients of 1e-9 ‖h‖ times the condition number of S, some hundreds.
            assert!(distance(&found.solution.multiplier, &newton.unknowns) < 1e-6);
            // Measured: a twentieth.
            assert!(10 * found.solution.trace.applications < paper.solution.trace.applications);
        }
    }
}

#[test]
fn gpcg_converges_under_adaptive_precision() {
    let mut scene = hkl_scene(1, 8);
    scene.solve.precision = Adaptive;
    scene.solve.epsilon = Some(1e-8);
    let case = Dense::new(scene);
    let found = case.approximate(Inner::Gpcg(&case.local.stiffness));
    assert_eq!(found.stop, StopReason::Converged);
    let newton = case.solve(&case.law());
    // As above, with a condition number of some thousands.
    assert!(distance(&found.solution.multiplier, &newton.unknowns) < 1e-5);
}

#[test]
fn gpcg_out_of_actions_is_a_status() {
    let mut scene = hkl_scene(1, 4);
    scene.solve.max_operator_applications = 5;
    let case = Dense::new(scene);
    let found = case.approximate(Inner::Gpcg(&case.local.stiffness));
    assert_eq!(found.stop, StopReason::MaxOperatorApplications);
}

/// The implicit operator, whose applications give NaN from some number on.
struct Broken<'a> {
    sound: ContactOperator<'a>,
    from: usize,
}

impl DualOperator for Broken<'_> {
    fn dimension(&self) -> usize {
        self.sound.dimension()
    }
    fn rhs(&self) -> &[f64] {
        self.sound.rhs()
    }
    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let product = self.sound.apply(multiplier);
        let broken = self.applications() >= self.from;
        let factor = if broken { f64::NAN } else { 1.0 };
        product.iter().map(|v| factor * v).collect()
    }
    fn applications(&self) -> usize {
        self.sound.applications()
    }
}

impl PrimalOperator for Broken<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.sound.to_primal(multiplier)
    }
    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        self.sound.tangential_displacement(multiplier)
    }
}

#[test]
fn gpcg_with_values_that_are_not_finite_is_a_status() {
    let case = Dense::new(hkl_scene(1, 4));
    let mut sound = ContactOperator::implicit(case.problem.assembly(), case.problem.contact());
    let _ = projected_gradient_steplength(&mut sound);
    let first = sound.applications() + 1;
    for from in [first, first + 1, first + 40] {
        let found = case.with_contact(&case.law(), |laws, law| {
            let mut operator = Broken {
                sound: ContactOperator::implicit(case.problem.assembly(), case.problem.contact()),
                from,
            };
            let method = SuccessiveApproximations {
                inner: Inner::Gpcg(&case.local.stiffness),
                body: &case.problem.body(),
                laws,
                law,
                settings: &case.scene.solve,
            };
            let mut held = BodyOperator::Constrained(&mut operator);
            method.solve(&mut held, Start::default(), &mut |_| {})
        });
        assert_eq!(
            found.stop,
            StopReason::NumericalError,
            "from application {from}"
        );
    }
}
