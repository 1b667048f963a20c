//! Coefficients of friction made of straight lines, over intervals of slips.

use super::interval::Interval;

/// Rounding of the values of a law at its knots, of which the evaluations make a few.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A coefficient over its own slip: straight lines between knots, the last one constant without end.
#[derive(Debug, Clone)]
pub(super) struct StraightLines {
    knots: Vec<(f64, Interval)>,
}

/// The coefficients at one contact node.
#[derive(Debug, Clone)]
pub(super) enum NodeLaw {
    /// F(|u_t|).
    Isotropic(StraightLines),
    /// F₁(|u_t1|), F₂(|u_t2|).
    Orthotropic([StraightLines; 2]),
}

impl StraightLines {
    /// From the slips at the knots, zero first, and the values there.
    pub(super) fn new(knots: impl Iterator<Item = (f64, f64)>) -> Self {
        let rounded = |value: f64| Interval::around(value, ROUNDING * value.abs());
        Self {
            knots: knots.map(|(slip, value)| (slip, rounded(value))).collect(),
        }
    }

    /// The values and the slopes on all lines that an interval of slips reaches.
    pub(super) fn over(&self, slip: Interval) -> (Interval, Interval) {
        let before = |slip: f64| self.knots.partition_point(|(knot, _)| *knot <= slip);
        let reached = before(slip.low).saturating_sub(1)..before(slip.high).max(1);
        let lines = reached.map(|line| {
            let (start, from) = self.knots[line];
            let Some((end, to)) = self.knots.get(line + 1) else {
                return (from, Interval::ZERO);
            };
            let length = Interval::point(*end) - Interval::point(start);
            let slope = (*to - from) * length.recip();
            let inside = Interval::new(slip.low.max(start), slip.high.min(*end));
            (from + slope * (inside - Interval::point(start)), slope)
        });
        let all = lines.reduce(|a, b| (a.0.hull(b.0), a.1.hull(b.1)));
        all.expect("every slip is on a line")
    }
}
