//! The model features that a scene calls for.

use super::{FrictionModel, Material, MultiplierSpace, Obstacle, Quantity, Scene};

/// What a scene calls for. The laws of the contact face ([`crate::contact::Interface`]) are made from
/// it and from nothing else: what is absent here has no unknowns, no datasets and no evaluations.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFeatures {
    /// What happens on each contact face, in the order of their multipliers; empty in the elastic problem alone.
    pub contact: Vec<ContactFeatures>,
    /// Clamps that hold somewhere else than at zero.
    pub prescribed_displacements: usize,
    /// Faces on springs.
    pub springs: usize,
    /// A body force f.
    pub body_force: bool,
    /// Parts of the body with a material of their own.
    pub regions: usize,
    /// Any material that is not isotropic.
    pub anisotropy: bool,
}

/// What a contact face has.
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

impl ModelFeatures {
    /// Decides what a validated scene calls for.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let regions = scene.regions.iter().map(|region| &region.material);
        let mut materials = regions.chain([&scene.material]);
        Self {
            contact: scene
                .contact_order()
                .into_iter()
                .map(|entry| ContactFeatures::new(scene, entry))
                .collect(),
            prescribed_displacements: scene.clamps.iter().filter(|c| c.is_moved()).count(),
            springs: scene.springs.len(),
            body_force: scene.body_force.is_some(),
            regions: scene.regions.len(),
            anisotropy: materials.any(|material| match material {
                Material::Isotropic(_) => false,
                Material::Orthotropic(_) | Material::Voigt(_) => true,
            }),
        }
    }

    /// The laws of the contact faces with friction.
    pub fn friction(&self) -> impl Iterator<Item = &FrictionModel> {
        self.contact
            .iter()
            .filter_map(|face| face.friction.as_ref())
    }

    /// Whether the coefficients of any face follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        self.friction()
            .any(|law| law.coefficients.depends_on_slip())
    }
}

impl ContactFeatures {
    fn new(scene: &Scene, entry: usize) -> Self {
        let contact = &scene.contacts[entry];
        let varies = |quantity: &Quantity| quantity.constant().is_none();
        Self {
            entry,
            name: contact.name().to_owned(),
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
