//! Errors of nested meshes against the finest one, with observed orders and limits.

use std::{path::Path, sync::Arc};

use super::{
    AccuracySettings, Cost, brick_n_div,
    cost::measure,
    extrapolated, nested_bricks, observed_order,
    refinement::{prolongate, with_brick},
};
use crate::StudyStep;
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    dual::PrimalSystem,
    elasticity::{InternalForces, MaterialField, SpringMatrix},
    linalg::{CscMatrix, dot},
    mesh::Mesh,
    scene::{AssembleSettings, Brick, Scene, SolveSettings},
    solver::Status,
};

/// A mesh is solved again, for the median of its seconds, when once took no longer than this.
pub(super) const CHEAP_SECONDS: f64 = 5.0;

/// Differences below this share of the quantity are rounding: the solves reach 1e-12.
const NEGLIGIBLE_DIFFERENCE: f64 = 1e-10;

/// One mesh of the study, solved to rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Level {
    /// Smallest number of cells along an edge.
    pub n_div: usize,
    /// Cells along the edges.
    pub cells: [usize; 3],
    /// h, the cube root of the mean volume of a cell, in m.
    pub cell_size: f64,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// How the solve ended.
    pub status: Status,
    /// n_A.
    pub applications: usize,
    /// ‖u_h − u_f‖_A / ‖u_f‖_A, with u_f of the finest mesh; 0 there, NaN where either has no solution.
    pub energy_difference: f64,
    /// ‖u_h − u‖_A / ‖u_f‖_A with the extrapolated limit; `None` where no order is observed.
    pub energy_error: Option<f64>,
    /// The estimated error over ‖u_h‖_A; see [`ErrorEstimate::relative`](contact3d::post::ErrorEstimate::relative).
    pub estimated_error: f64,
    /// J = ½ uᵀAu − lᵀu in J.
    pub potential_energy: f64,
    /// Mesh, assembly, solve and evaluation in memory, without files.
    pub cost: Cost,
}

/// How one quantity goes with the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Order observed from each level and the two before it, `[n_levels]`; `None` where the three
    /// do not approach a limit.
    pub orders: Vec<Option<f64>>,
    /// Limit of the last two levels at the last order; `None` without it.
    pub limit: Option<f64>,
}

/// Nested meshes of one scene, coarse to fine.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscretisationStudy {
    /// n_div of the scene itself.
    pub scene_n_div: usize,
    /// One record per mesh.
    pub levels: Vec<Level>,
    /// The energy-norm error; its limit is 0.
    pub energy_norm: Trend,
    /// J.
    pub potential_energy: Trend,
}

impl DiscretisationStudy {
    /// Solves the nested meshes of a scene's brick; `None` for another body.
    ///
    /// # Errors
    /// [`ProblemError`].
    pub fn measure(
        scene: &Scene,
        settings: &AccuracySettings,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Option<Self>, ProblemError> {
        let mut meshes = NestedMeshes::new(scene, Path::new(""), settings)?;
        meshes.solve(false, observe)?;
        Ok(meshes.study())
    }

    /// Orders and limits of solved levels, coarse to fine.
    ///
    /// For nested spaces ‖u_h − u_f‖² = ‖u_h − u‖² − ‖u_f − u‖² in a linear problem (Galerkin), and
    /// nearly so here: e_h² is a sequence whose limit −‖u_f − u‖² turns differences to the finest
    /// mesh into errors.
    #[must_use]
    pub fn new(scene_n_div: usize, mut levels: Vec<Level>) -> Self {
        let h: Vec<f64> = levels.iter().map(|level| level.cell_size).collect();
        let squares: Vec<f64> = levels.iter().map(|l| l.energy_difference.powi(2)).collect();
        let trend = Trend::new(&h, &squares, NEGLIGIBLE_DIFFERENCE * NEGLIGIBLE_DIFFERENCE);
        for (level, square) in levels.iter_mut().zip(&squares) {
            level.energy_error = trend.limit.map(|limit| (square - limit).max(0.0).sqrt());
        }
        let energies: Vec<f64> = levels.iter().map(|level| level.potential_energy).collect();
        let size = energies.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        Self {
            scene_n_div,
            energy_norm: Trend {
                orders: trend.orders.iter().map(|p| p.map(|p| p / 2.0)).collect(),
                limit: trend.limit.map(|_| 0.0),
            },
            potential_energy: Trend::new(&h, &energies, NEGLIGIBLE_DIFFERENCE * size),
            levels,
        }
    }

    /// The level of the scene's own mesh.
    #[must_use]
    pub(crate) fn scene_level(&self) -> Option<&Level> {
        self.levels.iter().find(|l| l.n_div == self.scene_n_div)
    }
}

/// The meshes of a study while they are solved.
pub(super) struct NestedMeshes<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    /// Those to come, fine to coarse.
    bricks: Vec<Brick>,
    levels: Vec<Level>,
    fields: Vec<SolvedBrick>,
    /// A of the last mesh.
    finest: Option<PrimalSystem>,
}

