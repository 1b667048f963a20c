//! Sequences of meshes: what linear and quadratic elements on uniform, graded and adaptive meshes reach, and for which time.
//!
//! Each sequence has ever finer meshes of one body, solved to rounding. Their true errors are the distances to
//! a reference, the last quadratic adaptive sequence carried on until its own estimated error is a quarter of the smallest
//! one to be judged (half of it where time or memory end first). That estimate is the uncertainty of all of them. Where
//! no adaptive mesh is solved, the reference is the mesh with the smallest estimated error of any sequence.

mod refining;

use std::{fmt, path::Path, sync::Arc};

use super::{AccuracySettings, Cost, Distance, Forces, MeshField, cost::BudgetShares, distance};
use crate::progress::{Pieces, StudyStep};
use contact3d::{
    Problem, ProblemError,
    contact::transferred,
    mesh::Mesh,
    scene::{ElementOrder, InvalidValue, Scene},
    solver::{Start, Status},
};

use refining::{Meshes, SequenceRun};

/// The reference is to have this share of the smallest error that it judges.
const WANTED_SHARE: f64 = 0.25;

/// Errors of which the reference has a larger share are not judged.
const LARGEST_SHARE: f64 = 0.5;

/// The reference may take this many times the seconds that a sequence may.
const REFERENCE_PARTS: usize = 4;

/// Equal parts of the budget.
const PARTS: usize = SequenceKind::ALL.len() + REFERENCE_PARTS;

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
            _ => ElementOrder::P2,
        }
    }

    fn is_adaptive(self) -> bool {
        use SequenceKind::{LinearAdaptive, QuadraticAdaptive, QuadraticGradedAdaptive};
        matches!(
            self,
            LinearAdaptive | QuadraticAdaptive | QuadraticGradedAdaptive
        )
    }

    fn is_graded(self) -> bool {
        matches!(self, Self::QuadraticGraded | Self::QuadraticGradedAdaptive)
    }
}

