//! What the panes do: the states of which every solution has one.

use super::interval::Interval;

/// cos and sin of the direction around which half circles of slip lie: no direction that a scene is likely to prefer.
const TURNED: [f64; 2] = [28.0 / 53.0, 45.0 / 53.0];

/// What a pane does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PaneCase {
    Open,
    Stick,
    Slip(Chart),
}

impl PaneCase {
    pub(super) fn slips(self) -> bool {
        matches!(self, Self::Slip(_))
    }
}

/// The directions in which a pane slips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chart {
    /// Half a circle: ±Q (1 − t², 2t)/(1 + t²) for t between −1 and 1, with a fixed rotation Q.
    Half { negative: bool },
    /// The only axis along which the pane moves.
    Axis { axis: usize, negative: bool },
}

impl Chart {
    /// Those of a pane that moves along given axes.
    pub(super) fn of(moves: [bool; 2]) -> Vec<Self> {
        let chart = |negative: bool| match moves {
            [true, true] => Some(Self::Half { negative }),
            [true, false] => Some(Self::Axis { axis: 0, negative }),
            [false, true] => Some(Self::Axis { axis: 1, negative }),
            [false, false] => None,
        };
        [false, true].into_iter().filter_map(chart).collect()
    }

    pub(super) fn has_angle(self) -> bool {
        matches!(self, Self::Half { .. })
    }

    /// The part of an interval of t in which some vector has the direction; `None` where there is none.
    pub(super) fn narrowed(self, t: Interval, vector: [Interval; 2]) -> Option<Interval> {
        let Self::Half { negative } = self else {
            return Some(t);
        };
        let [x, y] = vector.map(|v| if negative { -v } else { v });
        let [c, s] = TURNED.map(|v| Interval::around(v, f64::EPSILON));
        let ahead = (c * x + s * y).meet(Interval::new(0.0, f64::INFINITY))?;
        let aside = c * y - s * x;
        // tan θ/2 = y/(√(x² + y²) + x) falls with x > 0 where y > 0.
        let half_tangent = |aside: f64, near: f64, far: f64| {
            let ahead = Interval::point(if aside > 0.0 { near } else { far });
            let aside = Interval::point(aside);
            aside.over((ahead.square() + aside.square()).sqrt() + ahead)
        };
        let low = half_tangent(aside.low, ahead.high, ahead.low);
        let high = half_tangent(aside.high, ahead.low, ahead.high);
        match low.zip(high) {
            Some((low, high)) => t.meet(Interval::new(low.low, high.high)),
            None => Some(t),
        }
    }

    /// The direction at t, which an axis does not have, and its derivative by t.
    pub(super) fn direction(self, t: Interval) -> [[Interval; 2]; 2] {
        match self {
            Self::Axis { axis, negative } => {
                let mut along = [Interval::ZERO; 2];
                along[axis] = if negative {
                    -Interval::ONE
                } else {
                    Interval::ONE
                };
                [along, [Interval::ZERO; 2]]
            }
            Self::Half { negative } => {
                let (circle, speed) = circle(t);
                let [c, s] = TURNED.map(|v| Interval::around(v, f64::EPSILON));
                let turned = [c * circle[0] - s * circle[1], s * circle[0] + c * circle[1]];
                let along = turned.map(|e| if negative { -e } else { e });
                [along, [-(along[1] * speed), along[0] * speed]]
            }
        }
    }
}

/// (1 − t², 2t)/(1 + t²) and the angle's derivative 2/(1 + t²).
fn circle(t: Interval) -> ([Interval; 2], Interval) {
    let two = Interval::point(2.0);
    let speed_at = |t: Interval| two * (Interval::ONE + t.square()).recip();
    let speed = speed_at(t);
    let sine = |t: f64| Interval::point(t) * speed_at(Interval::point(t));
    // 2t/(1 + t²) grows up to t = 1 and from −1 on.
    let ends = sine(t.low).hull(sine(t.high));
    let tops = [-1.0, 1.0].into_iter();
    let tops = tops.filter(|top| t.low < *top && *top < t.high);
    let sine = tops.fold(ends, |hull, top| hull.hull(Interval::point(top)));
    ([speed - Interval::ONE, sine], speed)
}

/// All choices of one state for each pane.
pub(super) fn choices(of_panes: &[Vec<PaneCase>]) -> impl Iterator<Item = Vec<PaneCase>> + '_ {
    let count: usize = of_panes.iter().map(Vec::len).product();
    (0..count).map(move |mut code| {
        let states = of_panes.iter().map(|states| {
            let state = states[code % states.len()];
            code /= states.len();
            state
        });
        states.collect()
    })
}