/// A brick with its mesh and the displacement of the nodes in m.
struct SolvedBrick {
    brick: Brick,
    mesh: Arc<Mesh>,
    displacement: Vec<[f64; 3]>,
}

impl<'a> NestedMeshes<'a> {
    /// The meshes of a scene's brick, none of another body.
    pub(super) fn new(
        scene: &'a Scene,
        folder: &'a Path,
        settings: &AccuracySettings,
    ) -> Result<Self, ProblemError> {
        let bricks = scene.as_brick();
        let bricks = bricks.map(|brick| nested_bricks(scene, brick, settings));
        let mut bricks = bricks.transpose()?.unwrap_or_default();
        bricks.reverse();
        Ok(Self {
            scene,
            folder,
            bricks,
            levels: Vec::new(),
            fields: Vec::new(),
            finest: None,
        })
    }

    /// Solves the meshes to come, or only those coarser than the scene's own.
    pub(super) fn solve(
        &mut self,
        coarser: bool,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<(), ProblemError> {
        let own = self.scene.as_brick().map_or(0, brick_n_div);
        let wanted = |brick: &mut Brick| !coarser || brick_n_div(brick) < own;
        while let Some(brick) = self.bricks.pop_if(wanted) {
            let n_div = brick_n_div(&brick);
            observe(StudyStep::Begin(format!("mesh n_div = {n_div}")));
            let scene = solved_to_rounding(with_brick(self.scene, &brick));
            drop(self.finest.take());
            let ((level, field, primal), cost) =
                measure(CHEAP_SECONDS, || solve_level(&scene, &brick, self.folder))?;
            let error = match level.estimated_error {
                error if error.is_nan() => format!("no solution ({})", level.status.word()),
                error => format!("estimated error {:.2} %", 100.0 * error),
            };
            let (n_free, seconds) = (level.n_free, cost.seconds);
            let words = format!("n_div = {n_div}: {n_free} unknowns, {error}, {seconds:.2} s");
            observe(StudyStep::Figure(words));
            self.levels.push(Level { cost, ..level });
            self.fields.push(field);
            self.finest = Some(primal);
        }
        Ok(())
    }

    /// All meshes against the finest; `None` for another body.
    pub(super) fn study(mut self) -> Option<DiscretisationStudy> {
        let brick = self.scene.as_brick()?;
        if let (Some(primal), Some(last)) = (self.finest, self.fields.last()) {
            let (mesh, finest) = (&last.mesh, &last.displacement);
            let norm = |field: &[[f64; 3]]| match primal.dofs.prescribed {
                None if primal.dofs.tied.is_empty() => {
                    energy_norm(&primal.stiffness, &primal.dofs.to_free(field))
                }
                _ => whole_energy_norm(self.scene, mesh, field),
            };
            let size = norm(finest);
            let has_finest = self
                .levels
                .last()
                .is_some_and(|last| !last.estimated_error.is_nan());
            for (level, own) in self.levels.iter_mut().zip(&self.fields) {
                let same = prolongate(&own.brick, &own.mesh, &own.displacement, &mesh.coordinates);
                let pairs = same.iter().zip(finest);
                let apart: Vec<[f64; 3]> = pairs
                    .map(|(a, b)| std::array::from_fn(|c| a[c] - b[c]))
                    .collect();
                let difference = norm(&apart);
                level.energy_difference = match size {
                    _ if !has_finest || level.estimated_error.is_nan() => f64::NAN,
                    0.0 => 0.0,
                    _ => difference / size,
                };
            }
        }
        Some(DiscretisationStudy::new(brick_n_div(brick), self.levels))
    }
}

impl Trend {
    fn new(h: &[f64], values: &[f64], negligible: f64) -> Self {
        let order = |k: usize| {
            let at = |list: &[f64]| [list[k - 2], list[k - 1], list[k]];
            (k >= 2).then(|| observed_order(at(h), at(values), negligible))?
        };
        let orders: Vec<Option<f64>> = (0..h.len()).map(order).collect();
        let last = h.len().wrapping_sub(1);
        let order = orders.last().copied().flatten();
        // The least observed order that a limit is claimed from: that of the energy norm at an edge between a clamp and a free face. With a
        // lower one the meshes are too coarse to tell, and the limit lies far beyond the last of them.
        let limit = order.filter(|order| *order >= 0.5).map(|order| {
            let pair = |list: &[f64]| [list[last - 1], list[last]];
            extrapolated(pair(h), pair(values), order)
        });
        Self { orders, limit }
    }
}

/// ‖u‖_A = √(uᵀAu).
pub(super) fn energy_norm(stiffness: &CscMatrix, displacement: &[f64]) -> f64 {
    let mut forces = vec![0.0; displacement.len()];
    stiffness.mul(displacement, &mut forces);
    dot(displacement, &forces).max(0.0).sqrt()
}

/// √a(u, u) of a nodal displacement in m, `[n_nodes]`, whose held nodes may have moved.
fn whole_energy_norm(scene: &Scene, mesh: &Mesh, displacement: &[[f64; 3]]) -> f64 {
    let material = MaterialField::new(scene, mesh);
    let elastic = InternalForces::of(mesh, &material, displacement).forces;
    // A stiffness without a value was refused when A was assembled.
    let springs = SpringMatrix::of(scene, mesh).ok().flatten();
    let springs = springs.map(|springs| springs.forces(displacement));
    let work = |forces: &Vec<[f64; 3]>| dot(forces.as_flattened(), displacement.as_flattened());
    let square = work(&elastic) + springs.as_ref().map_or(0.0, work);
    square.max(0.0).sqrt()
}

/// The scene with default settings of assembly and solve.
pub(super) fn solved_to_rounding(mut scene: Scene) -> Scene {
    scene.assemble = AssembleSettings::default();
    scene.solve = SolveSettings::default();
    scene
}

/// A level, its displacement, and A.
fn solve_level(
    scene: &Scene,
    brick: &Brick,
    folder: &Path,
) -> Result<(Level, SolvedBrick, PrimalSystem), ProblemError> {
    let mesh = Mesh::of_scene(scene, folder)?;
    let problem = Problem::of_checked(scene.clone(), Arc::new(mesh))?;
    let assembled = problem.assemble()?;
    let (solution, report) = assembled.solve_and_report(&scene.solve)?;
    let r = report.resultants;
    let cells = brick.size.iter().zip(brick.cells);
    let volume: f64 = cells.map(|(l, n)| l / n as f64).product();
    let AssembledProblem { problem, system } = assembled;
    let level = Level {
        n_div: brick_n_div(brick),
        cells: brick.cells,
        cell_size: volume.cbrt(),
        n_free: solution.displacement.len(),
        n_multipliers: solution.multiplier.len(),
        status: solution.status,
        applications: solution.trace.applications,
        estimated_error: match solution.has_computed_solution() {
            true => report.discretisation_error.relative(),
            false => f64::NAN,
        },
        potential_energy: r.strain_energy - r.load_work,
        ..Level::default()
    };
    let field = SolvedBrick {
        brick: brick.clone(),
        mesh: Arc::clone(problem.mesh()),
        displacement: report.displacement,
    };
    Ok((level, field, system.assembly.primal))
}
