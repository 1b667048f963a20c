//! Formulas as they are written on paper: words and signs, and the precedence of what they mean.

use thiserror::Error;

use super::program::{Binary, Comparison, Instruction};

/// Longest text of an expression, in bytes.
const LONGEST_TEXT: usize = 4096;

/// Deepest nesting of parentheses; the parser recurses.
const DEEPEST_NESTING: usize = 64;

/// The functions of an expression. `min` and `max` take two arguments or more, `if` a condition and
/// the two values, the others one argument.
pub const FUNCTIONS: &[&str] = &[
    "sqrt", "exp", "ln", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh",
    "tanh", "abs", "min", "max", "if",
];

/// The constants of an expression.
pub(super) const CONSTANTS: [(&str, f64); 2] =
    [("PI", std::f64::consts::PI), ("E", std::f64::consts::E)];

/// Why a text is no usable expression.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ExpressionError {
    /// No formula.
    #[error("{text:?} is no expression: {reason}")]
    Syntax {
        /// The text.
        text: String,
        /// What is wrong, and what to write instead.
        reason: String,
    },
    /// A name that is no variable or parameter here.
    #[error("unknown name {name:?}; expected {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that mean something here.
        known: String,
    },
    /// A name before parentheses that is no function.
    #[error("{name:?} is no function; expected one of {} (write * for a product)", FUNCTIONS.join(", "))]
    NoFunction {
        /// The name.
        name: String,
    },
    /// Too long, or too deeply nested.
    #[error(
        "an expression has at most {LONGEST_TEXT} bytes and {DEEPEST_NESTING} nested parentheses; a table or a grid takes more"
    )]
    TooLarge,
}

/// The steps of a formula in the given variables, and the names in it that are neither variables nor functions.
pub(super) fn parse(
    text: &str,
    variables: &[&str],
) -> Result<(Vec<Instruction>, Vec<String>), ExpressionError> {
    if text.len() > LONGEST_TEXT {
        return Err(ExpressionError::TooLarge);
    }
    let mut parser = Parser {
        text,
        tokens: Tokens::new(text),
        variables,
        depth: 0,
        steps: Vec::new(),
        parameters: Vec::new(),
    };
    parser.sum()?;
    match parser.tokens.peek() {
        Token::End => Ok((parser.steps, parser.parameters)),
        Token::Comparison(_) => Err(parser
            .syntax("a comparison is the first argument of `if`, such as if(x < 1, 0.3, 0.2)")),
        _ => Err(parser.expected("an operator or the end")),
    }
}

struct Parser<'a> {
    text: &'a str,
    tokens: Tokens<'a>,
    variables: &'a [&'a str],
    depth: usize,
    steps: Vec<Instruction>,
    parameters: Vec<String>,
}

