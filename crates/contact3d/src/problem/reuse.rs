//! Other loads, gaps and laws of friction on one factor.

use super::{AssembledProblem, Problem, ProblemError};
use crate::{
    contact::Interface,
    scene::{InvalidValue, ProblemPart, Scene},
};

impl AssembledProblem {
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
        let previous = interface.and_then(|interface| interface.slip.previous.clone());
        let problem = Problem::of_checked(scene, self.problem.mesh.clone())?;
        self.require_compliance(problem.interface())?;
        let problem = problem.following(previous);
        let system = self.system.clone();
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
