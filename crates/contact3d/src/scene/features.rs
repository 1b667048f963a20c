//! The model features that a scene calls for.

use super::{Friction, FrictionLaw, Material, MultiplierSpace, Obstacle, Quantity, Scene};

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
    /// The law of tangential stresses.
    pub friction: FrictionModel,
    /// The rigid obstacle; `None` for the half-space behind the flat face.
    pub obstacle: Option<Obstacle>,
    /// An initial gap d in m; `None` for none. The distance from an obstacle comes on top.
    pub gap: Option<Quantity>,
    /// Whether the frame (t₁, t₂) turns from place to place.
    pub turning_frame: bool,
    /// The space of the contact stresses.
    pub space: MultiplierSpace,
}

/// The law of tangential stresses.
#[derive(Debug, Clone, PartialEq)]
pub enum FrictionModel {
    /// None: m normal multipliers and no tangential ones.
    Frictionless,
    /// A given slip bound g, ‖F⁻¹σ_t‖ ≤ g: one minimisation.
    Tresca {
        /// g in Pa.
        slip_bound: Quantity,
        /// F, which is constant.
        coefficients: FrictionLaw,
    },
    /// A slip bound that is the pressure itself, ‖F⁻¹σ_t‖ ≤ −σ_ν.
    Coulomb {
        /// F, which may follow the slip.
        coefficients: FrictionLaw,
    },
    /// A slip bound that is the pressure up to a cap, ‖F⁻¹σ_t‖ ≤ min(−σ_ν, p_cap).
    CappedCoulomb {
        /// F, which may follow the slip.
        coefficients: FrictionLaw,
        /// p_cap in Pa.
        pressure_cap: f64,
    },
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

    /// The laws of tangential stresses, one for each contact face.
    pub fn friction(&self) -> impl Iterator<Item = &FrictionModel> {
        self.contact.iter().map(|face| &face.friction)
    }

    /// Whether the coefficients of any face follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        self.friction().any(FrictionModel::follows_slip)
    }
}

impl ContactFeatures {
    fn new(scene: &Scene, entry: usize) -> Self {
        let contact = &scene.contacts[entry];
        let varies = |quantity: &Quantity| quantity.constant().is_none();
        Self {
            entry,
            name: contact.name().to_owned(),
            friction: FrictionModel::new(scene.friction_on(entry).map(|(_, friction)| friction)),
            obstacle: contact.obstacle.clone(),
            gap: (contact.gap != Quantity::Constant(0.0)).then(|| contact.gap.clone()),
            turning_frame: contact.axis_1.iter().flatten().any(varies)
                || contact.angle.as_ref().is_some_and(varies),
            space: contact.multipliers,
        }
    }
}

impl FrictionModel {
    fn new(given: Option<&Friction>) -> Self {
        let Some((friction, coefficients)) = given.and_then(|f| Some((f, f.law()?))) else {
            return Self::Frictionless;
        };
        match (friction.slip_bound.clone(), friction.pressure_cap) {
            (Some(slip_bound), _) => Self::Tresca {
                slip_bound,
                coefficients,
            },
            (None, None) => Self::Coulomb { coefficients },
            (None, Some(pressure_cap)) => Self::CappedCoulomb {
                coefficients,
                pressure_cap,
            },
        }
    }

    /// The name of the law; `None` without friction.
    #[must_use]
    pub fn name(&self) -> Option<&'static str> {
        match self {
            Self::Frictionless => None,
            Self::Tresca { .. } => Some("Tresca"),
            Self::Coulomb { .. } => Some("Coulomb"),
            Self::CappedCoulomb { .. } => Some("capped Coulomb"),
        }
    }

    /// The condition of the law where it is not Coulomb's own, for a person; `None` where it is, and
    /// without friction.
    #[must_use]
    pub fn condition(&self) -> Option<&'static str> {
        match self {
            Self::Frictionless | Self::Coulomb { .. } => None,
            Self::Tresca { .. } => Some("with a given slip bound: |F^-1 sigma_t| <= g"),
            Self::CappedCoulomb { .. } => {
                Some("up to a pressure cap: |F^-1 sigma_t| <= min(-sigma_nu, p_cap)")
            }
        }
    }

    /// The law as programs see it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Frictionless => "frictionless",
            Self::Tresca { .. } => "tresca",
            Self::Coulomb { coefficients } => coefficients.shape(),
            Self::CappedCoulomb { .. } => "capped",
        }
    }

    /// F; `None` without friction.
    #[must_use]
    pub fn coefficients(&self) -> Option<&FrictionLaw> {
        match self {
            Self::Frictionless => None,
            Self::Tresca { coefficients, .. }
            | Self::Coulomb { coefficients }
            | Self::CappedCoulomb { coefficients, .. } => Some(coefficients),
        }
    }

    /// The stress that the scene gives the law, with its name; `None` for laws without one.
    #[must_use]
    pub fn given_stress(&self) -> Option<(&'static str, Quantity)> {
        match self {
            Self::Frictionless | Self::Coulomb { .. } => None,
            Self::Tresca { slip_bound, .. } => Some(("slip bound g", slip_bound.clone())),
            Self::CappedCoulomb { pressure_cap, .. } => {
                Some(("pressure cap", Quantity::Constant(*pressure_cap)))
            }
        }
    }

    /// Whether the coefficients follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        self.coefficients()
            .is_some_and(FrictionLaw::depends_on_slip)
    }
}
