//! The driver from an assembled problem to an assessed solution: static or increment by increment.

use super::{AssembledProblem, Checkpoint, Problem, ProblemError, RunStep, RunStorage};
use crate::{
    contact::{PASSES, tool_rows},
    dual::AssemblyError,
    history::{EnergyLedger, StepRecord},
    post::{ContactReport, EstimatedErrors, StressRecovery},
    scene::{Increment, InvalidValue, SlipMeasure, SolveSettings},
    solver::{Adjoint, ContactProblem, ContactSide, LinearFunctional, Progress, Solution, Start},
};

/// What a solve came to.
#[derive(Debug)]
pub struct SolvedProblem {
    /// The problem that was solved: of a load history the last increment that was tried.
    pub problem: AssembledProblem,
    /// Its solution.
    pub solution: Solution,
    /// What follows from it.
    pub report: ContactReport,
    /// One record for each increment of a load history that was solved, of which the last may have failed; none without a history.
    pub records: Vec<StepRecord>,
}

impl AssembledProblem {
    /// Solves the problem from a start, a scene with steps increment by increment after those of `done`, each from the
    /// multipliers of the one before, until one fails. `settings` replace those of the scene.
    ///
    /// Records hold all that the next increment depends on, so a history that goes on from some of them has the bits of one that
    /// was never stopped. The last increment of a complete history is solved again.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a value that no problem can have, [`ProblemError::NeedsExplicit`] for a method that needs the dense operator.
    pub fn run(
        &self,
        settings: &SolveSettings,
        start: Start<'_>,
        done: Vec<StepRecord>,
        storage: &mut dyn RunStorage,
    ) -> Result<SolvedProblem, ProblemError> {
        self.run_evaluated(settings, start, done, EstimatedErrors::Quantities, storage)
    }

    pub(super) fn run_evaluated(
        &self,
        settings: &SolveSettings,
        start: Start<'_>,
        mut records: Vec<StepRecord>,
        errors: EstimatedErrors,
        storage: &mut dyn RunStorage,
    ) -> Result<SolvedProblem, ProblemError> {
        let solved = |problem, (solution, report), records| SolvedProblem {
            problem,
            solution,
            report,
            records,
        };
        if !self.scene().has_history() {
            let contact = self.contact_problem();
            let contact = contact.as_ref();
            let solution = self.solution(contact, settings, start, None, storage)?;
            let recovery = StressRecovery::new(self.mesh());
            let evaluation = (errors, &recovery);
            let assessed = self.assessed(contact, solution, settings, evaluation, false)?;
            return Ok(solved(self.clone(), assessed, Vec::new()));
        }
        let increments = self.scene().increments();
        records.truncate(increments.len().saturating_sub(1));
        if let Some(last) = records.last() {
            let counts = [records.len(), increments.len()];
            storage.observe(RunStep::Resuming(last.increment, counts));
        }
        let recovery = StressRecovery::new(self.mesh());
        let along_curves = self.closes_along_curves();
        let last = match records.as_slice() {
            [] => None,
            done => self.problem.after_increments(done)?.interface,
        };
        let frame = last.map(|interface| interface.frame);
        let mut ledger = EnergyLedger::new(self.scene(), self.mesh(), &records, frame)?;
        // An increment that is solved again, with the solution and the number of solves before.
        let mut again: Option<(Self, Solution, usize)> = None;
        loop {
            let increment = increments[records.len()];
            let is_last = records.len() + 1 == increments.len();
            let errors = match self.scene().adapt {
                Some(_) => errors,
                None if is_last => EstimatedErrors::Energy,
                None => EstimatedErrors::Nothing,
            };
            let before = records.last();
            let (problem, last) = match again.take() {
                None => (self.at_increment(increment, before)?, None),
                Some((problem, last, passes)) => (problem, Some((last, passes))),
            };
            let contact = problem.contact_problem();
            let contact = contact.as_ref();
            let from = match (&last, before) {
                (Some((last, _)), _) => Start::at(&last.multiplier),
                (None, Some(before)) => Start::at(&before.multiplier),
                (None, None) => start,
            };
            let found = problem.solution(contact, settings, from, Some(increment), storage)?;
            let (solution, passes) = match last {
                None => (found, 1),
                Some((last, passes)) => (found.after(last.trace), passes + 1),
            };
            let along_curves = match self.scene().follows_tools() {
                true => problem.closes_along_curves(),
                false => along_curves,
            };
            if along_curves && passes < PASSES && solution.status.is_success(settings) {
                let follows = self.scene().slip_measure();
                if let Some(next) = problem.counted_from_touch(&solution, before, follows)? {
                    again = Some((next, solution, passes));
                    continue;
                }
            }
            let evaluation = (errors, &recovery);
            let assessed = problem.assessed(contact, solution, settings, evaluation, !is_last)?;
            let (solution, report) = &assessed;
            let dual = problem.system.contact.as_ref();
            let dual_rhs = dual.map_or(&[][..], |contact| contact.dual_rhs());
            let of = problem.solved(solution);
            let mut record = StepRecord::new(increment, &of, dual_rhs, report);
            if let Some(ContactSide { surface, interface }) =
                problem.contact_side().filter(|_| along_curves)
            {
                let nodes = 0..surface.nodes.len();
                record.slip_origin = nodes.map(|node| interface.slip_origin(node)).collect();
            }
            let record = ledger.record(record, &of, before, report)?;
            records.push(record.known_part());
            let failed = !solution.status.is_success(settings);
            if failed || is_last {
                return Ok(solved(problem, assessed, records));
            }
            storage.checkpoint(Checkpoint::History(&records));
        }
    }

