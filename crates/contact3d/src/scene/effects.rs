use super::{FrictionLaw, Material, MultiplierSpace, Quantity, Scene};

/// The effects a scene calls for. Everything that is computed is decided here and nowhere else;
/// what is absent has no datasets, no unknowns and no code on its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effects {
    /// What happens on Γ_c.
    pub contact: ContactEffect,
    /// A body force f.
    pub body_force: bool,
    /// Parts of the body with a material of their own.
    pub regions: usize,
    /// Any material that is not isotropic.
    pub anisotropy: bool,
}

/// What happens on Γ_c.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactEffect {
    /// No contact face: the elastic problem alone.
    Absent,
    /// A contact face.
    Present {
        /// The law of tangential stresses.
        friction: FrictionEffect,
        /// An initial gap d.
        gap: bool,
        /// A frame (t₁, t₂) that turns from place to place.
        turning_frame: bool,
        /// The space of the contact stresses.
        space: MultiplierSpace,
    },
}

/// The law of tangential stresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionEffect {
    /// None: m normal multipliers and no tangential ones.
    Frictionless,
    /// A given slip bound: one minimisation.
    Tresca {
        /// F₁ ≠ F₂.
        orthotropic: bool,
    },
    /// A slip bound that is the normal stress itself.
    Coulomb {
        /// F₁ and F₂ are given separately.
        orthotropic: bool,
        /// F depends on the slip.
        slip_dependent: bool,
        /// F depends on the place.
        place_dependent: bool,
    },
}

impl Effects {
    /// Decides what a validated scene calls for.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let materials = scene
            .regions
            .iter()
            .map(|region| &region.material)
            .chain([&scene.material]);
        Self {
            contact: contact(scene),
            body_force: scene.body_force.is_some(),
            regions: scene.regions.len(),
            anisotropy: materials
                .into_iter()
                .any(|m| !matches!(m, Material::Isotropic(_))),
        }
    }

    /// The law of tangential stresses; `None` without contact.
    #[must_use]
    pub fn friction(&self) -> Option<FrictionEffect> {
        match self.contact {
            ContactEffect::Absent => None,
            ContactEffect::Present { friction, .. } => Some(friction),
        }
    }
}

fn contact(scene: &Scene) -> ContactEffect {
    let Some(contact) = &scene.contact else {
        return ContactEffect::Absent;
    };
    let varies = |quantity: &Quantity| quantity.constant().is_none();
    ContactEffect::Present {
        friction: friction(scene),
        gap: contact.gap != Quantity::Constant(0.0),
        turning_frame: contact.axis_1.iter().flatten().any(varies)
            || contact.angle.as_ref().is_some_and(varies),
        space: contact.multipliers,
    }
}

fn friction(scene: &Scene) -> FrictionEffect {
    let given = scene.friction.as_ref();
    let Some((friction, law)) = given.and_then(|f| Some((f, f.law()?))) else {
        return FrictionEffect::Frictionless;
    };
    let orthotropic = matches!(law, FrictionLaw::Orthotropic(_));
    match friction.slip_bound {
        Some(_) => FrictionEffect::Tresca { orthotropic },
        None => FrictionEffect::Coulomb {
            orthotropic,
            slip_dependent: law.depends_on_slip(),
            place_dependent: law.depends_on_place(),
        },
    }
}
