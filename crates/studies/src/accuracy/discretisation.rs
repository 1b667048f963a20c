//! Errors of nested meshes against the finest one, with observed orders and limits.

use std::{path::Path, sync::Arc, time::Instant};

use super::{
    AccuracySettings, Cost, MOST_UNKNOWNS,
    algebraic::CHEAP_SHARE,
    brick_n_div,
    cost::measure,
    extrapolated, nested_bricks, observed_order,
    refinement::{SolvedMesh, with_brick},
};
use crate::StudyStep;
use contact3d::{
    Problem, ProblemError,
    elasticity::{InternalForces, MaterialField, SpringMatrix},
    linalg::dot,
    mesh::{Mesh, RefinableBody},
    post::StressConcentration,
    scene::{AssembleSettings, Brick, Functional, InvalidValue, Scene, SolveSettings},
    solver::Status,
};

/// Differences below this share of the quantity are rounding: the solves reach 1e-12.
const NEGLIGIBLE_DIFFERENCE: f64 = 1e-10;

/// One mesh of the study, solved to rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Level {
    /// Cells along the edges of a brick; `None` of another body.
    pub cells: Option<[usize; 3]>,
    /// Tetrahedra.
    pub n_tetrahedra: usize,
    /// h, the cube root of the mean volume of a cell, or of a tetrahedron without cells, in m.
    pub size: f64,
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
    /// Values of the quantities of the study, `[n_quantities]`; NaN for one that the level does not have.
    pub quantities: Vec<f64>,
    /// Where each grows with every finer mesh, `[n_quantities]`; empty where nothing tells so.
    pub grows: Vec<Option<StressConcentration>>,
    /// Mesh, assembly, solve and evaluation in memory, without files.
    pub cost: Cost,
}

impl Level {
    /// What people call its mesh.
    #[must_use]
    pub fn name(&self) -> String {
        match self.cells {
            Some([x, y, z]) => format!("{x} x {y} x {z} cells"),
            None => format!("{} tetrahedra", self.n_tetrahedra),
        }
    }
}

/// How one quantity goes with the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Order observed from each level and the two before it, `[n_levels]`; `None` where the three
    /// do not approach a limit.
    pub orders: Vec<Option<f64>>,
    /// Limit of the last two levels at the last order; `None` without it, of what grows, and of a quantity other than energy whose
    /// order before was another one.
    pub limit: Option<f64>,
    /// Where it grows with every finer mesh, as the finest level that tells so says; `None` of a pressure that falls on the last.
    pub grows: Option<StressConcentration>,
}

/// Nested meshes of one scene, coarse to fine.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscretisationStudy {
    /// Which level is the scene's own mesh.
    pub scene_level: usize,
    /// One record per mesh.
    pub levels: Vec<Level>,
    /// The energy-norm error; its limit is 0.
    pub energy_norm: Trend,
    /// J.
    pub potential_energy: Trend,
    /// Quantities of the solution.
    pub quantities: Vec<(Functional, Trend)>,
}

impl DiscretisationStudy {
    /// Solves the nested meshes of a scene; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`ProblemError`].
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        settings: &AccuracySettings,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Self, ProblemError> {
        let mut meshes = NestedMeshes::new(scene, folder, settings)?;
        meshes.solve(false, observe)?;
        Ok(meshes.study())
    }

