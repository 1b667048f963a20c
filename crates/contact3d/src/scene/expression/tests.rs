//! Branches, parameters and derivatives of formulas.

use proptest::prelude::*;

use super::*;

const SPACE: &[&str] = &["x", "y", "z"];

fn parse(text: &str) -> Expression {
    Expression::parse(text, SPACE).unwrap()
}

fn value(text: &str, at: [f64; 3]) -> f64 {
    parse(text).evaluate(&at)
}

fn slopes(text: &str, at: [f64; 3]) -> [f64; 3] {
    parse(text).derivatives(&at, [0, 1, 2])
}

fn bound(text: &str, parameters: &[(&str, f64)]) -> Result<Expression, ExpressionError> {
    let parameters = parameters.iter().map(|(name, v)| ((*name).to_owned(), *v));
    let mut expression = Expression::unbound(text, SPACE)?;
    expression.bind(&parameters.collect())?;
    Ok(expression)
}

#[test]
fn a_branch_ends_only_at_forks_on_its_way() {
    let e = Expression::parse("if(x < 1, 0.3, max(0.1, 0.3 - y*(x - 1)))", SPACE).unwrap();
    let ends = |x: f64| {
        let values = [x, 0.1, 0.0];
        let branch = e.branch(&values, [0, 1, 2]);
        let found = e.on_branch(&values, [0, 1, 2], branch);
        found.ends.iter().map(|end| end.fork).collect::<Vec<_>>()
    };
    // The arguments of `if` are computed first, so its own fork is the second.
    assert_eq!(ends(0.5), [1]);
    assert_eq!(ends(2.0), [0, 1]);
    // Forks beyond the sixty-fourth go their own way.
    let many = (0..70).map(|_| "abs(x)").collect::<Vec<_>>().join(" + ");
    let many = Expression::parse(&many, SPACE).unwrap();
    let branch = many.branch(&[-1.0, 0.0, 0.0], [0, 1, 2]);
    let beyond = many.on_branch(&[1.0, 0.0, 0.0], [0, 1, 2], branch);
    assert_eq!((beyond.value, beyond.ends.len()), (-64.0 + 6.0, 64));
}

#[test]
fn parameters_have_the_values_they_are_bound_to() {
    let e = bound("mu*x + mu^k", &[("mu", 3.0), ("k", 2.0), ("spare", 0.0)]).unwrap();
    assert_eq!(e.evaluate(&[2.0, 0.0, 0.0]), 15.0);
    assert_eq!(e.derivatives(&[2.0, 0.0, 0.0], [0, 1, 2]), [3.0, 0.0, 0.0]);
    assert_eq!(e.parameters().collect::<Vec<_>>(), ["mu", "k"]);
    let moved = e.with_variables(&[("x", "2*x".to_owned())]).times(2.0);
    assert_eq!(moved.text(), "(2.0)*(mu*(2*x) + mu^k)");
    assert_eq!(moved.evaluate(&[1.0, 0.0, 0.0]), 30.0);
    assert_ne!(e, bound("mu*x + mu^k", &[("mu", 4.0), ("k", 2.0)]).unwrap());
    let error = bound("mo*x", &[("mu", 3.0)]).unwrap_err().to_string();
    assert!(
        error.contains("\"mo\"") && error.contains("the parameters mu"),
        "{error}"
    );
}

/// Formulas with the places near which they have kinks.
fn smooth_away_from_kinks() -> impl Strategy<Value = (String, f64)> {
    let inner = prop_oneof![
        Just("x".to_owned()),
        (0.1..3.0_f64).prop_map(|a| format!("{a}*x")),
        (0.1..3.0_f64).prop_map(|a| format!("sin({a}*x) + 1.5")),
        (0.1..3.0_f64).prop_map(|a| format!("x^{a} + tanh(x)")),
        (0.1..3.0_f64).prop_map(|a| format!("exp(-x/{a}) + ln(x + {a})/log10(x + 20)")),
        (0.1..3.0_f64).prop_map(|a| format!("atan(x - {a}) + cosh(x/3) - sinh(x/4)")),
        (0.1..3.0_f64)
            .prop_map(|a| format!("sqrt(x + {a})*asin(x/5) + acos(x/6)*cos(x)/tan(1 + x/9)")),
        (0.1..3.0_f64).prop_map(|a| format!("{a}^x - x^x")),
    ];
    (inner.clone(), inner, 0.3..3.0_f64, 0_usize..8).prop_map(|(f, g, kink, shape)| {
        let text = match shape {
            0 => format!("abs(x - {kink})*({f}) + {g}"),
            1 => format!("max(x - {kink}, 0)*({f}) - min(x, {kink})*({g})"),
            2 => format!("if(x < {kink}, {f}, {g})"),
            3 => format!("if({kink} >= x, {f}, ({g})^2)"),
            4 => format!("({f})*if(x > {kink}, abs(x - {kink}), 1)/(1 + ({g})^2)"),
            5 => format!("max({kink}, x)^min(2, x - x + 3)*({f})"),
            6 => format!("if(x <= {kink}, 0, 1)*({f}) + if(x > {kink}, 0, 1)*({g})"),
            _ => format!("({f})/(3 + ({g})^2) - abs({kink} - x)"),
        };
        (text, kink)
    })
}