impl Parser<'_> {
    fn push(&mut self, step: Instruction) {
        self.steps.push(step);
    }

    fn syntax(&self, reason: impl Into<String>) -> ExpressionError {
        ExpressionError::Syntax {
            text: self.text.to_owned(),
            reason: reason.into(),
        }
    }

    fn expected(&self, what: &str) -> ExpressionError {
        self.syntax(format!("expected {what}, found {}", self.tokens.found()))
    }

    fn require(&mut self, token: Token<'_>, what: &str) -> Result<(), ExpressionError> {
        if self.tokens.accept(token) {
            Ok(())
        } else {
            Err(self.expected(what))
        }
    }

    /// Terms with + and − between them, perhaps with a sign in front.
    fn sum(&mut self) -> Result<(), ExpressionError> {
        if self.tokens.peek() == Token::Operator('-') {
            self.push(Instruction::Number(0.0));
        } else {
            self.tokens.accept(Token::Operator('+'));
            self.product()?;
        }
        self.chain(['+', '-'], [Binary::Add, Binary::Subtract], Self::product)
    }

    fn product(&mut self) -> Result<(), ExpressionError> {
        self.power()?;
        self.chain(['*', '/'], [Binary::Multiply, Binary::Divide], Self::power)
    }

    /// Operators of one precedence, each with what follows it.
    fn chain(
        &mut self,
        signs: [char; 2],
        meanings: [Binary; 2],
        operand: fn(&mut Self) -> Result<(), ExpressionError>,
    ) -> Result<(), ExpressionError> {
        while let Token::Operator(sign) = self.tokens.peek()
            && let Some(place) = signs.iter().position(|known| *known == sign)
        {
            self.tokens.take();
            operand(self)?;
            self.push(Instruction::Binary(meanings[place]));
        }
        Ok(())
    }

    fn power(&mut self) -> Result<(), ExpressionError> {
        self.operand()?;
        if self.tokens.accept(Token::Operator('^')) {
            self.operand()?;
            self.push(Instruction::Binary(Binary::Power));
        }
        match self.tokens.peek() {
            Token::Operator('^') => {
                Err(self.syntax("put one of two powers in parentheses, such as (x^2)^3"))
            }
            _ => Ok(()),
        }
    }

    fn operand(&mut self) -> Result<(), ExpressionError> {
        match self.tokens.peek() {
            Token::Number(value) => {
                self.tokens.take();
                self.push(Instruction::Number(value));
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
                return Err(
                    self.syntax("put a signed factor or exponent in parentheses, such as x*(-y)")
                );
            }
            _ => return Err(self.expected("a number, a name or parentheses")),
        }
        Ok(())
    }

    /// Something in parentheses.
    fn parenthesised(
        &mut self,
        content: impl FnOnce(&mut Self) -> Result<(), ExpressionError>,
    ) -> Result<(), ExpressionError> {
        self.require(Token::Open, "`(`")?;
        self.depth += 1;
        if self.depth > DEEPEST_NESTING {
            return Err(ExpressionError::TooLarge);
        }
        content(self)?;
        self.depth -= 1;
        self.require(Token::Close, "an operator or `)`")
    }

    /// A variable, a constant or a parameter.
    fn name(&mut self, name: &str) -> Result<(), ExpressionError> {
        let constant = CONSTANTS.iter().find(|(constant, _)| *constant == name);
        let variable = self.variables.iter().position(|variable| *variable == name);
        let step = match (constant, variable) {
            _ if FUNCTIONS.contains(&name) => {
                return Err(self.syntax("put the argument of a function in parentheses"));
            }
            (Some((_, value)), _) => Instruction::Number(*value),
            (None, Some(place)) => Instruction::Variable(place),
            (None, None) => Instruction::Parameter(self.parameter(name)),
        };
        self.push(step);
        Ok(())
    }

    /// The place of a parameter among those of the formula.
    fn parameter(&mut self, name: &str) -> usize {
        let names = &mut self.parameters;
        let known = names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        })
    }

    /// A function with its arguments.
    fn call(&mut self, name: &str) -> Result<(), ExpressionError> {
        match (name, Instruction::function(name)) {
            (_, Some(function)) => {
                self.parenthesised(Self::sum)?;
                self.push(function);
                Ok(())
            }
            ("min", None) => self.parenthesised(|parser| parser.extreme(Binary::Min)),
            ("max", None) => self.parenthesised(|parser| parser.extreme(Binary::Max)),
            ("if", None) => self.parenthesised(Self::choice),
            _ => Err(ExpressionError::NoFunction {
                name: name.to_owned(),
            }),
        }
    }

    /// The arguments of `min` or `max`.
    fn extreme(&mut self, binary: Binary) -> Result<(), ExpressionError> {
        self.sum()?;
        if self.tokens.peek() == Token::Close {
            return Err(
                self.syntax("`min` and `max` take two arguments or more, such as max(x, 0)")
            );
        }
        while self.tokens.peek() != Token::Close {
            self.require(Token::Comma, "an operator, `,` or `)`")?;
            self.sum()?;
            self.push(Instruction::Binary(binary));
        }
        Ok(())
    }

    /// The arguments of `if`.
    fn choice(&mut self) -> Result<(), ExpressionError> {
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
        self.push(Instruction::Choose(comparison));
        Ok(())
    }

    fn comparison(&mut self) -> Result<Comparison, ExpressionError> {
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

/// One word or sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    Name(&'a str),
    /// One of + − * / ^.
    Operator(char),
    Comparison(Comparison),
    Open,
    Close,
    Comma,
    End,
    /// Something that no formula has.
    Foreign(&'a str),
}

/// The words of a text, one after the other.
pub(super) struct Tokens<'a> {
    rest: &'a str,
    next: Token<'a>,
    /// The text of `next`.
    word: &'a str,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let mut tokens = Self {
            rest: text,
            next: Token::End,
            word: "",
        };
        tokens.advance();
        tokens
    }

    /// The next word, which stays.
    pub(super) fn peek(&self) -> Token<'a> {
        self.next
    }

    /// The next word, which goes.
    pub(super) fn take(&mut self) -> Token<'a> {
        let next = self.next;
        self.advance();
        next
    }

    /// Takes the next word if it is this one.
    pub(super) fn accept(&mut self, token: Token<'_>) -> bool {
        let is_next = self.next == token;
        if is_next {
            self.advance();
        }
        is_next
    }

    /// The next word as a message says it.
    pub(super) fn found(&self) -> String {
        match self.next {
            Token::End => "the end".to_owned(),
            _ => format!("`{}`", self.word),
        }
    }

    fn advance(&mut self) {
        let text = self.rest.trim_start();
        let (next, length) = first(text);
        self.next = next;
        (self.word, self.rest) = text.split_at(length);
    }
}

