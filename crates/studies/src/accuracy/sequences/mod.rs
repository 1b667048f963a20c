//! Sequences of meshes: what linear and quadratic elements on uniform, graded and adaptive meshes reach, and for which time.
//!
//! Each sequence has ever finer meshes of one body, solved to rounding. Their true errors are the distances to
//! a reference, the last quadratic adaptive sequence carried on until its own estimated error is a quarter of the smallest
//! one to be judged (half of it where time or memory end first). That estimate is the uncertainty of all of them. Where
//! no adaptive mesh is solved, the reference is the mesh with the smallest estimated error of any sequence.

mod level;
mod refining;

pub use level::SequenceLevel;
pub use level::{Cheapest, SequenceAdvice, TARGETS};

use std::path::Path;

use super::{Field, Forces, Points, distance};
use contact3d::{
    ProblemError,
    scene::{ElementOrder, Invalid, Scene},
    solver::Status,
};

use level::SolvedMesh;
use refining::{Meshes, SequenceRun};

/// The reference is to have this share of the smallest error that it judges.
const WANTED_SHARE: f64 = 0.25;

/// Errors of which the reference has a larger share are not judged.
const LARGEST_SHARE: f64 = 0.5;

/// The reference may take this many times the seconds that a sequence may.
const REFERENCE_BUDGET: f64 = 4.0;

/// A kind of sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SequenceKind {
    /// Linear tetrahedra on uniform meshes.
    LinearUniform,
    /// Quadratic tetrahedra on uniform meshes.
    QuadraticUniform,
    /// Linear tetrahedra on meshes that follow the estimated error.
    LinearAdaptive,
    /// Quadratic tetrahedra on cells that shrink towards the faces on which something is prescribed.
    QuadraticGraded,
    /// Quadratic tetrahedra on meshes that follow the estimated error.
    QuadraticAdaptive,
    /// The same from graded cells on.
    QuadraticGradedAdaptive,
}

impl SequenceKind {
    /// All kinds; the last one that the body has leads to the reference.
    pub const ALL: [Self; 6] = [
        Self::LinearUniform,
        Self::QuadraticUniform,
        Self::LinearAdaptive,
        Self::QuadraticGraded,
        Self::QuadraticAdaptive,
        Self::QuadraticGradedAdaptive,
    ];

    /// The kind in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::LinearUniform => "P1 uniform",
            Self::QuadraticUniform => "P2 uniform",
            Self::LinearAdaptive => "P1 adaptive",
            Self::QuadraticGraded => "P2 graded",
            Self::QuadraticAdaptive => "P2 adaptive",
            Self::QuadraticGradedAdaptive => "P2 graded, adaptive",
        }
    }

    /// The element.
    #[must_use]
    pub fn element(self) -> ElementOrder {
        match self {
            Self::LinearUniform | Self::LinearAdaptive => ElementOrder::P1,
            Self::QuadraticUniform
            | Self::QuadraticGraded
            | Self::QuadraticAdaptive
            | Self::QuadraticGradedAdaptive => ElementOrder::P2,
        }
    }

    fn is_adaptive(self) -> bool {
        match self {
            Self::LinearUniform | Self::QuadraticUniform | Self::QuadraticGraded => false,
            Self::LinearAdaptive | Self::QuadraticAdaptive | Self::QuadraticGradedAdaptive => true,
        }
    }

    fn is_graded(self) -> bool {
        match self {
            Self::LinearUniform
            | Self::QuadraticUniform
            | Self::LinearAdaptive
            | Self::QuadraticAdaptive => false,
            Self::QuadraticGraded | Self::QuadraticGradedAdaptive => true,
        }
    }
}

/// How far the sequences go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SequenceSettings {
    /// Seconds for each sequence; finer meshes are left out. The reference may take four times as many.
    pub budget: f64,
    /// A sequence ends where its estimated relative error is below this.
    pub goal: f64,
    /// Smallest n_div of the meshes of a brick.
    pub coarsest: usize,
    /// Bytes that a mesh may take, estimated from the one before; no limit when not given.
    pub memory: Option<f64>,
}

/// What an observer of the sequences sees before each piece of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SequenceProgress {
    /// A mesh is solved, the n-th of its sequence.
    Level(SequenceKind, usize),
    /// A further mesh of the reference is solved, the n-th of its sequence.
    Reference(usize),
    /// The solutions of all sequences are compared with the reference.
    Comparison,
}

