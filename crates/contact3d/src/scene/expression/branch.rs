//! One smooth piece of a formula: the way it goes at each of its branch points, continued beyond the ends of the piece.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use super::program::{BranchPoints, Dual, Number};

/// Branch points of a formula that are told apart; the others go their own way.
const MAX_BRANCH_POINTS: usize = u64::BITS as usize;

/// The way that a formula goes at each of its branch points, in the order in which they are met: bit k is set where the left number is the
/// smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
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

/// Goes the way that a branch prescribes, or, without one, the way of the point, and remembers it.
#[derive(Debug)]
pub(super) struct BranchChoice {
    branch: FormulaBranch,
    is_given: bool,
    /// The difference left − right at each branch point so far.
    differences: Vec<Dual>,
}

impl BranchChoice {
    /// Along a branch.
    pub(super) fn along(branch: FormulaBranch) -> Self {
        Self {
            branch,
            is_given: true,
            differences: Vec::new(),
        }
    }

    /// Where the point goes.
    pub(super) fn open() -> Self {
        Self {
            branch: FormulaBranch::default(),
            is_given: false,
            differences: Vec::new(),
        }
    }

    /// The branch that was gone.
    pub(super) fn branch(&self) -> FormulaBranch {
        self.branch
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
                margin: sign * difference.value(),
                slopes: difference.derivatives().map(|slope| sign * slope),
            }
        });
        OnBranch {
            value: value.value(),
            slopes: value.derivatives(),
            ends: ends.collect(),
        }
    }

    /// The order of two numbers at a branch point: that of the branch, or without one as they compare; `None` where one is no number.
    fn at(
        &self,
        branch_point: usize,
        [left, right]: [Dual; 2],
        compare: impl FnOnce() -> Option<Ordering>,
    ) -> Option<Ordering> {
        let is_none = left.value().is_nan() || right.value().is_nan();
        match (is_none, self.is_given && branch_point < MAX_BRANCH_POINTS) {
            (true, _) => None,
            (false, false) => compare(),
            (false, true) if self.branch.is_less(branch_point) => Some(Ordering::Less),
            (false, true) => Some(Ordering::Greater),
        }
    }
}

impl BranchPoints<Dual> for BranchChoice {
    fn order(&mut self, left: Dual, right: Dual) -> Option<Ordering> {
        let branch_point = self.differences.len();
        let gap = left.value() - right.value();
        let difference = left.with(right, gap, || [1.0, -1.0]);
        self.differences.push(difference);
        let order = self.at(branch_point, [left, right], || {
            left.compare_right_limit(right)
        })?;
        if !self.is_given && branch_point < MAX_BRANCH_POINTS {
            self.branch = self.branch.with(branch_point, order.is_lt());
        }
        Some(order)
    }

    fn here(&self, left: Dual, right: Dual) -> Option<Ordering> {
        let compare = || left.value().partial_cmp(&right.value());
        self.at(self.differences.len(), [left, right], compare)
    }

    fn joined(&mut self, mut value: Dual, compared: [Dual; 2]) -> Dual {
        let branch_point = self.differences.len() - 1;
        let own = if branch_point < MAX_BRANCH_POINTS {
            1 << branch_point
        } else {
            0
        };
        let behind = compared
            .iter()
            .fold(own, |all, number| all | number.branch_points);
        value.branch_points |= behind;
        value
    }
}
