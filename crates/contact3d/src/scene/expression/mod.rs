//! Formulas in named variables.

mod branch;
mod parse;
mod print;
mod program;

use std::{borrow::Cow, collections::BTreeMap, fmt};

use serde::{Serialize, Serializer};

use branch::{BranchChoice, Dual};
pub use branch::{BranchEnd, FormulaBranch, OnBranch};
use parse::CONSTANTS;
pub(super) use parse::is_identifier;
pub use parse::{ExpressionError, FUNCTIONS};
use program::{Binary, Instruction, run};

/// A formula in named variables, such as `0.3 - 0.1*tanh(s1/1e-5)`.
///
/// Operators + − * / ^, the functions of [`FUNCTIONS`] with parentheses, the constants PI and E, and
/// named parameters; −x^2 is −(x^2).
#[derive(Clone)]
pub struct Expression {
    parsed: Box<ParsedFormula>,
    variables: &'static [&'static str],
}

/// A formula as written, and as read: its tree, arguments before what is made of them.
#[derive(Clone)]
struct ParsedFormula {
    /// As written; `None` for one that was made of others.
    text: Option<String>,
    steps: Vec<Instruction>,
    /// The names of the parameters.
    names: Vec<String>,
    /// Their values; none before they are bound.
    values: Vec<f64>,
}

/// The names that a formula may use, in words.
fn known_names(variables: &[&str], parameters: &BTreeMap<String, f64>) -> String {
    let names: Vec<&str> = parameters.keys().map(String::as_str).collect();
    let parameters = match names.as_slice() {
        [] => "names of the table [parameters], which is empty".to_owned(),
        names => format!("the parameters {}", names.join(", ")),
    };
    let (variables, functions) = (variables.join(", "), FUNCTIONS.join(", "));
    format!("the variables {variables}, {parameters}, the functions {functions}, PI or E")
}

/// Whether formulas give a name a meaning of their own, and which.
pub(super) fn meaning(name: &str, variables: &[&str]) -> Option<&'static str> {
    match name {
        _ if variables.contains(&name) => Some("a variable"),
        _ if FUNCTIONS.contains(&name) => Some("a function"),
        _ if CONSTANTS.iter().any(|(constant, _)| *constant == name) => Some("a constant"),
        _ => None,
    }
}

