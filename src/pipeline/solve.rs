//! The stage `solve`: multipliers and displacement.

use std::{path::Path, sync::Arc};

use contact3d::{
    contact::{Coupling, Interface},
    dual::{DualSystem, PrimalSystem},
    mesh::ContactSurface,
    scene::{Friction, Parameters, Scene, SlipInterpolation, SolveSettings},
    solver::{OuterState, Progress, Solution, Start, solve},
};
use runfile::{GroupWriter, Reader, StoreError};
use serde::Serialize;

use super::{
    Freshness, StageError, load,
    mesh::{self, Meshed, only_contact, several_contacts},
    states,
};
use crate::format::{self, FormatError, LAYOUT, Stage};

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) settings: &'a SolveSettings,
    pub(super) meshed: &'a Meshed,
    /// The assembled problem with the loads of the scene.
    pub(super) problem: Arc<DualSystem>,
    pub(super) start: &'a StartFrom,
    /// Where a killed solve of the same problem was.
    pub(super) checkpoint: Option<&'a OuterState>,
}

/// The multipliers that a solve starts from.
#[derive(Debug)]
pub(super) enum StartFrom {
    /// λ = 0; a stored solve stays fresh, whatever it started from.
    Any,
    /// λ = 0, and nothing else.
    Zero,
    /// Those of a similar problem, `[n_multipliers]` in Pa.
    Given {
        multiplier: Vec<f64>,
        digest: String,
    },
}

/// The equations that an answer belongs to.
#[derive(Debug)]
pub(super) enum Equations {
    /// The whole assembled problem.
    CachedProblem(Arc<DualSystem>),
    /// A, l and B, read without the factor.
    Primal(PrimalSystem, Option<Coupling>),
}

/// What the solver found.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) equations: Equations,
    pub(super) solution: Solution,
}

/// Solves the contact problem; `observe` sees every step. A solve that does not converge is an
/// answer with a status.
///
/// # Errors
/// A method that needs the dense dual operator where there is none.
pub(super) fn run(
    inputs: Inputs<'_>,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Result<Answer, StageError> {
    let solution = solve(
        &inputs.problem,
        inputs.meshed.contact().as_ref(),
        inputs.settings,
        Start {
            multiplier: inputs.start.multiplier(),
            checkpoint: inputs.checkpoint,
        },
        observe,
    )?;
    Ok(Answer {
        equations: Equations::CachedProblem(inputs.problem),
        solution,
    })
}

/// Reads the answer to equations back.
///
/// # Errors
/// Missing or altered datasets.
pub(super) fn read(reader: &Reader, equations: Equations) -> Result<Answer, FormatError> {
    let solution = format::read_solution(reader, &equations.primal().dofs)?;
    Ok(Answer {
        equations,
        solution,
    })
}

/// Writes the answer; that of a load history belongs to increments with some digest.
pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    meshed: &Meshed,
    answer: &Answer,
    history_digest: Option<&str>,
) -> Result<(), StoreError> {
    let surface = meshed.mesh.contact.as_ref();
    let n_panes = surface.map_or(0, |surface| surface.n_panes());
    let dofs = &answer.equations.primal().dofs;
    format::write_solution(writer, &answer.solution, n_panes, dofs, history_digest)
}

/// The part of a scene that the stage depends on directly.
#[derive(Serialize)]
pub(super) struct Settings<'a> {
    /// Digest of the multipliers the solve started from; none for λ = 0.
    start: Option<&'a str>,
    friction: Option<&'a Friction>,
    /// The laws of several contact faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frictions: Vec<FaceFriction<'a>>,
    /// None for the default.
    #[serde(skip_serializing_if = "Option::is_none")]
    slip_interpolation: Option<SlipInterpolation>,
    solve: &'a SolveSettings,
    /// All loads of a load history, of which `/load` holds the last ones only.
    #[serde(skip_serializing_if = "Option::is_none")]
    history: Option<load::Settings<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

impl<'a> Settings<'a> {
    pub(super) fn of(scene: &'a Scene, start: Option<&'a str>) -> Self {
        Self {
            start,
            friction: only_friction(scene),
            frictions: several_frictions(scene),
            slip_interpolation: scene
                .contacts
                .first()
                .map(|contact| contact.slip_interpolation)
                .filter(|kind| *kind != SlipInterpolation::default()),
            solve: &scene.solve,
            history: scene.has_history().then(|| load::Settings::of(scene)),
            parameters: scene.parameters_used(of_friction),
        }
    }
}

/// The law of the only contact face; `None` where there are several.
pub(super) fn only_friction(scene: &Scene) -> Option<&Friction> {
    only_contact(scene)?;
    scene.friction_on(0).map(|(_, friction)| friction)
}

