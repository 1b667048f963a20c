//! A formula as steps on a stack, for numbers with and without slopes.

use std::cmp::Ordering;

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
type Smooth = (&'static str, fn(f64) -> f64, fn(f64) -> f64);

/// The smooth functions of one argument.
pub(super) const SMOOTH: [Smooth; 13] = [
    ("sqrt", f64::sqrt, |x| 0.5 / x.sqrt()),
    ("exp", f64::exp, f64::exp),
    ("ln", f64::ln, f64::recip),
    ("log10", f64::log10, |x| {
        (x * std::f64::consts::LN_10).recip()
    }),
    ("sin", f64::sin, f64::cos),
    ("cos", f64::cos, |x| -x.sin()),
    ("tan", f64::tan, |x| x.cos().powi(-2)),
    ("asin", f64::asin, |x| (1.0 - x * x).sqrt().recip()),
    ("acos", f64::acos, |x| -(1.0 - x * x).sqrt().recip()),
    ("atan", f64::atan, |x| (1.0 + x * x).recip()),
    ("sinh", f64::sinh, f64::cosh),
    ("cosh", f64::cosh, f64::sinh),
    ("tanh", f64::tanh, |x| 1.0 - x.tanh().powi(2)),
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

fn absolute<N: Number>(argument: N, points: &mut impl BranchPoints<N>) -> N {
    let (x, zero) = (argument.value(), N::number(0.0));
    let (value, sign) = match points.order(argument, zero) {
        // Adding zero leaves no sign on it.
        Some(Ordering::Less) => (-x + 0.0, -1.0),
        Some(_) => (x + 0.0, 1.0),
        None => (f64::NAN, 1.0),
    };
    points.joined(argument.through(value, || sign), [argument, zero])
}

impl Binary {
    fn of<N: Number>(self, a: N, b: N, points: &mut impl BranchPoints<N>) -> N {
        let (x, y) = (a.value(), b.value());
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
fn pick<N: Number>(a: N, b: N, second_if: Ordering, points: &mut impl BranchPoints<N>) -> N {
    let picked = match points.order(a, b) {
        None => N::number(f64::NAN),
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
    fn choose<N: Number>(
        self,
        [left, right, first, second]: [N; 4],
        points: &mut impl BranchPoints<N>,
    ) -> N {
        let (Some(here), Some(ahead)) = (points.here(left, right), points.order(left, right))
        else {
            return N::number(f64::NAN);
        };
        let chosen = |order| if self.holds(order) { first } else { second };
        let value = chosen(ahead).at(chosen(here).value());
        points.joined(value, [left, right])
    }
}

/// Runs the steps of a formula; not a number where it is not defined.
pub(super) fn run<N: Number>(
    steps: &[Instruction],
    parameters: &[f64],
    variable: impl Fn(usize) -> N,
    points: &mut impl BranchPoints<N>,
) -> N {
    let mut stack: Vec<N> = Vec::with_capacity(16);
    for step in steps {
        let value = match *step {
            Instruction::Number(value) => N::number(value),
            Instruction::Variable(place) => variable(place),
            Instruction::Parameter(place) => {
                N::number(parameters.get(place).copied().unwrap_or(f64::NAN))
            }
            Instruction::Smooth(place) => {
                let [argument] = taken::<N, 1>(&mut stack);
                let (_, value, derivative) = SMOOTH[place];
                let x = argument.value();
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
fn taken<N: Number, const K: usize>(stack: &mut Vec<N>) -> [N; K] {
    let mut arguments = [N::number(f64::NAN); K];
    for argument in arguments.iter_mut().rev() {
        *argument = stack.pop().expect("a step has its arguments");
    }
    arguments
}

/// What a formula computes with: a value, perhaps with its slopes.
pub(super) trait Number: Copy {
    /// A number that does not change.
    fn number(value: f64) -> Self;

    fn value(self) -> f64;

    /// A function of this number, by its value and derivative.
    fn through(self, value: f64, derivative: impl FnOnce() -> f64) -> Self;

    /// A function of this number and another, by its value and partial derivatives.
    fn with(self, other: Self, value: f64, derivatives: impl FnOnce() -> [f64; 2]) -> Self;

    /// Which of two numbers is the larger one, of equal ones that which grows faster; `None` where
    /// one is no number.
    fn compare_right_limit(self, other: Self) -> Option<Ordering>;

    /// Another value with the slopes of this number.
    fn at(self, value: f64) -> Self;
}

/// Which way a formula goes where `abs`, `min`, `max` and `if` part, its branch points.
pub(super) trait BranchPoints<N: Number> {
    /// Which of two numbers is the larger one for the slopes; `None` where one is none.
    fn order(&mut self, left: N, right: N) -> Option<Ordering>;

    /// The same for the value of `if`; asked before [`Self::order`] of the same branch point.
    fn here(&self, left: N, right: N) -> Option<Ordering>;

    /// What a branch point gives, with what the two numbers that were compared at it left behind.
    fn joined(&mut self, value: N, compared: [N; 2]) -> N;
}

/// Every branch point goes the way of the piece on which all variables grow alike.
pub(super) struct OneSidedJet;

impl<N: Number> BranchPoints<N> for OneSidedJet {
    fn order(&mut self, left: N, right: N) -> Option<Ordering> {
        left.compare_right_limit(right)
    }

    fn here(&self, left: N, right: N) -> Option<Ordering> {
        left.value().partial_cmp(&right.value())
    }

    fn joined(&mut self, value: N, _: [N; 2]) -> N {
        value
    }
}

impl Number for f64 {
    fn number(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn through(self, value: f64, _: impl FnOnce() -> f64) -> Self {
        value
    }

    fn with(self, _: Self, value: f64, _: impl FnOnce() -> [f64; 2]) -> Self {
        value
    }

    fn compare_right_limit(self, other: Self) -> Option<Ordering> {
        self.partial_cmp(&other)
    }

    fn at(self, value: f64) -> Self {
        value
    }
}

/// A number with its partial derivatives by three variables, `None` by those it does not depend on,
/// so that an infinite derivative beside it does no harm.
///
/// At a kink the derivatives are those of the piece that holds when all three variables grow at the
/// same rate: one-sided, and for slips, which are not negative, on the side where there are slips.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dual {
    value: f64,
    slopes: [Option<f64>; 3],
    /// The branch points at which the branch ends that the number comes from, a bit each.
    pub(super) branch_points: u64,
}

impl Dual {
    /// A variable, the `k`-th of the three or none of them.
    pub(super) fn variable(value: f64, k: Option<usize>) -> Self {
        let mut slopes = [None; 3];
        if let Some(k) = k {
            slopes[k] = Some(1.0);
        }
        Self {
            value,
            slopes,
            branch_points: 0,
        }
    }

    /// The partial derivatives.
    pub(super) fn derivatives(self) -> [f64; 3] {
        self.slopes.map(Option::unwrap_or_default)
    }

    /// The rate of change when all variables grow at the same rate.
    fn growth(self) -> f64 {
        self.slopes.iter().flatten().sum()
    }
}

/// The slope of a function of something with a slope. What stands still there leaves no slope even where the function is
/// infinitely steep: sqrt(x^2 + y^2) has the slope 0 at its apex, the middle one of all those around it.
fn chained(derivative: f64, slope: f64) -> f64 {
    if slope == 0.0 {
        0.0
    } else {
        derivative * slope
    }
}

impl Number for Dual {
    fn number(value: f64) -> Self {
        Self::variable(value, None)
    }

    fn value(self) -> f64 {
        self.value
    }

    fn through(self, value: f64, derivative: impl FnOnce() -> f64) -> Self {
        let derivative = derivative();
        Self {
            value,
            slopes: self
                .slopes
                .map(|slope| slope.map(|slope| chained(derivative, slope))),
            ..self
        }
    }

    fn with(self, other: Self, value: f64, derivatives: impl FnOnce() -> [f64; 2]) -> Self {
        let [first, second] = derivatives();
        let slopes = std::array::from_fn(|k| match (self.slopes[k], other.slopes[k]) {
            (None, None) => None,
            (Some(a), None) => Some(chained(first, a)),
            (None, Some(b)) => Some(chained(second, b)),
            (Some(a), Some(b)) => Some(chained(first, a) + chained(second, b)),
        });
        Self {
            value,
            slopes,
            branch_points: self.branch_points | other.branch_points,
        }
    }

    fn compare_right_limit(self, other: Self) -> Option<Ordering> {
        let order = self.value.partial_cmp(&other.value)?;
        let growth = || self.growth().partial_cmp(&other.growth());
        Some(order.then_with(|| growth().unwrap_or(Ordering::Equal)))
    }

    fn at(self, value: f64) -> Self {
        Self { value, ..self }
    }
}
