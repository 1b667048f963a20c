use std::{fmt, thread};

use exmex::{Differentiate, Express, FlatEx, FloatOpsFactory, MatchLiteral};
use thiserror::Error;

use super::notation::on_paper;

/// Longest text of an expression, in bytes.
const LONGEST_TEXT: usize = 4096;

/// Deepest nesting of parentheses; the parser and the derivatives recurse.
const DEEPEST_NESTING: usize = 64;

/// Most signs + − * / ^, those of exponents such as 1e-5 included: the
/// derivatives recurse over them, and their time grows with a high power of this number.
const MOST_OPERATORS: usize = 40;

/// Stack of the thread that differentiates, in bytes: it takes up to some 200 kB for each operator.
const DERIVATIVE_STACK: usize = 256 << 20;

exmex::literal_matcher_from_pattern!(Decimal, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?");

type Tree = FlatEx<f64, FloatOpsFactory<f64>, Decimal>;

/// A formula in named variables, such as `0.3 - 0.1*tanh(s1/1e-5)`.
///
/// Operators + − * / ^, the functions of [`FUNCTIONS`] with parentheses, and the constants PI and
/// E; −x^2 is −(x^2).
#[derive(Clone)]
pub struct Expression {
    parsed: Box<Parsed>,
    /// For each variable of the tree, its place among the allowed ones.
    places: Vec<usize>,
    variables: &'static [&'static str],
}

/// A formula as written, and as read.
#[derive(Clone)]
struct Parsed {
    text: String,
    tree: Tree,
}

/// The functions of an expression, all of them differentiable where they are defined.
pub const FUNCTIONS: &[&str] = &[
    "sqrt", "exp", "ln", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh",
    "tanh",
];

/// Why a text is no usable expression.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ExpressionError {
    /// The parser does not understand the text.
    #[error("{text:?} is no expression: {reason}")]
    Syntax {
        /// The text.
        text: String,
        /// What the parser says.
        reason: String,
    },
    /// A name that is no variable here.
    #[error("unknown name {name:?}; expected the variables {allowed}, the functions {}, PI or E", FUNCTIONS.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// The variables that may be used.
        allowed: String,
    },
    /// Too long, or too deeply nested.
    #[error(
        "an expression has at most {LONGEST_TEXT} bytes, {MOST_OPERATORS} operators and {DEEPEST_NESTING} nested parentheses; a table or a grid takes more"
    )]
    TooLarge,
}

impl Expression {
    /// Parses a formula that may use the given variables only.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula, unknown names, and formulas without limits.
    pub fn parse(text: &str, variables: &'static [&'static str]) -> Result<Self, ExpressionError> {
        check_size(text)?;
        check_names(text, variables)?;
        let syntax = |reason: String| ExpressionError::Syntax {
            text: text.to_owned(),
            reason,
        };
        let unambiguous = on_paper(text).map_err(|advice| syntax(advice.to_owned()))?;
        let tree = Tree::parse(&unambiguous).map_err(|e| syntax(e.msg().to_owned()))?;
        let places: Option<Vec<usize>> = tree
            .var_names()
            .iter()
            .map(|name| variables.iter().position(|v| v == name))
            .collect();
        let expression = Self {
            places: places.ok_or_else(|| syntax("a name in braces is no variable".into()))?,
            parsed: Box::new(Parsed {
                text: text.to_owned(),
                tree,
            }),
            variables,
        };
        Ok(expression)
    }

    /// The formula as written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.parsed.text
    }

    /// The value for the variables in the order in which [`Self::parse`] was given them; not
    /// finite outside the formula's domain.
    #[must_use]
    pub fn evaluate(&self, values: &[f64]) -> f64 {
        let mut own = [0.0; 8];
        for (own, &place) in own.iter_mut().zip(&self.places) {
            *own = values[place];
        }
        self.parsed
            .tree
            .eval(&own[..self.places.len()])
            .unwrap_or(f64::NAN)
    }

    /// Whether the formula uses a variable.
    #[must_use]
    pub fn uses(&self, variable: &str) -> bool {
        self.places.iter().any(|&p| self.variables[p] == variable)
    }

    /// The partial derivative with respect to a variable; `None` for one it does not use.
    ///
    /// # Errors
    /// [`ExpressionError::Syntax`] when a function has no derivative.
    pub fn derivative(&self, variable: &str) -> Result<Option<Self>, ExpressionError> {
        let Some(index) = self
            .places
            .iter()
            .position(|&p| self.variables[p] == variable)
        else {
            return Ok(None);
        };
        let tree = Tree::clone(&self.parsed.tree);
        let tree = thread::Builder::new()
            .stack_size(DERIVATIVE_STACK)
            .spawn(move || tree.partial(index))
            .ok()
            .and_then(|thread| thread.join().ok())
            .ok_or(ExpressionError::TooLarge)?
            .map_err(|e| ExpressionError::Syntax {
                text: self.text().to_owned(),
                reason: e.msg().to_owned(),
            })?;
        Ok(Some(Self {
            parsed: Box::new(Parsed {
                text: format!("d/d{variable} ({})", self.text()),
                tree,
            }),
            places: self.places.clone(),
            variables: self.variables,
        }))
    }
}

