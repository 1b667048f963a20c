//! A problem with its factor, from which solves start, also with other loads, gaps and laws of friction.

use std::sync::Arc;

use super::{InMemory, Problem, ProblemError, SolvedProblem};
use crate::{
    contact::Interface,
    dual::{DualSystem, LocalStiffness},
    mesh::Mesh,
    post::{ContactReport, EstimatedErrors, Rounding, Solved},
    scene::{InvalidValue, ProblemPart, Scene, SolveSettings},
    solver::{
        ContactProblem, ContactSide, FrictionState, NeedsExplicit, Progress, Solution, Start,
        Trace, coulomb_state, without_contact,
    },
};

/// A problem with its stiffness factorised and, where it has contact, with its dual problem.
#[derive(Debug, Clone)]
pub struct AssembledProblem {
    /// The problem.
    pub problem: Problem,
    /// A, l and the dual problem, assembled for a scene that differs in no more than [`Self::with_changes`] may, whatever their loads.
    pub system: DualSystem,
}

impl AssembledProblem {
    /// The problem with the loads of its scene, which its operators may lack.
    pub(super) fn with_own_loads(mut self) -> Result<Self, InvalidValue> {
        let Problem {
            scene,
            mesh,
            interface,
        } = &self.problem;
        self.system.apply(scene, mesh, interface.as_ref())?;
        Ok(self)
    }

