//! The words that people read; no computing here.

use crate::{
    dual::OperatorEstimate,
    solver::{Progress, Solution, Status},
    stages::Performed,
};

/// One line per stage done.
pub(super) fn stage_line(performed: &Performed) -> String {
    let stage = performed.stage.group();
    let computed = format!("{stage:<9} done in {:.3} s", performed.compute_seconds);
    match performed.store_seconds {
        0.0 => format!("{computed}, stored with the next stage"),
        seconds => format!("{computed}, stored in {seconds:.3} s"),
    }
}

/// How the dual operator is held, and what either form costs.
pub(super) fn operator_line(estimate: &OperatorEstimate, dense: bool) -> String {
    format!(
        "{:<9} {} (dense: {:.1} MB and {:.2e} operations to form; factor: {:.1} MB, {:.2e} operations an action)",
        "dual",
        if dense { "explicit" } else { "implicit" },
        estimate.explicit_bytes / 1e6,
        estimate.explicit_operations,
        estimate.factor_bytes / 1e6,
        estimate.action_operations,
    )
}

/// Progress of a solve.
pub(super) fn progress(progress: Progress<'_>) -> String {
    match progress {
        Progress::Outer(k, step) => {
            format!(
                "outer step {}, change {:.1e}, {} actions",
                k + 1,
                step.change,
                step.actions
            )
        }
        Progress::Newton(k, step) => {
            let how = if step.fallback { "safeguard" } else { "Newton" };
            let law = match step.law_share {
                1.0 => String::new(),
                share => format!(", law F^{share:.3}"),
            };
            format!("{how} step {}, residual {:.1e}{law}", k + 1, step.residual)
        }
        Progress::Between(_) => String::new(),
    }
}

/// What a status means to a person.
pub(super) fn status(solution: &Solution) -> String {
    let accuracy = solution.accuracy;
    match solution.status {
        Status::Converged => format!("converged to {accuracy:.1e}"),
        Status::RoundingLimit => {
            format!("stopped at the attainable accuracy {accuracy:.1e}: rounding forbids more")
        }
        Status::MaxOuterSteps => {
            "NOT CONVERGED: out of outer steps; raise max_outer_steps or epsilon".into()
        }
        Status::MaxInnerActions => {
            "NOT CONVERGED: an inner problem ran out of actions; raise max_inner_actions or epsilon"
                .into()
        }
        Status::NumericalError => {
            "NOT CONVERGED: a value is not finite, or a coefficient of friction not positive at the slips reached; check loads, material and formulas".into()
        }
        Status::MaxNewtonSteps => {
            "NOT CONVERGED: Newton's method gave up; choose method auto or fixed-point".into()
        }
        Status::Inaccurate => format!(
            "NOT CONVERGED: the stopping rule is met, but the multipliers are off by about {accuracy:.1e}; lower epsilon, or choose method auto"
        ),
        Status::Cycling => {
            "NOT CONVERGED: successive approximations go round in a cycle; choose method newton".into()
        }
    }
}
