//! The admissible set of a frozen problem.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::Ellipse;
use crate::contact::MultiplierLayout;

/// The admissible multipliers of a frozen problem: λ_ν ≥ 0 on every pane and ‖𝓕_i⁻¹ λ_t,i‖ ≤ g_i
/// on those with friction.
#[derive(Debug, Clone)]
pub struct FeasibleSet<'a> {
    layout: MultiplierLayout,
    /// One ellipse for each pane with friction.
    pub ellipses: Vec<Ellipse>,
    projections: &'a AtomicUsize,
}

impl<'a> FeasibleSet<'a> {
    /// Bounds on all normal components and ellipses of given semi-axes in Pa on the first panes, `[n_friction_panes]`;
    /// projections on ellipses are added to `projections`.
    #[must_use]
    pub fn new(n_panes: usize, semi_axes: Vec<[f64; 2]>, projections: &'a AtomicUsize) -> Self {
        let layout = MultiplierLayout::new(n_panes, semi_axes.len());
        let ellipses = semi_axes.into_iter();
        Self {
            layout,
            ellipses: ellipses.map(|semi_axes| Ellipse { semi_axes }).collect(),
            projections,
        }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.layout.n_panes()
    }

    /// The order of the multipliers.
    #[must_use]
    pub fn layout(&self) -> MultiplierLayout {
        self.layout
    }

    /// Adds to the count of projections on ellipses.
    pub(super) fn count_projections(&self) {
        self.projections
            .fetch_add(self.ellipses.len(), Ordering::Relaxed);
    }

    /// The tangential pair of a pane in a multiplier-sized vector.
    #[must_use]
    pub fn tangential(&self, vector: &[f64], pane: usize) -> [f64; 2] {
        self.layout.pair(vector, pane)
    }

    /// P: the nearest admissible multiplier.
    pub fn project(&self, multiplier: &mut [f64]) {
        let (normal, tangential) = self.layout.split_mut(multiplier);
        for value in normal {
            *value = value.max(0.0);
        }
        self.count_projections();
        for (ellipse, pair) in self.ellipses.iter().zip(tangential) {
            *pair = ellipse.project(*pair);
        }
    }

    /// Marks the entries of free blocks: λ_ν > 0, λ_t strictly inside its ellipse.
    pub(crate) fn mark_free(&self, multiplier: &[f64], free: &mut [bool]) {
        let (normal, tangential) = self.layout.split(multiplier);
        let (free_normal, free_pairs) = self.layout.split_mut(free);
        for (free, value) in free_normal.iter_mut().zip(normal) {
            *free = *value > 0.0;
        }
        let pairs = free_pairs.iter_mut().zip(tangential);
        for ((free, pair), ellipse) in pairs.zip(&self.ellipses) {
            *free = [!ellipse.on_boundary(*pair); 2];
        }
    }

    /// The largest s ≥ 0 with λ − s d admissible, for an admissible λ.
    #[must_use]
    pub(crate) fn largest_step(&self, multiplier: &[f64], direction: &[f64]) -> f64 {
        let normal = (0..self.n_panes())
            .filter(|&i| direction[i] > 0.0)
            .map(|i| multiplier[i] / direction[i])
            .fold(f64::INFINITY, f64::min);
        (0..self.ellipses.len())
            .map(|pane| {
                let p = self.tangential(multiplier, pane);
                self.ellipses[pane].largest_step(p, self.tangential(direction, pane))
            })
            .fold(normal, f64::min)
    }
}
