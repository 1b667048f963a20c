//! Arithmetic of intervals, rounded outwards, and of functions over boxes with their slopes by the unknowns.

use std::ops::{Add, Mul, Neg, Sub};

/// All numbers between two. An operation of IEEE 754 gives the nearest number to the true result, so its neighbours enclose that;
/// sums that vanish are exact, and so are products with zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
}

/// The number below a rounded result.
fn below(value: f64) -> f64 {
    if value == 0.0 {
        value
    } else {
        value.next_down()
    }
}

fn above(value: f64) -> f64 {
    if value == 0.0 { value } else { value.next_up() }
}

impl Interval {
    pub(super) const ZERO: Self = Self::point(0.0);
    pub(super) const ONE: Self = Self::point(1.0);

    pub(super) const fn point(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    pub(super) const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// The numbers no farther than a distance from a value.
    pub(super) fn around(value: f64, distance: f64) -> Self {
        Self::point(value) + Self::new(-distance, distance)
    }

    pub(super) fn middle(self) -> f64 {
        0.5 * self.low + 0.5 * self.high
    }

    pub(super) fn width(self) -> f64 {
        self.high - self.low
    }

    /// The largest absolute value.
    pub(super) fn size(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    pub(super) fn has_zero(self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }

    pub(super) fn is_inside(self, other: Self) -> bool {
        other.low <= self.low && self.high <= other.high
    }

    pub(super) fn is_strictly_inside(self, other: Self) -> bool {
        other.low < self.low && self.high < other.high
    }

    /// What both have in common.
    pub(super) fn meet(self, other: Self) -> Option<Self> {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        (low <= high).then_some(Self { low, high })
    }

    pub(super) fn hull(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }

    pub(super) fn abs(self) -> Self {
        if self.has_zero() {
            Self::new(0.0, self.size())
        } else {
            Self::new(self.low.abs().min(self.high.abs()), self.size())
        }
    }

    pub(super) fn square(self) -> Self {
        let size = self.abs();
        let square = Self::new(size.low * size.low, size.high * size.high);
        Self::new(below(square.low).max(0.0), above(square.high))
    }

    /// The root of what is not negative in it.
    pub(super) fn sqrt(self) -> Self {
        let root = Self::new(self.low.max(0.0).sqrt(), self.high.max(0.0).sqrt());
        Self::new(below(root.low).max(0.0), above(root.high))
    }

    /// The quotient; `None` by an interval that holds zero.
    pub(super) fn over(self, divisor: Self) -> Option<Self> {
        if divisor.has_zero() {
            return None;
        }
        let ends = [divisor.low, divisor.high];
        let quotients = ends.map(|d| [self.low / d, self.high / d]);
        Some(spanned(quotients.as_flattened()))
    }

    /// 1/x; everything where x may be zero.
    pub(super) fn recip(self) -> Self {
        let everything = Self::new(f64::NEG_INFINITY, f64::INFINITY);
        Self::ONE.over(self).unwrap_or(everything)
    }
}

/// The smallest interval around rounded results; everything where one is no number.
fn spanned(values: &[f64]) -> Interval {
    if values.iter().any(|v| v.is_nan()) {
        return Interval::new(f64::NEG_INFINITY, f64::INFINITY);
    }
    let low = values.iter().fold(f64::INFINITY, |low, v| low.min(*v));
    let high = values
        .iter()
        .fold(f64::NEG_INFINITY, |high, v| high.max(*v));
    Interval::new(low.next_down(), high.next_up())
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(below(self.low + other.low), above(self.high + other.high))
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.high, -self.low)
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self == Self::ZERO || other == Self::ZERO {
            return Self::ZERO;
        }
        spanned(&[
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ])
    }
}

impl std::iter::Sum for Interval {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, Add::add)
    }
}

/// a · b.
pub(super) fn product(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

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