    /// Orders and limits of solved levels, coarse to fine, and of some quantities that they have values of.
    ///
    /// For nested spaces ‖u_h − u_f‖² = ‖u_h − u‖² − ‖u_f − u‖² in a linear problem (Galerkin), and
    /// nearly so here: e_h² is a sequence whose limit −‖u_f − u‖² turns differences to the finest
    /// mesh into errors.
    #[must_use]
    pub fn new(scene_level: usize, mut levels: Vec<Level>, quantities: Vec<Functional>) -> Self {
        let h: Vec<f64> = levels.iter().map(|level| level.size).collect();
        let squares: Vec<f64> = levels.iter().map(|l| l.energy_difference.powi(2)).collect();
        let trend = Trend::new(&h, &squares, NEGLIGIBLE_DIFFERENCE * NEGLIGIBLE_DIFFERENCE);
        for (level, square) in levels.iter_mut().zip(&squares) {
            level.energy_error = trend.limit.map(|limit| (square - limit).max(0.0).sqrt());
        }
        let of_levels = |value: &dyn Fn(&Level) -> f64| {
            let values: Vec<f64> = levels.iter().map(value).collect();
            let size = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            Trend::new(&h, &values, NEGLIGIBLE_DIFFERENCE * size)
        };
        let of_quantity = |(k, of): (usize, Functional)| {
            let value = |level: &Level| level.quantities[k];
            let trend = of_levels(&value);
            let grows = levels.iter().rev().find_map(|level| *level.grows.get(k)?);
            let falls = of == Functional::LargestPressure
                && matches!(&levels[..], [.., before, last] if value(last) <= value(before));
            let is_told = of == Functional::StrainEnergy || trend.is_confirmed();
            let limit = trend.limit.filter(|_| is_told && grows.is_none());
            (
                of,
                Trend {
                    limit,
                    grows: grows.filter(|_| !falls),
                    ..trend
                },
            )
        };
        let quantities = quantities.into_iter().enumerate().map(of_quantity);
        Self {
            scene_level,
            energy_norm: Trend {
                orders: trend.orders.iter().map(|p| p.map(|p| p / 2.0)).collect(),
                limit: trend.limit.map(|_| 0.0),
                grows: None,
            },
            potential_energy: of_levels(&|level| level.potential_energy),
            quantities: quantities.collect(),
            levels,
        }
    }
}

/// The meshes of a study while they are solved.
pub(super) struct NestedMeshes<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    /// Those to come, fine to coarse: cells of a brick, or another body cut once more than before.
    to_come: Vec<Option<Brick>>,
    most_unknowns: usize,
    budget: Option<f64>,
    began: Instant,
    quantities: Vec<Functional>,
    levels: Vec<Level>,
    fields: Vec<SolvedMesh>,
}

impl<'a> NestedMeshes<'a> {
    /// The meshes of a scene.
    pub(super) fn new(
        scene: &'a Scene,
        folder: &'a Path,
        settings: &AccuracySettings,
    ) -> Result<Self, ProblemError> {
        refuse_other_options(scene, settings)?;
        let mut to_come = match scene.as_brick() {
            Some(brick) => {
                let bricks = nested_bricks(scene, brick, settings)?;
                bricks.into_iter().map(Some).collect()
            }
            // As many as an order takes.
            None => vec![None; 3],
        };
        to_come.reverse();
        Ok(Self {
            scene,
            folder,
            to_come,
            most_unknowns: settings.unknowns.unwrap_or(MOST_UNKNOWNS),
            budget: settings.budget,
            began: Instant::now(),
            quantities: quantities_of(scene),
            levels: Vec::new(),
            fields: Vec::new(),
        })
    }