/// The law of one of several contact faces; an empty table without friction, since TOML has no null.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum FaceFriction<'a> {
    Law(&'a Friction),
    Frictionless {},
}

/// The laws of several contact faces, in the order of their multipliers; none for one.
pub(super) fn several_frictions(scene: &Scene) -> Vec<FaceFriction<'_>> {
    let law = |entry| match scene.friction_on(entry) {
        Some((_, friction)) => FaceFriction::Law(friction),
        None => FaceFriction::Frictionless {},
    };
    several_contacts(scene)
        .map(|(entry, _)| law(entry))
        .collect()
}

/// Whether a key is part of a law of friction.
pub(super) fn of_friction(key: &str) -> bool {
    key.starts_with("friction.") || key.starts_with("contact.") && key.contains(".friction.")
}

impl StartFrom {
    /// From these multipliers, or from λ = 0 if there are none.
    pub(super) fn multipliers(multiplier: Vec<f64>) -> Self {
        if multiplier.is_empty() {
            return Self::Zero;
        }
        let bytes: Vec<u8> = multiplier.iter().flat_map(|v| v.to_le_bytes()).collect();
        Self::Given {
            multiplier,
            digest: blake3::hash(&bytes).to_hex().to_string(),
        }
    }

    pub(super) fn multiplier(&self) -> Option<&[f64]> {
        match self {
            Self::Any | Self::Zero => None,
            Self::Given { multiplier, .. } => Some(multiplier),
        }
    }

    /// The digest of the multipliers; `None` for λ = 0.
    pub(super) fn digest(&self) -> Option<&str> {
        match self {
            Self::Any | Self::Zero => None,
            Self::Given { digest, .. } => Some(digest),
        }
    }
}

impl Equations {
    /// Reads A, l and B without the factor.
    ///
    /// # Errors
    /// Missing or altered datasets.
    pub(super) fn read(reader: &Reader) -> Result<Self, FormatError> {
        let coupling = format::read_coupling(reader)?;
        Ok(Self::Primal(format::read_primal(reader)?, coupling))
    }

    /// A, l and B by themselves.
    pub(super) fn into_primal(self) -> (PrimalSystem, Option<Coupling>) {
        match self {
            Self::Primal(primal, coupling) => (primal, coupling),
            Self::CachedProblem(system) => {
                let coupling = system
                    .contact
                    .as_ref()
                    .map(|contact| contact.coupling.clone());
                (system.assembly.primal.clone(), coupling)
            }
        }
    }

    /// A and l.
    pub(super) fn primal(&self) -> &PrimalSystem {
        match self {
            Self::CachedProblem(system) => &system.assembly.primal,
            Self::Primal(primal, _) => primal,
        }
    }

    /// B; `None` without contact.
    pub(super) fn coupling(&self) -> Option<&Coupling> {
        match self {
            Self::CachedProblem(system) => system.contact.as_ref().map(|contact| &contact.coupling),
            Self::Primal(_, coupling) => coupling.as_ref(),
        }
    }
}

/// A solved problem with its equations.
#[derive(Debug)]
pub struct Solved {
    /// The scene.
    pub scene: Scene,
    /// A, its factor, B, h and perhaps S.
    pub system: Arc<DualSystem>,
    /// What the solver found.
    pub solution: Solution,
    meshed: Meshed,
}

impl Solved {
    /// The contact face and its laws; `None` without contact.
    #[must_use]
    pub fn contact(&self) -> Option<(&ContactSurface, &Interface)> {
        let surface = self.meshed.mesh.contact.as_ref()?;
        Some((surface, self.meshed.interface.as_ref()?))
    }
}

/// Reads a run file whose stages up to `solve` are fresh.
///
/// # Errors
/// A stage that is missing, stale or damaged, unreadable datasets.
pub fn read_solved(path: &Path) -> Result<Solved, StageError> {
    let reader = Reader::open(path, LAYOUT)?;
    let input = format::read_scene(&reader, path)?;
    let states = states(&reader, &input.scene);
    let mut needed = states
        .into_iter()
        .filter(|state| state.stage <= Stage::Solve);
    if let Some(state) = needed.find(|state| state.freshness != Freshness::Fresh) {
        return Err(StageError::Unfit {
            file: path.to_owned(),
            reason: format!(
                "`export` needs a solved file, but `{}` cannot be used, {}; run `contact3d-pipe run` first",
                state.stage.word(),
                state.freshness.why()
            ),
        });
    }
    let meshed = mesh::read(&reader, &input)?;
    let operator = Arc::new(format::read_assembly(&reader)?);
    let system = Arc::new(load::read(&reader, operator)?);
    let answer = read(&reader, Equations::CachedProblem(system.clone()))?;
    Ok(Solved {
        scene: input.scene,
        system,
        solution: answer.solution,
        meshed,
    })
}
