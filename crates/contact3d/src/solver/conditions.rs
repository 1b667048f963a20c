//! The conditions of contact and friction on every pane, for given λ, r and u_t.

use std::sync::Arc;

use super::{FeasibleSet, PaneLaws};
use crate::{
    contact::{
        CoulombLaw, Ellipse, FrictionField, MultiplierLayout, change_of_slips, slip_signs, slips,
    },
    dual::stresses_between,
    linalg::{norm, ratio},
};

/// Where the semi-axes of the ellipses come from.
#[derive(Clone, Copy)]
pub enum Bound<'a> {
    /// Coulomb friction with F(u): (a, b) = g / 𝓕⁻¹(u_t(λ)) with the law's slip bound g under the pressure
    /// max(z_ν, 0).
    Coulomb(&'a PaneLaws, &'a CoulombLaw),
    /// Given ellipses: Tresca's law, or one inner problem of Algorithm 4.1, whose ellipses are frozen; none in frictionless contact.
    Given(&'a FeasibleSet),
}

impl<'a> Bound<'a> {
    /// Coulomb friction where it is the law, else the ellipses of a set.
    pub(super) fn of(laws: &'a PaneLaws, set: &'a FeasibleSet) -> Self {
        match laws.coulomb() {
            Some(law) => Self::Coulomb(laws, law),
            None => Self::Given(set),
        }
    }
}

/// The natural map of given steplengths, as a function of λ, of the gradient r and of the
/// tangential displacement, which an operator adds.
///
/// z = λ − ρ r; R_ν = λ_ν − max(z_ν, 0), R_t = λ_t − P_{a,b}(z_t), with Coulomb friction for the slip bound g
/// of the pressure max(z_ν, 0); the equilibrium of rigid motions has the rows ρ (e − Gᵀλ − D α). The zeros do not depend on ρ > 0,
/// but the meaning of a small ‖R‖ does. With the stiffness 1/S_ii of a pane whose neighbours follow it, a
/// body that nearly floats can have a small R although its zones are wrong; with its local stiffness
/// ([`crate::dual::LocalStiffness`]) it cannot. A component whose row of S vanishes (its
/// displacement is prescribed) moves nothing; it has z = 0, and so becomes 0.
pub(super) struct Conditions<'a> {
    pub(super) bound: Bound<'a>,
    /// ρ of every component, in Pa/m³; 0 where the row of S vanishes; then in Pa/N those of the balance of a body that floats,
    /// `[n_unknowns]`.
    pub(super) steplengths: Vec<f64>,
    pub(super) layout: MultiplierLayout,
    /// 𝓕⁻¹ where it does not follow the slip, `[n_friction_panes]`.
    pub(super) constant_inverse: Option<Vec<[f64; 2]>>,
    /// σ where the unknowns are those with contact springs.
    pub(super) contact_springs: Option<Arc<Vec<f64>>>,
}

/// What a pane of the contact face does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zone {
    /// λ_ν = 0 but for rounding, and λ_t = 0 too unless the slip bound is given apart from the pressure.
    Open,
    /// In contact, the trial stress inside its ellipse: no slip.
    Stick,
    /// In contact and free to slide: the trial stress outside its ellipse, or no friction.
    Slip,
}

/// The natural map at some λ with what its derivative needs.
pub struct Evaluation {
    /// R in Pa, `[n_unknowns]`.
    pub(super) residual: Vec<f64>,
    /// ‖R‖.
    pub norm: f64,
    /// What each pane does.
    pub panes: Vec<PaneEvaluation>,
    /// ∂(1/F_k)/∂φ_l at the contact nodes, in 1/m; empty when F does not follow the slip or is
    /// frozen.
    pub(super) inverse_slope: Vec<[[f64; 2]; 2]>,
    /// ∂φ/∂u_t; `None` where `inverse_slope` is empty.
    pub(crate) slip_derivative: Option<Vec<[f64; 2]>>,
}

