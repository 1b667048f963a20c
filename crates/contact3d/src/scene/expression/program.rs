//! A formula as steps on a stack.

use std::cmp::Ordering;

use super::branch::{BranchChoice, Dual};

/// One step: takes its arguments from the stack and puts its value there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instruction {
    Number(f64),
    /// A variable, by its place among the allowed ones.
    Variable(usize),
    /// A parameter, by its place among the formula's own.
    Parameter(usize),
    /// A smooth function, by its place in the list of them.
    Smooth(usize),
    Abs,
    Binary(Binary),
    /// The third of four arguments if the first two compare so, else the fourth.
    Choose(Comparison),
}

/// A function of two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Min,
    Max,
}

/// How the two sides of a condition compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    Below,
    AtMost,
    Above,
    AtLeast,
}

/// Name, value and derivative of a smooth function of one argument.
type Smooth = (&'static str, [fn(f64) -> f64; 2]);

/// The smooth functions of one argument.
pub(super) const SMOOTH: [Smooth; 13] = [
    ("sqrt", [f64::sqrt, |x| 0.5 / x.sqrt()]),
    ("exp", [f64::exp, f64::exp]),
    ("ln", [f64::ln, f64::recip]),
    (
        "log10",
        [f64::log10, |x| (x * std::f64::consts::LN_10).recip()],
    ),
    ("sin", [f64::sin, f64::cos]),
    ("cos", [f64::cos, |x| -x.sin()]),
    ("tan", [f64::tan, |x| x.cos().powi(-2)]),
    ("asin", [f64::asin, |x| (1.0 - x * x).sqrt().recip()]),
    ("acos", [f64::acos, |x| -(1.0 - x * x).sqrt().recip()]),
    ("atan", [f64::atan, |x| (1.0 + x * x).recip()]),
    ("sinh", [f64::sinh, f64::cosh]),
    ("cosh", [f64::cosh, f64::sinh]),
    ("tanh", [f64::tanh, |x| 1.0 - x.tanh().powi(2)]),
];

impl Instruction {
    /// The function of one argument with a name.
    pub(super) fn function(name: &str) -> Option<Self> {
        let place = SMOOTH.iter().position(|(known, ..)| *known == name);
        place
            .map(Self::Smooth)
            .or_else(|| (name == "abs").then_some(Self::Abs))
    }
}

fn absolute(argument: Dual, points: &mut BranchChoice) -> Dual {
    let (x, zero) = (argument.value, Dual::number(0.0));
    let (value, sign) = match points.order(argument, zero) {
        // Adding zero leaves no sign on it.
        Some(Ordering::Less) => (-x + 0.0, -1.0),
        Some(_) => (x + 0.0, 1.0),
        None => (f64::NAN, 1.0),
    };
    points.joined(argument.through(value, || sign), [argument, zero])
}

impl Binary {
    fn of(self, a: Dual, b: Dual, points: &mut BranchChoice) -> Dual {
        let (x, y) = (a.value, b.value);
        match self {
            Self::Add => a.with(b, x + y, || [1.0, 1.0]),
            Self::Subtract => a.with(b, x - y, || [1.0, -1.0]),
            Self::Multiply => a.with(b, x * y, || [y, x]),
            Self::Divide => a.with(b, x / y, || [y.recip(), -x / y / y]),
            Self::Power => a.with(b, x.powf(y), || {
                let by_base = if y == 0.0 { 0.0 } else { y * x.powf(y - 1.0) };
                [by_base, x.powf(y) * x.ln()]
            }),
            Self::Min => pick(a, b, Ordering::Greater, points),
            Self::Max => pick(a, b, Ordering::Less, points),
        }
    }
}

/// The second number if the first compares so to it, else the first; no number where one is none.
fn pick(a: Dual, b: Dual, second_if: Ordering, points: &mut BranchChoice) -> Dual {
    let picked = match points.order(a, b) {
        None => Dual::number(f64::NAN),
        Some(order) if order == second_if => b,
        Some(_) => a,
    };
    points.joined(picked, [a, b])
}

impl Comparison {
    /// How a formula writes it.
    pub(super) fn sign(self) -> &'static str {
        ["<", "<=", ">", ">="][self as usize]
    }

    fn holds(self, order: Ordering) -> bool {
        match self {
            Self::Below => order.is_lt(),
            Self::AtMost => order.is_le(),
            Self::Above => order.is_gt(),
            Self::AtLeast => order.is_ge(),
        }
    }

    /// One of two numbers: the value by the condition here, the slope by that just ahead.
    fn choose(self, [left, right, first, second]: [Dual; 4], points: &mut BranchChoice) -> Dual {
        let (Some(here), Some(ahead)) = (points.here(left, right), points.order(left, right))
        else {
            return Dual::number(f64::NAN);
        };
        let chosen = |order| if self.holds(order) { first } else { second };
        let value = Dual {
            value: chosen(here).value,
            ..chosen(ahead)
        };
        points.joined(value, [left, right])
    }
}

/// Runs the steps of a formula; not a number where it is not defined.
pub(super) fn run(
    steps: &[Instruction],
    parameters: &[f64],
    variable: impl Fn(usize) -> Dual,
    points: &mut BranchChoice,
) -> Dual {
    let mut stack: Vec<Dual> = Vec::with_capacity(16);
    for step in steps {
        let value = match *step {
            Instruction::Number(value) => Dual::number(value),
            Instruction::Variable(place) => variable(place),
            Instruction::Parameter(place) => {
                Dual::number(parameters.get(place).copied().unwrap_or(f64::NAN))
            }
            Instruction::Smooth(place) => {
                let [argument] = taken(&mut stack);
                let (_, [value, derivative]) = SMOOTH[place];
                let x = argument.value;
                argument.through(value(x), || derivative(x))
            }
            Instruction::Abs => {
                let [argument] = taken(&mut stack);
                absolute(argument, points)
            }
            Instruction::Binary(binary) => {
                let [a, b] = taken(&mut stack);
                binary.of(a, b, points)
            }
            Instruction::Choose(comparison) => comparison.choose(taken(&mut stack), points),
        };
        stack.push(value);
    }
    let [value] = taken(&mut stack);
    value
}

/// The last numbers of the stack, the oldest first; the parser has put them there.
fn taken<const K: usize>(stack: &mut Vec<Dual>) -> [Dual; K] {
    let mut arguments = [Dual::number(f64::NAN); K];
    for argument in arguments.iter_mut().rev() {
        *argument = stack.pop().expect("a step has its arguments");
    }
    arguments
}
