//! Bodies, supports, loads, contact and friction of a scene, built in Rust.

use std::path::PathBuf;

use super::super::{
    Body, Brick, Clamp, Coefficient, Component, Contact, ElementOrder, Expression, ExpressionError,
    Formula, Friction, GmshFile, Isotropic, LawFunction, LawPoint, Material, MultiplierSpace,
    Obstacle, POSITION, PlaceFunction, Pressure, Quantity, Ramp, Shape, SlipDerivative,
    SlipInterpolation, Table, Traction,
};

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
            name: None,
            face: None,
            corners: Some(corners),
            components: Component::ALL.to_vec(),
            value: Default::default(),
        }
    }

    /// The clamp with some components only.
    #[must_use]
    pub fn along(mut self, components: &[Component]) -> Self {
        self.components = components.to_vec();
        self
    }

    /// The clamp at a displacement in m along x, y and z; zero for components that are not held.
    #[must_use]
    pub fn moved(mut self, value: [impl Into<Quantity>; 3]) -> Self {
        self.value = value.map(Into::into);
        self
    }
}

impl Traction {
    /// The traction with a name that steps may use.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// A traction in Pa on a face.
    #[must_use]
    pub fn on(face: impl Into<String>, value: [impl Into<Quantity>; 3]) -> Self {
        Self {
            name: None,
            face: face.into(),
            value: value.map(Into::into),
        }
    }
}

impl Pressure {
    /// The pressure with a name that steps may use.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// A pressure in Pa on a face.
    #[must_use]
    pub fn on(face: impl Into<String>, value: impl Into<Quantity>) -> Self {
        Self {
            name: None,
            face: face.into(),
            value: value.into(),
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

    /// The same against a rigid obstacle; the face may then be curved.
    #[must_use]
    pub fn against(mut self, obstacle: Obstacle) -> Self {
        self.obstacle = Some(obstacle);
        self
    }

    /// The same under another name than that of the face.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
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

    /// The same with an initial gap in m.
    #[must_use]
    pub fn with_gap(mut self, gap: impl Into<Quantity>) -> Self {
        self.gap = gap.into();
        self
    }

    /// The same with a first axis of friction.
    #[must_use]
    pub fn with_axis_1(mut self, axis: [impl Into<Quantity>; 3]) -> Self {
        self.axis_1 = Some(axis.map(Into::into));
        self
    }

    /// The same with slips that are means over the triangles around each node (HKL (3.19)).
    #[must_use]
    pub fn with_clement_interpolation(mut self) -> Self {
        self.slip_interpolation = SlipInterpolation::Clement;
        self
    }

    /// The same with one multiplier for each contact node.
    #[must_use]
    pub fn nodal(mut self) -> Self {
        self.multipliers = MultiplierSpace::Nodal;
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
            unit,
            digest: None,
        };
        Shape::Gmsh(file).into()
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

    /// Straight lines between pairs of a slip in m and a value.
    #[must_use]
    pub fn table(points: &[(f64, f64)]) -> Self {
        let (slip, value) = points.iter().copied().unzip();
        Self::Table(Table { slip, value })
    }

    /// A formula in the slips, the place and the scene's parameters, differentiated by this crate.
    ///
    /// # Errors
    /// Text that is no formula.
    pub fn formula(text: &str) -> Result<Self, ExpressionError> {
        Formula::try_from(text.to_owned()).map(Self::Expression)
    }

    /// A Rust function that gives F and dF/dζ in 1/m for a slip ζ in m: |u_t| of an isotropic law, that along its axis of
    /// an orthotropic one. Newton's method needs the derivative, one-sided at kinks; a wrong one costs steps or the
    /// status, never the meaning of `Converged`.
    #[must_use]
    pub fn of_slip(function: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Self {
        Self::Function(LawFunction::of_slip(function))
    }

    /// As [`Self::of_slip`], of the place and both slips.
    #[must_use]
    pub fn of_point(
        function: impl Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync + 'static,
    ) -> Self {
        Self::Function(LawFunction::of_point(function))
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

    /// A Rust function of the place in m.
    #[must_use]
    pub fn function(function: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function(PlaceFunction::new(function))
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}
