//! Numbers that know how they change.

use std::cmp::Ordering;

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
    fn compare_ahead(self, other: Self) -> Option<Ordering>;

    /// Another value with the slopes of this number.
    fn at(self, value: f64) -> Self;
}

/// Which way a formula goes where `abs`, `min`, `max` and `if` part, its forks.
pub(super) trait Forks<N: Number> {
    /// Which of two numbers is the larger one for the slopes; `None` where one is none.
    fn order(&mut self, left: N, right: N) -> Option<Ordering>;

    /// The same for the value of `if`; asked before [`Self::order`] of the same fork.
    fn here(&self, left: N, right: N) -> Option<Ordering>;

    /// What a fork gives, with what the two numbers that were compared at it left behind.
    fn joined(&mut self, value: N, compared: [N; 2]) -> N;
}

/// Every fork goes the way of the piece on which all variables grow alike.
pub(super) struct Ahead;

impl<N: Number> Forks<N> for Ahead {
    fn order(&mut self, left: N, right: N) -> Option<Ordering> {
        left.compare_ahead(right)
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

    fn compare_ahead(self, other: Self) -> Option<Ordering> {
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
pub(super) struct Sloped {
    value: f64,
    slopes: [Option<f64>; 3],
}

impl Sloped {
    /// A variable, the `k`-th of the three or none of them.
    pub(super) fn variable(value: f64, k: Option<usize>) -> Self {
        let mut slopes = [None; 3];
        if let Some(k) = k {
            slopes[k] = Some(1.0);
        }
        Self { value, slopes }
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

impl Number for Sloped {
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
        Self { value, slopes }
    }

    fn compare_ahead(self, other: Self) -> Option<Ordering> {
        let order = self.value.partial_cmp(&other.value)?;
        let growth = || self.growth().partial_cmp(&other.growth());
        Some(order.then_with(|| growth().unwrap_or(Ordering::Equal)))
    }

    fn at(self, value: f64) -> Self {
        Self { value, ..self }
    }
}
