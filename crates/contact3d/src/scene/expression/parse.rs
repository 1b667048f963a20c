//! Formulas as they are written on paper: a leading minus binds less than a power, and what paper
//! leaves unclear is refused.

use super::{
    program::{Binary, Comparison, Function, Step},
    token::{Token, Tokens},
};

/// Deepest nesting of parentheses; the parser recurses.
pub(super) const DEEPEST_NESTING: usize = 64;

/// The functions of an expression. `min` and `max` take two arguments or more, `if` a condition and
/// the two values, the others one argument.
pub const FUNCTIONS: &[&str] = &[
    "sqrt", "exp", "ln", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh",
    "tanh", "abs", "min", "max", "if",
];

/// The constants of an expression.
pub(super) const CONSTANTS: [(&str, f64); 2] =
    [("PI", std::f64::consts::PI), ("E", std::f64::consts::E)];

/// Why a text is no formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ParseError {
    /// What is wrong, and what to write instead.
    Syntax(String),
    /// A name before parentheses that is no function.
    NoFunction(String),
    /// Too deeply nested.
    TooDeep,
}

/// A formula as steps, and the names in it that are neither variables nor functions.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub(super) steps: Vec<Step>,
    pub(super) parameters: Vec<String>,
}

/// Reads a formula in the given variables.
pub(super) fn parse(text: &str, variables: &[&str]) -> Result<Parsed, ParseError> {
    let mut parser = Parser {
        tokens: Tokens::new(text),
        variables,
        depth: 0,
        parsed: Parsed::default(),
    };
    parser.sum()?;
    match parser.tokens.peek() {
        Token::End => Ok(parser.parsed),
        Token::Comparison(_) => Err(syntax(
            "a comparison is the first argument of `if`, such as if(x < 1, 0.3, 0.2)",
        )),
        _ => Err(parser.expected("an operator or the end")),
    }
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    variables: &'a [&'a str],
    depth: usize,
    parsed: Parsed,
}

fn syntax(problem: &str) -> ParseError {
    ParseError::Syntax(problem.to_owned())
}

