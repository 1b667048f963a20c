//! Smooth pieces of formulas, and derivatives against differences.

use contact3d::scene::{Formula, LAW_VARIABLES, LawPoint};
use proptest::prelude::*;

/// The places of the slips in [`LAW_VARIABLES`], that of `s` first.
const BY: [usize; 3] = [3, 4, 5];

fn formula(text: &str) -> Formula {
    assert_eq!(BY.map(|place| LAW_VARIABLES[place]), ["s", "s1", "s2"]);
    Formula::parse(text).unwrap()
}

fn point(s: f64) -> LawPoint {
    LawPoint {
        position: [0.0; 3],
        slip: [0.1, 0.0],
        own_slip: s,
    }
}

fn value(text: &str, s: f64) -> f64 {
    formula(text).expression().evaluate(&values(s))
}

fn slopes(text: &str, s: f64) -> [f64; 3] {
    formula(text).expression().derivatives(&values(s), BY)
}

/// The values of [`LAW_VARIABLES`].
fn values(s: f64) -> [f64; 6] {
    [0.0, 0.0, 0.0, s, 0.1, 0.0]
}

#[test]
fn a_branch_ends_only_at_branch_points_on_its_way() {
    let law = formula("if(s < 1, 0.3, max(0.1, 0.3 - s1*(s - 1)))");
    let ends = |s: f64| {
        let branch = law.branch(&point(s));
        let found = law.on_branch(&point(s), branch);
        found
            .ends
            .iter()
            .map(|end| end.branch_point)
            .collect::<Vec<_>>()
    };
    // The arguments of `if` are computed first, so its own branch point is the second.
    assert_eq!(ends(0.5), [1]);
    assert_eq!(ends(2.0), [0, 1]);
    // Branch points beyond the sixty-fourth go their own way.
    let many = (0..70).map(|_| "abs(s)").collect::<Vec<_>>().join(" + ");
    let many = formula(&many);
    let branch = many.branch(&point(-1.0));
    let beyond = many.on_branch(&point(1.0), branch);
    assert_eq!((beyond.value, beyond.ends.len()), (-64.0 + 6.0, 64));
}

/// Formulas with the places near which they have kinks.
fn smooth_away_from_kinks() -> impl Strategy<Value = (String, f64)> {
    let inner = prop_oneof![
        Just("s".to_owned()),
        (0.1..3.0_f64).prop_map(|a| format!("{a}*s")),
        (0.1..3.0_f64).prop_map(|a| format!("sin({a}*s) + 1.5")),
        (0.1..3.0_f64).prop_map(|a| format!("s^{a} + tanh(s)")),
        (0.1..3.0_f64).prop_map(|a| format!("exp(-s/{a}) + ln(s + {a})/log10(s + 20)")),
        (0.1..3.0_f64).prop_map(|a| format!("atan(s - {a}) + cosh(s/3) - sinh(s/4)")),
        (0.1..3.0_f64)
            .prop_map(|a| format!("sqrt(s + {a})*asin(s/5) + acos(s/6)*cos(s)/tan(1 + s/9)")),
        (0.1..3.0_f64).prop_map(|a| format!("{a}^s - s^s")),
    ];
    (inner.clone(), inner, 0.3..3.0_f64, 0_usize..8).prop_map(|(f, g, kink, shape)| {
        let text = match shape {
            0 => format!("abs(s - {kink})*({f}) + {g}"),
            1 => format!("max(s - {kink}, 0)*({f}) - min(s, {kink})*({g})"),
            2 => format!("if(s < {kink}, {f}, {g})"),
            3 => format!("if({kink} >= s, {f}, ({g})^2)"),
            4 => format!("({f})*if(s > {kink}, abs(s - {kink}), 1)/(1 + ({g})^2)"),
            5 => format!("max({kink}, s)^min(2, s - s + 3)*({f})"),
            6 => format!("if(s <= {kink}, 0, 1)*({f}) + if(s > {kink}, 0, 1)*({g})"),
            _ => format!("({f})/(3 + ({g})^2) - abs({kink} - s)"),
        };
        (text, kink)
    })
}

proptest! {
    // One formula in three has no derivative at its kink.
    #![proptest_config(ProptestConfig { max_global_rejects: 1 << 16, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_equal_differences((text, kink) in smooth_away_from_kinks(), x in 0.2..3.0_f64) {
        prop_assume!((x - kink).abs() > 1e-4);
        let step = 1e-5;
        let f = |x: f64| value(&text, x);
        let difference = (f(x + step) - f(x - step)) / (2.0 * step);
        let slope = slopes(&text, x)[0];
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
        let law = formula(&text);
        let branch = law.branch(&point(x));
        let here = law.on_branch(&point(x), branch);
        prop_assert_eq!(here.value.to_bits(), value(&text, x).to_bits(), "{}", text);
        prop_assert_eq!(here.slopes, slopes(&text, x), "{}", text);
        prop_assert!(here.ends.iter().all(|end| end.margin >= 0.0), "{text}: {here:?}");
        // The branch point at the kink, if the branch goes by it, has the distance to the kink as its margin.
        let end = here.ends.iter().find(|end| end.slopes[0].abs() == 1.0);
        if let Some(end) = end {
            prop_assert!((end.margin - (x - kink).abs()).abs() < 1e-12, "{text}: {end:?}");
            // Beyond it the branch goes on: no jump, and no bend, over a step across the kink.
            let beyond = kink - (x - kink).signum() * 1e-6;
            let across = law.on_branch(&point(beyond), branch);
            let before = law.on_branch(&point(2.0 * kink - beyond), branch);
            let line = before.value + before.slopes[0] * 2.0 * (beyond - kink);
            // 1e-12 times second derivatives up to 1e3.
            let size = 1.0 + across.value.abs() + across.slopes[0].abs();
            prop_assert!((across.value - line).abs() < 1e-8 * size, "{text} at {kink}: {across:?}");
            let own = across.ends.iter().find(|other| other.branch_point == end.branch_point).unwrap();
            prop_assert!(own.margin < 0.0);
            // The other side has a branch of its own there.
            let other = branch.with(end.branch_point, !end.less);
            let found = law.on_branch(&point(beyond), other);
            prop_assert!((found.value - value(&text, beyond)).abs() <= 1e-15 * size || found.ends.iter().any(|end| end.margin < 0.0));
        }
    }

    /// At a kink the derivative is that on the right, here by a one-sided difference.
    #[test]
    fn derivatives_at_kinks_equal_differences_to_the_right((text, kink) in smooth_away_from_kinks()) {
        let f = |x: f64| value(&text, x);
        let step = 1e-6;
        let (near, far) = (f(kink + step), f(kink + 2.0 * step));
        let slope = slopes(&text, kink)[0];
        let size = 1.0 + near.abs() + slope.abs();
        // Products with jumps mix values here with slopes behind. Without a jump the second
        // difference is 1e-12 times second derivatives up to 1e2.
        prop_assume!((f(kink) - 2.0 * near + far).abs() < 1e-8 * size);
        // Truncation 1e-6 times second derivatives up to 1e2, cancellation 1e-10 of values up to
        // 1e3.
        prop_assert!((slope - (far - near) / step).abs() < 1e-3 * size, "{text} at {kink}");
    }
}