    /// The problem with the loads of its scene, those of the last increment of a load history.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn with_last_loads(mut self) -> Result<Self, InvalidValue> {
        let scene = self.problem.scene.at_end()?;
        self.system.apply_loads(&scene, &self.problem.mesh)?;
        Ok(self)
    }

    /// Solves from λ = 0. A solve that does not converge is a solution with a [status](crate::solver::Status).
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for settings that no solve can have and for a scene with steps, which
    /// [`Self::solve_history`] solves; [`ProblemError::NeedsExplicit`] when
    /// Newton's method is asked for and S is not dense.
    pub fn solve(&self, settings: &SolveSettings) -> Result<Solution, ProblemError> {
        let solved = self.solve_evaluated(settings, EstimatedErrors::Nothing)?;
        Ok(solved.solution)
    }

    /// [`Self::solve`] with the [report](Self::report) that assessed it.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_and_report(
        &self,
        settings: &SolveSettings,
    ) -> Result<(Solution, ContactReport), ProblemError> {
        let solved = self.solve_evaluated(settings, EstimatedErrors::Quantities)?;
        Ok((solved.solution, solved.report))
    }

    fn solve_evaluated(
        &self,
        settings: &SolveSettings,
        errors: EstimatedErrors,
    ) -> Result<SolvedProblem, ProblemError> {
        settings.validate()?;
        self.scene().require_no_history("a solve")?;
        self.run_evaluated(
            settings,
            Start::default(),
            Vec::new(),
            errors,
            &mut InMemory,
        )
    }

    /// Solves the steps of the scene one after the other, on one factor; a scene without steps once.
    ///
    /// ```
    /// use contact3d::{Problem, scene::*};
    ///
    /// let scene = Scene::new(Body::brick([1.0; 3], [2, 2, 2]), Material::isotropic(2e11, 0.3))
    ///     .with_clamp(Clamp::face("z_max"))
    ///     .with_pressure(Pressure::on("x_min", 1e7).named("push"))
    ///     .with_body_force([0.0, 0.0, -1e8])
    ///     .with_contact(Contact::on("z_min"))
    ///     .with_friction(Friction::coulomb(0.3))
    ///     .with_step(Step::new("weight").with_factor("push", 0.0))
    ///     .with_step(Step::new("push").with_factor("push", 1.0).in_increments(4))
    ///     .with_step(Step::new("let go").with_factor("push", 0.0));
    /// let history = Problem::new(scene)?.assemble()?.solve_history(&SolveSettings::default())?;
    /// let dissipated: f64 = history.records.iter().map(|record| record.energies.dissipation).sum();
    /// assert_eq!(history.records.len(), 6);
    /// assert!(dissipated > 0.0);
    /// # Ok::<(), contact3d::ProblemError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn solve_history(&self, settings: &SolveSettings) -> Result<SolvedProblem, ProblemError> {
        settings.validate()?;
        self.run(settings, Start::default(), Vec::new(), &mut InMemory)
    }

    /// As [`Self::solve`] from a given start, such as the multipliers of a similar problem, while
    /// `observe` sees the steps; those that measure the error of the solution are in its history only.
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
        let contact = self.contact_problem();
        let mut solution = self.solve_static(contact.as_ref(), settings, start, observe)?;
        if let Some(contact) = contact.filter(|_| solution.status.is_solved()) {
            contact.linearise(&mut solution);
        }
        Ok(solution)
    }

    /// The contact problem of its loads; `None` without contact.
    pub(crate) fn contact_problem(&self) -> Option<ContactProblem<'_>> {
        ContactProblem::new(&self.system, self.contact_side()?)
    }

    pub(super) fn solve_static(
        &self,
        contact: Option<&ContactProblem<'_>>,
        settings: &SolveSettings,
        start: Start<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        match contact {
            Some(contact) => contact.solve(settings, start, observe),
            None => Ok(without_contact(&self.system)),
        }
    }

    /// What multipliers that were found elsewhere, `[n_multipliers]` in Pa, make of the body: its displacement, and with the dense
    /// operator the slip and the friction that follow. Nothing is assessed, so it claims nothing. A body that floats is left
    /// without its rigid motion.
    #[must_use]
    pub fn state_of(&self, multiplier: Vec<f64>) -> Solution {
        let (Some(dual), Some(contact)) = (&self.system.contact, self.contact_side()) else {
            return Solution::unassessed(multiplier, Vec::new(), Trace::default());
        };
        let displacement = dual.displacement(&self.system.assembly, &multiplier);
        let mut solution = Solution::unassessed(multiplier, displacement, Trace::default());
        if let Some(explicit) = dual.explicit() {
            solution.trace.local_stiffness = LocalStiffness::new(explicit).stiffness;
            if let Some(law) = contact.interface.coulomb() {
                let state = coulomb_state(explicit, &contact.laws(), law, &solution.multiplier);
                solution.friction = Some(FrictionState {
                    coulomb: state,
                    ..FrictionState::default()
                });
            }
        }
        solution
    }

    /// Zones, stresses, resultants and certificate of a solution.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a load that is not finite.
    pub fn report(&self, solution: &Solution) -> Result<ContactReport, ProblemError> {
        Ok(ContactReport::new(&self.solved(solution), Vec::new())?)
    }

    /// What rounding makes of the residuals of a solution, with |S||λ| in m³, `[n_multipliers]`.
    #[must_use]
    pub fn rounding_of(
        &self,
        solution: &Solution,
        report: &ContactReport,
        moved: &[f64],
    ) -> Rounding {
        Rounding::of_answer(&self.solved(solution), report, moved)
    }

    pub(super) fn solved<'a>(&'a self, solution: &'a Solution) -> Solved<'a> {
        let contact = self.system.contact.as_ref();
        let coupling = contact.map(|contact| &contact.coupling);
        self.problem
            .solved(&self.system.assembly.primal, coupling, solution)
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.problem.scene
    }

    /// Its mesh.
    #[must_use]
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.problem.mesh
    }

    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact_side(&self) -> Option<ContactSide<'_>> {
        self.problem.contact_side()
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

    /// The problem of a changed scene on the same mesh, factor and S, which are shared: one solve with the factor in
    /// place of an assembly. `change` may change loads, the values of clamps, gap, the law of friction and its slips, settings of the solve, title.
    ///
    /// ```
    /// use contact3d::{Problem, scene::{Body, Clamp, Contact, Friction, Material, Pressure, Scene}};
    ///
    /// let scene = Scene::new(Body::brick([1.0; 3], [2, 2, 2]), Material::isotropic(2e11, 0.3))
    ///     .with_clamp(Clamp::face("x_min"))
    ///     .with_contact(Contact::on("z_min"))
    ///     .with_friction(Friction::coulomb(0.3))
    ///     .with_pressure(Pressure::on("z_max", 1e7));
    /// let first = Problem::new(scene)?.assemble()?;
    /// let second = first.with_changes(|scene| scene.pressures[0].value = 2e7.into())?;
    /// let [one, two] = [&first, &second].map(|problem| problem.solve(&problem.scene().solve));
    /// assert!((two?.multiplier[0] / one?.multiplier[0] - 2.0).abs() < 1e-9);
    /// # Ok::<(), contact3d::ProblemError>(())
    /// ```
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a value that no problem can have, [`ProblemError::OtherOperator`] for a change
    /// that needs an assembly of its own.
    pub fn with_changes(&self, change: impl FnOnce(&mut Scene)) -> Result<Self, ProblemError> {
        let mut scene = self.scene().clone();
        change(&mut scene);
        self.with_scene(scene)
    }

    /// As [`Self::with_changes`], with a scene that differs from this one in no more than that.
    ///
    /// # Errors
    /// As [`Self::with_changes`].
    pub fn with_scene(&self, scene: Scene) -> Result<Self, ProblemError> {
        let scene = scene.checked()?;
        if let Some(key) = other_part(self.scene(), &scene) {
            return Err(ProblemError::OtherOperator { key });
        }
        let interface = self.problem.interface();
        let previous = interface.and_then(|interface| interface.previous.clone());
        let problem = Problem::of_checked(scene, self.problem.mesh.clone())?;
        self.require_compliance(problem.interface())?;
        let problem = problem.following(previous);
        let DualSystem {
            assembly, contact, ..
        } = self.system.clone();
        let system = DualSystem::of(assembly, contact);
        Ok(Self { problem, system }.with_own_loads()?)
    }

    /// Refuses a law that follows the slip where the dense operator was formed without the compliance of the contact
    /// nodes.
    fn require_compliance(&self, interface: Option<&Interface>) -> Result<(), ProblemError> {
        let contact = self.system.contact.as_ref();
        let explicit = contact.and_then(|contact| contact.explicit());
        let is_missing = explicit.is_some_and(|explicit| explicit.compliance.is_none());
        if is_missing && interface.is_some_and(Interface::follows_slip) {
            return Err(ProblemError::Invalid(InvalidValue {
                key: "friction".into(),
                expected: "a law that does not follow the slip, as when the problem was assembled".into(),
                found: "one that follows the slip".into(),
                help: "assemble the problem with a law that follows the slip; laws that do not can then share it".into(),
            }));
        }
        Ok(())
    }
}

/// The first table in which two scenes differ and on which mesh, stiffness, coupling or S depend.
fn other_part(old: &Scene, new: &Scene) -> Option<String> {
    let parts = [old, new].map(|scene| scene.part(&[ProblemPart::Mesh, ProblemPart::Operator]));
    let mut keys = parts[0].keys().chain(parts[1].keys());
    let differs = |key: &&String| parts[0].get(*key) != parts[1].get(*key);
    if let Some(key) = keys.find(differs) {
        return Some(key.clone());
    }
    let [old, new] = [old, new].map(|scene| {
        let faces = 0..scene.contacts.len();
        faces
            .map(|face| scene.friction_on(face).is_some())
            .collect::<Vec<_>>()
    });
    (old != new).then(|| "friction".to_owned())
}
