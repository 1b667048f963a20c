use super::{ContactState, Ellipse, FeasibleSet, vector::norm};
use crate::{contact::FrictionField, dual::ExplicitDual};

/// Where the semi-axes of the ellipses come from.
pub(super) enum Bound<'a> {
    /// Coulomb friction with F(u): (a, b) = g / 𝓕⁻¹(u_t(λ)) with g = max(z_ν, 0).
    Coulomb(&'a ContactState<'a>),
    /// Frozen ellipses, one inner problem of Algorithm 4.1.
    Frozen(&'a FeasibleSet),
}

/// The natural map R(λ) = λ − P(λ − ρ r), r = S λ − h, whose zeros solve the contact problem.
///
/// z = λ − ρ r with ρ = 1/S_ii for normal components and the mean of a pair's two for tangential
/// ones; R_ν = λ_ν − max(z_ν, 0), R_t = λ_t − P_{a,b}(z_t).
pub(super) struct NaturalMap<'a> {
    pub(super) dual: &'a ExplicitDual,
    pub(super) bound: Bound<'a>,
    /// ρ of every component, `[3 n_panes]`, in Pa/m³.
    pub(super) steplengths: Vec<f64>,
}

/// What a pane does at some λ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PaneZone {
    Open,
    Stick,
    Slip,
}

/// The natural map at some λ with what its derivative needs.
pub(super) struct Evaluation {
    /// R in Pa, `[3 n_panes]`.
    pub(super) residual: Vec<f64>,
    /// ‖R‖.
    pub(super) norm: f64,
    pub(super) panes: Vec<PaneEvaluation>,
    /// ∂(1/F_k)/∂u_tk at the contact nodes, in 1/m; empty when F is constant
    /// or frozen.
    pub(super) inverse_slope: Vec<[f64; 2]>,
}

/// One pane of an [`Evaluation`].
pub(super) struct PaneEvaluation {
    /// z_ν > 0.
    pub(super) pressed: bool,
    pub(super) ellipse: Ellipse,
    /// z_t.
    pub(super) trial: [f64; 2],
    /// Diagonal of 𝓕⁻¹; unused when frozen.
    pub(super) inverse: [f64; 2],
}

impl PaneEvaluation {
    pub(super) fn zone(&self) -> PaneZone {
        if !self.pressed {
            PaneZone::Open
        } else if self.ellipse.level(self.trial) <= 1.0 {
            PaneZone::Stick
        } else {
            PaneZone::Slip
        }
    }
}

impl<'a> NaturalMap<'a> {
    pub(super) fn new(dual: &'a ExplicitDual, bound: Bound<'a>) -> Self {
        let m = dual.n_panes();
        let inverse = |value: f64| if value > 0.0 { 1.0 / value } else { 1.0 };
        let diagonal = |j: usize| dual.column(j)[j];
        let normal = (0..m).map(|i| inverse(diagonal(i)));
        let tangential = (0..2 * m).map(|k| {
            let first = m + k / 2 * 2;
            inverse(0.5 * (diagonal(first) + diagonal(first + 1)))
        });
        Self {
            steplengths: normal.chain(tangential).collect(),
            dual,
            bound,
        }
    }

    pub(super) fn evaluate(&self, multiplier: &[f64]) -> Evaluation {
        let m = self.dual.n_panes();
        let gradient = self.dual.apply(multiplier);
        let trial: Vec<f64> = (0..3 * m)
            .map(|i| multiplier[i] - self.steplengths[i] * (gradient[i] - self.dual.rhs[i]))
            .collect();
        let (inverse, inverse_slope) = self.friction(multiplier);
        let mut residual = multiplier.to_vec();
        let mut panes = Vec::with_capacity(m);
        for i in 0..m {
            let slip_bound = trial[i].max(0.0);
            let ellipse = match self.bound {
                Bound::Coulomb(_) => Ellipse {
                    semi_axes: inverse[i].map(|f| slip_bound / f),
                },
                Bound::Frozen(set) => set.ellipses[i],
            };
            let at = m + 2 * i;
            let pair = [trial[at], trial[at + 1]];
            let projected = ellipse.project(pair);
            residual[i] -= slip_bound;
            residual[at] -= projected[0];
            residual[at + 1] -= projected[1];
            panes.push(PaneEvaluation {
                pressed: trial[i] > 0.0,
                ellipse,
                trial: pair,
                inverse: inverse.get(i).copied().unwrap_or([1.0; 2]),
            });
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
        }
    }

    /// 𝓕⁻¹ on the panes and ∂(1/F)/∂u_t at the nodes.
    pub(super) fn friction(&self, multiplier: &[f64]) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
        let Bound::Coulomb(contact) = self.bound else {
            return (Vec::new(), Vec::new());
        };
        let depends = contact.law.depends_on_slip();
        let displacement = if depends {
            self.dual.tangential_displacement(multiplier)
        } else {
            vec![[0.0; 2]; self.dual.slip_free.len()]
        };
        let slip: Vec<[f64; 2]> = displacement.iter().map(|u| u.map(f64::abs)).collect();
        let field = FrictionField::new(contact.law, contact.surface, &slip);
        let mut slopes = Vec::new();
        if depends {
            slopes.extend((0..slip.len()).map(|node| {
                let derivative = contact.law.derivative(slip[node]);
                std::array::from_fn(|k| {
                    let sign = match displacement[node][k] {
                        0.0 => 0.0,
                        u => u.signum(),
                    };
                    -sign * derivative[k] / field.nodal[node][k].powi(2)
                })
            }));
        }
        (field.pane_inverse, slopes)
    }
}