    /// Solves the meshes to come, or only those coarser than the scene's own.
    pub(super) fn solve(
        &mut self,
        coarser: bool,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<(), ProblemError> {
        let own = self.scene.as_brick().map_or(0, brick_n_div);
        let is_coarser = |brick: &Brick| brick_n_div(brick) < own;
        let wanted = |brick: &mut Option<Brick>| !coarser || brick.as_ref().is_some_and(is_coarser);
        while let Some(brick) = self.to_come.pop_if(wanted) {
            let cuts = self.levels.len();
            let is_finer = brick.as_ref().is_none_or(|brick| brick_n_div(brick) > own);
            if let Some(why) = self.too_much(brick.as_ref()).filter(|_| is_finer) {
                observe(StudyStep::Figure(format!("no finer mesh: {why}")));
                self.to_come.clear();
                break;
            }
            let of = cuts + 1 + self.to_come.len();
            observe(StudyStep::Begin(format!("mesh {} of {of}", cuts + 1)));
            let scene = solved_to_rounding(self.scene.clone());
            let scene = brick.iter().fold(scene, |s, brick| with_brick(&s, brick));
            // Again, for the median of its seconds, when once took no longer than this.
            let cheap = self.budget.map_or(5.0, |budget| budget * CHEAP_SHARE);
            let ((level, field), cost) = measure(cheap, || {
                solve_level(&scene, self.folder, brick.as_ref(), cuts, &self.quantities)
            })?;
            let error = match level.estimated_error {
                error if error.is_nan() => format!("no solution ({})", level.status.word()),
                error => format!("estimated error {:.2} %", 100.0 * error),
            };
            let (name, n_free, seconds) = (level.name(), level.n_free, cost.seconds);
            let words = format!("{name}: {n_free} unknowns, {error}, {seconds:.2} s");
            observe(StudyStep::Figure(words));
            self.levels.push(Level { cost, ..level });
            self.fields.push(field);
        }
        Ok(())
    }

    /// Why a mesh is too much by its forecast; `None` where it is not.
    fn too_much(&self, brick: Option<&Brick>) -> Option<String> {
        let last = self.levels.last()?;
        let before = last.cells.and_then(|cells| cells.into_iter().min());
        let finer = |(brick, n_div)| brick_n_div(brick) as f64 / n_div as f64;
        let edges = brick.zip(before).map_or(2.0, finer);
        let (most, n_free) = (self.most_unknowns, last.n_free as f64 * edges.powi(3));
        if brick.is_none() && n_free > most as f64 {
            return Some(format!(
                "expected at most {most} unknowns, found about {n_free:.0}; allow more with --unknowns"
            ));
        }
        // Of the published brick seconds went with the power 2.1, 3.2, 3.9 and 4.5 of the cells along an edge, from 4 to 24 of them.
        let coarser = self.levels.iter().rev().nth(1);
        let order = coarser.map_or(3.5, |coarser| {
            (last.cost.seconds / coarser.cost.seconds).ln() / (coarser.size / last.size).ln()
        });
        let seconds = last.cost.seconds * edges.powf(order.clamp(3.0, 4.5));
        let left = self.left()?;
        (seconds > left).then(|| {
            format!("it is forecast to take {seconds:.1} s, more than is left of --budget")
        })
    }

    /// Seconds left of the budget; `None` without one.
    pub(super) fn left(&self) -> Option<f64> {
        Some(self.budget? - self.began.elapsed().as_secs_f64())
    }

    /// All meshes against the finest.
    pub(super) fn study(mut self) -> DiscretisationStudy {
        if let Some(last) = self.fields.last() {
            let (mesh, finest) = (&last.mesh, &last.displacement);
            let norm = |field: &[[f64; 3]]| energy_norm(self.scene, mesh, field);
            let size = norm(finest);
            let finest_error = self.levels.last().map(|last| last.estimated_error);
            // The tetrahedron of each level that each of the finest mesh lies in, of meshes that were cut.
            let mut around: Vec<usize> = (0..last.descendants.len()).collect();
            for (level, own) in self.levels.iter_mut().zip(&self.fields).rev() {
                let same = own.prolongated(last, &around);
                around
                    .iter_mut()
                    .for_each(|t| *t = own.descendants[*t].parent);
                let pairs = same.iter().zip(finest);
                let apart: Vec<[f64; 3]> = pairs
                    .map(|(a, b)| std::array::from_fn(|c| a[c] - b[c]))
                    .collect();
                let difference = norm(&apart);
                level.energy_difference = match size {
                    _ if finest_error.is_none_or(f64::is_nan) || level.estimated_error.is_nan() => {
                        f64::NAN
                    }
                    0.0 => 0.0,
                    _ => difference / size,
                };
            }
        }
        let own = self.scene.as_brick().map(|brick| brick.cells);
        let scene_level = self.levels.iter().position(|level| level.cells == own);
        DiscretisationStudy::new(scene_level.unwrap_or(0), self.levels, self.quantities)
    }
}

/// The quantities of the study: what there is to ask of the solution of a scene, and what its mesh is refined for.
fn quantities_of(scene: &Scene) -> Vec<Functional> {
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let is_there = |of: &Functional| match of {
        Functional::LargestVonMises => true,
        Functional::StickArea => scene.has_friction(),
        Functional::NormalForce | Functional::LargestPressure | Functional::ContactArea => {
            scene.has_contact()
        }
        _ => false,
    };
    let others = wanted.filter(|of| !is_there(of));
    let always = Functional::NAMED.into_iter().filter(is_there);
    always.chain(others).collect()
}

/// Refuses limits that the meshes of a scene do not have.
fn refuse_other_options(scene: &Scene, settings: &AccuracySettings) -> Result<(), InvalidValue> {
    const BRICK: &str = "a body that is one brick";
    let options = [
        ("--finest", settings.finest, BRICK),
        ("--coarsest", settings.coarsest, BRICK),
        (
            "--unknowns",
            settings.unknowns,
            "a mesh file or several bodies",
        ),
    ];
    let is_brick = scene.as_brick().is_some();
    let mut others = options
        .into_iter()
        .filter(|(.., body)| (*body == BRICK) != is_brick);
    let given = others.find(|(_, value, _)| value.is_some());
    given.map_or(Ok(()), |(key, _, expected)| {
        Err(InvalidValue {
            key: key.into(),
            expected: expected.into(),
            found: "another body".into(),
            help: "cells of one brick have --coarsest and --finest; tetrahedra of mesh files and of several bodies are cut up to twice, as far as --unknowns allows".into(),
        })
    })
}

impl Trend {
    /// Whether the order before the last is about the same. Forces, areas and largest values depend on where panes lie: of 56 limits by
    /// three meshes 42 were further from the value on the next mesh than that on the third, of 34 limits of energies 6 (cells halved).
    #[must_use]
    pub fn is_confirmed(&self) -> bool {
        matches!(self.orders[..], [.., Some(before), Some(last)] if (last - before).abs() <= 0.5)
    }

