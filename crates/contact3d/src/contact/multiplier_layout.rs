//! Where the components of a multiplier lie.

use std::ops::Range;

/// The order of the components of a multiplier λ: the m normal ones first, then, with friction, m
/// tangential pairs. All that is indexed by multipliers (B, S, h, residuals, stiffness) follows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MultiplierLayout {
    n_panes: usize,
    friction: bool,
}

impl MultiplierLayout {
    /// The layout for m panes, with pairs or without.
    #[must_use]
    pub fn new(n_panes: usize, friction: bool) -> Self {
        Self { n_panes, friction }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(self) -> usize {
        self.n_panes
    }

    /// Whether there are tangential pairs.
    #[must_use]
    pub fn has_friction(self) -> bool {
        self.friction
    }

    /// Number of multipliers: 3m, or m without friction.
    #[must_use]
    pub fn n_multipliers(self) -> usize {
        if self.friction {
            3 * self.n_panes
        } else {
            self.n_panes
        }
    }

    /// The normal component of a pane.
    #[must_use]
    pub fn normal(self, pane: usize) -> usize {
        pane
    }

    /// The tangential pair of a pane; `None` without friction.
    #[must_use]
    pub fn tangential(self, pane: usize) -> Option<[usize; 2]> {
        self.friction.then(|| {
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

    /// The normal components and the tangential pairs of a vector of multipliers, `[n_panes]` each;
    /// no pairs without friction. What follows them, the rigid motions of a body that floats, is left out.
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
        let layout = MultiplierLayout::new(3, true);
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
        let layout = MultiplierLayout::new(2, false);
        assert_eq!(layout.n_multipliers(), 2);
        assert_eq!(layout.tangential(1), None);
        assert_eq!(layout.tangentials(), 2..2);
        assert_eq!(layout.pair(&[1.0, 2.0], 1), [0.0; 2]);
    }
}
