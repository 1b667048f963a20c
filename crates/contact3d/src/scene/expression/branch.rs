//! Numbers with slopes, and the smooth pieces of a formula: the way it goes at each of its branch points, continued beyond the ends of the
//! piece.

use std::cmp::Ordering;

/// Branch points of a formula that are told apart; the others go their own way.
const MAX_BRANCH_POINTS: usize = u64::BITS as usize;

/// The way that a formula goes at each of its branch points, in the order in which they are met: bit k is set where the left number is the
/// smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FormulaBranch(u64);

impl FormulaBranch {
    /// The branch beyond a branch point, on the side where its left number is the smaller one or not.
    #[must_use]
    pub fn with(self, branch_point: usize, less: bool) -> Self {
        let bit = 1 << branch_point;
        Self(if less { self.0 | bit } else { self.0 & !bit })
    }

    fn is_less(self, branch_point: usize) -> bool {
        self.0 >> branch_point & 1 == 1
    }
}

/// A formula on one of its branches.
#[derive(Debug, Clone, PartialEq)]
pub struct OnBranch {
    /// Its value.
    pub value: f64,
    /// By the three variables that were asked for.
    pub slopes: [f64; 3],
    /// The branch points at which the branch ends, of those on its way.
    pub ends: Vec<BranchEnd>,
}

/// A branch point at which a branch ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchEnd {
    /// Which branch point, in the order in which they are met.
    pub branch_point: usize,
    /// On which side of the branch point the branch lies.
    pub less: bool,
    /// The difference of the numbers compared, positive on the branch.
    pub margin: f64,
    /// Its slopes.
    pub slopes: [f64; 3],
}

/// Which way a formula goes where `abs`, `min`, `max` and `if` part, its branch points: that of a branch, or, without one, that of the
/// point, which is remembered.
#[derive(Debug, Default)]
pub(super) struct BranchChoice {
    pub(super) branch: FormulaBranch,
    is_given: bool,
    /// Branch points so far.
    n_met: usize,
    /// The differences left − right at them, along a given branch.
    differences: Vec<Dual>,
}

impl BranchChoice {
    /// Along a branch.
    pub(super) fn along(branch: FormulaBranch) -> Self {
        Self {
            branch,
            is_given: true,
            ..Self::default()
        }
    }

    /// What was found along it.
    pub(super) fn found(&self, value: Dual) -> OnBranch {
        let known = self.differences.len().min(MAX_BRANCH_POINTS);
        let branch_points =
            (0..known).filter(|branch_point| value.branch_points >> branch_point & 1 == 1);
        let ends = branch_points.map(|branch_point| {
            let less = self.branch.is_less(branch_point);
            let sign = if less { -1.0 } else { 1.0 };
            let difference = self.differences[branch_point];
            BranchEnd {
                branch_point,
                less,
                margin: sign * difference.value,
                slopes: difference.derivatives().map(|slope| sign * slope),
            }
        });
        OnBranch {
            value: value.value,
            slopes: value.derivatives(),
            ends: ends.collect(),
        }
    }

    /// The order of two numbers at the next branch point: that of the branch, or without one as they compare; `None` where one is no
    /// number.
    fn next(
        &self,
        [left, right]: [Dual; 2],
        compare: impl FnOnce() -> Option<Ordering>,
    ) -> Option<Ordering> {
        let is_none = left.value.is_nan() || right.value.is_nan();
        match (is_none, self.is_given && self.n_met < MAX_BRANCH_POINTS) {
            (true, _) => None,
            (false, false) => compare(),
            (false, true) if self.branch.is_less(self.n_met) => Some(Ordering::Less),
            (false, true) => Some(Ordering::Greater),
        }
    }

    /// Which of two numbers is the larger one for the slopes, at the next branch point, which is behind afterwards; `None` where one is
    /// none.
    pub(super) fn order(&mut self, left: Dual, right: Dual) -> Option<Ordering> {
        let order = self.next([left, right], || left.compare_right_limit(right));
        if self.is_given {
            let gap = left.value - right.value;
            self.differences.push(left.with(right, gap, || [1.0, -1.0]));
        } else if let Some(order) = order.filter(|_| self.n_met < MAX_BRANCH_POINTS) {
            self.branch = self.branch.with(self.n_met, order.is_lt());
        }
        self.n_met += 1;
        order
    }

    /// The same for the value of `if`; asked before [`Self::order`] of the same branch point.
    pub(super) fn here(&self, left: Dual, right: Dual) -> Option<Ordering> {
        self.next([left, right], || left.value.partial_cmp(&right.value))
    }

    /// What a branch point gives, with what the two numbers that were compared at it left behind.
    pub(super) fn joined(&self, mut value: Dual, compared: [Dual; 2]) -> Dual {
        let own = 1_u64
            .checked_shl((self.n_met - 1) as u32)
            .unwrap_or_default();
        let behind = compared.iter().map(|number| number.branch_points);
        value.branch_points |= behind.fold(own, |all, points| all | points);
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
    pub(super) value: f64,
    pub(super) slopes: [Option<f64>; 3],
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

    /// A number that does not change.
    pub(super) fn number(value: f64) -> Self {
        Self::variable(value, None)
    }

    /// The partial derivatives.
    pub(super) fn derivatives(self) -> [f64; 3] {
        self.slopes.map(Option::unwrap_or_default)
    }

    /// The rate of change when all variables grow at the same rate.
    fn growth(self) -> f64 {
        self.slopes.iter().flatten().sum()
    }
    /// A function of this number, by its value and derivative.
    pub(super) fn through(self, value: f64, derivative: impl FnOnce() -> f64) -> Self {
        self.with(Self::number(0.0), value, || [derivative(), 0.0])
    }

    /// A function of this number and another, by its value and partial derivatives.
    pub(super) fn with(
        self,
        other: Self,
        value: f64,
        derivatives: impl FnOnce() -> [f64; 2],
    ) -> Self {
        let branch_points = self.branch_points | other.branch_points;
        let mut slopes = [None; 3];
        if self.has_slopes() || other.has_slopes() {
            let [first, second] = derivatives();
            slopes = std::array::from_fn(|k| {
                let own = self.slopes[k].map(|slope| chained(first, slope));
                let others = other.slopes[k].map(|slope| chained(second, slope));
                match (own, others) {
                    (Some(own), Some(others)) => Some(own + others),
                    (own, others) => own.or(others),
                }
            });
        }
        Self {
            value,
            slopes,
            branch_points,
        }
    }

    fn has_slopes(&self) -> bool {
        self.slopes.iter().any(Option::is_some)
    }

    /// Which of two numbers is the larger one, of equal ones that which grows faster; `None` where
    /// one is no number.
    fn compare_right_limit(self, other: Self) -> Option<Ordering> {
        let order = self.value.partial_cmp(&other.value)?;
        let growth = || self.growth().partial_cmp(&other.growth());
        Some(order.then_with(|| growth().unwrap_or(Ordering::Equal)))
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
