//! Points of paths: what is stored of them.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    corrector::PathState,
    equations::PieceEquations,
    family::ParameterRange,
    kink::HalfPath,
    path::{FIRST_STEP, PathFront},
    piece::{NodePiece, Piece, Switch},
};
use contact3d::{
    AssembledProblem, ProblemError,
    contact::{CoulombLaw, Interface},
    dual::{ExplicitDual, LocalStiffness},
    linalg::{difference, dot, norm},
    mesh::ContactSurface,
    post::Zone,
    solver::{Bound, ContactState, NaturalMap},
};

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
            parameter: self.family.range().value(state.parameter().clamp(0.0, 1.0)),
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
        let laws = ContactState { surface, interface }.laws();
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PathOrigin {
    /// The solver's answer at the start of the range.
    Solver,
    /// A solution at one end of the range that was searched for.
    Search,
    /// A branch point.
    BranchPoint,
}

/// How zones are stored.
const LETTERS: [(char, Zone); 3] = [('o', Zone::Open), ('t', Zone::Stick), ('l', Zone::Slip)];

/// A front: where a path stands and how it goes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FrontRecord {
    pub(super) origin: PathOrigin,
    point: Vec<f64>,
    tangent: Vec<f64>,
    orientation: i8,
    step: f64,
    zones: String,
    capped: Vec<bool>,
    nodes: Vec<Option<NodePiece>>,
}

impl FrontRecord {
    pub(super) fn of(origin: PathOrigin, state: &PathState, piece: &Piece, step: f64) -> Self {
        let letter = |zone: &Zone| LETTERS.iter().find(|(_, known)| known == zone);
        Self {
            origin,
            point: state.point.clone(),
            tangent: state.tangent.clone(),
            orientation: state.orientation,
            step,
            zones: piece
                .zones
                .iter()
                .filter_map(letter)
                .map(|it| it.0)
                .collect(),
            capped: piece.capped.clone(),
            nodes: piece.nodes.clone(),
        }
    }

    /// The parameter and λ in Pa.
    pub(super) fn solution(&self, range: &ParameterRange, stress: f64) -> (f64, Vec<f64>) {
        let (s, y) = self.point.split_last().unwrap_or((&0.0, &[]));
        (range.value(*s), y.iter().map(|y| stress * y).collect())
    }

    /// Whether a path that ends in a state came along this front, the other way.
    pub(super) fn arrives(&self, state: &PathState, tolerance: f64) -> bool {
        norm(&difference(&self.point, &state.point)) <= tolerance
            && dot(&self.tangent, &state.tangent) <= -1.0 + tolerance
    }

    /// The front again; `None` where the record does not fit the problem.
    pub(super) fn front(
        &self,
        equations: &PieceEquations<'_>,
    ) -> Result<Option<PathFront>, ProblemError> {
        let zone = |letter: char| LETTERS.iter().find(|(known, _)| *known == letter);
        let zones = self.zones.chars().map(|letter| Some(zone(letter)?.1));
        let Some(zones) = zones.collect() else {
            return Ok(None);
        };
        let piece = Piece {
            zones,
            capped: self.capped.clone(),
            nodes: self.nodes.clone(),
        };
        let n = self.point.len();
        let member = equations.family.member(0.0)?;
        let panes = member.dual.n_panes();
        let fits = n == member.dual.dimension() + 1
            && self.tangent.len() == n
            && piece.zones.len() == panes
            && piece.capped.len() == panes;
        if !fits {
            return Ok(None);
        }
        let Some((member, evaluated)) = equations.at(&piece, &self.point)? else {
            return Ok(None);
        };
        Ok(Some(PathFront {
            state: PathState {
                point: self.point.clone(),
                tangent: self.tangent.clone(),
                orientation: self.orientation,
                steps: 0,
                member,
                evaluated,
            },
            piece,
            step: self.step,
        }))
    }
}

impl HalfPath {
    pub(super) fn record(&self, origin: PathOrigin) -> FrontRecord {
        FrontRecord::of(origin, &self.state, &self.piece, FIRST_STEP)
    }
}