/// Announces the sequences and their reference by the seconds that they may take.
pub(super) fn announce(settings: &AccuracySettings, pieces: &mut Pieces<'_>) -> usize {
    let kind = pieces.kind(Some(settings.budget / PARTS as f64));
    let efforts = SequenceKind::ALL.map(|_| 1.0);
    let efforts = efforts.into_iter().chain([REFERENCE_PARTS as f64]);
    efforts.for_each(|effort| pieces.announce(kind, effort));
    kind
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
    /// Solves all sequences, each until its estimated relative error is below `goal`; mesh files are looked for in `folder`.
    /// The budget in `settings` is for all of them together: each has a share of what is left, the reference four.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem.
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        goal: f64,
        settings: &AccuracySettings,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Self, ProblemError> {
        let mut pieces = Pieces::new(observe);
        let kind = announce(settings, &mut pieces);
        Self::of(scene, folder, goal, settings, (kind, &mut pieces))
    }

    /// The same as announced.
    pub(super) fn of(
        scene: &Scene,
        folder: &Path,
        goal: f64,
        settings: &AccuracySettings,
        (work, pieces): (usize, &mut Pieces<'_>),
    ) -> Result<Self, ProblemError> {
        let mut runs = Vec::new();
        let mut shares = BudgetShares::new(settings.budget, PARTS);
        for kind in SequenceKind::ALL {
            let meshes = Meshes::of(kind, scene, folder, settings)?;
            let mut run = SequenceRun::new(kind, meshes, folder);
            pieces.begin(work, 1.0, kind.words().to_owned());
            run.go(shares.take(1), goal, settings.memory, &mut |n, last| {
                pieces.say(mesh_words(kind.words(), n, last));
            })?;
            if let Some(last) = run.solved.last() {
                pieces.figure(mesh_words(kind.words(), run.solved.len(), Some(last)));
            }
            runs.push(run);
        }
        let all = runs.iter().flat_map(|run| &run.solved);
        let smallest = all.map(SolvedMesh::rank).fold(f64::INFINITY, f64::min);
        let mut finest_first = runs.iter_mut().rev();
        let last = finest_first
            .find(|run| !run.solved.is_empty())
            .expect("every body has quadratic meshes");
        let (carried_on, n_judged) = (last.kind, last.solved.len());
        pieces.begin(work, REFERENCE_PARTS as f64, "reference".to_owned());
        last.go(
            shares.take(REFERENCE_PARTS),
            WANTED_SHARE * smallest,
            settings.memory,
            &mut |n, last| pieces.say(mesh_words("reference", n, last)),
        )?;
        pieces.say("comparison of the sequences".to_owned());
        let meshes = runs
            .iter()
            .flat_map(|run| run.solved.iter().map(|mesh| (run.kind, mesh)));
        let (kind, reference) = meshes
            .min_by(|(_, a), (_, b)| a.rank().total_cmp(&b.rank()))
            .expect("the first mesh of the last sequence is always solved");
        let sequences = runs.iter().map(|run| {
            // The meshes that the reference was carried on by are not judged.
            let most = if run.kind == carried_on {
                n_judged
            } else {
                run.solved.len()
            };
            let levels = run.solved[..most].iter();
            Ok(MeshSequence {
                kind: run.kind,
                levels: levels
                    .map(|mesh| mesh.judged(reference, scene))
                    .collect::<Result<_, InvalidValue>>()?,
            })
        });
        Ok(Self {
            sequences: sequences.collect::<Result<_, InvalidValue>>()?,
            reference: Reference {
                kind,
                level: reference.level.clone(),
                potential_energy: reference.potential_energy,
                forces: reference.forces,
            },
        })
    }

    /// The cheapest sequence for each of the targets.
    #[must_use]
    pub fn advice(&self) -> SequenceAdvice {
        SequenceAdvice::new(&self.sequences)
    }
}

/// How far a sequence of meshes is.
fn mesh_words(sequence: &str, n_solved: usize, last: Option<&SolvedMesh>) -> String {
    let Some(last) = last else {
        return format!("{sequence}: first mesh");
    };
    format!(
        "{sequence}: mesh {n_solved}, {} unknowns, estimated error {:.2} %",
        last.level.n_free,
        100.0 * last.level.estimated_error
    )
}

/// One mesh of a sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SequenceLevel {
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Tetrahedra.
    pub n_tetrahedra: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// How the solve ended.
    pub status: Status,
    /// The estimated error over ‖u_h‖_A; see [`ErrorEstimate::relative`](contact3d::post::ErrorEstimate::relative).
    pub estimated_error: f64,
    /// The part of the estimated error that the multipliers are to blame for, over ‖u_h‖_A too; 0 without contact.
    pub contact_error: f64,
    /// ‖u_h − u_r‖_A / ‖u_r‖_A with the reference u_r; `None` where the reference is too inaccurate to tell.
    pub error: Option<f64>,
    /// Mesh, assembly, solve and evaluation in memory, without files; on an adaptive sequence together with all coarser
    /// meshes, which it needs.
    pub cost: Cost,
}

impl SequenceLevel {
    /// The estimated error over the true one; `None` without a true one.
    #[must_use]
    pub fn effectivity(&self) -> Option<f64> {
        let error = self.error.filter(|error| *error > 0.0)?;
        Some(self.estimated_error / error)
    }
}

/// A solved mesh with all that the next one and the comparison need.
#[derive(Debug)]
struct SolvedMesh {
    level: SequenceLevel,
    mesh: Arc<Mesh>,
    /// Nodal displacement in m.
    displacement: Vec<[f64; 3]>,
    multiplier: Vec<f64>,
    /// Estimated error of each tetrahedron in √J.
    indicator: Vec<f64>,
    /// The estimated error in √J.
    estimated: f64,
    potential_energy: f64,
    forces: Option<Forces>,
}

impl SolvedMesh {
    /// Assembles, solves and evaluates a scene on a mesh, perhaps from the multipliers of a coarser mesh whose tetrahedra are the
    /// given parents; its cost is not known yet.
    fn new(
        scene: &Scene,
        mesh: Mesh,
        start: Option<(&Self, Vec<usize>)>,
    ) -> Result<Self, ProblemError> {
        let mesh = Arc::new(mesh);
        let start = start.map(|(coarse, parents)| {
            transferred(&coarse.mesh, &mesh, &parents, &coarse.multiplier)
        });
        let problem = Problem::of_checked(scene.clone(), Arc::clone(&mesh))?;
        let assembled = problem.assemble()?;
        let start = Start {
            multiplier: start.as_deref(),
            ..Start::default()
        };
        let mut solution = assembled.solve_from(&scene.solve, start, &mut |_| {})?;
        let report = assembled.report(&solution)?;
        report.classify(&mut solution);
        let r = report.resultants;
        let estimate = report.discretisation_error;
        Ok(Self {
            level: SequenceLevel {
                n_free: solution.displacement.len(),
                n_tetrahedra: mesh.tetrahedra.len(),
                n_multipliers: solution.multiplier.len(),
                status: solution.status,
                estimated_error: estimate.relative(),
                contact_error: estimate.relative_contact(),
                ..SequenceLevel::default()
            },
            estimated: estimate.total(),
            indicator: estimate.indicator,
            displacement: report.displacement,
            multiplier: solution.multiplier,
            potential_energy: r.strain_energy - r.load_work,
            forces: Forces::of(&r),
            mesh,
        })
    }

