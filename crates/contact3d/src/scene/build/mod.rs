//! Scenes built in Rust: constructors with the defaults of scene files.

mod parts;

use units::Units;

use super::{
    AssembleSettings, Body, BodyForce, Clamp, Contact, DualOperatorKind, Friction, Invalid,
    Material, Parameters, Part, Pressure, Quantity, Region, Scene, SolveSettings, Spring, Step,
    Traction,
};

impl Scene {
    /// A body of one material, with nothing that holds, loads or touches it yet.
    ///
    /// ```
    /// use contact3d::scene::{Body, Clamp, Contact, Friction, Material, Pressure, Scene};
    ///
    /// let scene = Scene::new(Body::brick([3.0, 1.0, 1.0], [12, 4, 4]), Material::isotropic(2.1e11, 0.3))
    ///     .with_clamp(Clamp::face("x_min"))
    ///     .with_pressure(Pressure::on("z_max", 2e7))
    ///     .with_contact(Contact::on("z_min"))
    ///     .with_friction(Friction::coulomb(0.3));
    /// assert!(scene.validate().is_ok());
    /// ```
    #[must_use]
    pub fn new(body: Body, material: Material) -> Self {
        Self {
            title: "untitled".to_owned(),
            reference: None,
            units: Units::default(),
            parameters: Parameters::new(),
            body,
            material,
            regions: Vec::new(),
            clamps: Vec::new(),
            springs: Vec::new(),
            tractions: Vec::new(),
            pressures: Vec::new(),
            body_force: None,
            contacts: Vec::new(),
            friction: None,
            steps: Vec::new(),
            assemble: AssembleSettings::default(),
            solve: SolveSettings::default(),
            adapt: None,
        }
    }

    /// The scene with a name.
    #[must_use]
    pub fn with_title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The scene with a number that its formulas may use.
    #[must_use]
    pub fn with_parameter(mut self, name: impl Into<String>, value: f64) -> Self {
        self.parameters.insert(name.into(), value);
        self
    }

    /// The scene with one more part of another material.
    #[must_use]
    pub fn with_region(mut self, part: Part, material: Material) -> Self {
        self.regions.push(Region { part, material });
        self
    }

    /// The scene with one more clamp.
    #[must_use]
    pub fn with_clamp(mut self, clamp: Clamp) -> Self {
        self.clamps.push(clamp);
        self
    }

    /// The scene with one more traction.
    #[must_use]
    pub fn with_traction(mut self, traction: Traction) -> Self {
        self.tractions.push(traction);
        self
    }

    /// The scene with springs on one more face.
    #[must_use]
    pub fn with_spring(mut self, spring: Spring) -> Self {
        self.springs.push(spring);
        self
    }

    /// The scene with one more pressure.
    #[must_use]
    pub fn with_pressure(mut self, pressure: Pressure) -> Self {
        self.pressures.push(pressure);
        self
    }

    /// The scene with a force per volume in N/m³.
    #[must_use]
    pub fn with_body_force(mut self, value: [impl Into<Quantity>; 3]) -> Self {
        self.body_force = Some(BodyForce {
            value: value.map(Into::into),
        });
        self
    }

    /// The scene with one more contact face.
    #[must_use]
    pub fn with_contact(mut self, contact: Contact) -> Self {
        self.contacts.push(contact);
        self
    }

    /// The scene with friction on the contact faces that have none of their own.
    #[must_use]
    pub fn with_friction(mut self, friction: Friction) -> Self {
        self.friction = Some(friction);
        self
    }

    /// The scene with one more step of a load history.
    #[must_use]
    pub fn with_step(mut self, step: Step) -> Self {
        self.steps.push(step);
        self
    }

    /// The scene with the dual operator held in a given way.
    #[must_use]
    pub fn with_dual_operator(mut self, kind: DualOperatorKind) -> Self {
        self.assemble.dual_operator = kind;
        self
    }

    /// The scene with its parameters in its formulas, checked.
    ///
    /// # Errors
    /// The first offending key.
    pub fn checked(mut self) -> Result<Self, Invalid> {
        self.bind_parameters()?;
        self.validate()?;
        Ok(self)
    }
}
