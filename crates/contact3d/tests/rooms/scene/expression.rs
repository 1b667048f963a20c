//! Parsing, evaluation and derivatives of formulas.

use contact3d::scene::{Expression, ExpressionError};
use proptest::prelude::*;

/// The most bytes that a formula may have, as its refusal says.
const LONGEST_TEXT: usize = 4096;

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

#[test]
fn formulas_are_evaluated_in_the_order_of_the_variables() {
    let e = parse("2*z - x^2 + 1e-3*sin(PI/2)");
    // Three roundings of numbers near 5.
    assert!((e.evaluate(&[1.0, 7.0, 3.0]) - 5.001).abs() < 1e-14);
    assert!(e.uses("x") && !e.uses("y"));
    assert_eq!(value("4.5", [0.0; 3]), 4.5);
    assert_eq!(value("8/4/2 - 1 - 1 + 2*3^2", [0.0; 3]), 17.0);
    assert_eq!(value("+x*(-y)", [2.0, 3.0, 0.0]), -6.0);
}

#[test]
fn a_leading_minus_binds_less_than_a_power() {
    let e = parse("exp(-x^2) - 2*(-y^2)");
    let (x, y) = (0.7_f64, 0.3_f64);
    // A few roundings of numbers near 1.
    let expected = (-x * x).exp() + 2.0 * y * y;
    assert!((e.evaluate(&[x, y, 0.0]) - expected).abs() < 1e-14);
    let expected = -2.0 * x * (-x * x).exp();
    assert!((e.derivatives(&[x, y, 0.0], [0, 1, 2])[0] - expected).abs() < 1e-14);
    assert_eq!(e.text(), "exp(-x^2) - 2*(-y^2)");
    assert_eq!(
        value("max(-x^2, -9) + if(-x < -1, -x, 0)", [2.0, 0.0, 0.0]),
        -6.0
    );
}

#[test]
fn choices_take_the_value_of_their_condition() {
    for (text, expected) in [
        ("abs(-3)", 3.0),
        ("min(3, 1, 2)", 1.0),
        ("max(1, 3, 2)", 3.0),
        ("if(1 < 2, 10, 20)", 10.0),
        ("if(2 < 2, 10, 20)", 20.0),
        ("if(2 <= 2, 10, 20)", 10.0),
        ("if(2 > 2, 10, 20)", 20.0),
        ("if(2 >= 2, 10, 20)", 10.0),
        ("if(1 > 2, 10, if(1 < 2, 30, 40))", 30.0),
        // What is not chosen need not be defined.
        ("if(1 < 2, 10, sqrt(0-1))", 10.0),
    ] {
        assert_eq!(value(text, [0.0; 3]), expected, "{text}");
    }
    for text in [
        "max(sqrt(0-1), 1)",
        "min(1, sqrt(0-1))",
        "if(sqrt(0-1) < 1, 1, 2)",
    ] {
        assert!(value(text, [0.0; 3]).is_nan(), "{text}");
    }
}

#[test]
fn derivatives_at_kinks_are_those_where_variables_grow() {
    for (text, at, expected) in [
        ("abs(x)", 0.0, 1.0),
        ("abs(0-x)", 0.0, 1.0),
        ("abs(1-x)", 1.0, 1.0),
        ("max(x, 1)", 1.0, 1.0),
        ("max(1, 2*x - 1)", 1.0, 2.0),
        ("min(x, 1)", 1.0, 0.0),
        ("min(1, 2*x - 1)", 1.0, 0.0),
        ("if(x < 1, 5*x, 3*x + 2)", 1.0, 3.0),
        ("if(x <= 1, 5*x, 3*x + 2)", 1.0, 3.0),
        ("if(x > 1, 5*x, 3*x + 2)", 1.0, 5.0),
        ("if(x <= 0, 0.3, 0.3 - x)", 0.0, -1.0),
        // A jump has the slope of the piece behind it.
        ("if(x <= 1, 5*x, 3*x)", 1.0, 3.0),
        ("if(x <= 1, x^2, sqrt(x-1))", 0.5, 1.0),
    ] {
        assert_eq!(slopes(text, [at, 0.0, 0.0])[0], expected, "{text}");
    }
    assert_eq!(value("if(x <= 1, 5*x, 3*x)", [1.0, 0.0, 0.0]), 5.0);
    // Where two variables meet, the derivatives are those of one piece.
    assert_eq!(slopes("max(x, y)", [1.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    assert_eq!(slopes("max(x, 2*y - 1)", [1.0, 1.0, 0.0]), [0.0, 2.0, 0.0]);
    // An infinite slope stays with its variable.
    assert_eq!(
        slopes("sqrt(x) + 2*y", [0.0, 1.0, 0.0]),
        [f64::INFINITY, 2.0, 0.0]
    );
}

#[test]
fn unknown_names_and_nonsense_are_refused() {
    for text in [
        "s1 + x",
        "foo(x)",
        "{x y}",
        "x +",
        "(x",
        "",
        "x y",
        "--",
        "1..2",
        "{x",
        "2*-x",
        "2^-x",
        "x--y",
        "sin x",
        "exp -x",
        "x^2^3",
        "x^(2)^3",
        "2(x)",
        "2x",
        "x < 1",
        "if(x, 1, 2)",
        "x)",
        "if(x < 1, 2)",
        "if(x < y < z, 1, 2)",
        "if(x = 1, 1, 2)",
        "max(x)",
        "min()",
        "max(x,)",
        "abs(x, y)",
        "x(2)",
        "PI(2)",
        "if",
        "max",
        "1,2",
        "if(x == 1, 2, 3)",
    ] {
        assert!(Expression::parse(text, SPACE).is_err(), "{text}");
    }
    let nested = "(".repeat(500) + "x" + &")".repeat(500);
    let long = "x*".repeat(LONGEST_TEXT / 2) + "x";
    for text in [&nested, &long] {
        assert_eq!(
            Expression::parse(text, SPACE).unwrap_err(),
            ExpressionError::TooLarge
        );
    }
    let product = "x*".repeat(LONGEST_TEXT / 2 - 1) + "x";
    // ∂xⁿ/∂x = n at 1: sums of ones.
    assert_eq!(
        slopes(&product, [1.0, 0.0, 0.0])[0],
        LONGEST_TEXT as f64 / 2.0
    );
}

proptest! {
    /// No text makes the parser or the evaluation panic.
    #[test]
    fn any_text_is_a_value_or_an_error(text in "[-+*/^()<>=xyz0-9.eE ,sincoqrtabmaxif{}π]{0,40}") {
        if let Ok(e) = Expression::parse(&text, SPACE) {
            let _ = e.evaluate(&[0.5, -1.0, 2.0]);
            let _ = e.derivatives(&[0.5, -1.0, 2.0], [0, 1, 2]);
        }
    }
}
