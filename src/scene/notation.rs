//! The parser binds a sign and a bare function closer than a power, and reads powers from the left:
//! for it −x^2 is (−x)^2 and 2^3^2 is (2^3)^2. Formulas here mean what they mean on paper.

use exmex::MatchLiteral;

use super::expression::{Decimal, FUNCTIONS};

/// What stands before a token.
#[derive(Clone, Copy, PartialEq)]
enum Before {
    Opening,
    Operator,
    Function,
    Operand,
}

/// The formula with every leading minus as a subtraction from 0, which binds less than a power.
///
/// # Errors
/// What to write instead of a sign after an operator, a function without parentheses, or a power
/// of a power.
pub(super) fn on_paper(text: &str) -> Result<String, &'static str> {
    let mut result = String::with_capacity(text.len() + 4);
    let mut before = Before::Opening;
    // The last operator at each depth of parentheses.
    let mut operators = vec![None];
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = token_length(rest, c);
        let (token, after) = rest.split_at(length);
        rest = after;
        if before == Before::Function && !c.is_whitespace() && c != '(' {
            return Err("put the argument of a function in parentheses");
        }
        match c {
            '-' | '+' if before == Before::Operator => {
                return Err("put a signed factor or exponent in parentheses, such as x*(-y)");
            }
            '-' if before == Before::Opening => result.push('0'),
            '^' if operators.last() == Some(&Some('^')) => {
                return Err("put one of two powers in parentheses, such as (x^2)^3");
            }
            _ => {}
        }
        match c {
            '(' => operators.push(None),
            ')' if operators.len() > 1 => {
                operators.pop();
            }
            '+' | '-' | '*' | '/' | '^' => {
                if let Some(last) = operators.last_mut() {
                    *last = Some(c);
                }
            }
            _ => {}
        }
        before = match c {
            _ if c.is_whitespace() => before,
            '(' => Before::Opening,
            '+' | '-' | '*' | '/' | '^' => Before::Operator,
            _ if FUNCTIONS.contains(&token) => Before::Function,
            _ => Before::Operand,
        };
        result.push_str(token);
    }
    Ok(result)
}

/// Bytes of the number, the name or the sign at the beginning of a text.
fn token_length(text: &str, first: char) -> usize {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    match Decimal::is_literal(text) {
        Some(number) => number.len(),
        None if is_name(first) => text.find(|c| !is_name(c)).unwrap_or(text.len()),
        None => first.len_utf8(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_subtractions_and_the_unclear_is_refused() {
        for (text, expected) in [
            ("-x^2", "0-x^2"),
            ("2*(-x^2 + 1e-3)", "2*(0-x^2 + 1e-3)"),
            ("exp(-x^2/0.04)", "exp(0-x^2/0.04)"),
            ("x - y", "x - y"),
            ("2E-5-x", "2E-5-x"),
            ("(x^2)^3 + y^2*z^2", "(x^2)^3 + y^2*z^2"),
        ] {
            assert_eq!(on_paper(text).as_deref(), Ok(expected));
        }
        for text in [
            "2*-x", "2^-x", "x--y", "sin x", "exp -x", "x^2^3", "x^(2)^3",
        ] {
            assert!(on_paper(text).is_err(), "{text}");
        }
    }
}