/// One pane of an [`Evaluation`].
pub struct PaneEvaluation {
    /// z_ν.
    pub(super) normal_trial: f64,
    /// z_ν > 0.
    pub(super) pressed: bool,
    /// dg/dz_ν where pressed; 0 when frozen.
    pub(super) bound_slope: f64,
    /// A point without friction.
    pub(super) ellipse: Ellipse,
    /// z_t.
    pub(super) trial: [f64; 2],
    /// Diagonal of 𝓕⁻¹; unused when frozen.
    pub(super) inverse: [f64; 2],
}

impl Evaluation {
    /// ‖R‖ beside a size of λ, and 0 for 0/0.
    pub(super) fn relative_to(&self, size: f64) -> f64 {
        ratio(self.norm, size)
    }
}

impl PaneEvaluation {
    /// The zone that z tells.
    #[must_use]
    pub fn zone(&self) -> Zone {
        if !self.pressed {
            Zone::Open
        } else if self.ellipse.semi_axes != [0.0; 2] && self.ellipse.level(self.trial) <= 1.0 {
            Zone::Stick
        } else {
            Zone::Slip
        }
    }
}

impl<'a> Conditions<'a> {
    pub(super) fn new(bound: Bound<'a>, layout: MultiplierLayout, steplengths: Vec<f64>) -> Self {
        let constant_inverse = match bound {
            Bound::Coulomb(laws, law) if !law.depends_on_slip() => {
                Some(FrictionField::new(law, &laws.average, &[]).pane_inverse)
            }
            Bound::Coulomb(..) | Bound::Given(_) => None,
        };
        Self {
            bound,
            steplengths,
            layout,
            constant_inverse,
            contact_springs: None,
        }
    }

    /// Whether the ellipses move with the slip.
    pub(super) fn follows_slip(&self) -> bool {
        matches!(self.bound, Bound::Coulomb(..)) && self.constant_inverse.is_none()
    }

    /// R and what its derivative needs at λ in Pa with r in m³ and the signed (u_t1, u_t2) of the
    /// contact nodes in m, which only a law that follows the slip reads.
    pub(super) fn evaluate(
        &self,
        unknowns: &[f64],
        gradient: &[f64],
        displacement: &[[f64; 2]],
    ) -> Evaluation {
        let trial = self.trial(unknowns, gradient);
        let (inverse, inverse_slope) = self.friction(displacement);
        let slip_derivative = self.slip_derivative(displacement);
        let panes = (0..self.layout.n_panes()).map(|i| self.pane(i, &trial, inverse.get(i)));
        let panes: Vec<PaneEvaluation> = panes.collect();
        let mut residual = self.stresses(unknowns, gradient);
        self.equilibrium_rows(gradient, &mut residual);
        for (i, pane) in panes.iter().enumerate() {
            residual[i] -= pane.normal_trial.max(0.0);
            let projected = pane.ellipse.project(pane.trial);
            let pair = self.layout.tangential(i).into_iter().flatten();
            pair.zip(projected).for_each(|(j, p)| residual[j] -= p);
        }
        Evaluation {
            norm: if residual.iter().all(|r| r.is_finite()) {
                norm(&residual)
            } else {
                f64::NAN
            },
            residual,
            panes,
            inverse_slope,
            slip_derivative,
        }
    }

    /// λ, beside the rigid motions, or its change.
    fn stresses(&self, unknowns: &[f64], gradient: &[f64]) -> Vec<f64> {
        match &self.contact_springs {
            None => unknowns.to_vec(),
            Some(springs) => stresses_between(unknowns, springs, gradient),
        }
    }

    /// z = λ − ρ r, or its change; μ − ρ r with contact springs, whose σ are part of ρ.
    fn trial(&self, unknowns: &[f64], gradient: &[f64]) -> Vec<f64> {
        let trial = |i: usize| match self.steplengths[i] {
            0.0 => 0.0,
            rho => unknowns[i] - rho * gradient[i],
        };
        (0..unknowns.len()).map(trial).collect()
    }

