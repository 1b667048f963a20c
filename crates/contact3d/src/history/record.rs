//! What one increment of a history leaves, and how far the increments on one mesh lie from the body, by one measure for all of them.

use super::StepEnergies;
use crate::{
    post::{ContactReport, FunctionalEstimate, MAX_RELIABLE_ESTIMATE, Solved, ToolState, Zone},
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
    /// Von Mises stress at the nodes of each material, `[n_material_nodes]`, in Pa.
    pub von_mises: Vec<f64>,
    /// Signed (u_t1, u_t2) since the first step began, `[n_contact_nodes]`, in m; empty without friction.
    pub tangential: Vec<[f64; 2]>,
    /// (u_t1, u_t2) that the slip of the increment is counted from, `[n_contact_nodes]`, in m; empty where no face with friction is curved.
    pub slip_origin: Vec<[f64; 2]>,
    /// Lengths of the path of sliding along t₁, along t₂ and in the plane, `[n_contact_nodes]`, in m; empty without friction.
    pub path: Vec<[f64; 3]>,
    /// `[n_panes]`.
    pub panes: Vec<StepPane>,
    /// `[n_tools]`.
    pub tools: Vec<ToolState>,
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
    /// What an increment is loaded by: strain energy in J, the largest von Mises stress in Pa, the normal force in N.
    pub const LOADS: [fn(&Self) -> f64; 3] = [
        |record| record.energies.strain,
        |record| largest(record.von_mises.iter().copied()),
        |record| record.multiplier_force[0],
    ];

    /// The increments with a solution: all but the last where that has none.
    #[must_use]
    pub fn solved(records: &[Self]) -> &[Self] {
        match records {
            [solved @ .., last] if !last.status.is_solved() => solved,
            all => all,
        }
    }

    /// The record with NaN for forces, means and energies where the increment has no solution.
    pub(crate) fn known_part(self) -> Self {
        if self.status.is_solved() {
            return self;
        }
        let none = [f64::NAN; 3];
        let [clamp_force, contact_force, multiplier_force, loaded_force] = [none; 4];
        Self {
            forces: vec![none; self.forces.len()],
            clamp_force,
            contact_force,
            multiplier_force,
            loaded_force,
            loaded_displacement: none,
            contact_displacement: [f64::NAN; 2],
            face_dissipation: vec![f64::NAN; self.face_dissipation.len()],
            energies: StepEnergies::NONE,
            ..self
        }
    }

    /// The place of the solved increment with the largest load of a kind, of the last of equal ones.
    #[must_use]
    pub fn loaded_most(records: &[Self], load: fn(&Self) -> f64) -> usize {
        let loads = Self::solved(records).iter().map(load).enumerate();
        let most = loads.max_by(|(_, a), (_, b)| a.total_cmp(b));
        most.map_or(0, |(place, _)| place)
    }

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

    /// The record of a solved increment, but for its works and the origin of its slip; `dual_rhs` is its h.
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
            let dofs = &solved.system.dofs;
            let at_row = |row| dofs.at_node(row, &solution.displacement);
            interface.frame.nodal_tangential(surface, dofs, at_row)
        });
        let pane_tangential = face.map_or_else(Vec::new, |(interface, surface)| {
            let at_node = |node: usize| report.displacement[node];
            interface.pane_tangential(surface, &tangential, at_node)
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
            slip_origin: Vec::new(),
            panes: report.panes.iter().map(StepPane::of).collect(),
            tools: report.tools.clone(),
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
                    let panes = areas.iter().zip(&pane_tangential);
                    let integral: f64 = panes.map(|(area, mean)| area * mean[k]).sum();
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

/// The estimated errors of the increments of a history, all over the largest size in it: an increment that hardly deforms the body, or
/// in which a quantity passes through zero, has a large error over its own size, which says nothing of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryErrors {
    /// Estimate of each increment over the largest size, `[n_increments]`; NaN where it has none.
    pub relative: Vec<f64>,
    /// The largest that each tetrahedron contributes in any increment, `[n_tetrahedra]`: η_T in √J, of a quantity |share| in its unit.
    pub indicator: Vec<f64>,
}

/// The largest ‖u_h‖_A in √J over some increments.
#[must_use]
pub fn largest_norm(records: &[StepRecord]) -> f64 {
    let norms = records.iter().map(|record| 2.0 * record.energies.strain);
    norms.fold(0.0, f64::max).sqrt()
}

impl HistoryErrors {
    /// Those of the displacement in the energy norm, over the largest ‖u_h‖_A, or of a quantity, over its largest size; `None` where
    /// no increment has an estimate. Quantities of a displacement with an error of half of itself have that error.
    #[must_use]
    pub fn new(records: &[StepRecord], of: Option<Functional>) -> Option<Self> {
        let of_displacement = Self::of_displacement(records);
        let is_unreliable = |errors: &Self| errors.largest() >= MAX_RELIABLE_ESTIMATE;
        let Some(of) = of.filter(|_| !of_displacement.as_ref().is_some_and(is_unreliable)) else {
            return of_displacement;
        };
        let found = records.iter().map(|record| record.quantity(of));
        let found: Vec<Option<&FunctionalEstimate>> = found.collect();
        let size = largest(found.iter().flatten().map(|it| it.value.abs()));
        let bar = |it: &Option<&FunctionalEstimate>| {
            it.map_or(f64::NAN, |it| it.relative() * it.value.abs() / size)
        };
        let shares = found.iter().flatten().map(|it| &it.indicator);
        (size > 0.0).then(|| Self {
            relative: found.iter().map(bar).collect(),
            indicator: envelope(shares, f64::abs),
        })
    }

    fn of_displacement(records: &[StepRecord]) -> Option<Self> {
        let errors = records
            .iter()
            .map(|record| record.error_energy.iter().sum::<f64>().sqrt());
        // Of a body at rest that misses its contact the error is all of the solution.
        let size = largest_norm(records).max(largest(errors.clone()));
        let relative = |error: f64| if error == 0.0 { 0.0 } else { error / size };
        let is_estimated = records.iter().any(|record| !record.error_energy.is_empty());
        is_estimated.then(|| Self {
            relative: errors.map(relative).collect(),
            indicator: envelope(records.iter().map(|record| &record.error_energy), f64::sqrt),
        })
    }

    /// The largest estimate of an increment: that of the mesh.
    #[must_use]
    pub fn largest(&self) -> f64 {
        largest(self.relative.iter().copied())
    }
}

/// The largest of some numbers, NaN left out; 0 of none.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// The largest size that each entry has in any of some lists.
fn envelope<'a>(lists: impl Iterator<Item = &'a Vec<f64>>, size: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut most = Vec::new();
    for list in lists {
        most.resize(list.len(), 0.0_f64);
        let both = most.iter_mut().zip(list);
        both.for_each(|(most, value)| *most = most.max(size(*value)));
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::StepEnergies;

    fn record(strain: f64, squares: [f64; 2]) -> StepRecord {
        StepRecord {
            error_energy: squares.to_vec(),
            energies: StepEnergies {
                strain,
                ..StepEnergies::default()
            },
            ..StepRecord::default()
        }
    }

    /// An increment with half its norm as error, but hardly any norm, does not count; the envelope takes the worst of each tetrahedron.
    #[test]
    fn an_increment_of_hardly_any_deformation_does_not_count() {
        let records = [
            record(8.0, [0.16, 0.0]),
            record(8e-6, [0.0, 4e-6]),
            record(4.5, [0.09, 0.16]),
        ];
        let errors = HistoryErrors::new(&records, None).expect("estimates");
        // Roots of numbers that are no binary fractions: some roundings.
        let near = |found: f64, expected: f64| (found - expected).abs() <= 1e-15;
        let expected = [0.1, 5e-4, 0.125];
        let mut pairs = errors.relative.iter().zip(expected);
        assert!(
            pairs.all(|(found, expected)| near(*found, expected)),
            "{errors:?}"
        );
        assert!(near(errors.largest(), 0.125));
        assert_eq!(errors.indicator, [0.4, 0.4]);
        assert_eq!(HistoryErrors::new(&[StepRecord::default()], None), None);
    }

    /// What a quantity is in some increments is measured by its largest value, whatever its sign.
    #[test]
    fn quantities_are_measured_by_their_largest_value() {
        let force = |value: f64, bar: f64, shares: [f64; 2]| StepRecord {
            quantities: vec![FunctionalEstimate {
                functional: Functional::NormalForce,
                value,
                signed_error: bar,
                range: [value - bar, value + bar],
                corners: None,
                kinks: 0,
                indicator: shares.to_vec(),
            }],
            ..StepRecord::default()
        };
        let records = [
            force(0.5, 0.25, [0.25, 0.0]),
            StepRecord::default(),
            force(-4.0, 1.0, [-0.75, -0.25]),
        ];
        let errors = HistoryErrors::new(&records, Some(Functional::NormalForce));
        let errors = errors.expect("estimates");
        assert_eq!(errors.relative[0], 0.0625);
        assert!(errors.relative[1].is_nan());
        assert_eq!(errors.largest(), 0.25);
        assert_eq!(errors.indicator, [0.75, 0.25]);
    }
}
