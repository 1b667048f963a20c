//! One smooth piece of a formula: the way it goes at each of its forks, continued beyond the ends of the piece.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use super::program::{Forks, Number, Sloped};

/// Forks of a formula that are told apart; the others go their own way.
const MOST_FORKS: usize = u64::BITS as usize;

/// The way that a formula goes at each of its forks, in the order in which they are met: bit k is set where the left number is the
/// smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FormulaBranch(u64);

impl FormulaBranch {
    /// The branch beyond a fork, on the side where its left number is the smaller one or not.
    #[must_use]
    pub fn with(self, fork: usize, less: bool) -> Self {
        let bit = 1 << fork;
        Self(if less { self.0 | bit } else { self.0 & !bit })
    }

    fn is_less(self, fork: usize) -> bool {
        self.0 >> fork & 1 == 1
    }
}

/// A formula on one of its branches.
#[derive(Debug, Clone, PartialEq)]
pub struct OnBranch {
    /// Its value.
    pub value: f64,
    /// By the three variables that were asked for.
    pub slopes: [f64; 3],
    /// The forks at which the branch ends, of those on its way.
    pub ends: Vec<BranchEnd>,
}

/// A fork at which a branch ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchEnd {
    /// Which fork, in the order in which they are met.
    pub fork: usize,
    /// On which side of the fork the branch lies.
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
    /// The difference left − right at each fork so far.
    differences: Vec<Sloped>,
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
    pub(super) fn found(&self, value: Sloped) -> OnBranch {
        let known = self.differences.len().min(MOST_FORKS);
        let forks = (0..known).filter(|fork| value.forks >> fork & 1 == 1);
        let ends = forks.map(|fork| {
            let less = self.branch.is_less(fork);
            let sign = if less { -1.0 } else { 1.0 };
            let difference = self.differences[fork];
            BranchEnd {
                fork,
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

    /// The order of two numbers at a fork: that of the branch, or without one as they compare; `None` where one is no number.
    fn at(
        &self,
        fork: usize,
        [left, right]: [Sloped; 2],
        compare: impl FnOnce() -> Option<Ordering>,
    ) -> Option<Ordering> {
        let is_none = left.value().is_nan() || right.value().is_nan();
        match (is_none, self.is_given && fork < MOST_FORKS) {
            (true, _) => None,
            (false, false) => compare(),
            (false, true) if self.branch.is_less(fork) => Some(Ordering::Less),
            (false, true) => Some(Ordering::Greater),
        }
    }
}

impl Forks<Sloped> for BranchChoice {
    fn order(&mut self, left: Sloped, right: Sloped) -> Option<Ordering> {
        let fork = self.differences.len();
        let gap = left.value() - right.value();
        let difference = left.with(right, gap, || [1.0, -1.0]);
        self.differences.push(difference);
        let order = self.at(fork, [left, right], || left.compare_ahead(right))?;
        if !self.is_given && fork < MOST_FORKS {
            self.branch = self.branch.with(fork, order.is_lt());
        }
        Some(order)
    }

    fn here(&self, left: Sloped, right: Sloped) -> Option<Ordering> {
        let compare = || left.value().partial_cmp(&right.value());
        self.at(self.differences.len(), [left, right], compare)
    }

    fn joined(&mut self, mut value: Sloped, compared: [Sloped; 2]) -> Sloped {
        let fork = self.differences.len() - 1;
        let own = if fork < MOST_FORKS { 1 << fork } else { 0 };
        let behind = compared.iter().fold(own, |all, number| all | number.forks);
        value.forks |= behind;
        value
    }
}
