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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_component_has_one_place() {
        let layout = MultiplierLayout::new(3, 3);
        let places = (0..3).flat_map(|pane| {
            let [first, second] = layout.tangential(pane).expect("friction");
            [(layout.normal(pane), pane), (first, pane), (second, pane)]
        });
        let mut panes = [None; 9];
        for (place, pane) in places {
            assert_eq!(panes[place].replace(pane), None);
            assert_eq!(layout.pane_of(place), pane);
        }
        assert_eq!(layout.n_multipliers(), panes.len());
        let vector: Vec<f64> = (0..9).map(f64::from).collect();
        let (normal, pairs) = layout.split(&vector);
        assert_eq!(normal, [0.0, 1.0, 2.0]);
        assert_eq!(pairs[1], layout.pair(&vector, 1));
        assert_eq!(pairs[1], [5.0, 6.0]);
    }

    #[test]
    fn without_friction_there_are_no_pairs() {
        let layout = MultiplierLayout::new(2, 0);
        assert_eq!(layout.n_multipliers(), 2);
        assert_eq!(layout.tangential(1), None);
        assert_eq!(layout.tangentials(), 2..2);
        assert_eq!(layout.pair(&[1.0, 2.0], 1), [0.0; 2]);
    }

    #[test]
    fn panes_with_friction_come_first() {
        let layout = MultiplierLayout::new(3, 1);
        assert_eq!(layout.n_multipliers(), 5);
        assert_eq!(layout.tangential(0), Some([3, 4]));
        assert_eq!(layout.tangential(1), None);
        assert_eq!([3, 4].map(|j| layout.pane_of(j)), [0, 0]);
        let (normal, pairs) = layout.split(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!((normal.len(), pairs), (3, &[[4.0, 5.0]][..]));
    }
}
