//! Load histories: problems solved one after the other, each from where the one before left the body.
//!
//! Quasi-static friction in backward differences: in step n the conditions of friction hold for the slip
//! u_tⁿ − u_tⁿ⁻¹ of the step. In the dual problem that moves h_t by −T uⁿ⁻¹ ([`crate::contact::Past`]) and nothing else, so
//! all steps share the factor, S and the compliance of the contact face. Coefficients follow the total slip, that of the step, or
//! the path of sliding, as [`crate::scene::SlipMeasure`] says.

mod energies;
mod record;

pub use energies::StepEnergies;
pub use record::{StepPane, StepRecord};

use energies::Bookkeeping;

use crate::{
    contact::{Interface, Past},
    dual::{Admission, DualSystem, Observation},
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    scene::{Increment, Invalid, Scene, SolveSettings},
    solver::{ContactState, Goal, NeedsExplicit, Progress, Solution, Start, solve},
};

use thiserror::Error;

/// A scene with steps on its mesh, and the operators that all of them share.
#[derive(Debug, Clone, Copy)]
pub struct LoadHistory<'a> {
    /// The scene with its steps.
    pub scene: &'a Scene,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// The assembled problem, whatever its loads.
    pub operator: &'a DualSystem,
}

/// The problem of one increment.
#[derive(Debug)]
pub struct StepProblem {
    /// The scene without steps, with the loads of the increment.
    pub scene: Scene,
    /// The laws of the contact face, which know where the increment begins; `None` without contact.
    pub interface: Option<Interface>,
    /// The assembled problem with the loads of the increment.
    pub system: DualSystem,
}

/// A history as far as it was solved.
#[derive(Debug)]
pub struct SolvedHistory {
    /// One record for each increment that was solved; the last one may have failed.
    pub records: Vec<StepRecord>,
    /// The problem of the last increment that was solved.
    pub problem: StepProblem,
    /// Its solution.
    pub solution: Solution,
    /// What follows from it.
    pub report: ContactReport,
}

/// Why a history cannot be solved; steps that do not converge are a status.
#[derive(Debug, Error)]
pub enum HistoryError {
    /// A value that no problem can have.
    #[error("{}: expected {}, found {}; {}", .0.key, .0.expected, .0.found, .0.help)]
    Invalid(Invalid),
    /// A method that needs the dense operator.
    #[error(transparent)]
    NeedsExplicit(#[from] NeedsExplicit),
}

impl From<Invalid> for HistoryError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl<'a> LoadHistory<'a> {
    /// The problem of an increment that begins where `before` ended.
    ///
    /// # Errors
    /// Loads, gaps and laws that no problem can have.
    pub fn problem(
        &self,
        increment: Increment,
        before: Option<&StepRecord>,
    ) -> Result<StepProblem, Invalid> {
        let scene = self.scene.at_increment(increment)?;
        let interface = interface_after(self.scene, &scene, self.mesh, before)?;
        let mut system = self.operator.clone();
        system.apply(&scene, self.mesh, interface.as_ref())?;
        Ok(StepProblem {
            scene,
            interface,
            system,
        })
    }

    /// Solves the increments that follow those of `records`, each from the multipliers of the one before, the first from
    /// `start`, until one fails. `observe` sees the steps of the solver with the increment they belong to, `keep` all records after
    /// each increment. The settings are those of every solve.
    ///
    /// Records hold all that the next increment depends on, so a history that goes on from some of them has the bits of one that
    /// was never stopped. The last increment of a complete history is solved again.
    ///
    /// # Errors
    /// A value that no problem can have, a method that needs the dense operator.
    pub fn solve(
        &self,
        settings: &SolveSettings,
        mut records: Vec<StepRecord>,
        start: Start<'_>,
        observe: &mut dyn FnMut(Increment, Progress<'_>),
        keep: &mut dyn FnMut(&[StepRecord]),
    ) -> Result<SolvedHistory, HistoryError> {
        let increments = self.scene.increments();
        records.truncate(increments.len().saturating_sub(1));
        let mut books = Bookkeeping::new(self, &records)?;
        loop {
            let increment = increments[records.len()];
            let problem = self.problem(increment, records.last())?;
            let from = match records.last() {
                None => start,
                Some(before) => Start {
                    multiplier: Some(&before.multiplier),
                    checkpoint: None,
                },
            };
            let mut solution = solve(
                &problem.system,
                problem.contact(self.mesh).as_ref(),
                settings,
                from,
                &mut |progress| observe(increment, progress),
            )?;
            let report = problem.report(self.mesh, &solution)?;
            report.judge(&mut solution);
            let mut record = StepRecord::new(self, &problem, increment, &solution, &report);
            books.enter(&problem, &mut record, records.last(), &report)?;
            records.push(record);
            let failed = !solution.status.is_success(Goal::of(settings));
            if failed || records.len() == increments.len() {
                return Ok(SolvedHistory {
                    records,
                    problem,
                    solution,
                    report,
                });
            }
            keep(&records);
        }
    }
}

impl LoadHistory<'_> {
    /// The operators in double precision that a history goes on with after [`SolvedHistory::records_before`] its last increment,
    /// whose solve gave up with a factor in single precision that the program chose.
    #[must_use]
    pub fn reconsidered(
        &self,
        solved: &SolvedHistory,
        settings: &SolveSettings,
        admit: Admission<'_>,
        begun: Observation<'_>,
    ) -> Option<DualSystem> {
        let gave_up = solved.solution.status.gave_up(settings);
        gave_up
            .then(|| {
                self.operator
                    .in_double_precision(self.scene, self.mesh, admit, begun)
            })
            .flatten()
    }
}

impl SolvedHistory {
    /// The records without that of the last increment.
    #[must_use]
    pub fn records_before(mut self) -> Vec<StepRecord> {
        self.records.pop();
        self.records
    }
}

/// The laws of the contact face in the increment `scene` of a history, which begins where `before` ended; `None` without
/// contact.
///
/// # Errors
/// Laws that no problem can have.
pub fn interface_after(
    history: &Scene,
    scene: &Scene,
    mesh: &Mesh,
    before: Option<&StepRecord>,
) -> Result<Option<Interface>, Invalid> {
    let interface = Interface::new(scene, mesh)?;
    Ok(match (interface, before) {
        (Some(interface), Some(before)) if interface.has_friction() => {
            Some(interface.after(Past {
                tangential: before.tangential.clone(),
                path: before.path.clone(),
                follows: history.slip_measure(),
            }))
        }
        (interface, _) => interface,
    })
}

impl StepProblem {
    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact<'b>(&'b self, mesh: &'b Mesh) -> Option<ContactState<'b>> {
        Some(ContactState {
            surface: mesh.contact.as_ref()?,
            interface: self.interface.as_ref()?,
        })
    }

    /// Zones, stresses, resultants and certificate of a solution.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn report(&self, mesh: &Mesh, solution: &Solution) -> Result<ContactReport, Invalid> {
        let contact = self.system.contact.as_ref().zip(self.contact(mesh));
        ContactReport::new(&Solved {
            scene: &self.scene,
            mesh,
            system: &self.system.assembly.primal,
            contact: contact.map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
            solution,
        })
    }
}
