//! What one increment of a history leaves.

use super::StepEnergies;
use crate::{
    post::{ContactReport, FunctionalEstimate, Solved, Zone},
    scene::{Functional, Increment},
    solver::{SolvedBy, Status},
};

/// One increment of a history: what the next one begins from, and what a table, a chart or a film shows of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepRecord {
    /// Which one.
    pub increment: Increment,
    /// How its solve ended.
    pub status: Status,
    /// Which algorithm gave the solution.
    pub solved_by: SolvedBy,
    /// Relative error of λ, as [`Solution::accuracy`](crate::solver::Solution::accuracy).
    pub accuracy: f64,
    /// Applications of A⁻¹ or S.
    pub applications: usize,
    /// The largest figure of the certificate.
    pub certificate: f64,
    /// h with the slip counted from where the increment begins, `[n_multipliers]`, in m³.
    pub dual_rhs: Vec<f64>,
    /// λ, `[n_multipliers]`, in Pa.
    pub multiplier: Vec<f64>,
    /// u, `[n_nodes]`, in m.
    pub displacement: Vec<[f64; 3]>,
    /// Von Mises stress, `[n_tetrahedra]`, in Pa.
    pub von_mises: Vec<f64>,
    /// Signed (u_t1, u_t2) since the first step began, `[n_contact_nodes]`, in m; empty without friction.
    pub tangential: Vec<[f64; 2]>,
    /// Lengths of the path of sliding along t₁, along t₂ and in the plane, `[n_contact_nodes]`, in m; empty without friction.
    pub path: Vec<[f64; 3]>,
    /// `[n_panes]`.
    pub panes: Vec<StepPane>,
    /// Forces of the clamps on the nodes, `[n_nodes]`, in N; empty where all clamps hold at zero in all steps.
    pub reaction: Vec<[f64; 3]>,
    /// Forces on the body in N by their sources, in the order of [`ContactReport::forces`].
    pub forces: Vec<[f64; 3]>,
    /// Loads in N.
    pub applied_force: [f64; 3],
    /// Reaction of the clamps in N.
    pub clamp_force: [f64; 3],
    /// Force of the foundation on the body in N; zero without contact.
    pub contact_force: [f64; 3],
    /// Total of λ_ν and λ_t over the face in N, zero where there is none.
    pub multiplier_force: [f64; 3],
    /// Force on the body in N of tractions, pressures and clamps that move; of the body force where there are none.
    pub loaded_force: [f64; 3],
    /// Mean displacement in m of the faces that they act on; of all nodes where there are none.
    pub loaded_displacement: [f64; 3],
    /// Mean of (u_t1, u_t2) over the contact face in m; zero without friction.
    pub contact_displacement: [f64; 2],
    /// Energy that friction took on each contact face in J, `[n_contact_faces]`.
    pub face_dissipation: Vec<f64>,
    /// The energies of the increment.
    pub energies: StepEnergies,
    /// η_T² in J, the estimated discretisation error given the increments before, `[n_tetrahedra]`; empty unless the scene asks for an error.
    pub error_energy: Vec<f64>,
    /// Quantities with their errors, likewise; those of the increment that are not zero.
    pub quantities: Vec<FunctionalEstimate>,
}

/// One pane at the end of an increment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepPane {
    /// What it does.
    pub zone: Zone,
    /// Mean gap d − u_ν in m.
    pub gap: f64,
    /// Mean slip of the increment in m; zero without friction.
    pub slip: [f64; 2],
    /// (F₁, F₂); NaN without Coulomb's law.
    pub coefficients: [f64; 2],
}

impl StepRecord {
    /// Numbers of open, sticking and slipping panes.
    #[must_use]
    pub fn zone_counts(&self) -> [usize; 3] {
        let count = |zone| self.panes.iter().filter(|pane| pane.zone == zone).count();
        [Zone::Open, Zone::Stick, Zone::Slip].map(count)
    }

    /// A quantity with its error; `None` where it is absent or zero.
    #[must_use]
    pub fn quantity(&self, functional: Functional) -> Option<&FunctionalEstimate> {
        let mut all = self.quantities.iter();
        all.find(|it| it.functional == functional && it.value != 0.0)
    }

    /// The record of a solved increment, but for its works; `dual_rhs` is its h.
    pub(crate) fn new(
        increment: Increment,
        solved: &Solved<'_>,
        dual_rhs: &[f64],
        report: &ContactReport,
    ) -> Self {
        let solution = solved.solution;
        let face = solved.contact.map(|contact| contact.state);
        let face = face.filter(|face| face.interface.has_friction());
        let face = face.map(|face| (face.interface, face.surface));
        let tangential: Vec<[f64; 2]> = face.map_or_else(Vec::new, |(interface, surface)| {
            let nodes = surface.nodes.iter().enumerate();
            nodes
                .map(|(local, &node)| interface.frame.tangential(local, report.displacement[node]))
                .collect()
        });
        let resultants = &report.resultants;
        let contact = resultants.contact.as_ref();
        let indicator = &report.discretisation_error.indicator;
        let indicator = indicator.iter().filter(|_| solved.scene.adapt.is_some());
        Self {
            increment,
            status: solution.status,
            solved_by: solution.trace.solved_by,
            accuracy: solution.accuracy,
            applications: solution.trace.applications,
            certificate: report.certificate.worst(),
            dual_rhs: dual_rhs.to_vec(),
            multiplier: solution.multiplier.clone(),
            displacement: report.displacement.clone(),
            von_mises: report.von_mises.clone(),
            path: face.map_or_else(Vec::new, |(interface, _)| interface.path_after(&tangential)),
            panes: report.panes.iter().map(StepPane::of).collect(),
            reaction: Vec::new(),
            forces: report.forces.iter().map(|source| source.force).collect(),
            applied_force: resultants.applied_force,
            clamp_force: resultants.clamp_force,
            contact_force: contact.map_or([0.0; 3], |contact| contact.contact_force),
            multiplier_force: contact.map_or([0.0; 3], |contact| {
                let [first, second] = contact.tangential_force.unwrap_or_default();
                [contact.normal_force, first, second]
            }),
            loaded_force: [0.0; 3],
            loaded_displacement: [0.0; 3],
            contact_displacement: face.map_or([0.0; 2], |(_, surface)| {
                let areas = &surface.pane_area;
                let whole: f64 = areas.iter().sum();
                [0, 1].map(|k| {
                    let values: Vec<f64> = tangential.iter().map(|u| u[k]).collect();
                    let panes = areas.iter().enumerate();
                    let integral: f64 = panes
                        .map(|(pane, area)| area * surface.pane_mean(pane, &values))
                        .sum();
                    integral / whole
                })
            }),
            tangential,
            face_dissipation: Vec::new(),
            energies: StepEnergies::default(),
            error_energy: indicator.map(|eta| eta * eta).collect(),
            quantities: report.functionals.clone(),
        }
    }
}

impl StepPane {
    fn of(pane: &crate::post::PaneState) -> Self {
        let friction = pane.friction.as_ref();
        Self {
            zone: pane.zone,
            gap: pane.gap,
            slip: friction.map_or([0.0; 2], |friction| friction.slip),
            coefficients: friction
                .and_then(|friction| friction.coulomb)
                .map_or([f64::NAN; 2], |coulomb| coulomb.coefficients),
        }
    }
}