/// One sequence, coarse to fine.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSequence {
    /// Which one.
    pub kind: SequenceKind,
    /// Its meshes; empty where the body has none of this kind, as a file of second-order tetrahedra has no linear ones.
    pub levels: Vec<SequenceLevel>,
}

/// What all others are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The sequence that it is the last mesh of.
    pub kind: SequenceKind,
    /// Its mesh and its own estimated error, the uncertainty of all true errors.
    pub level: SequenceLevel,
    /// J = ½ uᵀAu − lᵀu in J.
    pub potential_energy: f64,
    /// The foundation's forces; `None` without contact.
    pub forces: Option<Forces>,
}

/// All sequences of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSequences {
    /// In the order of [`SequenceKind::ALL`].
    pub sequences: Vec<MeshSequence>,
    /// What their true errors refer to.
    pub reference: Reference,
}

impl MeshSequences {
    /// Solves all sequences; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem.
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        settings: &SequenceSettings,
        observe: &mut dyn FnMut(SequenceProgress),
    ) -> Result<Self, ProblemError> {
        let mut runs = Vec::new();
        for kind in SequenceKind::ALL {
            let meshes = Meshes::of(kind, scene, folder, settings)?;
            let mut run = SequenceRun::new(kind, meshes, folder);
            run.go(settings.budget, settings.goal, settings.memory, &mut |n| {
                observe(SequenceProgress::Level(kind, n));
            })?;
            runs.push(run);
        }
        let smallest = solved_levels(&runs).fold(f64::INFINITY, |least, level| {
            least.min(level.estimated_error)
        });
        let mut finest_first = runs.iter_mut().rev();
        let last = finest_first
            .find(|run| !run.levels().is_empty())
            .expect("every body has quadratic meshes");
        let (carried_on, n_judged) = (last.kind(), last.levels().len());
        last.go(
            REFERENCE_BUDGET * settings.budget,
            WANTED_SHARE * smallest,
            settings.memory,
            &mut |n| observe(SequenceProgress::Reference(n)),
        )?;
        observe(SequenceProgress::Comparison);
        let meshes = runs
            .iter()
            .flat_map(|run| run.levels().iter().map(|mesh| (run.kind(), mesh)));
        let (kind, reference) = meshes
            .min_by(|(_, a), (_, b)| a.rank().total_cmp(&b.rank()))
            .expect("the first mesh of the last sequence is always solved");
        let sequences = runs.iter().map(|run| {
            Ok(MeshSequence {
                kind: run.kind(),
                levels: judged(run.levels(), reference, scene)?,
            })
        });
        let mut sequences: Vec<MeshSequence> = sequences.collect::<Result<_, Invalid>>()?;
        for sequence in sequences
            .iter_mut()
            .filter(|sequence| sequence.kind == carried_on)
        {
            sequence.levels.truncate(n_judged);
        }
        Ok(Self {
            reference: reference.to_reference(kind),
            sequences,
        })
    }

    /// The cheapest sequence for each of the targets.
    #[must_use]
    pub fn advice(&self) -> SequenceAdvice {
        SequenceAdvice::new(&self.sequences)
    }
}

fn solved_levels<'a>(runs: &'a [SequenceRun<'_>]) -> impl Iterator<Item = &'a SequenceLevel> {
    let levels = runs.iter().flat_map(SequenceRun::levels);
    levels
        .map(|mesh| &mesh.level)
        .filter(|level| level.status.is_solved())
}

/// The levels with their true errors, where the reference is good enough to tell.
fn judged(
    solved: &[SolvedMesh],
    reference: &SolvedMesh,
    scene: &Scene,
) -> Result<Vec<SequenceLevel>, Invalid> {
    let uncertainty = reference.level.estimated_error;
    let error = |mesh: &SolvedMesh| -> Result<Option<f64>, Invalid> {
        let is_judged = reference.level.status.is_solved()
            && mesh.level.status.is_solved()
            && uncertainty <= LARGEST_SHARE * mesh.level.estimated_error;
        if !is_judged {
            return Ok(None);
        }
        let found = distance(mesh.field(), reference.field(), scene, Points::default())?;
        Ok(Some(found.relative()))
    };
    let levels = solved.iter().map(|mesh| {
        Ok(SequenceLevel {
            error: error(mesh)?,
            ..mesh.level.clone()
        })
    });
    levels.collect()
}

#[cfg(test)]
mod tests;
