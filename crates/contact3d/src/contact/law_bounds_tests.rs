//! Laws that are warned of and refused.

use super::{
    FaceLaw,
    law_bounds::{refuse_unusable, warnings},
};
use crate::scene::{Coefficient, Formula, FrictionLaw};

fn formula(text: &str) -> Coefficient {
    Coefficient::Expression(Formula::parse(text).unwrap())
}

fn pair(first: Coefficient, second: Coefficient) -> FrictionLaw {
    FrictionLaw::Orthotropic(Box::new([first, second]))
}

/// A law on 33 × 33 nodes of (0, 1)².
fn on_square(law: FrictionLaw) -> FaceLaw {
    let at = |k: usize| [(k % 33) as f64 / 32.0, (k / 33) as f64 / 32.0, 0.0];
    FaceLaw::new("friction", law, (0..33 * 33).map(at).collect())
}

fn words(law: &FaceLaw) -> Vec<String> {
    warnings(law, 3.0, "m")
        .iter()
        .map(ToString::to_string)
        .collect()
}

#[test]
fn laws_that_fail_at_some_slip_are_warned_of_with_onset_and_place() {
    let cases = [
        (
            "0.3 - 0.2*s1",
            "first at |u_t1| = 1.5000e0 m",
            "|u_t1| = 3.0000e0 m",
        ),
        (
            "0.3 - 2e5*s2",
            "first at |u_t2| = 1.5000e-6 m",
            "|u_t2| = 3.0000e0 m",
        ),
        (
            "0.3 + exp(1e3*s2)",
            "first at |u_t2| = 7.0978e-1 m",
            "at worst inf at |u_t2|",
        ),
        (
            "sqrt(1 - s1)",
            "first at |u_t1| = 1.0000e0 m",
            "at worst nan at |u_t1|",
        ),
        // Negative only around 1e-3, in a dip narrower than a decade.
        (
            "0.3 - 0.31*exp(0 - ((s2-1e-3)/1e-3)^2)",
            "first at |u_t2| = 8.1892e-4 m",
            "|u_t2| = 1.0000e-3 m",
        ),
    ];
    for (text, onset, place) in cases {
        let law = on_square(pair(Coefficient::Constant(0.3), formula(text)));
        assert_eq!(refuse_unusable(&law, "m"), Ok(()), "{text}");
        let found = words(&law);
        assert_eq!(found.len(), 1, "{found:?}");
        for fragment in ["friction.coefficient_2.expression: not 0 < F", onset, place] {
            assert!(found[0].contains(fragment), "{text}: {}", found[0]);
        }
    }
    let isotropic = on_square(FrictionLaw::Isotropic(formula("0.3 - s")));
    let found = words(&isotropic);
    assert!(
        found[0].starts_with("friction.coefficient.expression"),
        "{found:?}"
    );
    assert!(
        found[0].contains("first at |u_t| = 3.0000e-1 m,"),
        "{found:?}"
    );
    let good = on_square(pair(formula("0.3 - 0.09*s1 + 1e-9*x"), formula("1e-30")));
    assert!(words(&good).is_empty());
}

/// What a warning advises ends it.
#[test]
fn the_advice_about_a_law_helps() {
    for (text, advice, followed) in [
        (
            "0.3 - 1e3*s",
            "max(FORMULA, 0.05)",
            "max(0.3 - 1e3*s, 0.05)",
        ),
        (
            "0.3 + exp(1e3*s)",
            "min(FORMULA, 1)",
            "min(0.3 + exp(1e3*s), 1)",
        ),
        (
            "sqrt(1 - s)",
            "if(CONDITION, FORMULA, VALUE)",
            "if(s < 0.99, sqrt(1 - s), 0.1)",
        ),
    ] {
        let found = words(&on_square(FrictionLaw::Isotropic(formula(text))));
        assert!(found[0].contains(advice), "{}", found[0]);
        let found = words(&on_square(FrictionLaw::Isotropic(formula(followed))));
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn laws_that_fail_without_slip_are_refused_with_the_place() {
    for (text, fragment) in [
        ("0.3 + ln(s2)", "-inf at |u_t2| = 0.0000e0 m"),
        ("x - 0.5", "-0.5 at x, y, z = 0.0, 0.0, 0.0"),
        ("0 - 1", "-1.0 at every slip"),
        ("0", "0.0 at every slip"),
    ] {
        let law = on_square(pair(Coefficient::Constant(0.3), formula(text)));
        let refused = refuse_unusable(&law, "m").expect_err(text);
        assert_eq!(refused.key, "friction.coefficient_2.expression");
        assert!(
            refused.found.contains(fragment),
            "{text}: {}",
            refused.found
        );
    }
}