fn check_size(text: &str) -> Result<(), ExpressionError> {
    let operators = text.bytes().filter(|byte| b"+-*/^".contains(byte)).count();
    let mut depth = 0_usize;
    for byte in text.bytes() {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST_NESTING {
            return Err(ExpressionError::TooLarge);
        }
    }
    if text.len() > LONGEST_TEXT || operators > MOST_OPERATORS {
        return Err(ExpressionError::TooLarge);
    }
    Ok(())
}

/// Refuses every name that is neither a variable, a function nor a constant.
fn check_names(text: &str, variables: &[&str]) -> Result<(), ExpressionError> {
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let number = Decimal::is_literal(rest).map_or(0, str::len);
        let name = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let length = match (number, name) {
            (0, 0) if "{}".contains(c) => {
                return Err(ExpressionError::Syntax {
                    text: text.to_owned(),
                    reason: "braces have no meaning".into(),
                });
            }
            (0, 0) => c.len_utf8(),
            (0, name) => {
                let found = &rest[..name];
                let known = variables.contains(&found)
                    || FUNCTIONS.contains(&found)
                    || ["PI", "E"].contains(&found);
                if !known {
                    return Err(ExpressionError::Unknown {
                        name: found.to_owned(),
                        allowed: variables.join(", "),
                    });
                }
                name
            }
            (number, _) => number,
        };
        rest = &rest[length..];
    }
    Ok(())
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text() == other.text() && self.variables == other.variables
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SPACE: &[&str] = &["x", "y", "z"];

    #[test]
    fn formulas_are_evaluated_in_the_order_of_the_variables() {
        let e = Expression::parse("2*z - x^2 + 1e-3*sin(PI/2)", SPACE).unwrap();
        // Three roundings of numbers near 5.
        assert!((e.evaluate(&[1.0, 7.0, 3.0]) - 5.001).abs() < 1e-14);
        assert!(e.uses("x") && !e.uses("y"));
        assert_eq!(
            Expression::parse("4.5", SPACE).unwrap().evaluate(&[0.0; 3]),
            4.5
        );
    }

    #[test]
    fn derivatives_are_exact() {
        let e = Expression::parse("tanh(x/2)*exp(-y)", SPACE).unwrap();
        let d = e.derivative("x").unwrap().unwrap();
        let (x, y) = (0.7_f64, 0.3_f64);
        let expected = (-y).exp() / (2.0 * (x / 2.0).cosh().powi(2));
        // A few roundings of numbers below 1.
        assert!((d.evaluate(&[x, y, 0.0]) - expected).abs() < 1e-14);
        assert!(e.derivative("z").unwrap().is_none());
    }

    #[test]
    fn a_leading_minus_binds_less_than_a_power() {
        let e = Expression::parse("exp(-x^2) - 2*(-y^2)", SPACE).unwrap();
        let (x, y) = (0.7_f64, 0.3_f64);
        // A few roundings of numbers near 1.
        let expected = (-x * x).exp() + 2.0 * y * y;
        assert!((e.evaluate(&[x, y, 0.0]) - expected).abs() < 1e-14);
        let slope = e.derivative("x").unwrap().unwrap();
        let expected = -2.0 * x * (-x * x).exp();
        assert!((slope.evaluate(&[x, y, 0.0]) - expected).abs() < 1e-14);
        assert_eq!(e.text(), "exp(-x^2) - 2*(-y^2)");
    }

    #[test]
    fn unknown_names_and_nonsense_are_refused() {
        for text in [
            "s1 + x", "foo(x)", "abs(x)", "{x y}", "x +", "(x", "", "x y", "--", "1..2", "{x",
        ] {
            assert!(Expression::parse(text, SPACE).is_err(), "{text}");
        }
        let nested = "(".repeat(500) + "x" + &")".repeat(500);
        assert_eq!(
            Expression::parse(&nested, SPACE).unwrap_err(),
            ExpressionError::TooLarge
        );
        let long = "x*".repeat(MOST_OPERATORS) + "x";
        let product = Expression::parse(&long, SPACE).unwrap();
        // ∂xⁿ⁺¹/∂x = n + 1 at 1: sums of ones.
        let derivative = product.derivative("x").unwrap().unwrap();
        assert_eq!(
            derivative.evaluate(&[1.0, 0.0, 0.0]),
            MOST_OPERATORS as f64 + 1.0
        );
        let longer = "x*".repeat(MOST_OPERATORS + 1) + "x";
        assert_eq!(
            Expression::parse(&longer, SPACE).unwrap_err(),
            ExpressionError::TooLarge
        );
    }

    proptest! {
        /// No text makes the parser or the evaluation panic.
        #[test]
        fn any_text_is_a_value_or_an_error(text in "[-+*/^()xyz0-9.eE ,sincoqrt{}π]{0,40}") {
            if let Ok(e) = Expression::parse(&text, SPACE) {
                let _ = e.evaluate(&[0.5, -1.0, 2.0]);
                let _ = e.derivative("x");
            }
        }
    }
}
