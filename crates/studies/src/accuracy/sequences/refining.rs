//! The meshes of a sequence, one after the other, as far as time and memory go.

use std::path::Path;

use super::{AccuracySettings, ElementOrder, SequenceKind, SolvedMesh};
use crate::accuracy::{
    brick_n_div,
    cost::measure,
    discretisation::{CHEAP_SECONDS, solved_to_rounding},
    refinement::{contact_parts_fit, proportions, with_cells},
};
use contact3d::{
    ProblemError,
    adaptation::{Target, next_cuts},
    mesh::{Mesh, MeshError, RefinableBody, RefinedLevel, Refinement, tetrahedron_volume},
    scene::{Brick, Scene},
};

/// Multiples of the proportions of a brick that uniform meshes have: unknowns grow about threefold.
const MULTIPLES: [usize; 14] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128];

/// Smallest n_div of the graded cells that an adaptive sequence begins with: cuts of many cells keep better shapes than
/// many cuts of a few.
const FIRST_GRADED: usize = 6;

/// Cuts that halve all edges of a tetrahedron.
const HALVES: u8 = 3;

/// Each adaptive mesh is to have about this many times the unknowns of the one before.
const GROWTH: f64 = 2.0;

/// Memory of a factor grows with this power of the unknowns (nested dissection in space).
const MEMORY_POWER: f64 = 4.0 / 3.0;

/// Its operations grow with this one, at most.
const TIME_POWER: f64 = 2.0;

/// Volumes that differ by less than this share of the body's are the same but for roundings.
const SAME_VOLUME: f64 = 1e-9;

/// Where the meshes of a sequence come from.
#[derive(Debug)]
pub(super) enum Meshes {
    /// A list of scenes, each with a mesh of its own; empty where the body has no such mesh.
    Scenes(Vec<Scene>),
    /// One scene, whose tetrahedra are all cut into eight again and again.
    Halved(Box<Scene>),
    /// One scene, whose tetrahedra are cut where the estimated error sits.
    Adaptive(Box<Scene>),
}

impl Meshes {
    /// Those of a sequence.
    pub(super) fn of(
        kind: SequenceKind,
        scene: &Scene,
        folder: &Path,
        settings: &AccuracySettings,
    ) -> Result<Self, ProblemError> {
        let nothing = || Ok(Self::Scenes(Vec::new()));
        let mut scene = solved_to_rounding(scene.clone());
        let is_other = scene.body.element != kind.element();
        scene.body.element = kind.element();
        match scene.body.as_brick() {
            // Other planes between cells would give the regions other volumes.
            Some(_) if kind.is_graded() && !scene.regions.is_empty() => nothing(),
            Some(brick) => {
                let coarsest = coarsest_with_regions(&scene, brick)?;
                let multiples = MULTIPLES.map(|m| coarsest.map(|n| n * m));
                let scenes = multiples.into_iter().map(|cells| {
                    if kind.is_graded() {
                        scene.clone().with_graded_cells(cells)
                    } else {
                        with_cells(&scene, cells)
                    }
                });
                let is_both = kind.is_graded() && kind.is_adaptive();
                let least = if is_both { FIRST_GRADED } else { 0 };
                let mut fitting = scenes.filter(|scene| {
                    let n_div = scene.body.as_brick().map_or(0, brick_n_div);
                    n_div >= settings.coarsest.max(least) && scene.validate().is_ok()
                });
                Ok(match (kind.is_adaptive(), fitting.next()) {
                    (true, Some(first)) => Self::Adaptive(Box::new(first)),
                    (_, first) => Self::Scenes(first.into_iter().chain(fitting).collect()),
                })
            }
            None if kind.is_graded() => nothing(),
            None => match Mesh::of_scene(&scene, folder) {
                // A file of second-order tetrahedra has no linear ones.
                Err(MeshError::Scene(_)) if is_other => nothing(),
                Err(error) => Err(error.into()),
                Ok(_) if kind.is_adaptive() => Ok(Self::Adaptive(Box::new(scene))),
                Ok(_) => Ok(Self::Halved(Box::new(scene))),
            },
        }
    }

