//! Works and energies of the increments of a history.

use super::StepRecord;
use crate::{
    contact::ContactFrame,
    elasticity::{Loads, ToolPlace},
    mesh::Mesh,
    post::{ContactReport, Solved, ToolState},
    scene::{FaceLoad, FacePart, InvalidValue, Scene, Traction},
};

/// Works and energies of one increment in J.
///
/// Loads, reactions and pressures act along a straight path from where the increment begins to where it ends, so their works are means
/// of both ends times the path, which is exact. The work of friction is that of the stresses at the end, as the conditions
/// of friction have it (backward Euler): never negative, and off by half the change of λ_t times the slip, which is the
/// [`Self::imbalance`] and falls with the increments.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepEnergies {
    /// Strain energy ½ uᵀAu at the end.
    pub strain: f64,
    /// Work of the loads, and of the clamps and tools that move.
    pub load_work: f64,
    /// Work ∫ ½ (λ_ν⁰ ν⁰ + λ_ν ν) · Δu on the foundation, against tools that move with them, by pressures and normals of both ends: over gaps that
    /// open and close, and along curved tools that slide, where it falls with the increments.
    pub normal_work: f64,
    /// Dissipated by friction: ∫ λ_t · Δu_t with λ_t at the end.
    pub dissipation: f64,
    /// Work of the loads less what became strain energy, work on the foundation and dissipation.
    pub imbalance: f64,
}

impl StepEnergies {
    /// Those of an increment without a solution.
    pub(super) const NONE: Self = Self {
        strain: f64::NAN,
        load_work: f64::NAN,
        normal_work: f64::NAN,
        dissipation: f64::NAN,
        imbalance: f64::NAN,
    };
}

/// What drives the body, tractions, pressures and clamps that move, or the body force where there are none, and what the works of the next
/// increment need of the last one.
pub(crate) struct EnergyLedger {
    /// Clamps that move, by their places.
    clamps: Vec<usize>,
    /// Keys of the sources.
    sources: Vec<String>,
    /// ∫ φ_k over their faces in m², with the nodes; one for every node where they have none.
    shares: Vec<(usize, f64)>,
    /// Forces of the loads on the nodes at the end of the last increment in N; `None` before the first.
    forces: Option<Vec<[f64; 3]>>,
    /// Normals and axes of the contact face in the last increment; `None` before the first, and without contact.
    frame: Option<ContactFrame>,
}

impl EnergyLedger {
    /// Begins after the last of `records` of the history of a scene, in which the contact face had a frame.
    pub(crate) fn new(
        history: &Scene,
        mesh: &Mesh,
        records: &[StepRecord],
        frame: Option<ContactFrame>,
    ) -> Result<Self, InvalidValue> {
        let forces = |last: &StepRecord| {
            let scene = history.at_increment(last.increment)?;
            Loads::of(&scene).nodal_forces(mesh)
        };
        let clamps = history.moved_clamps()?;
        let held = clamps.iter().filter_map(|&clamp| {
            let clamp = &history.clamps[clamp];
            Some(FacePart {
                face: clamp.face.as_deref()?,
                corners: clamp.corners,
                disc: None,
            })
        });
        let loaded = history.face_loads().map(|load| load.part());
        let mut parts: Vec<FacePart<'_>> = Vec::new();
        for part in loaded.chain(held) {
            if !parts.contains(&part) {
                parts.push(part);
            }
        }
        parts.sort_by_key(|part| part.face);
        let mut sources: Vec<String> = history.face_loads().map(|load| load.key()).collect();
        sources.extend(clamps.iter().map(|clamp| format!("clamp.{clamp}")));
        if sources.is_empty() {
            sources.push("body_force".into());
        }
        let ones: Vec<Traction> = parts
            .into_iter()
            .map(|part| Traction {
                corners: part.corners,
                disc: part.disc,
                ..Traction::on(part.face, [1.0, 0.0, 0.0])
            })
            .collect();
        let ones = ones.iter().enumerate();
        let unit = Loads {
            faces: ones.map(|(i, one)| FaceLoad::Traction(i, one)).collect(),
            body_force: None,
        };
        let shares = unit.nodal_forces(mesh)?.into_iter().enumerate();
        let mut shares: Vec<(usize, f64)> = shares
            .map(|(node, [share, _, _])| (node, share))
            .filter(|(_, share)| *share != 0.0)
            .collect();
        if shares.is_empty() {
            shares = (0..mesh.coordinates.len())
                .map(|node| (node, 1.0))
                .collect();
        }
        Ok(Self {
            clamps,
            sources,
            shares,
            forces: records.last().map(forces).transpose()?,
            frame,
        })
    }