    fn new(h: &[f64], values: &[f64], negligible: f64) -> Self {
        let order = |k: usize| {
            let at = |list: &[f64]| [list[k - 2], list[k - 1], list[k]];
            (k >= 2).then(|| observed_order(at(h), at(values), negligible))?
        };
        let orders: Vec<Option<f64>> = (0..h.len()).map(order).collect();
        let last = h.len().wrapping_sub(1);
        let order = orders.last().copied().flatten();
        // The least observed order that a limit is claimed from: that of energies and quantities at a crack, twice that of the energy norm.
        // With a lower one the meshes are too coarse to tell, and the limit lies far beyond the last of them.
        let limit = order.filter(|order| *order >= 1.0).map(|order| {
            let pair = |list: &[f64]| [list[last - 1], list[last]];
            extrapolated(pair(h), pair(values), order)
        });
        Self {
            orders,
            limit,
            grows: None,
        }
    }
}

/// √a(u, u) of a nodal displacement in m, `[n_nodes]`, whose held nodes may have moved.
fn energy_norm(scene: &Scene, mesh: &Mesh, displacement: &[[f64; 3]]) -> f64 {
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

/// A level and its displacement: of a brick, or of another body whose tetrahedra are all cut so often.
fn solve_level(
    scene: &Scene,
    folder: &Path,
    brick: Option<&Brick>,
    cuts: usize,
    quantities: &[Functional],
) -> Result<(Level, SolvedMesh), ProblemError> {
    let (mesh, descendants) = match brick {
        Some(_) => (Mesh::of_scene(scene, folder)?, Vec::new()),
        None => {
            let mut body = RefinableBody::new(scene, folder)?;
            // Three cuts halve all edges.
            (0..cuts).for_each(|_| body.refine(&vec![3; body.n_tetrahedra()]));
            (body.mesh()?, body.descendants())
        }
    };
    let problem = Problem::of_checked(scene.clone(), Arc::new(mesh))?;
    let assembled = problem.assemble()?;
    let (solution, report) = assembled.solve_and_report(&scene.solve)?;
    let r = &report.resultants;
    let mesh = assembled.mesh();
    let n_tetrahedra = mesh.tetrahedra.len();
    let cells = brick.map(|brick| brick.cells);
    let parts = cells.map_or(n_tetrahedra, |cells| cells.iter().product());
    let volume: f64 = mesh.corner_volumes().iter().sum();
    let is_solved = solution.status.is_solved();
    let value = |of: &Functional| report.value(*of).filter(|_| is_solved).unwrap_or(f64::NAN);
    let grows = |of: &Functional| report.concentration(*of).filter(|_| is_solved);
    let level = Level {
        cells,
        n_tetrahedra,
        size: (volume / parts as f64).cbrt(),
        n_free: solution.displacement.len(),
        n_multipliers: solution.multiplier.len(),
        status: solution.status,
        applications: solution.trace.applications,
        estimated_error: match solution.has_computed_solution() {
            true => report.discretisation_error.relative(),
            false => f64::NAN,
        },
        potential_energy: r.strain_energy - r.load_work,
        quantities: quantities.iter().map(value).collect(),
        grows: quantities.iter().map(grows).collect(),
        ..Level::default()
    };
    let field = SolvedMesh {
        brick: brick.cloned(),
        mesh: Arc::clone(mesh),
        descendants,
        displacement: report.displacement,
    };
    Ok((level, field))
}
