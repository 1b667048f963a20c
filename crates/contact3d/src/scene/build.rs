//! Scenes and their parts built in Rust: constructors with the defaults of scene files.

use std::path::PathBuf;

use super::{
    Body, BodyForce, Brick, Clamp, Coefficient, Component, Contact, Disc, ElementOrder, Expression,
    ExpressionError, Force, Formula, Friction, GmshFile, InvalidValue, Isotropic, Material,
    POSITION, Part, Pressure, Quantity, Ramp, Region, Scene, Step, Tool, Traction,
};

impl Scene {
    /// The scene with a name.
    #[must_use]
    pub fn with_title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The scene with one more part of another material.
    #[must_use]
    pub fn with_region(mut self, part: Part, material: Material) -> Self {
        self.regions.push(Region { part, material });
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

    /// The scene with friction on the contact faces that have none of their own.
    #[must_use]
    pub fn with_friction(mut self, friction: Friction) -> Self {
        self.friction = Some(friction);
        self
    }

    /// The scene with its parameters in its formulas, checked.
    ///
    /// # Errors
    /// The first offending key.
    pub fn checked(mut self) -> Result<Self, InvalidValue> {
        self.bind_parameters()?;
        self.validate()?;
        Ok(self)
    }
}

/// Scenes with one more entry of a list.
macro_rules! with_one_more {
    ($($(#[$doc:meta])* $method:ident($list:ident: $entry:ty);)+) => {
        impl Scene {
            $($(#[$doc])*
            #[must_use]
            pub fn $method(mut self, entry: $entry) -> Self {
                self.$list.push(entry);
                self
            })+
        }
    };
}
with_one_more! {
    /// The scene with one more body.
    with_body(bodies: Body);
    /// The scene with one more clamp.
    with_clamp(clamps: Clamp);
    /// The scene with one more traction.
    with_traction(tractions: Traction);
    /// The scene with one more pressure.
    with_pressure(pressures: Pressure);
    /// The scene with one more total force.
    with_force(forces: Force);
    /// The scene with one more contact face.
    with_contact(contacts: Contact);
    /// The scene with one more tool.
    with_tool(tools: Tool);
    /// The scene with one more step of a load history.
    with_step(steps: Step);
}

impl Clamp {
    /// All components held on a face.
    #[must_use]
    pub fn face(name: impl Into<String>) -> Self {
        Self {
            name: None,
            face: Some(name.into()),
            corners: None,
            components: Component::ALL.to_vec(),
            value: Default::default(),
        }
    }

    /// All components held at the nodes between two corners [min, max] in m.
    #[must_use]
    pub fn inside(corners: [[f64; 3]; 2]) -> Self {
        Self {
            face: None,
            corners: Some(corners),
            ..Self::face("")
        }
    }

    /// The clamp with some components only.
    #[must_use]
    pub fn along(mut self, components: &[Component]) -> Self {
        self.components = components.to_vec();
        self
    }
}

/// What loads on faces have in common.
macro_rules! loads_on_faces {
    ($($load:ident),+) => {
        $(impl $load {
            /// The load with a name that steps may use.
            #[must_use]
            pub fn named(mut self, name: impl Into<String>) -> Self {
                self.name = Some(name.into());
                self
            }

            /// The load on the disc of the face around a centre, both in m.
            #[must_use]
            pub fn within(mut self, centre: [f64; 3], radius: f64) -> Self {
                self.disc = Some(Disc { centre, radius });
                self
            }
        })+
    };
}
loads_on_faces!(Traction, Pressure, Force);

impl Traction {
    /// A traction in Pa on a face.
    #[must_use]
    pub fn on(face: impl Into<String>, value: [impl Into<Quantity>; 3]) -> Self {
        Self {
            face: face.into(),
            value: value.map(Into::into),
            ..Self::default()
        }
    }
}

impl Pressure {
    /// A pressure in Pa on a face.
    #[must_use]
    pub fn on(face: impl Into<String>, value: impl Into<Quantity>) -> Self {
        Self {
            face: face.into(),
            value: value.into(),
            ..Self::default()
        }
    }
}

impl Force {
    /// A force in N on a face, spread uniformly.
    #[must_use]
    pub fn on(face: impl Into<String>, value: [impl Into<Quantity>; 3]) -> Self {
        Self {
            face: face.into(),
            value: value.map(Into::into),
            ..Self::default()
        }
    }
}

impl Contact {
    /// Contact of a flat face with the foundation, without a gap, with panes.
    #[must_use]
    pub fn on(face: impl Into<String>) -> Self {
        Self {
            face: face.into(),
            ..Self::default()
        }
    }

    /// Contact between faces of two bodies.
    #[must_use]
    pub fn between(first: impl Into<String>, second: impl Into<String>) -> Self {
        Self {
            between: Some([first.into(), second.into()]),
            ..Self::default()
        }
    }

    /// Faces of two bodies that are bonded.
    #[must_use]
    pub fn glued(first: impl Into<String>, second: impl Into<String>) -> Self {
        Self {
            glued: true,
            ..Self::between(first, second)
        }
    }

    /// The same under another name than that of the face.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// The same with an obstacle, or a foundation, that is part of a tool.
    #[must_use]
    pub fn of_tool(mut self, name: impl Into<String>) -> Self {
        self.tool = Some(name.into());
        self
    }

    /// The part of the face between two corners [min, max] in m.
    #[must_use]
    pub fn inside(mut self, corners: [[f64; 3]; 2]) -> Self {
        self.corners = Some(corners);
        self
    }

    /// The same with a law of friction of its own.
    #[must_use]
    pub fn with_friction(mut self, friction: Friction) -> Self {
        self.friction = Some(friction);
        self
    }
}

impl Body {
    /// A box (0, Lx) × (0, Ly) × (0, Lz) in m, cut in equal cells; for others make a [`Brick`] first.
    #[must_use]
    pub fn brick(size: [f64; 3], cells: [usize; 3]) -> Self {
        Brick::new(size, cells).into()
    }

    /// A mesh file of Gmsh whose unit of length is `unit` metres.
    #[must_use]
    pub fn gmsh(file: impl Into<PathBuf>, unit: f64) -> Self {
        let file = GmshFile {
            file: file.into(),
            volume: None,
            unit,
            digest: None,
        };
        file.into()
    }

    /// The same body under a name, among several.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self {
            name: Some(name.into()),
            ..self
        }
    }

    /// The same body with its origin elsewhere, in m.
    #[must_use]
    pub fn at(self, origin: [f64; 3]) -> Self {
        Self { origin, ..self }
    }

    /// The same body of a material of its own.
    #[must_use]
    pub fn of(self, material: Material) -> Self {
        Self {
            material: Some(material),
            ..self
        }
    }

    /// The same body with other elements.
    #[must_use]
    pub fn with_element(self, element: ElementOrder) -> Self {
        Self { element, ..self }
    }
}

impl Material {
    /// Hooke's law with Young's modulus in Pa and Poisson's ratio.
    #[must_use]
    pub fn isotropic(young_modulus: f64, poisson_ratio: f64) -> Self {
        Self::Isotropic(Isotropic {
            young_modulus,
            poisson_ratio,
        })
    }
}

impl Friction {
    /// Coulomb's law with one coefficient.
    #[must_use]
    pub fn coulomb(coefficient: impl Into<Coefficient>) -> Self {
        Self {
            coefficient: Some(coefficient.into()),
            ..Self::default()
        }
    }

    /// Coulomb's law with coefficients along t₁ and t₂.
    #[must_use]
    pub fn orthotropic(first: impl Into<Coefficient>, second: impl Into<Coefficient>) -> Self {
        Self {
            coefficient_1: Some(first.into()),
            coefficient_2: Some(second.into()),
            ..Self::default()
        }
    }

    /// Coulomb's law capped at a pressure p_cap > 0 in Pa, ‖F⁻¹σ_t‖ ≤ min(−σ_ν, p_cap).
    #[must_use]
    pub fn capped(self, pressure_cap: f64) -> Self {
        Self {
            pressure_cap: Some(pressure_cap),
            ..self
        }
    }

    /// Tresca's law ‖σ_t‖ ≤ g with a given slip bound g in Pa.
    #[must_use]
    pub fn tresca(slip_bound: impl Into<Quantity>) -> Self {
        Self {
            slip_bound: Some(slip_bound.into()),
            ..Self::default()
        }
    }
}

impl Coefficient {
    /// A straight change from `initial` to `residual` that begins at the slip `onset` in m, with the steepness `rate`
    /// in 1/m.
    #[must_use]
    pub fn ramp(initial: f64, residual: f64, onset: f64, rate: f64) -> Self {
        Self::Ramp(Ramp {
            initial,
            residual,
            onset,
            rate,
        })
    }

    /// A formula in the slips, the place and the scene's parameters, differentiated by this crate.
    ///
    /// # Errors
    /// Text that is no formula.
    pub fn formula(text: &str) -> Result<Self, ExpressionError> {
        Formula::try_from(text.to_owned()).map(Self::Expression)
    }
}

impl From<f64> for Coefficient {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl Quantity {
    /// A formula in x, y, z and the scene's parameters.
    ///
    /// # Errors
    /// Text that is no formula.
    pub fn formula(text: &str) -> Result<Self, ExpressionError> {
        Expression::unbound(text, POSITION).map(Self::Varying)
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}
