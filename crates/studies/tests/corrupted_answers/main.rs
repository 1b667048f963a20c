//! Answers that are wrong by a known amount: the certificate shows the amount, the verdict of the
//! stability suite rejects them, and the uncorrupted answer passes beside them.
//!
//! What each corruption must leave in the certificate follows from the amount by hand, in the
//! comments of `corruptions.rs`; no threshold of the program is used.

mod case;
mod corruptions;
mod figures;
mod operators;

use case::{Case, NAMES};
use contact3d::solver::Status;
use corruptions::{Corruption, all};
use studies::stability::{Invariance, InvarianceResult, VerdictLevel};

/// Between an answer and the smallest corruption of it lie at least this many times.
const SEPARATION: f64 = 100.0;

/// Every corruption that a scene has panes for is shown in full and fails the verdict.
#[test]
fn corrupted_answers_are_shown_and_rejected() {
    for (name, kinds) in NAMES {
        let case = Case::named(name);
        let clean = case.figure(&case.solution);
        let judged = case.judged(case.solution.clone());
        assert_eq!(judged.status, case.solution.status, "{name}");
        assert_eq!(judged.accuracy, case.solution.accuracy, "{name}");
        assert_ne!(
            case.verdict_of_certificate(clean),
            VerdictLevel::Fail,
            "{name}"
        );
        let corruptions = all(&case);
        // A scene that loses its sticking or open panes would test less without a word.
        assert_eq!(corruptions.len(), kinds, "{name}");
        for Corruption {
            what,
            solution,
            expected,
        } in corruptions
        {
            let figure = case.figure(&solution);
            assert!(
                figure >= expected && SEPARATION * clean <= expected,
                "{name}, {what}: the certificate shows {figure:e}, expected {expected:e}, clean {clean:e}"
            );
            let verdict = case.verdict_of_certificate(figure);
            assert_eq!(verdict, VerdictLevel::Fail, "{name}, {what}: {figure:e}");
            // The gate takes the claim back, as far as it speaks at all: above √ε.
            let judged = case.judged(solution);
            if expected > 1e-7 {
                assert_ne!(judged.status, Status::Converged, "{name}, {what}");
                // Within the hundredfold that a largest entry may exceed the mean error by.
                assert!(
                    judged.accuracy >= 0.01 * expected.min(1.0),
                    "{name}, {what}"
                );
            }
        }
    }
}

/// Algorithms that find another answer reject one whose certificate is said to be clean.
#[test]
fn cross_checks_reject_a_corrupted_multiplier() {
    for (name, _) in NAMES {
        // The algorithms agree to 1e-10, and 1e-6 of one of a hundred panes is 1e-8 of the whole at
        // least. Where the body nearly floats double precision tells no more than six digits from S
        // alone.
        let change = if name == "hard/soft_block.toml" {
            1e-5
        } else {
            1e-6
        };
        let case = Case::named(name);
        assert_ne!(
            case.verdict_of_multiplier(&case.solution.multiplier),
            VerdictLevel::Fail,
            "{name}"
        );
        let most = case.most_pressed();
        let mut multiplier = case.solution.multiplier.clone();
        multiplier[most] *= 1.0 + change;
        assert_eq!(
            case.verdict_of_multiplier(&multiplier),
            VerdictLevel::Fail,
            "{name}"
        );
    }
}

/// Whatever else is in order: a solve that failed, an answer that only one algorithm finds, and a
/// bit that changes with the number of threads are each a failure.
#[test]
fn one_fault_alone_fails_the_verdict() {
    let case = Case::named("frictionless.toml");
    assert_eq!(case.verdict(|_| {}), VerdictLevel::Pass);
    for status in [Status::Inaccurate, Status::Cycling, Status::NumericalError] {
        let verdict = case.verdict(|check| check.status = status);
        assert_eq!(verdict, VerdictLevel::Fail, "{status:?}");
    }
    assert_eq!(
        case.verdict(|check| check.cross_checks.truncate(1)),
        VerdictLevel::Fail
    );
    for invariance in Invariance::ALL {
        let differs = |difference: f64| {
            case.verdict(|check| {
                check.invariances = vec![InvarianceResult {
                    invariance,
                    status: Status::Converged,
                    difference,
                    residual: 0.0,
                }];
            })
        };
        let exact = matches!(
            invariance,
            Invariance::BinaryUnits | Invariance::LoadScaling | Invariance::Threads
        );
        let by_a_bit = if exact {
            VerdictLevel::Fail
        } else {
            VerdictLevel::Pass
        };
        assert_eq!(differs(f64::EPSILON), by_a_bit, "{invariance:?}");
        assert_eq!(differs(0.0), VerdictLevel::Pass, "{invariance:?}");
        // Another answer, where one was expected.
        assert_eq!(differs(1e-3), VerdictLevel::Fail, "{invariance:?}");
    }
}