    /// The unknowns of mesh n over those of the one before, estimated; `None` where there is no mesh n.
    fn growth(&self, n: usize) -> Option<f64> {
        match self {
            Self::Scenes(scenes) => {
                let cells = |n: usize| -> Option<f64> {
                    let brick = scenes.get(n)?.body.as_brick()?;
                    Some(brick.cells.iter().map(|n| *n as f64).product())
                };
                let (fine, coarse) = (cells(n)?, n.checked_sub(1).and_then(cells));
                Some(coarse.map_or(1.0, |coarse| fine / coarse))
            }
            Self::Halved(_) => Some(8.0),
            Self::Adaptive(_) => Some(1.5 * GROWTH),
        }
    }
}

/// A sequence and how far it has come.
#[derive(Debug)]
pub(super) struct SequenceRun<'a> {
    pub(super) kind: SequenceKind,
    meshes: Meshes,
    folder: &'a Path,
    pub(super) solved: Vec<SolvedMesh>,
    /// Cuts of each level, on an adaptive sequence.
    refinement: Refinement,
    /// Seconds of all solves, repeated ones too.
    spent: f64,
}

impl<'a> SequenceRun<'a> {
    pub(super) fn new(kind: SequenceKind, meshes: Meshes, folder: &'a Path) -> Self {
        Self {
            kind,
            meshes,
            folder,
            solved: Vec::new(),
            refinement: Refinement::default(),
            spent: 0.0,
        }
    }

    /// Goes on until the estimated relative error is at most `goal`, the seconds of further levels would exceed `budget`, or
    /// the next mesh would take more than `memory` bytes. The first mesh is always solved, and an answer that did not
    /// converge ends the sequence.
    pub(super) fn go(
        &mut self,
        budget: f64,
        goal: f64,
        memory: Option<f64>,
        observe: &mut dyn FnMut(usize, Option<&SolvedMesh>),
    ) -> Result<(), ProblemError> {
        let budget = self.spent + budget;
        while let Some(growth) = self.meshes.growth(self.solved.len()) {
            if let Some(last) = self.solved.last() {
                let ends = last.level.estimated_error <= goal || !last.level.status.is_solved();
                if ends || !self.fits(growth, budget, memory) {
                    break;
                }
            }
            observe(self.solved.len(), self.solved.last());
            let next = self.next()?;
            self.solved.push(next);
        }
        Ok(())
    }

    /// Whether a mesh with `growth` times as many unknowns is within the limits, judged by the last one.
    fn fits(&self, growth: f64, budget: f64, memory: Option<f64>) -> bool {
        let Some(last) = self.solved.last() else {
            return true;
        };
        let before = self.solved.len().checked_sub(2).map(|k| &self.solved[k]);
        // Seconds of one mesh alone.
        let own = |n: usize| {
            let until = |n: usize| self.solved[n].level.cost.seconds;
            let before = n.checked_sub(1).filter(|_| self.kind.is_adaptive());
            until(n) - before.map_or(0.0, until)
        };
        let power = before.map_or(1.0, |before| {
            let seconds = own(self.solved.len() - 1) / own(self.solved.len() - 2);
            let unknowns = last.level.n_free as f64 / before.level.n_free as f64;
            (seconds.ln() / unknowns.ln()).clamp(1.0, TIME_POWER)
        });
        let seconds = own(self.solved.len() - 1) * growth.powf(power);
        let peak = last.level.cost.peak_bytes;
        let bytes = peak.map(|peak| peak * growth.powf(MEMORY_POWER));
        self.spent + seconds <= budget
            && memory.zip(bytes).is_none_or(|(most, bytes)| bytes <= most)
    }

