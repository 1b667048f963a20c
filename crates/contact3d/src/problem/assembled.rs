//! A problem with its factor, from which solves start.

use std::sync::Arc;

use super::{Problem, ProblemError};
use crate::{
    dual::{AssemblySeconds, DualSystem, LocalStiffness},
    linalg::Workspace,
    mesh::Mesh,
    post::{ContactReport, Rounding, Solved, SolvedContact},
    scene::{Invalid, Scene, SolveSettings},
    solver::{ContactState, Progress, Solution, Start, Status, coulomb_state, solve},
};

/// A problem with its stiffness factorised and, where it has contact, with its dual problem.
#[derive(Debug)]
pub struct AssembledProblem {
    pub(super) problem: Problem,
    pub(super) system: DualSystem,
}

impl AssembledProblem {
    pub(super) fn new(problem: Problem) -> Result<Self, ProblemError> {
        let system = DualSystem::new(&problem.scene, &problem.mesh)?;
        Ok(Self { problem, system })
    }

    /// Solves from λ = 0, again with a factor in double precision where one in single precision that the program chose led to no
    /// answer. A solve that does not converge is a solution with a [status](crate::solver::Status).
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for settings that no solve can have and for a scene with steps, which
    /// [`Self::solve_history`] solves; [`ProblemError::NeedsExplicit`] when
    /// Newton's method is asked for and S is not dense.
    pub fn solve(&self, settings: &SolveSettings) -> Result<Solution, ProblemError> {
        let (solution, _) = self.solve_judged(settings, ContactReport::without_estimate)?;
        Ok(solution)
    }

