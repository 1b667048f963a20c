//! Where the components of a multiplier lie.

use std::ops::Range;

/// The order of the components of a multiplier λ: the m normal ones first, then the tangential pairs of the panes with
/// friction, which come before those without. All that is indexed by multipliers (B, S, h, residuals, stiffness) follows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MultiplierLayout {
    n_panes: usize,
    n_pairs: usize,
}

impl MultiplierLayout {
    /// The layout for m panes, of which the first `n_pairs` have friction.
    #[must_use]
    pub fn new(n_panes: usize, n_pairs: usize) -> Self {
        Self { n_panes, n_pairs }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(self) -> usize {
        self.n_panes
    }

    /// Number of tangential pairs: that of the panes with friction.
    #[must_use]
    pub fn n_pairs(self) -> usize {
        self.n_pairs
    }

    /// Whether there are tangential pairs.
    #[must_use]
    pub fn has_friction(self) -> bool {
        self.n_pairs > 0
    }

    /// Number of multipliers: 3m where all panes have friction, m where none has.
    #[must_use]
    pub fn n_multipliers(self) -> usize {
        self.n_panes + 2 * self.n_pairs
    }

    /// The normal component of a pane.
    #[must_use]
    pub fn normal(self, pane: usize) -> usize {
        pane
    }

    /// The tangential pair of a pane; `None` without friction.
    #[must_use]
    pub fn tangential(self, pane: usize) -> Option<[usize; 2]> {
        (pane < self.n_pairs).then(|| {
            let first = self.n_panes + 2 * pane;
            [first, first + 1]
        })
    }

    /// The pane that a component belongs to.
    #[must_use]
    pub fn pane_of(self, component: usize) -> usize {
        if component < self.n_panes {
            component
        } else {
            (component - self.n_panes) / 2
        }
    }

    /// The normal components.
    #[must_use]
    pub fn normals(self) -> Range<usize> {
        0..self.n_panes
    }

    /// The tangential components; none without friction.
    #[must_use]
    pub fn tangentials(self) -> Range<usize> {
        self.n_panes..self.n_multipliers()
    }

    /// The tangential pair of a pane in a vector of multipliers; zero without friction.
    #[must_use]
    pub fn pair(self, vector: &[f64], pane: usize) -> [f64; 2] {
        self.tangential(pane)
            .map_or([0.0; 2], |pair| pair.map(|j| vector[j]))
    }

    /// The normal components, `[n_panes]`, and the tangential pairs of a vector of multipliers, `[n_pairs]`. What follows them, the
    /// rigid motions of a body that floats, is left out.
    #[must_use]
    pub fn split<T>(self, vector: &[T]) -> (&[T], &[[T; 2]]) {
        let (normal, rest) = vector.split_at(self.n_panes);
        (normal, rest[..self.tangentials().len()].as_chunks().0)
    }

    /// As [`Self::split`], to write to.
    #[must_use]
    pub fn split_mut<T>(self, vector: &mut [T]) -> (&mut [T], &mut [[T; 2]]) {
        let n_tangential = self.tangentials().len();
        let (normal, rest) = vector.split_at_mut(self.n_panes);
        (normal, rest[..n_tangential].as_chunks_mut().0)
    }
}