    /// The record of an increment with what it did, which the one before precedes.
    pub(crate) fn record(
        &mut self,
        mut record: StepRecord,
        solved: &Solved<'_>,
        before: Option<&StepRecord>,
        report: &ContactReport,
    ) -> Result<StepRecord, InvalidValue> {
        self.add_driving(&mut record, report);
        let moved_at = |node: usize| {
            let from = before.map_or([0.0; 3], |before| before.displacement[node]);
            let to = record.displacement[node];
            [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
        };
        let forces = Loads::of(solved.scene).nodal_forces(solved.mesh)?;
        let work = |forces: &[[f64; 3]], earlier: Option<&Vec<[f64; 3]>>| -> f64 {
            let works = forces.iter().enumerate().map(|(node, force)| {
                let earlier = earlier.map_or([0.0; 3], |forces| forces[node]);
                let moved = moved_at(node);
                let works = (0..3).map(|c| 0.5 * (force[c] + earlier[c]) * moved[c]);
                works.sum::<f64>()
            });
            works.sum()
        };
        let tools_before = before.map_or_else(
            || vec![ToolState::default(); record.tools.len()],
            |before| before.tools.clone(),
        );
        let tools = || record.tools.iter().zip(&tools_before);
        let tool_work: f64 = tools().map(|(to, from)| to.work_since(from)).sum();
        let load_work = work(&forces, self.forces.as_ref())
            + work(&record.reaction, before.map(|before| &before.reaction))
            + tool_work;
        let places = ToolPlace::of_scene(solved.scene, solved.mesh);
        let tool_rows = tools().zip(&places).flat_map(|((to, from), place)| {
            let moved = |to: [f64; 3], from: [f64; 3]| [0, 1, 2].map(|c| to[c] - from[c]);
            place.rows([
                moved(to.displacement, from.displacement),
                moved(to.turn, from.turn),
            ])
        });
        let tool_rows: Vec<[f64; 3]> = tool_rows.collect();
        let face = solved.contact.map(|contact| contact.state);
        let normal_work = face.map_or(0.0, |face| {
            let surface = face.surface;
            let along = |frame: &ContactFrame, pressures: &[f64]| -> f64 {
                let panes = (0..face.n_panes()).map(|pane| {
                    let [normal, ..] =
                        frame.pane_relative(surface, pane, moved_at, |row| tool_rows[row]);
                    0.5 * pressures[pane] * surface.pane_area[pane] * normal
                });
                panes.sum()
            };
            let earlier = before.zip(self.frame.as_ref());
            let earlier = earlier.map_or(0.0, |(it, frame)| along(frame, &it.multiplier));
            earlier + along(&face.interface.frame, &record.multiplier)
        });
        self.frame = face.map(|face| face.interface.frame.clone());
        let taken = |pane: usize, area: f64| {
            let friction = report.panes[pane].friction.as_ref()?;
            let [stress, slip] = [friction.stress, friction.slip];
            Some(area * (-stress[0] * slip[0] - stress[1] * slip[1]))
        };
        record.face_dissipation = face.map_or_else(Vec::new, |face| {
            let areas = &face.surface.pane_area;
            let faces = face.surface.faces.iter();
            faces
                .map(|face| {
                    face.panes
                        .clone()
                        .filter_map(|pane| taken(pane, areas[pane]))
                        .sum()
                })
                .collect()
        });
        let dissipation: f64 = record.face_dissipation.iter().sum();
        let strain = report.resultants.strain_energy;
        let stored = strain - before.map_or(0.0, |before| before.energies.strain);
        record.energies = StepEnergies {
            strain,
            load_work,
            normal_work,
            dissipation,
            imbalance: load_work - stored - normal_work - dissipation,
        };
        self.forces = Some(forces);
        Ok(record)
    }

    /// Adds force, displacement and, where clamps move, reactions to a record.
    fn add_driving(&self, record: &mut StepRecord, report: &ContactReport) {
        record.loaded_displacement = mean(&self.shares, &record.displacement);
        let driving = report
            .forces
            .iter()
            .filter(|force| self.sources.contains(&force.source));
        record.loaded_force = driving.fold([0.0; 3], |sum, source| {
            std::array::from_fn(|c| sum[c] + source.force[c])
        });
        if !self.clamps.is_empty() {
            record.reaction.clone_from(&report.reaction);
        }
    }
}

/// The mean of nodal vectors with given weights.
fn mean(shares: &[(usize, f64)], vectors: &[[f64; 3]]) -> [f64; 3] {
    let whole: f64 = shares.iter().map(|(_, share)| share).sum();
    [0, 1, 2].map(|c| {
        let parts = shares.iter().map(|(node, share)| share * vectors[*node][c]);
        parts.sum::<f64>() / whole
    })
}
