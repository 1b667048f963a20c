//! Contact faces, built in Rust.

use super::super::{Contact, Friction, MultiplierSpace, Obstacle, Quantity, SlipInterpolation};

impl Contact {
    /// Contact of a flat face with the foundation, without a gap, with panes.
    #[must_use]
    pub fn on(face: impl Into<String>) -> Self {
        Self {
            face: face.into(),
            obstacle: None,
            name: None,
            corners: None,
            gap: Quantity::default(),
            axis_1: None,
            angle: None,
            multipliers: MultiplierSpace::default(),
            slip_interpolation: SlipInterpolation::default(),
            friction: None,
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