/// The first word of a text that does not begin with a space, and its bytes.
fn first(text: &str) -> (Token<'_>, usize) {
    let Some(c) = text.chars().next() else {
        return (Token::End, 0);
    };
    let number = number_length(text);
    if let Ok(value) = text[..number].parse() {
        return (Token::Number(value), number);
    }
    if is_name(c) {
        let length = text.find(|c| !is_name(c)).unwrap_or(text.len());
        return (Token::Name(&text[..length]), length);
    }
    let or_equal = text[c.len_utf8()..].starts_with('=');
    match (c, or_equal) {
        ('<', true) => (Token::Comparison(Comparison::AtMost), 2),
        ('>', true) => (Token::Comparison(Comparison::AtLeast), 2),
        ('<', false) => (Token::Comparison(Comparison::Below), 1),
        ('>', false) => (Token::Comparison(Comparison::Above), 1),
        ('(', _) => (Token::Open, 1),
        (')', _) => (Token::Close, 1),
        (',', _) => (Token::Comma, 1),
        ('+' | '-' | '*' | '/' | '^', _) => (Token::Operator(c), 1),
        _ => (Token::Foreign(&text[..c.len_utf8()]), c.len_utf8()),
    }
}

/// Whether a name may hold a character; a number in front of one is a number of its own.
fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether a text can be the name of a parameter.
pub(in crate::scene) fn is_identifier(text: &str) -> bool {
    matches!(first(text), (Token::Name(name), _) if name.len() == text.len())
}

/// Bytes of the decimal number that a text begins with: digits with a point, an exponent.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let rest = text.as_bytes()[from..].iter();
        rest.take_while(|byte| byte.is_ascii_digit()).count()
    };
    let whole = digits(0);
    let mut length = whole;
    if text[length..].starts_with('.') {
        let fraction = digits(length + 1);
        if whole + fraction == 0 {
            return 0;
        }
        length += 1 + fraction;
    }
    if length > 0 && text[length..].starts_with(['e', 'E']) {
        let sign = usize::from(text[length + 1..].starts_with(['+', '-']));
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_names_and_signs_are_told_apart() {
        let mut tokens = Tokens::new(" 2.5e-3x1 <= .5E2 -1. e5\u{3c0}, 3e");
        for expected in [
            Token::Number(2.5e-3),
            Token::Name("x1"),
            Token::Comparison(Comparison::AtMost),
            Token::Number(50.0),
            Token::Operator('-'),
            Token::Number(1.0),
            Token::Name("e5\u{3c0}"),
            Token::Comma,
            Token::Number(3.0),
            Token::Name("e"),
            Token::End,
            Token::End,
        ] {
            assert_eq!(tokens.take(), expected);
        }
        assert_eq!(Tokens::new("{").take(), Token::Foreign("{"));
        assert_eq!(Tokens::new(".").take(), Token::Foreign("."));
    }

    #[test]
    fn parameters_have_names() {
        for name in ["mu", "F_0", "\u{3bc}"] {
            assert!(is_identifier(name), "{name}");
        }
        for text in ["", "a-b", "a b", "1a", "(", "2", " a"] {
            assert!(!is_identifier(text), "{text}");
        }
    }
}
