//! Sweeps of nonlinear block Gauss–Seidel.

use super::natural_map::NaturalMap;
use crate::{contact::Ellipse, linalg::add_scaled, solver::conditions::Bound};

impl NaturalMap<'_> {
    /// Sweeps of nonlinear block Gauss–Seidel: in pane after pane the normal component goes to its
    /// minimum max(λ_ν − r_ν/S_νν, 0), then the pair makes one projected step of length 1/trace of
    /// its 2 × 2 block, and r = S λ − h follows at once.
    ///
    /// With Coulomb friction the ellipse has the g of λ_ν, the value just found, and 𝓕 changes between
    /// sweeps. With frozen ellipses every move decreases the energy. A sweep costs as much as one
    /// application of S.
    pub(in crate::solver) fn relax(&self, unknowns: &mut [f64], sweeps: usize) {
        let m = self.dual.n_panes();
        let mut gradient = self.dual.gradient(unknowns);
        let mut inverse = self.friction_inverse(unknowns);
        for sweep in 0..sweeps {
            if sweep > 0 {
                let next = self.friction_inverse(unknowns);
                // Half of the way to the 𝓕⁻¹ of the present λ: undamped, a law that hardens with slip makes panes stick and slip in
                // turn from sweep to sweep.
                for (old, new) in inverse.iter_mut().flatten().zip(next.iter().flatten()) {
                    *old += 0.5 * (new - *old);
                }
            }
            for pane in 0..m {
                self.relax_pane(pane, inverse.get(pane), unknowns, &mut gradient);
            }
        }
    }

    /// One pane of a sweep, at the 𝓕⁻¹ of its ellipse.
    fn relax_pane(
        &self,
        pane: usize,
        inverse: Option<&[f64; 2]>,
        unknowns: &mut [f64],
        gradient: &mut [f64],
    ) {
        let diagonal = |j: usize| self.dual.diagonal(j);
        let set = |unknowns: &mut [f64], gradient: &mut [f64], j: usize, value: f64| {
            let change = value - unknowns[j];
            if change != 0.0 {
                add_scaled(gradient, change, self.dual.column(j));
                unknowns[j] = value;
            }
        };
        if diagonal(pane) > 0.0 {
            let value = (unknowns[pane] - gradient[pane] / diagonal(pane)).max(0.0);
            set(unknowns, gradient, pane, value);
        }
        let Some(at) = self.dual.layout.tangential(pane) else {
            return;
        };
        let trace = diagonal(at[0]) + diagonal(at[1]);
        if trace > 0.0 {
            let ellipse = match (&self.conditions.bound, inverse) {
                (Bound::Given(set), _) => set.ellipses[pane],
                (Bound::Coulomb(_, law), inverse) => {
                    let slip_bound = law.slip_bound(pane, unknowns[pane]);
                    Ellipse {
                        semi_axes: inverse.map_or([0.0; 2], |f| f.map(|f| slip_bound / f)),
                    }
                }
            };
            let trial = at.map(|j| unknowns[j] - gradient[j] / trace);
            let next = ellipse.project(trial);
            set(unknowns, gradient, at[0], next[0]);
            set(unknowns, gradient, at[1], next[1]);
        }
    }
}