    /// [`Self::solve`] with the [report](Self::report) that judged it.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_and_report(
        &self,
        settings: &SolveSettings,
    ) -> Result<(Solution, ContactReport), ProblemError> {
        self.solve_judged(settings, ContactReport::new)
    }

    fn solve_judged(
        &self,
        settings: &SolveSettings,
        evaluate: fn(&Solved<'_>) -> Result<ContactReport, Invalid>,
    ) -> Result<(Solution, ContactReport), ProblemError> {
        settings.validate("solve")?;
        let judged = |problem: &Self| -> Result<_, ProblemError> {
            let mut solution = problem.solve_from(settings, Start::default(), &mut |_| {})?;
            let report = evaluate(&problem.solved(&solution))?;
            report.judge(&mut solution);
            Ok((solution, report))
        };
        let first = judged(self)?;
        match self.reconsidered(first.0.status, settings)? {
            None => Ok(first),
            Some(double) => judged(&double),
        }
    }

    /// The same problem with a factor in double precision, after a solve that gave up with one in single precision that the
    /// program chose.
    ///
    /// # Errors
    /// Laws of the contact face that no problem can have.
    pub fn reconsidered(
        &self,
        status: Status,
        settings: &SolveSettings,
    ) -> Result<Option<Self>, ProblemError> {
        if !status.gave_up(settings) {
            return Ok(None);
        }
        let double =
            self.system
                .in_double_precision(self.scene(), self.mesh(), &|_| Ok(()), &|_, _| ());
        let Some(mut system) = double else {
            return Ok(None);
        };
        system.apply(self.scene(), self.mesh(), self.problem.interface())?;
        let problem = Problem {
            scene: self.problem.scene.clone(),
            mesh: self.problem.mesh.clone(),
            interface: self.problem.interface.clone(),
        };
        Ok(Some(Self { problem, system }))
    }

    /// As [`Self::solve`] with the factor that there is, from a given start, such as the multipliers of a similar problem, while
    /// `observe` sees the steps; those that measure the error of the answer are in its history only.
    /// The settings are taken as they are: ε = 0 means to rounding.
    ///
    /// # Errors
    /// [`ProblemError::NeedsExplicit`].
    pub fn solve_from(
        &self,
        settings: &SolveSettings,
        start: Start<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, ProblemError> {
        self.scene().require_no_history("a solve")?;
        Ok(solve(
            &self.system,
            self.contact_state().as_ref(),
            settings,
            start,
            observe,
        )?)
    }

    /// What multipliers that were found elsewhere, `[n_multipliers]` in Pa, make of the body: its displacement, and with the dense
    /// operator the slip and the friction that follow. Nothing is judged: the status is that of an empty solution. A body that floats is left
    /// without its rigid motion.
    #[must_use]
    pub fn state_of(&self, multiplier: Vec<f64>) -> Solution {
        let (Some(dual), Some(contact)) = (&self.system.contact, self.contact_state()) else {
            return Solution::default();
        };
        let mut work = Workspace::default();
        let mut solution = Solution {
            displacement: dual.displacement(&self.system.assembly, &multiplier, &mut work),
            ..Solution::default()
        };
        if let Some(explicit) = dual.explicit() {
            solution.local_stiffness = LocalStiffness::new(explicit).stiffness;
            if let Some(law) = contact.interface.coulomb() {
                let state = coulomb_state(explicit, &contact.laws(), law, &multiplier);
                solution.coulomb = Some(state);
            }
        }
        solution.multiplier = multiplier;
        solution
    }

    /// Zones, stresses, resultants and certificate of a solution.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a load that is not finite.
    pub fn report(&self, solution: &Solution) -> Result<ContactReport, ProblemError> {
        Ok(ContactReport::new(&self.solved(solution))?)
    }

    /// What rounding makes of the residuals of a solution, with |S||λ| in m³, `[n_multipliers]`.
    pub(crate) fn rounding_of(
        &self,
        solution: &Solution,
        report: &ContactReport,
        moved: &[f64],
    ) -> Rounding {
        Rounding::of_answer(&self.solved(solution), report, moved)
    }

    fn solved<'a>(&'a self, solution: &'a Solution) -> Solved<'a> {
        let contact = self.system.contact.as_ref().zip(self.contact_state());
        Solved {
            scene: self.scene(),
            mesh: self.mesh(),
            system: &self.system.assembly.primal,
            contact: contact.map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
            solution,
        }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.problem.scene
    }

    /// Its mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.problem.mesh
    }

    /// A, l and the dual problem.
    #[must_use]
    pub fn system(&self) -> &DualSystem {
        &self.system
    }

    /// The same, to study solves with operators that are not those of the scene.
    #[must_use]
    pub fn system_mut(&mut self) -> &mut DualSystem {
        &mut self.system
    }

    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact_state(&self) -> Option<ContactState<'_>> {
        Some(ContactState {
            surface: self.mesh().contact.as_ref()?,
            interface: self.problem.interface()?,
        })
    }

    /// Number of panes m; 0 without contact.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        let surface = self.mesh().contact.as_ref();
        surface.map_or(0, |surface| surface.n_panes())
    }

    /// Number of free degrees of freedom.
    #[must_use]
    pub fn n_free(&self) -> usize {
        self.system.assembly.primal.dofs.n_free
    }

    /// Whether S is held as a dense matrix, which Newton's method needs.
    #[must_use]
    pub fn is_explicit(&self) -> bool {
        let contact = self.system.contact.as_ref();
        contact.is_some_and(|contact| contact.explicit().is_some())
    }

    /// Refuses a body that only contact holds, or weak springs, where `what` needs A⁻¹ itself.
    pub(crate) fn refuse_floating(&self, what: &str) -> Result<(), Invalid> {
        let Some(body) = &self.system.assembly.primal.floating else {
            return Ok(());
        };
        let (found, why) = match body.support {
            None => (
                "only contact holds",
                "A is singular: there is no S = B A^-1 B^T, no unique mapping of contact forces to displacements",
            ),
            Some(_) => (
                "only contact and weak springs hold",
                "springs far softer than the body leave S = B A^-1 B^T no digits of the body's own compliance",
            ),
        };
        Err(Invalid {
            key: "clamp".into(),
            expected: format!("a body that its supports hold, for {what}"),
            found: format!("a body that {found}"),
            help: format!("{why}; hold the body with [[clamp]] or solve it with run"),
        })
    }

    /// What the parts of the assembly took.
    #[must_use]
    pub fn assembly_seconds(&self) -> AssemblySeconds {
        self.system.assembly.seconds
    }

    /// The mesh and the assembled operators.
    pub(crate) fn into_parts(self) -> (Arc<Mesh>, DualSystem) {
        (self.problem.mesh, self.system)
    }

    /// Lets S be applied through the factor from now on.
    pub(crate) fn forget_dense_operator(&mut self) {
        if let Some(contact) = &mut self.system.contact {
            contact.make_implicit();
        }
    }
}
