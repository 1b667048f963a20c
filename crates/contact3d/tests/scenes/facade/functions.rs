//! A Rust function means what the formula or the ramp means that computes the same.

use contact3d::{
    scene::{Coefficient, Friction, LawPoint, Quantity, Scene, SlipDerivative},
    solver::Status,
};

use super::{assembled, block, distance, solved};

/// Two answers, each within 1e-12 of the same one, times the conditioning of the problem.
const SAME: f64 = 1e-10;

fn assert_same(by_function: Scene, by_text: Scene) {
    let [first, second] = [by_function, by_text].map(|scene| solved(&assembled(scene)));
    assert_eq!(first.status, Status::Converged);
    assert_eq!(second.status, Status::Converged);
    let difference = distance(&first.multiplier, &second.multiplier);
    assert!(difference < SAME, "{difference:e}");
}

fn formula(text: &str) -> Coefficient {
    Coefficient::formula(text).expect("a formula")
}

/// 0.3 + 0.05 x − 0.1 tanh(s1/2e-5) + 0.02 tanh(s2/1e-5).
fn varied(at: &LawPoint) -> (f64, SlipDerivative) {
    let [first, second] = [at.slip[0] / 2e-5, at.slip[1] / 1e-5];
    let value = 0.3 + 0.05 * at.position[0] - 0.1 * first.tanh() + 0.02 * second.tanh();
    let pair = [
        -0.1 / 2e-5 / first.cosh().powi(2),
        0.02 / 1e-5 / second.cosh().powi(2),
    ];
    let derivative = SlipDerivative { own: 0.0, pair };
    (value, derivative)
}

const VARIED: &str = "0.3 + 0.05*x - 0.1*tanh(s1/2e-5) + 0.02*tanh(s2/1e-5)";

#[test]
fn coefficients_of_place_and_both_slips_are_their_formulas() {
    let constant = || Coefficient::from(0.25);
    assert_same(
        block(Friction::orthotropic(
            Coefficient::of_point(varied),
            constant(),
        )),
        block(Friction::orthotropic(formula(VARIED), constant())),
    );
    let exponential = |slip: f64| {
        let excess = 0.1 * (-slip / 1e-5).exp();
        (0.2 + excess, -excess / 1e-5)
    };
    assert_same(
        block(Friction::orthotropic(
            0.3,
            Coefficient::of_slip(exponential),
        )),
        block(Friction::orthotropic(
            0.3,
            formula("0.2 + 0.1*exp(-s2/1e-5)"),
        )),
    );
}

#[test]
fn loads_and_gaps_are_their_formulas() {
    let with = |load: Quantity, gap: Quantity| {
        let mut scene = block(Friction::coulomb(0.3));
        scene.pressures[0].value = load;
        scene.contacts[0].gap = gap;
        scene
    };
    let text = |text| Quantity::formula(text).expect("a formula");
    assert_same(
        with(
            Quantity::function(|[x, y, _]| 1e7 + 4e6 * x * y),
            Quantity::function(|[x, _, _]| 1e-6 * x),
        ),
        with(text("1e7 + 4e6*x*y"), text("1e-6*x")),
    );
}

/// Newton's method goes by the derivative. A wrong one may cost the answer, but no wrong answer passes for the right
/// one.
#[test]
fn a_wrong_derivative_never_makes_a_wrong_answer() {
    let law = |slip: f64| 0.15 + 0.25 * (-slip / 2e-5).exp();
    let right = move |slip: f64| (law(slip), -(law(slip) - 0.15) / 2e-5);
    let exact = solved(&assembled(block(Friction::coulomb(Coefficient::of_slip(
        right,
    )))));
    for factor in [-1.0, 0.0, 3.0] {
        let wrong = move |slip: f64| (law(slip), factor * right(slip).1);
        let found = solved(&assembled(block(Friction::coulomb(Coefficient::of_slip(
            wrong,
        )))));
        let error = distance(&found.multiplier, &exact.multiplier);
        if found.status.is_solved() {
            // The stated error is that of a step with a wrong derivative, off by about its factor.
            assert!(error <= 1e-9 + 10.0 * found.accuracy, "{factor}: {error:e}");
        } else {
            assert!(found.accuracy > 0.0, "{factor}: {:?}", found.status);
        }
    }
}