    /// Whether panes of its contact faces with friction may close along other directions than one normal of all.
    fn closes_along_curves(&self) -> bool {
        let interface = self.problem.interface();
        interface.is_some_and(|interface| interface.closes_along_curves(self.mesh()))
    }

    /// The increment with its slip counted from where nodes of curved faces touch, as a solution of it has it; `None` where none does.
    fn counted_from_touch(
        &self,
        solution: &Solution,
        before: Option<&StepRecord>,
        follows: SlipMeasure,
    ) -> Result<Option<Self>, InvalidValue> {
        let (scene, mesh, dofs) = (self.scene(), self.mesh(), &self.system.assembly.primal.dofs);
        let Some(ContactSide { surface, interface }) = self.contact_side() else {
            return Ok(None);
        };
        let tools = dofs.tool_rows(&solution.displacement);
        let at_node = |node| dofs.at_node(node, &solution.displacement);
        let after = interface.state_at(surface, at_node, &tools, &solution.multiplier);
        let before = match before {
            None => interface.state_at(surface, |_| [0.0; 3], &vec![[0.0; 3]; tools.len()], &[]),
            Some(record) => {
                let tools = record.tools.iter();
                let motions: Vec<_> = tools.map(|tool| [tool.displacement, tool.turn]).collect();
                let rows = tool_rows(scene, mesh, &motions);
                let at_node = |node: usize| record.displacement[node];
                interface.state_at(surface, at_node, &rows, &record.multiplier)
            }
        };
        let Some(origin) = interface.touching(mesh, &before, &after) else {
            return Ok(None);
        };
        let problem = self.problem.clone().counted_from(origin, follows);
        let system = self.system.clone();
        Self { problem, system }.with_own_loads().map(Some)
    }

    /// Solves one problem.
    fn solution(
        &self,
        contact: Option<&ContactProblem<'_>>,
        settings: &SolveSettings,
        start: Start<'_>,
        increment: Option<Increment>,
        storage: &mut dyn RunStorage,
    ) -> Result<Solution, ProblemError> {
        let nested = match start {
            Start {
                multiplier: None,
                checkpoint: None,
            } => self.nested_start(settings, storage),
            _ => None,
        };
        let start = Start {
            multiplier: start.multiplier.or(nested.as_deref()),
            ..start
        };
        let mut observe = |progress: Progress<'_>| match (progress, increment) {
            (Progress::Between(state), None) => storage.checkpoint(Checkpoint::Solve(state)),
            (Progress::Between(_), Some(_)) => {}
            (Progress::Outer(..) | Progress::Newton(..), _) => {
                storage.observe(RunStep::Solving(increment, progress));
            }
        };
        Ok(self.solve_static(contact, settings, start, &mut observe)?)
    }

    /// Evaluates the solution of one problem and holds it against its report. Of a success that other increments follow the mapping Ψ is
    /// not kept; where their solve fails, the error in the energy norm is estimated.
    fn assessed(
        &self,
        contact: Option<&ContactProblem<'_>>,
        mut solution: Solution,
        settings: &SolveSettings,
        (errors, recovery): (EstimatedErrors, &StressRecovery),
        is_followed: bool,
    ) -> Result<(Solution, ContactReport), ProblemError> {
        let mut report = self.evaluated(contact, &solution, (errors, recovery))?;
        if let Some(failure) = self.system.assembly.factor.failure() {
            return Err(AssemblyError::Engine(failure).into());
        }
        let assessment = report.left_of(solution.assessment());
        let is_success = assessment.status.is_success(settings);
        if is_followed && !is_success && errors == EstimatedErrors::Nothing {
            report = self.evaluated(contact, &solution, (EstimatedErrors::Energy, recovery))?;
        }
        let is_kept = !(is_followed && is_success) && solution.status.is_solved();
        if let Some(contact) = contact.filter(|_| is_kept) {
            contact.linearise(&mut solution);
        }
        report.classify(&mut solution);
        Ok((solution, report))
    }

    fn evaluated(
        &self,
        contact: Option<&ContactProblem<'_>>,
        solution: &Solution,
        (errors, recovery): (EstimatedErrors, &StressRecovery),
    ) -> Result<ContactReport, InvalidValue> {
        let assembly = &self.system.assembly;
        let adjoints = |of: &[LinearFunctional]| Adjoint::of(assembly, contact, solution, of);
        ContactReport::with(
            &self.solved(solution),
            recovery,
            errors,
            &adjoints,
            Vec::new(),
        )
    }

    /// The problem of an increment of the scene's load history, which begins where `before` ended, on the same operators.
    ///
    /// # Errors
    /// Loads, gaps and laws that no problem can have.
    pub fn at_increment(
        &self,
        increment: Increment,
        before: Option<&StepRecord>,
    ) -> Result<Self, InvalidValue> {
        let problem = self.problem.at_increment(increment, before)?;
        let mut system = self.system.clone();
        let Problem { scene, mesh, .. } = &problem;
        match problem.contact_side() {
            Some(face) if scene.follows_tools() => {
                system.apply_to_face(scene, mesh, (face.surface, face.interface))?;
            }
            _ => system.apply(scene, mesh, problem.interface())?,
        }
        Ok(Self { problem, system })
    }
}
