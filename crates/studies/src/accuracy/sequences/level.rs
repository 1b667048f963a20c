//! One mesh of a sequence, solved; and what follows from all of them.

use std::{fmt, path::Path, sync::Arc};

use super::{Field, Forces, MeshSequence, Reference, SequenceKind, Status};
use crate::accuracy::Cost;
use contact3d::{
    Problem, ProblemError, adaptation::transferred, mesh::Mesh, scene::Scene, solver::Start,
};

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
pub(super) struct SolvedMesh {
    pub(super) level: SequenceLevel,
    pub(super) mesh: Arc<Mesh>,
    /// Nodal displacement in m.
    displacement: Vec<[f64; 3]>,
    multiplier: Vec<f64>,
    /// Estimated error of each tetrahedron in √J.
    pub(super) indicator: Vec<f64>,
    /// The estimated error in √J.
    pub(super) estimated: f64,
    potential_energy: f64,
    forces: Option<Forces>,
}

/// The multipliers of a coarser mesh and where its tetrahedra are in a finer one.
pub(super) struct WarmStart<'a> {
    pub(super) coarse: &'a SolvedMesh,
    pub(super) parents: Vec<usize>,
}

impl SolvedMesh {
    /// Assembles, solves and evaluates a scene on a mesh; its cost is not known yet.
    pub(super) fn new(
        scene: &Scene,
        mesh: Mesh,
        start: Option<WarmStart<'_>>,
    ) -> Result<Self, ProblemError> {
        let mesh = Arc::new(mesh);
        let start = start.map(|start| {
            let coarse = start.coarse;
            transferred(&coarse.mesh, &mesh, &start.parents, &coarse.multiplier)
        });
        let problem = Problem::of_checked(scene.clone(), Arc::clone(&mesh))?;
        let assembled = problem.assemble()?;
        let start = Start {
            multiplier: start.as_deref(),
            ..Start::default()
        };
        let mut solution = assembled.solve_from(&scene.solve, start, &mut |_| {})?;
        let report = assembled.report(&solution)?;
        report.judge(&mut solution);
        let r = report.resultants;
        let status = solution.status;
        let estimate = report.discretisation_error;
        Ok(Self {
            level: SequenceLevel {
                n_free: solution.displacement.len(),
                n_tetrahedra: mesh.tetrahedra.len(),
                n_multipliers: solution.multiplier.len(),
                status,
                estimated_error: estimate.relative(),
                contact_error: estimate.relative_contact(),
                error: None,
                cost: Cost {
                    seconds: 0.0,
                    repeats: 0,
                    peak_bytes: None,
                },
            },
            estimated: estimate.total(),
            indicator: estimate.indicator,
            displacement: report.displacement,
            multiplier: solution.multiplier,
            potential_energy: r.strain_energy - r.load_work,
            forces: r.contact.map(|contact| Forces {
                normal: contact.normal_force,
                tangential: contact.tangential_force,
            }),
            mesh,
        })
    }

    /// A scene on a mesh of its own.
    pub(super) fn of_scene(scene: &Scene, folder: &Path) -> Result<Self, ProblemError> {
        let mesh = Mesh::of_scene(scene, folder)?;
        Self::new(scene, mesh, None)
    }

    pub(super) fn field(&self) -> Field<'_> {
        Field {
            mesh: &self.mesh,
            displacement: &self.displacement,
        }
    }

    /// The estimated error, for the choice of the reference; a mesh that was not solved comes last.
    pub(super) fn rank(&self) -> f64 {
        if self.level.status.is_solved() {
            self.level.estimated_error
        } else {
            f64::INFINITY
        }
    }

    pub(super) fn to_reference(&self, kind: SequenceKind) -> Reference {
        Reference {
            kind,
            level: self.level.clone(),
            potential_energy: self.potential_energy,
            forces: self.forces,
        }
    }
}

/// The relative errors that advice is given for.
pub const TARGETS: [f64; 3] = [0.05, 0.02, 0.01];

/// The cheapest sequence for one accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cheapest {
    /// The relative error in the energy norm.
    pub target: f64,
    /// The sequence and its seconds; `None` where no sequence reached it within the budget.
    pub sequence: Option<(SequenceKind, f64)>,
}

/// The cheapest sequence for each of [`TARGETS`].
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceAdvice {
    /// One for each target.
    pub cheapest: Vec<Cheapest>,
}

impl SequenceAdvice {
    /// Reads the advice off the sequences.
    #[must_use]
    pub fn new(sequences: &[MeshSequence]) -> Self {
        let cheapest = TARGETS.map(|target| {
            let reached = sequences
                .iter()
                .filter_map(|sequence| Some((sequence.kind, sequence.seconds_to(target)?)));
            Cheapest {
                target,
                sequence: reached.min_by(|(_, a), (_, b)| a.total_cmp(b)),
            }
        });
        Self {
            cheapest: cheapest.to_vec(),
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
        let reached = self
            .levels
            .iter()
            .position(|level| error(level) <= target)?;
        let fine = &self.levels[reached];
        let Some(coarse) = reached.checked_sub(1).map(|k| &self.levels[k]) else {
            return Some(fine.cost.seconds);
        };
        if error(fine) == 0.0 {
            return Some(fine.cost.seconds);
        }
        let share = (error(coarse) / target).ln() / (error(coarse) / error(fine)).ln();
        let [from, to] = [coarse, fine].map(|level| level.cost.seconds.ln());
        Some((from + share * (to - from)).exp())
    }
}

impl fmt::Display for SequenceAdvice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, cheapest) in self.cheapest.iter().enumerate() {
            let separator = if k == 0 { "" } else { "; " };
            let percent = 100.0 * cheapest.target;
            write!(f, "{separator}{percent} %: ")?;
            match cheapest.sequence {
                Some((kind, seconds)) => write!(f, "{}, {seconds:.2} s", kind.words())?,
                None => f.write_str("not reached within the budget")?,
            }
        }
        Ok(())
    }
}