    /// Pane i at z, with its 𝓕⁻¹ where friction is Coulomb's.
    fn pane(&self, i: usize, trial: &[f64], inverse: Option<&[f64; 2]>) -> PaneEvaluation {
        let pressure = trial[i].max(0.0);
        let (ellipse, bound_slope) = match (self.bound, inverse) {
            (Bound::Coulomb(_, law), Some(inverse)) => {
                let slip_bound = law.slip_bound(i, pressure);
                let semi_axes = inverse.map(|f| slip_bound / f);
                (Ellipse { semi_axes }, law.slip_bound_slope(i, pressure))
            }
            (Bound::Coulomb(..), None) => (Ellipse::POINT, 0.0),
            (Bound::Given(set), _) => {
                let ellipse = set.ellipses.get(i).copied();
                (ellipse.unwrap_or(Ellipse::POINT), 0.0)
            }
        };
        PaneEvaluation {
            normal_trial: trial[i],
            pressed: trial[i] > 0.0,
            bound_slope,
            ellipse,
            trial: self.layout.pair(trial, i),
            inverse: inverse.copied().unwrap_or([1.0; 2]),
        }
    }

    /// R'(x) v for a direction v of the unknowns, with the changes along v of r in m³, of the equilibrium's residual in N where there are
    /// rigid motions, and of (u_t1, u_t2) at the contact nodes in m; one-sided at kinks.
    pub(super) fn derivative(
        &self,
        at: &Evaluation,
        direction: &[f64],
        gradient: &[f64],
        displacement: &[[f64; 2]],
    ) -> Vec<f64> {
        let trial = self.trial(direction, gradient);
        let slips = at.slip_derivative.as_ref();
        let slips = slips.map_or_else(Vec::new, |by| {
            change_of_slips(by, |node| displacement[node])
        });
        let mut change = self.stresses(direction, gradient);
        self.equilibrium_rows(gradient, &mut change);
        for (i, pane) in at.panes.iter().enumerate() {
            let pressure = if pane.pressed { trial[i] } else { 0.0 };
            change[i] -= pressure;
            let Some([first, second]) = self.layout.tangential(i) else {
                continue;
            };
            let axes = self.axes_change(at, i, pane.bound_slope * pressure, &slips);
            let derivative = pane.ellipse.projection_derivative(pane.trial);
            for k in 0..2 {
                let by_point = derivative.by_point[k];
                let by_axes = derivative.by_semi_axes[k];
                change[first + k] -= by_point[0] * trial[first]
                    + by_point[1] * trial[second]
                    + by_axes[0] * axes[0]
                    + by_axes[1] * axes[1];
            }
        }
        change
    }

    /// (∂R/∂h)ᵀy, `[n_multipliers]`, and (∂R/∂u_t)ᵀy at the contact nodes, empty where nothing follows the slip, for weights y of the
    /// rows: the transpose of [`Self::derivative`] by −r and by (u_t1, u_t2).
    pub(super) fn transposed(&self, at: &Evaluation, weights: &[f64]) -> (Vec<f64>, Vec<[f64; 2]>) {
        let mut by_rhs = vec![0.0; self.layout.n_multipliers()];
        let n_nodes = match self.bound {
            Bound::Coulomb(laws, _) if !at.inverse_slope.is_empty() => laws.average.rows,
            Bound::Coulomb(..) | Bound::Given(_) => 0,
        };
        let mut by_slip = vec![[0.0; 2]; n_nodes];
        for (i, pane) in at.panes.iter().enumerate() {
            if pane.pressed {
                by_rhs[i] = -weights[i];
            }
            let Some(pair) = self.layout.tangential(i) else {
                continue;
            };
            let derivative = pane.ellipse.projection_derivative(pane.trial);
            let y = pair.map(|j| weights[j]);
            let weighted =
                |by: &[[f64; 2]; 2], k: usize| -> f64 { y[0] * by[0][k] + y[1] * by[1][k] };
            for (k, j) in pair.into_iter().enumerate() {
                by_rhs[j] = -weighted(&derivative.by_point, k);
            }
            let Bound::Coulomb(laws, _) = self.bound else {
                continue;
            };
            let by_axes = [0, 1].map(|k| weighted(&derivative.by_semi_axes, k) / pane.inverse[k]);
            if pane.pressed {
                by_rhs[i] -= pane.bound_slope * (by_axes[0] + by_axes[1]);
            }
            let axes = pane.ellipse.semi_axes;
            for (node, weight) in laws.average.entries(i) {
                let Some(slope) = at.inverse_slope.get(node) else {
                    continue;
                };
                for l in 0..2 {
                    let change =
                        by_axes[0] * axes[0] * slope[0][l] + by_axes[1] * axes[1] * slope[1][l];
                    by_slip[node][l] += weight * change;
                }
            }
        }
        for (by, rho) in by_rhs.iter_mut().zip(&self.steplengths) {
            *by *= rho;
        }
        // λ = μ − σ r.
        let springs = self.contact_springs.iter().flat_map(|springs| &***springs);
        let parts = by_rhs.iter_mut().zip(springs.zip(weights));
        parts.for_each(|(by, (spring, weight))| *by += spring * weight);
        let slips = at.slip_derivative.as_ref();
        (
            by_rhs,
            slips.map_or_else(Vec::new, |by| change_of_slips(by, |node| by_slip[node])),
        )
    }

