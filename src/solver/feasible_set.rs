use super::Ellipse;
use crate::contact::FrictionField;

/// The admissible multipliers for a frozen slip bound g and friction 𝓕:
/// λ_ν ≥ 0 and ‖𝓕_i⁻¹ λ_t,i‖ ≤ g_i on every pane.
#[derive(Debug, Clone)]
pub struct FeasibleSet {
    /// One ellipse per pane, `[n_panes]`.
    pub ellipses: Vec<Ellipse>,
}

impl FeasibleSet {
    /// Ellipses with semi-axes g_i / (𝓕_i⁻¹)₁₁ and g_i / (𝓕_i⁻¹)₂₂ in Pa.
    #[must_use]
    pub fn new(slip_bound: &[f64], friction: &FrictionField) -> Self {
        let ellipses = slip_bound
            .iter()
            .zip(&friction.pane_inverse)
            .map(|(g, inverse)| Ellipse {
                semi_axes: [g / inverse[0], g / inverse[1]],
            })
            .collect();
        Self { ellipses }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.ellipses.len()
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
        for pane in 0..self.n_panes() {
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
        (0..self.n_panes())
            .map(|pane| {
                let p = self.tangential(multiplier, pane);
                self.ellipses[pane].largest_step(p, self.tangential(direction, pane))
            })
            .fold(normal, f64::min)
    }
}