impl Parser<'_> {
    fn push(&mut self, step: Step) {
        self.parsed.steps.push(step);
    }

    fn expected(&self, what: &str) -> ParseError {
        ParseError::Syntax(format!("expected {what}, found {}", self.tokens.found()))
    }

    fn require(&mut self, token: Token<'_>, what: &str) -> Result<(), ParseError> {
        match self.tokens.accept(token) {
            true => Ok(()),
            false => Err(self.expected(what)),
        }
    }

    /// Terms with + and − between them, perhaps with a sign in front.
    fn sum(&mut self) -> Result<(), ParseError> {
        if self.tokens.peek() == Token::Operator('-') {
            self.push(Step::Number(0.0));
        } else {
            self.tokens.accept(Token::Operator('+'));
            self.product()?;
        }
        loop {
            let binary = match self.tokens.peek() {
                Token::Operator('+') => Binary::Add,
                Token::Operator('-') => Binary::Subtract,
                _ => return Ok(()),
            };
            self.tokens.take();
            self.product()?;
            self.push(Step::Binary(binary));
        }
    }

    fn product(&mut self) -> Result<(), ParseError> {
        self.power()?;
        loop {
            let binary = match self.tokens.peek() {
                Token::Operator('*') => Binary::Multiply,
                Token::Operator('/') => Binary::Divide,
                _ => return Ok(()),
            };
            self.tokens.take();
            self.power()?;
            self.push(Step::Binary(binary));
        }
    }

    fn power(&mut self) -> Result<(), ParseError> {
        self.operand()?;
        if self.tokens.accept(Token::Operator('^')) {
            self.operand()?;
            self.push(Step::Binary(Binary::Power));
        }
        match self.tokens.peek() {
            Token::Operator('^') => Err(syntax(
                "put one of two powers in parentheses, such as (x^2)^3",
            )),
            _ => Ok(()),
        }
    }

    fn operand(&mut self) -> Result<(), ParseError> {
        match self.tokens.peek() {
            Token::Number(value) => {
                self.tokens.take();
                self.push(Step::Number(value));
            }
            Token::Open => self.parenthesised(Self::sum)?,
            Token::Name(name) => {
                self.tokens.take();
                if self.tokens.peek() == Token::Open {
                    return self.call(name);
                }
                self.name(name)?;
            }
            Token::Operator('+' | '-') => {
                return Err(syntax(
                    "put a signed factor or exponent in parentheses, such as x*(-y)",
                ));
            }
            _ => return Err(self.expected("a number, a name or parentheses")),
        }
        Ok(())
    }

    /// Something in parentheses.
    fn parenthesised(
        &mut self,
        content: impl FnOnce(&mut Self) -> Result<(), ParseError>,
    ) -> Result<(), ParseError> {
        self.require(Token::Open, "`(`")?;
        self.depth += 1;
        if self.depth > DEEPEST_NESTING {
            return Err(ParseError::TooDeep);
        }
        content(self)?;
        self.depth -= 1;
        self.require(Token::Close, "an operator or `)`")
    }

    /// A variable, a constant or a parameter.
    fn name(&mut self, name: &str) -> Result<(), ParseError> {
        let constant = CONSTANTS.iter().find(|(constant, _)| *constant == name);
        let variable = self.variables.iter().position(|variable| *variable == name);
        let step = match (constant, variable) {
            _ if FUNCTIONS.contains(&name) => {
                return Err(syntax("put the argument of a function in parentheses"));
            }
            (Some((_, value)), _) => Step::Number(*value),
            (None, Some(place)) => Step::Variable(place),
            (None, None) => Step::Parameter(self.parameter(name)),
        };
        self.push(step);
        Ok(())
    }

    /// The place of a parameter among those of the formula.
    fn parameter(&mut self, name: &str) -> usize {
        let names = &mut self.parsed.parameters;
        let known = names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        })
    }

    /// A function with its arguments.
    fn call(&mut self, name: &str) -> Result<(), ParseError> {
        match (name, Function::named(name)) {
            (_, Some(function)) => {
                self.parenthesised(Self::sum)?;
                self.push(Step::Function(function));
                Ok(())
            }
            ("min", None) => self.parenthesised(|parser| parser.extreme(Binary::Min)),
            ("max", None) => self.parenthesised(|parser| parser.extreme(Binary::Max)),
            ("if", None) => self.parenthesised(Self::choice),
            _ => Err(ParseError::NoFunction(name.to_owned())),
        }
    }

    /// The arguments of `min` or `max`.
    fn extreme(&mut self, binary: Binary) -> Result<(), ParseError> {
        self.sum()?;
        if self.tokens.peek() == Token::Close {
            return Err(syntax(
                "`min` and `max` take two arguments or more, such as max(x, 0)",
            ));
        }
        while self.tokens.peek() != Token::Close {
            self.require(Token::Comma, "an operator, `,` or `)`")?;
            self.sum()?;
            self.push(Step::Binary(binary));
        }
        Ok(())
    }

    /// The arguments of `if`.
    fn choice(&mut self) -> Result<(), ParseError> {
        self.sum()?;
        let comparison = self.comparison()?;
        self.sum()?;
        for _ in 0..2 {
            self.require(
                Token::Comma,
                "an operator or `,` (if takes a condition and two values)",
            )?;
            self.sum()?;
        }
        self.push(Step::Choose(comparison));
        Ok(())
    }

    fn comparison(&mut self) -> Result<Comparison, ParseError> {
        match self.tokens.peek() {
            Token::Comparison(comparison) => {
                self.tokens.take();
                Ok(comparison)
            }
            _ => Err(self
                .expected("an operator or one of < <= > >= (if takes a condition and two values)")),
        }
    }
}
