//! Points of paths: what is stored of them.

use std::sync::Arc;

use super::{
    corrector::PathState,
    equations::PieceEquations,
    piece::{Piece, Switch},
};
use contact3d::{
    AssembledProblem, ProblemError,
    contact::{CoulombLaw, Interface},
    dual::{ExplicitDual, LocalStiffness},
    mesh::ContactSurface,
    solver::{Bound, ContactSide, NaturalMap},
};

units::worded! {
    /// What is special about a point.
    #[derive(Default)]
    pub enum PointKind {
        /// The first of a path that begins at no special point.
        Start = "start",
        /// Nothing.
        #[default]
        Regular = "regular",
        /// A pane or a node of the law changes; the path goes on with the parameter.
        Kink = "kink",
        /// The parameter turns back on a smooth piece.
        Fold = "fold",
        /// The parameter turns back where a pane or a node changes.
        KinkFold = "fold at a kink",
        /// More than two half paths meet.
        BranchPoint = "branch point",
        /// The path ends here.
        End = "end",
    }
}

/// A certified solution on a path.
#[derive(Debug, Clone, Default, PartialEq)]
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

impl PieceEquations<'_> {
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
        let sum = |stress: &dyn Fn(usize) -> f64| -> f64 {
            let areas = surface.pane_area.iter().enumerate();
            areas.map(|(pane, area)| area * stress(pane)).sum()
        };
        Ok(PathPoint {
            parameter: self.family.range.value(state.parameter().clamp(0.0, 1.0)),
            residual: self.natural_residual(&state.point)?,
            determinant: match kind {
                PointKind::Fold => 0,
                _ => state.determinant(),
            },
            spectral_radius: self.spectral_radius(piece, state).unwrap_or(f64::NAN),
            zones: piece.counts(),
            normal_force: sum(&|pane| normal[pane]),
            tangential_force: [0, 1].map(|k| sum(&|pane| tangential[pane][k])),
            largest_pressure: normal.iter().copied().fold(0.0, f64::max),
            multiplier,
            kind,
            switches,
        })
    }
}

/// A contact problem at one value of the parameter.
pub(super) struct FamilyMember {
    pub(super) base: Arc<AssembledProblem>,
    pub(super) interface: Arc<Interface>,
    /// S, h and the compliance of the contact nodes.
    pub(super) dual: ExplicitDual,
    /// ρ: the stiffness of each pane while the others do not move, `[n_multipliers]`, in Pa/m³.
    pub(super) local: Arc<LocalStiffness>,
}

impl FamilyMember {
    pub(super) fn surface(&self) -> &ContactSurface {
        let surface = self.base.mesh().contact.as_ref();
        surface.expect("a family has contact")
    }

    pub(super) fn law(&self) -> &CoulombLaw {
        self.interface
            .coulomb()
            .expect("a family has Coulomb friction")
    }

    /// Uses the natural map R, measured by local stiffness as the solvers do; it knows nothing of pieces.
    pub(super) fn natural_map<T>(&self, work: impl FnOnce(&NaturalMap<'_>) -> T) -> T {
        let (surface, interface) = (self.surface(), &*self.interface);
        let laws = ContactSide { surface, interface }.laws();
        let bound = Bound::Coulomb(&laws, self.law());
        let steplengths = self.steplengths().to_vec();
        work(&NaturalMap::with_steplengths(
            &self.dual,
            bound,
            steplengths,
        ))
    }

    pub(super) fn steplengths(&self) -> &[f64] {
        &self.local.stiffness
    }
}

/// Where a path begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathOrigin {
    /// The solver's answer at the start of the range.
    Solver,
    /// A solution at one end of the range that was searched for.
    Search,
    /// A branch point.
    BranchPoint,
}