proptest! {
    #[test]
    fn derivatives_equal_differences((text, kink) in smooth_away_from_kinks(), x in 0.2..3.0_f64) {
        prop_assume!((x - kink).abs() > 1e-4);
        let step = 1e-5;
        let f = |x: f64| value(&text, [x, 0.0, 0.0]);
        let difference = (f(x + step) - f(x - step)) / (2.0 * step);
        let slope = slopes(&text, [x, 0.0, 0.0])[0];
        // Truncation 1e-10 times third derivatives up to 1e3, cancellation 1e-11 of values up to
        // 1e3.
        let size = 1.0 + f(x).abs() + slope.abs();
        prop_assert!((slope - difference).abs() < 1e-6 * size, "{text} at {x}: {slope}, {difference}");
    }

    /// On the branch of a point a formula is itself, and goes on smoothly to the other side of its kinks; the ends of the branch
    /// are where the kinks are.
    #[test]
    fn branches_are_the_formula_and_go_on_beyond_its_kinks((text, kink) in smooth_away_from_kinks(), x in 0.2..3.0_f64) {
        prop_assume!((x - kink).abs() > 1e-4);
        let e = Expression::parse(&text, SPACE).unwrap();
        let by = [0, 1, 2];
        let branch = e.branch(&[x, 0.0, 0.0], by);
        let here = e.on_branch(&[x, 0.0, 0.0], by, branch);
        prop_assert_eq!(here.value.to_bits(), e.evaluate(&[x, 0.0, 0.0]).to_bits(), "{}", text);
        prop_assert_eq!(here.slopes, e.derivatives(&[x, 0.0, 0.0], by), "{}", text);
        prop_assert!(here.ends.iter().all(|end| end.margin >= 0.0), "{text}: {here:?}");
        // The fork at the kink, if the branch goes by it, has the distance to the kink as its margin.
        let end = here.ends.iter().find(|end| end.slopes[0].abs() == 1.0);
        if let Some(end) = end {
            prop_assert!((end.margin - (x - kink).abs()).abs() < 1e-12, "{text}: {end:?}");
            // Beyond it the branch goes on: no jump, and no bend, over a step across the kink.
            let beyond = kink - (x - kink).signum() * 1e-6;
            let across = e.on_branch(&[beyond, 0.0, 0.0], by, branch);
            let before = e.on_branch(&[2.0 * kink - beyond, 0.0, 0.0], by, branch);
            let line = before.value + before.slopes[0] * 2.0 * (beyond - kink);
            // 1e-12 times second derivatives up to 1e3.
            let size = 1.0 + across.value.abs() + across.slopes[0].abs();
            prop_assert!((across.value - line).abs() < 1e-8 * size, "{text} at {kink}: {across:?}");
            let own = across.ends.iter().find(|other| other.fork == end.fork).unwrap();
            prop_assert!(own.margin < 0.0);
            // The other side has a branch of its own there.
            let other = branch.with(end.fork, !end.less);
            let found = e.on_branch(&[beyond, 0.0, 0.0], by, other);
            prop_assert!((found.value - e.evaluate(&[beyond, 0.0, 0.0])).abs() <= 1e-15 * size || found.ends.iter().any(|end| end.margin < 0.0));
        }
    }

    /// At a kink the derivative is that on the right, here by a one-sided difference.
    #[test]
    fn derivatives_at_kinks_equal_differences_to_the_right((text, kink) in smooth_away_from_kinks()) {
        let f = |x: f64| value(&text, [x, 0.0, 0.0]);
        let step = 1e-6;
        let (near, far) = (f(kink + step), f(kink + 2.0 * step));
        let slope = slopes(&text, [kink, 0.0, 0.0])[0];
        let size = 1.0 + near.abs() + slope.abs();
        // Products with jumps mix values here with slopes behind. Without a jump the second
        // difference is 1e-12 times second derivatives up to 1e2.
        prop_assume!((f(kink) - 2.0 * near + far).abs() < 1e-8 * size);
        // Truncation 1e-6 times second derivatives up to 1e2, cancellation 1e-10 of values up to
        // 1e3.
        prop_assert!((slope - (far - near) / step).abs() < 1e-3 * size, "{text} at {kink}");
    }
}
