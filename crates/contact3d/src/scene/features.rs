//! The model features that a scene calls for.

use super::{FrictionModel, MultiplierSpace, Obstacle, Quantity, Scene};

/// What a scene calls for on a contact face. The laws of the contact face ([`crate::contact::Interface`]) are made from
/// it and from nothing else: what is absent here has no unknowns, no datasets and no evaluations.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFeatures {
    /// Its number in the scene.
    pub entry: usize,
    /// Its name.
    pub name: String,
    /// The law of tangential stresses; `None` without friction: no tangential multipliers.
    pub friction: Option<FrictionModel>,
    /// The rigid obstacle; `None` for the half-space behind the flat face.
    pub obstacle: Option<Obstacle>,
    /// An initial gap d in m; `None` for none. The distance from an obstacle comes on top.
    pub gap: Option<Quantity>,
    /// Whether the frame (t₁, t₂) turns from place to place.
    pub turning_frame: bool,
    /// The space of the contact stresses.
    pub space: MultiplierSpace,
}

impl Scene {
    /// What happens on each contact face, in the order of their multipliers; empty in the elastic problem alone.
    #[must_use]
    pub fn contact_features(&self) -> Vec<ContactFeatures> {
        let order = self.contact_order().into_iter();
        order
            .map(|entry| ContactFeatures::new(self, entry))
            .collect()
    }

    /// Whether the coefficients of any face follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        let faces = self.contact_features().into_iter();
        let mut laws = faces.filter_map(|face| face.friction);
        laws.any(|law| law.coefficients.depends_on_slip())
    }
}

impl ContactFeatures {
    fn new(scene: &Scene, entry: usize) -> Self {
        let contact = &scene.contacts[entry];
        let varies = |quantity: &Quantity| quantity.constant().is_none();
        Self {
            entry,
            name: contact.name(),
            friction: scene
                .friction_on(entry)
                .and_then(|(_, table)| table.model()),
            obstacle: contact.obstacle.clone(),
            gap: (contact.gap != Quantity::Constant(0.0)).then(|| contact.gap.clone()),
            turning_frame: contact.axis_1.iter().flatten().any(varies)
                || contact.angle.as_ref().is_some_and(varies),
            space: contact.multipliers,
        }
    }
}
