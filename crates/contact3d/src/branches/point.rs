//! What is known of a point of a path.

use serde::{Deserialize, Serialize};

use super::{
    corrector::PathState,
    equations::Equations,
    piece::{Piece, Switch},
};
use crate::problem::ProblemError;

/// What is special about a point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PointKind {
    /// The first of a path that begins at no special point.
    Start,
    /// Nothing.
    #[default]
    Regular,
    /// A pane or a node of the law changes; the path goes on with the parameter.
    Kink,
    /// The parameter turns back on a smooth piece.
    Fold,
    /// The parameter turns back where a pane or a node changes.
    KinkFold,
    /// More than two half paths meet.
    BranchPoint,
    /// The path ends here.
    End,
}

/// A certified solution on a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathPoint {
    /// The value of the key.
    pub parameter: f64,
    /// λ in Pa, `[n_multipliers]`.
    pub multiplier: Vec<f64>,
    /// What is special about it.
    pub kind: PointKind,
    /// What changes here; at regular points nothing.
    pub switches: Vec<Switch>,
    /// ‖R(λ)‖ / ‖λ‖ of the natural map measured by local stiffness.
    pub residual: f64,
    /// The sign of det R', on the side the path comes from; 0 at folds.
    pub determinant: i8,
    /// ρ(Ψ'), on the side the path comes from; NaN where the frozen problem is singular.
    pub spectral_radius: f64,
    /// Open, sticking and slipping panes, on the side the path comes from.
    pub zones: [usize; 3],
    /// Σ |Rⁱ| λ_ν in N.
    pub normal_force: f64,
    /// Σ |Rⁱ| λ_t in N.
    pub tangential_force: [f64; 2],
    /// max λ_ν in Pa.
    pub largest_pressure: f64,
}

impl PathPoint {
    /// Whether successive approximations converge to it from nearby.
    #[must_use]
    pub fn is_attracting(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

impl Equations<'_> {
    /// Certifies a point and describes it.
    pub(super) fn describe(
        &self,
        piece: &Piece,
        state: &PathState,
        kind: PointKind,
        switches: Vec<Switch>,
    ) -> Result<PathPoint, ProblemError> {
        let multiplier = self.multiplier(&state.point);
        let surface = state.member.surface();
        let (normal, tangential) = state.member.dual.layout.split(&multiplier);
        let areas = || surface.pane_area.iter();
        let sum = |stresses: &mut dyn Iterator<Item = f64>| -> f64 {
            areas()
                .zip(stresses)
                .map(|(area, stress)| area * stress)
                .sum()
        };
        Ok(PathPoint {
            parameter: self.family.range().value(state.parameter().clamp(0.0, 1.0)),
            residual: self.natural_residual(&state.point)?,
            determinant: match kind {
                PointKind::Fold => 0,
                _ => state.determinant(),
            },
            spectral_radius: self.spectral_radius(piece, state).unwrap_or(f64::NAN),
            zones: piece.counts(),
            normal_force: sum(&mut normal.iter().copied()),
            tangential_force: [0, 1].map(|k| sum(&mut tangential.iter().map(|pair| pair[k]))),
            largest_pressure: normal.iter().copied().fold(0.0, f64::max),
            multiplier,
            kind,
            switches,
        })
    }
}