impl Expression {
    /// Parses a formula that may use the given variables, and no parameters.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula, unknown names, and formulas without limits.
    pub fn parse(text: &str, variables: &'static [&'static str]) -> Result<Self, ExpressionError> {
        let mut expression = Self::unbound(text, variables)?;
        expression.bind(&BTreeMap::new())?;
        Ok(expression)
    }

    /// Parses a formula; names that are no variables are parameters, without values until they are
    /// bound.
    pub(super) fn unbound(
        text: &str,
        variables: &'static [&'static str],
    ) -> Result<Self, ExpressionError> {
        let (steps, names) = parse::parse(text, variables)?;
        Ok(Self {
            parsed: Box::new(ParsedFormula {
                text: Some(text.to_owned()),
                steps,
                names,
                values: Vec::new(),
            }),
            variables,
        })
    }

    /// Gives the parameters their values.
    ///
    /// # Errors
    /// [`ExpressionError::Unknown`] for the first name without a value.
    pub(super) fn bind(
        &mut self,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<(), ExpressionError> {
        let values = self.parsed.names.iter().map(|name| {
            let value = parameters.get(name).copied();
            value.ok_or_else(|| ExpressionError::Unknown {
                name: name.clone(),
                known: known_names(self.variables, parameters),
            })
        });
        self.parsed.values = values.collect::<Result<_, _>>()?;
        Ok(())
    }

    /// A variable as a formula.
    ///
    /// # Panics
    /// If it is not among them.
    pub(super) fn variable(name: &str, variables: &'static [&'static str]) -> Self {
        let place = variables.iter().position(|known| *known == name);
        Self::leaf(Instruction::Variable(place.expect("a variable")), variables)
    }

    /// A number as a formula.
    pub(super) fn number(value: f64, variables: &'static [&'static str]) -> Self {
        Self::leaf(Instruction::Number(value), variables)
    }

    fn leaf(step: Instruction, variables: &'static [&'static str]) -> Self {
        Self {
            parsed: Box::new(ParsedFormula {
                text: None,
                steps: vec![step],
                names: Vec::new(),
                values: Vec::new(),
            }),
            variables,
        }
    }

    /// The formula with others in the same variables in the place of some of its variables.
    #[must_use]
    pub fn substitute(&self, new: &[(&str, Self)]) -> Self {
        let mut image = Self {
            parsed: Box::new(ParsedFormula {
                text: None,
                steps: Vec::new(),
                ..(*self.parsed).clone()
            }),
            variables: self.variables,
        };
        for step in &self.parsed.steps {
            let found = match step {
                Instruction::Variable(place) => {
                    let name = self.variables[*place];
                    new.iter().find(|(known, _)| *known == name)
                }
                _ => None,
            };
            match found {
                Some((_, formula)) => image.append(formula),
                None => image.parsed.steps.push(*step),
            }
        }
        image
    }

    /// The formula times a number.
    pub(super) fn times(&self, factor: f64) -> Self {
        Self::number(factor, self.variables).joined(self, Binary::Multiply)
    }

    /// The sum of two formulas in the same variables.
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.joined(other, Binary::Add)
    }

    /// Two formulas in the same variables as the arguments of an operator.
    fn joined(&self, other: &Self, operator: Binary) -> Self {
        let mut joined = self.clone();
        joined.parsed.text = None;
        joined.append(other);
        joined.parsed.steps.push(Instruction::Binary(operator));
        joined
    }

    /// Adds the steps of another formula in the same variables, with its parameters.
    fn append(&mut self, other: &Self) {
        let parsed = &mut *self.parsed;
        let n_parameters = parsed.names.len();
        parsed.names.extend_from_slice(&other.parsed.names);
        parsed.values.extend_from_slice(&other.parsed.values);
        let steps = other.parsed.steps.iter().map(|step| match step {
            Instruction::Parameter(place) => Instruction::Parameter(n_parameters + place),
            step => *step,
        });
        parsed.steps.extend(steps);
    }

    /// The formula as written, or one that says the same.
    #[must_use]
    pub fn text(&self) -> Cow<'_, str> {
        let parsed = &*self.parsed;
        match &parsed.text {
            Some(text) => text.into(),
            None => print::text(&parsed.steps, self.variables, &parsed.names).into(),
        }
    }

    /// The names of the parameters it uses.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.parsed.names.iter().map(String::as_str)
    }

    /// The value for the variables in the order in which [`Self::parse`] was given them; not
    /// finite outside the formula's domain.
    #[must_use]
    pub fn evaluate(&self, values: &[f64]) -> f64 {
        let number = |place| Dual::number(values[place]);
        let mut choice = BranchChoice::default();
        run(&self.parsed.steps, &self.parsed.values, number, &mut choice).value
    }

    /// The partial derivatives by three variables, given by their places; at kinks those of the
    /// piece that holds when all three grow at the same rate.
    #[must_use]
    pub fn derivatives(&self, values: &[f64], by: [usize; 3]) -> [f64; 3] {
        self.go(values, by, &mut BranchChoice::default())
            .derivatives()
    }

    /// The branch that the formula takes at a point; at a branch point the one on which three variables, given by their places, grow alike.
    #[must_use]
    pub(crate) fn branch(&self, values: &[f64], by: [usize; 3]) -> FormulaBranch {
        let mut choice = BranchChoice::default();
        self.go(values, by, &mut choice);
        choice.branch
    }

    /// The formula on one of its branches, also beyond the ends of it.
    #[must_use]
    pub(crate) fn on_branch(
        &self,
        values: &[f64],
        by: [usize; 3],
        branch: FormulaBranch,
    ) -> OnBranch {
        let mut choice = BranchChoice::along(branch);
        let value = self.go(values, by, &mut choice);
        choice.found(value)
    }

    fn go(&self, values: &[f64], by: [usize; 3], points: &mut BranchChoice) -> Dual {
        let variable = |place| {
            let wanted = by.iter().position(|wanted| *wanted == place);
            Dual::variable(values[place], wanted)
        };
        run(&self.parsed.steps, &self.parsed.values, variable, points)
    }

    /// Whether the formula uses a variable.
    #[must_use]
    pub fn uses(&self, variable: &str) -> bool {
        let is_used = |step: &Instruction| match step {
            Instruction::Variable(place) => self.variables[*place] == variable,
            _ => false,
        };
        self.parsed.steps.iter().any(is_used)
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        let (own, other_own) = (&*self.parsed, &*other.parsed);
        own.steps == other_own.steps
            && self.variables == other.variables
            && own.names == other_own.names
            && own.values == other_own.values
    }
}

impl Serialize for Expression {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text())
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

    fn bound(text: &str, parameters: &[(&str, f64)]) -> Result<Expression, ExpressionError> {
        let parameters = parameters.iter().map(|(name, v)| ((*name).to_owned(), *v));
        let mut expression = Expression::unbound(text, &["x", "y", "z"])?;
        expression.bind(&parameters.collect())?;
        Ok(expression)
    }

    #[test]
    fn parameters_have_the_values_they_are_bound_to() {
        let e = bound("mu*x + mu^k", &[("mu", 3.0), ("k", 2.0), ("spare", 0.0)]).unwrap();
        assert_eq!(e.evaluate(&[2.0, 0.0, 0.0]), 15.0);
        assert_eq!(e.derivatives(&[2.0, 0.0, 0.0], [0, 1, 2]), [3.0, 0.0, 0.0]);
        assert_eq!(e.parameters().collect::<Vec<_>>(), ["mu", "k"]);
        let doubled = Expression::parse("2*x", &["x", "y", "z"]).unwrap();
        let moved = e.substitute(&[("x", doubled)]).times(2.0);
        assert_eq!(moved.text(), "2.0*(mu*(2.0*x) + mu^k)");
        assert_eq!(moved.evaluate(&[1.0, 0.0, 0.0]), 30.0);
        assert_ne!(e, bound("mu*x + mu^k", &[("mu", 4.0), ("k", 2.0)]).unwrap());
        let error = bound("mo*x", &[("mu", 3.0)]).unwrap_err().to_string();
        assert!(
            error.contains("\"mo\"") && error.contains("the parameters mu"),
            "{error}"
        );
    }
}
