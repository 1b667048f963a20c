//! Numbers that vary over a box, with their slopes by the unknowns.

use std::ops::{Add, Mul, Neg, Sub};

use super::interval::Interval;

/// Most unknowns of one choice of states: a size of slip for each pane and an angle for some.
pub(super) const MOST_UNKNOWNS: usize = 9;

/// The values of a function over a box, and the slopes between any two of its points by each unknown.
#[derive(Debug, Clone, Copy)]
pub(super) struct IntervalFunction {
    pub(super) value: Interval,
    pub(super) slope: [Interval; MOST_UNKNOWNS],
}

impl IntervalFunction {
    pub(super) fn constant(value: Interval) -> Self {
        Self {
            value,
            slope: [Interval::ZERO; MOST_UNKNOWNS],
        }
    }

    /// A function of one unknown, by its values and slopes.
    pub(super) fn along(value: Interval, unknown: usize, slope: Interval) -> Self {
        let mut varying = Self::constant(value);
        varying.slope[unknown] = slope;
        varying
    }

    /// f(x), from the values and slopes of f over the values of x.
    pub(super) fn through(self, value: Interval, slope: Interval) -> Self {
        Self {
            value,
            slope: self.slope.map(|own| slope * own),
        }
    }

    pub(super) fn times(self, factor: Interval) -> Self {
        self.through(factor * self.value, factor)
    }

    pub(super) fn recip(self) -> Self {
        let value = self.value.recip();
        self.through(value, -value.square())
    }

    /// √(x² + y²), whose slopes are no larger than those of x and y together.
    pub(super) fn hypot(self, other: Self) -> Self {
        let value = (self.value.square() + other.value.square()).sqrt();
        let both = Interval::new(-1.0, 1.0);
        let along = |x: Self| {
            let share = x.value.over(value).and_then(|share| share.meet(both));
            x.through(value, share.unwrap_or(both))
        };
        let [first, second] = [along(self), along(other)];
        Self {
            value,
            ..first + second
        }
    }

    /// x/|x| of a vector whose length has bounds.
    pub(super) fn unit([x, y]: [Self; 2], length: Interval) -> [Self; 2] {
        let [along, aside] = [cosine(x.value, y.value), cosine(y.value, x.value)];
        let square = x.value.square() + y.value.square();
        let square = square.meet(length.square());
        let over = square.unwrap_or(length.square()).recip();
        let slope = std::array::from_fn(|k| (x.value * y.slope[k] - y.value * x.slope[k]) * over);
        let angle = Self {
            value: Interval::ZERO,
            slope,
        };
        [angle.through(along, -aside), angle.through(aside, along)]
    }

    /// |x|, whose slopes are those of the signs that x has.
    pub(super) fn abs(self) -> Self {
        let sign = match self.value {
            Interval { low, .. } if low > 0.0 => Interval::ONE,
            Interval { high, .. } if high < 0.0 => -Interval::ONE,
            _ => Interval::new(-1.0, 1.0),
        };
        self.through(self.value.abs(), sign)
    }
}

/// x/√(x² + y²), which grows with x, and is nearer to zero where |y| is larger.
fn cosine(x: Interval, y: Interval) -> Interval {
    let y = y.abs();
    let at = |x: f64, y: f64| {
        let [x, y] = [x, y].map(Interval::point);
        x.over((x.square() + y.square()).sqrt())
    };
    let low = at(x.low, if x.low > 0.0 { y.high } else { y.low });
    let high = at(x.high, if x.high > 0.0 { y.low } else { y.high });
    match low.zip(high) {
        Some((low, high)) => Interval::new(low.low.max(-1.0), high.high.min(1.0)),
        None => Interval::new(-1.0, 1.0),
    }
}

impl Add for IntervalFunction {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: std::array::from_fn(|k| self.slope[k] + other.slope[k]),
        }
    }
}

impl std::iter::Sum for IntervalFunction {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::constant(Interval::ZERO), Add::add)
    }
}

impl Neg for IntervalFunction {
    type Output = Self;
    fn neg(self) -> Self {
        self.through(-self.value, -Interval::ONE)
    }
}

impl Sub for IntervalFunction {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for IntervalFunction {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            ..[self.times(other.value), other.times(self.value)]
                .into_iter()
                .sum()
        }
    }
}