    /// The rows ρ r of unknowns that nothing bounds, the rigid motions.
    fn equilibrium_rows(&self, gradient: &[f64], rows: &mut [f64]) {
        for j in self.layout.n_multipliers()..rows.len() {
            rows[j] = self.steplengths[j] * gradient[j];
        }
    }

    /// The change of a pane's semi-axes g / 𝓕⁻¹ with that of g and of the slip at its nodes.
    fn axes_change(
        &self,
        at: &Evaluation,
        pane: usize,
        bound: f64,
        slips: &[[f64; 2]],
    ) -> [f64; 2] {
        if matches!(self.bound, Bound::Given(_)) {
            return [0.0; 2];
        }
        let here = &at.panes[pane];
        let inverse_change = self.inverse_change(at, pane, slips);
        [0, 1].map(|k| {
            let f = here.inverse[k];
            bound / f - here.ellipse.semi_axes[k] / f * inverse_change[k]
        })
    }

    /// The change Σ w ∂(1/F)/∂φ δφ of a pane's 𝓕⁻¹ with that of the slip at its nodes.
    pub(super) fn inverse_change(
        &self,
        at: &Evaluation,
        pane: usize,
        slips: &[[f64; 2]],
    ) -> [f64; 2] {
        let Bound::Coulomb(laws, _) = self.bound else {
            return [0.0; 2];
        };
        [0, 1].map(|k| {
            let nodes = laws.average.entries(pane);
            let slopes = nodes.filter_map(|(node, weight)| {
                let slope = at.inverse_slope.get(node)?[k];
                let slip = slips[node];
                Some(weight * (slope[0] * slip[0] + slope[1] * slip[1]))
            });
            slopes.sum()
        })
    }

    /// ∂φ/∂u_t where the ellipses move with the slip.
    fn slip_derivative(&self, displacement: &[[f64; 2]]) -> Option<Vec<[f64; 2]>> {
        match self.bound {
            Bound::Coulomb(laws, _) if self.follows_slip() => {
                Some(slip_signs(laws.previous.as_ref(), displacement))
            }
            Bound::Coulomb(..) | Bound::Given(_) => None,
        }
    }

    /// 𝓕⁻¹ on the panes and ∂(1/F)/∂φ at the nodes.
    pub(super) fn friction(
        &self,
        displacement: &[[f64; 2]],
    ) -> (Vec<[f64; 2]>, Vec<[[f64; 2]; 2]>) {
        let Bound::Coulomb(laws, law) = self.bound else {
            return (Vec::new(), Vec::new());
        };
        let Some(constant) = &self.constant_inverse else {
            let slip = slips(laws.previous.as_ref(), displacement);
            let field = FrictionField::new(law, &laws.average, &slip);
            let slopes = (0..law.n_nodes())
                .map(|node| {
                    let derivative = law.derivative(node, slip[node]);
                    [0, 1].map(|k| {
                        let square = field.nodal[node][k].powi(2);
                        [0, 1].map(|l| -derivative[k][l] / square)
                    })
                })
                .collect();
            return (field.pane_inverse, slopes);
        };
        (constant.clone(), Vec::new())
    }
}