    fn next(&mut self) -> Result<SolvedMesh, ProblemError> {
        let (n, folder) = (self.solved.len(), self.folder);
        let coarser = self.solved.last();
        let (mut solved, mut cost) = match &self.meshes {
            Meshes::Scenes(scenes) => {
                measure(CHEAP_SECONDS, || SolvedMesh::of_scene(&scenes[n], folder))?
            }
            Meshes::Halved(scene) => measure(CHEAP_SECONDS, || {
                let mut body = RefinableBody::new(scene, folder)?;
                for _ in 0..n {
                    let n_tetrahedra = body.n_tetrahedra();
                    body.refine(&vec![HALVES; n_tetrahedra]);
                }
                SolvedMesh::new(scene, body.mesh()?, None)
            })?,
            Meshes::Adaptive(scene) => {
                let refinement = &mut self.refinement;
                measure(-1.0, || {
                    let Some(coarse) = coarser else {
                        return SolvedMesh::of_scene(scene, folder);
                    };
                    let element = scene.body.element;
                    let target = Target {
                        estimated: coarse.estimated,
                        wanted: coarse.estimated * fall(element),
                        element,
                        achieved: None,
                    };
                    refinement
                        .levels
                        .push(RefinedLevel::Cuts(next_cuts(&coarse.indicator, target)));
                    let body = RefinableBody::refined(scene, folder, refinement)?;
                    SolvedMesh::new(scene, body.mesh()?, Some((coarse, body.parents())))
                })?
            }
        };
        self.spent += cost.seconds * cost.repeats as f64;
        if self.kind.is_adaptive() {
            cost.seconds = self.spent;
        }
        solved.level.cost = cost;
        Ok(solved)
    }
}

/// The fewest cells with the proportions of a brick on which each region has the volume that it has on the scene's own
/// mesh and parts of contact faces end between panes. On multiples of them boundaries of regions that are sides of tetrahedra stay so.
fn coarsest_with_regions(scene: &Scene, brick: &Brick) -> Result<[usize; 3], MeshError> {
    let base = proportions(brick);
    let fits = |cells: [usize; 3]| {
        with_cells(scene, cells)
            .body
            .as_brick()
            .is_none_or(|brick| contact_parts_fit(scene, brick))
    };
    let finer = (1..).map(|m| base.map(|n| n * m));
    let mut finer = finer.take_while(|cells| cells[0] < brick.cells[0]);
    if scene.regions.is_empty() {
        return Ok(finer.find(|cells| fits(*cells)).unwrap_or(brick.cells));
    }
    let own = region_volumes(scene)?;
    let whole: f64 = brick.size.iter().product();
    for cells in finer {
        // A coarse mesh may have no tetrahedron for a region at all.
        let Ok(volumes) = region_volumes(&with_cells(scene, cells)) else {
            continue;
        };
        if !fits(cells) {
            continue;
        }
        let differences = volumes.iter().zip(&own).map(|(a, b)| (a - b).abs());
        if differences.fold(0.0, f64::max) <= SAME_VOLUME * whole {
            return Ok(cells);
        }
    }
    Ok(brick.cells)
}

/// Volume of each region in m³ on a scene's own mesh.
fn region_volumes(scene: &Scene) -> Result<Vec<f64>, MeshError> {
    let mut body = scene.clone();
    // A mesh of the body alone: panes need not fit, nor clamps hold a node.
    body.body.element = ElementOrder::P1;
    body.contacts.clear();
    body.friction = None;
    body.clamps.clear();
    let mesh = Mesh::of_scene(&body, Path::new(""))?;
    let mut volumes = vec![0.0; scene.regions.len() + 1];
    for (nodes, region) in mesh.tetrahedra.iter().zip(&mesh.tetrahedron_region) {
        volumes[*region] += tetrahedron_volume(&mesh.corners(nodes));
    }
    Ok(volumes)
}

/// The share of the error that is left when unknowns grow by [`GROWTH`], at the best rate of the element.
fn fall(element: ElementOrder) -> f64 {
    let order = match element {
        ElementOrder::P1 => 1.0,
        ElementOrder::P2 => 2.0,
    };
    GROWTH.powf(-order / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The box of a region ends at a quarter of the height.
    #[test]
    fn meshes_on_which_regions_would_be_others_are_left_out() {
        let text = include_str!("../../../../../pipelines/regions.toml");
        let mut scene = Scene::parse("regions.toml", text).expect("a scene");
        let brick = scene.body.as_brick().expect("a brick").clone();
        assert_eq!(brick.cells, [24, 8, 8]);
        let found = coarsest_with_regions(&scene, &brick).expect("cells");
        assert_eq!(found, [12, 4, 4]);
        scene.regions.clear();
        let found = coarsest_with_regions(&scene, &brick).expect("cells");
        assert_eq!(found, [3, 1, 1]);
    }
}
