//! What holds and loads a body, built in Rust.

use super::super::{Clamp, Component, Pressure, Quantity, Traction};

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