    /// A scene on a mesh of its own.
    fn of_scene(scene: &Scene, folder: &Path) -> Result<Self, ProblemError> {
        let mesh = Mesh::of_scene(scene, folder)?;
        Self::new(scene, mesh, None)
    }

    fn field(&self) -> MeshField<'_> {
        MeshField {
            mesh: &self.mesh,
            displacement: &self.displacement,
        }
    }

    /// The estimated error, for the choice of the reference; a mesh that was not solved comes last.
    fn rank(&self) -> f64 {
        if self.level.status.is_solved() {
            self.level.estimated_error
        } else {
            f64::INFINITY
        }
    }

    /// The level with its true error, where the reference is good enough to tell.
    fn judged(&self, reference: &Self, scene: &Scene) -> Result<SequenceLevel, InvalidValue> {
        let is_judged = reference.level.status.is_solved()
            && self.level.status.is_solved()
            && reference.level.estimated_error <= LARGEST_SHARE * self.level.estimated_error;
        let error = is_judged.then(|| distance(self.field(), reference.field(), scene));
        Ok(SequenceLevel {
            error: error.transpose()?.map(Distance::relative),
            ..self.level.clone()
        })
    }
}

/// The relative errors that advice is given for.
pub const TARGETS: [f64; 5] = [0.1, 0.05, 0.02, 0.01, 0.005];

/// The cheapest sequence for each of [`TARGETS`].
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceAdvice {
    /// For each target the sequence and its seconds; `None` where no sequence reached it.
    pub cheapest: [Option<(SequenceKind, f64)>; 5],
}

impl SequenceAdvice {
    /// Reads the advice off the sequences.
    #[must_use]
    pub fn new(sequences: &[MeshSequence]) -> Self {
        let cheapest = |target: f64| {
            let known = sequences.iter();
            let reached = known.filter_map(|one| Some((one.kind, one.seconds_to(target)?)));
            reached.min_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        Self {
            cheapest: TARGETS.map(cheapest),
        }
    }
}

impl MeshSequence {
    /// Seconds to a relative error: those of the first mesh where that is as accurate, else between two meshes along a
    /// straight line in the plane of the logarithms; `None` where no mesh reaches it.
    ///
    /// The estimated error counts where the true one is not known.
    #[must_use]
    pub fn seconds_to(&self, target: f64) -> Option<f64> {
        let error = |level: &SequenceLevel| level.error.unwrap_or(level.estimated_error);
        let mut levels = self.levels.iter();
        let reached = levels.position(|level| error(level) <= target)?;
        let fine = &self.levels[reached];
        let coarse = reached.checked_sub(1).map(|k| &self.levels[k]);
        let Some(coarse) = coarse.filter(|_| error(fine) != 0.0) else {
            return Some(fine.cost.seconds);
        };
        let share = (error(coarse) / target).ln() / (error(coarse) / error(fine)).ln();
        let [from, to] = [coarse, fine].map(|level| level.cost.seconds.ln());
        Some((from + share * (to - from)).exp())
    }
}

/// The targets that some sequence reached.
impl fmt::Display for SequenceAdvice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = TARGETS.iter().zip(self.cheapest);
        let reached = all.filter_map(|(target, cheapest)| Some((target, cheapest?)));
        let words = reached.map(|(target, (kind, seconds))| {
            format!("{} %: {}, {seconds:.2} s", 100.0 * target, kind.words())
        });
        match words.collect::<Vec<_>>() {
            none if none.is_empty() => write!(f, "{} %: not reached by any", 100.0 * TARGETS[0]),
            words => f.write_str(&words.join("; ")),
        }
    }
}
