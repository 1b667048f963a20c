use std::sync::atomic::{AtomicUsize, Ordering};

use super::Ellipse;

/// The admissible multipliers of a frozen problem: λ_ν ≥ 0 and, with friction, ‖𝓕_i⁻¹ λ_t,i‖ ≤ g_i
/// on every pane.
#[derive(Debug, Clone)]
pub struct FeasibleSet<'a> {
    n_panes: usize,
    /// One ellipse per pane; none without friction.
    pub ellipses: Vec<Ellipse>,
    projections: &'a AtomicUsize,
}

impl<'a> FeasibleSet<'a> {
    /// Bounds on all normal components and ellipses of given semi-axes in Pa, `[n_panes]`, or none;
    /// projections on ellipses are added to `projections`.
    #[must_use]
    pub fn new(n_panes: usize, semi_axes: Vec<[f64; 2]>, projections: &'a AtomicUsize) -> Self {
        let ellipses = semi_axes.into_iter();
        Self {
            n_panes,
            ellipses: ellipses.map(|semi_axes| Ellipse { semi_axes }).collect(),
            projections,
        }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.n_panes
    }

    /// Adds to the count of projections on ellipses.
    pub(super) fn count_projections(&self) {
        self.projections
            .fetch_add(self.ellipses.len(), Ordering::Relaxed);
    }

    /// The tangential pair of a pane in a multiplier-sized vector.
    #[must_use]
    pub fn tangential(&self, vector: &[f64], pane: usize) -> [f64; 2] {
        let at = self.n_panes() + 2 * pane;
        [vector[at], vector[at + 1]]
    }

    /// P: the nearest admissible multiplier.
    pub fn project(&self, multiplier: &mut [f64]) {
        for value in &mut multiplier[..self.n_panes()] {
            *value = value.max(0.0);
        }
        self.count_projections();
        for pane in 0..self.ellipses.len() {
            let nearest = self.ellipses[pane].project(self.tangential(multiplier, pane));
            let at = self.n_panes() + 2 * pane;
            multiplier[at..at + 2].copy_from_slice(&nearest);
        }
    }

    /// Marks the entries of free blocks: λ_ν > 0, λ_t strictly inside its ellipse.
    pub fn mark_free(&self, multiplier: &[f64], free: &mut [bool]) {
        let m = self.n_panes();
        for pane in 0..m {
            free[pane] = multiplier[pane] > 0.0;
        }
        for pane in 0..self.ellipses.len() {
            let inside = !self.ellipses[pane].on_boundary(self.tangential(multiplier, pane));
            free[m + 2 * pane] = inside;
            free[m + 2 * pane + 1] = inside;
        }
    }

    /// The largest s ≥ 0 with λ − s d admissible, for an admissible λ.
    #[must_use]
    pub fn largest_step(&self, multiplier: &[f64], direction: &[f64]) -> f64 {
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
