//! The admissible set of a frozen problem.

use crate::contact::Ellipse;
use crate::{contact::MultiplierLayout, linalg::difference};

/// The admissible multipliers of a frozen problem: λ_ν ≥ 0 on every pane and ‖𝓕_i⁻¹ λ_t,i‖ ≤ g_i
/// on those with friction.
#[derive(Debug, Clone)]
pub struct FeasibleSet {
    /// The order of the multipliers.
    pub layout: MultiplierLayout,
    /// One ellipse for each pane with friction.
    pub ellipses: Vec<Ellipse>,
}

impl FeasibleSet {
    /// Bounds on all normal components and ellipses of given semi-axes in Pa on the first panes, `[n_friction_panes]`.
    #[must_use]
    pub fn new(n_panes: usize, semi_axes: Vec<[f64; 2]>) -> Self {
        let layout = MultiplierLayout::new(n_panes, semi_axes.len());
        let ellipses = semi_axes.into_iter();
        Self {
            layout,
            ellipses: ellipses.map(|semi_axes| Ellipse { semi_axes }).collect(),
        }
    }

    /// P: the nearest admissible multiplier.
    pub fn project(&self, multiplier: &mut [f64]) {
        let (normal, tangential) = self.layout.split_mut(multiplier);
        for value in normal {
            *value = value.max(0.0);
        }
        for (ellipse, pair) in self.ellipses.iter().zip(tangential) {
            *pair = ellipse.project(*pair);
        }
    }

    /// λ − P(λ − ρ r) for steplengths ρ of the components; for one ᾱ of all the reduced gradient g̃ times ᾱ.
    pub(super) fn projected_step(
        &self,
        multiplier: &[f64],
        gradient: &[f64],
        steplength: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        let terms = multiplier.iter().zip(gradient).enumerate();
        let mut next: Vec<f64> = terms.map(|(j, (l, r))| l - steplength(j) * r).collect();
        self.project(&mut next);
        difference(multiplier, &next)
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
        let normal = (0..self.layout.n_panes())
            .filter(|&i| direction[i] > 0.0)
            .map(|i| multiplier[i] / direction[i])
            .fold(f64::INFINITY, f64::min);
        (0..self.ellipses.len())
            .map(|pane| {
                let p = self.layout.pair(multiplier, pane);
                self.ellipses[pane].largest_step(p, self.layout.pair(direction, pane))
            })
            .fold(normal, f64::min)
    }
}
