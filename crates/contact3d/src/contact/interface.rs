//! What a scene asks of its contact face: frame, initial gap and law of friction.

use std::sync::{
    OnceLock,
    atomic::{AtomicUsize, Ordering},
};

use super::{ContactFrame, Coupling, SlipOperator, law_bounds, prescribed::refuse_penetration};
use crate::{
    elasticity::DofMap,
    mesh::{ContactSurface, Mesh},
    scene::{
        Coefficient, FrictionLaw, FrictionModel, Invalid, ModelFeatures, Quantity, Scene,
        UNDEFINED, Warning, Written, place_words,
    },
};

/// The laws of the contact face: frame, initial gap and friction. What a scene does not call for
/// is not there.
#[derive(Debug)]
pub struct Interface {
    /// ν and the axes of friction.
    pub frame: ContactFrame,
    /// Initial gap d ≥ 0 at the contact nodes in m, `[n_contact_nodes]`; `None` for no gap.
    pub gap: Option<Vec<f64>>,
    /// How slips are made from displacements.
    pub slip: SlipOperator,
    /// The law of tangential stresses.
    pub friction: InterfaceFriction,
    /// Projections on ellipses so far.
    pub projections: AtomicUsize,
}

/// The law of tangential stresses, with the data of the contact face it needs.
#[derive(Debug)]
pub enum InterfaceFriction {
    /// No tangential stresses, and no tangential multipliers.
    Frictionless,
    /// Tresca's law: the semi-axes g F₁, g F₂ in Pa of each pane, `[n_panes]`.
    Tresca(Vec<[f64; 2]>),
    /// A slip bound that follows the pressure, as Coulomb's law has.
    Coulomb(Box<CoulombLaw>),
}

/// Coulomb's law with F(x, |u_t1|, |u_t2|) at the contact nodes.
#[derive(Debug)]
pub struct CoulombLaw {
    law: FrictionLaw,
    /// Contact nodes, `[n_contact_nodes]`, in m.
    positions: Vec<[f64; 3]>,
    /// The coefficients at the contact nodes of a law that does not follow the slip.
    unchanging: OnceLock<Vec<[f64; 2]>>,
    evaluations: AtomicUsize,
    /// All coefficients are this many times those of `law`.
    factor: f64,
    softening: Option<Softening>,
    bound: PressureBound,
}

/// The slip bound g as a function of the pressure.
#[derive(Debug, Clone, Copy)]
enum PressureBound {
    /// g = λ_ν.
    Uncapped,
    /// g = min(λ_ν, p_cap), with p_cap in Pa.
    Capped(f64),
}

/// F₀^(1−τ) F^τ in place of F.
#[derive(Debug, Clone, Copy)]
struct Softening {
    reference: f64,
    share: f64,
}

impl Softening {
    /// F₀^(1−τ) F^τ.
    fn value(self, coefficient: f64) -> f64 {
        self.reference.powf(1.0 - self.share) * coefficient.powf(self.share)
    }
}

impl Interface {
    /// The same face with the coefficients of Coulomb's law multiplied by a factor t > 0, and counters of its own; `None`
    /// where the law is another one.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        Some(Self {
            frame: self.frame.clone(),
            gap: self.gap.clone(),
            slip: self.slip.clone(),
            friction: InterfaceFriction::Coulomb(Box::new(self.coulomb()?.scaled(factor))),
            projections: AtomicUsize::new(0),
        })
    }

    /// The contact face's laws; `None` in a scene without contact.
    ///
    /// # Errors
    /// Formulas that are not finite, a negative gap or slip bound, a coefficient of friction that
    /// is not positive without slip, an axis that is not tangential, a clamp that pushes a contact node into the foundation.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Option<Self>, Invalid> {
        let (Some(contact), Some(surface)) = (&scene.contact, &mesh.contact) else {
            return Ok(None);
        };
        let features = ModelFeatures::of(scene);
        let Some(has) = features.contact() else {
            return Ok(None);
        };
        let length = scene.units.length();
        let held = mesh.held_nodes(scene);
        let frame = ContactFrame::new(contact, has.turning_frame, surface, mesh)?;
        let gap = match &has.gap {
            None => None,
            Some(gap) => Some(non_negative("contact.gap", gap, &positions(surface, mesh))?),
        };
        refuse_penetration(scene, mesh, surface, &frame, gap.as_deref())?;
        Ok(Some(Self {
            slip: SlipOperator::new(contact.slip_interpolation, surface, mesh, |node| {
                held[node] == [true; 3]
            }),
            frame,
            gap,
            friction: InterfaceFriction::new(&has.friction, length, surface, mesh)?,
            projections: AtomicUsize::new(0),
        }))
    }

    /// Whether tangential multipliers exist.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        match self.friction {
            InterfaceFriction::Frictionless => false,
            InterfaceFriction::Tresca(_) | InterfaceFriction::Coulomb(_) => true,
        }
    }

    /// What is allowed in the laws and probably not meant, for a body of this extent in the unit of
    /// length called `length`.
    #[must_use]
    pub fn warnings(&self, extent: f64, length: &str) -> Vec<Warning> {
        let law = self.coulomb();
        law.map_or_else(Vec::new, |law| law_bounds::warnings(law, extent, length))
    }

    /// B, with rows of T where there is friction.
    #[must_use]
    pub fn coupling(&self, surface: &ContactSurface, dofs: &DofMap) -> Coupling {
        Coupling::new(surface, &self.frame, self.has_friction(), dofs)
    }

    /// Coulomb's law, where it is the law.
    #[must_use]
    pub fn coulomb(&self) -> Option<&CoulombLaw> {
        match &self.friction {
            InterfaceFriction::Coulomb(law) => Some(law),
            InterfaceFriction::Frictionless | InterfaceFriction::Tresca(_) => None,
        }
    }

    /// Whether the coefficients of friction follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        self.coulomb().is_some_and(CoulombLaw::depends_on_slip)
    }

    /// Evaluations of the friction law at nodes so far.
    #[must_use]
    pub fn law_evaluations(&self) -> usize {
        self.coulomb()
            .map_or(0, |law| law.evaluations.load(Ordering::Relaxed))
    }

    /// Sets the number of evaluations, for a solve that goes on from a checkpoint.
    pub(crate) fn set_law_evaluations(&self, evaluations: usize) {
        if let Some(law) = self.coulomb() {
            law.evaluations.store(evaluations, Ordering::Relaxed);
        }
    }
}

impl InterfaceFriction {
    /// A model of friction on the panes, in the unit of length called `length`.
    fn new(
        model: &FrictionModel,
        length: &str,
        surface: &ContactSurface,
        mesh: &Mesh,
    ) -> Result<Self, Invalid> {
        let positions = positions(surface, mesh);
        match model {
            FrictionModel::Frictionless => Ok(Self::Frictionless),
            FrictionModel::Tresca {
                slip_bound,
                coefficients,
            } => {
                let bound = non_negative("friction.slip_bound", slip_bound, &positions)?;
                let coefficients = coefficients.evaluate([0.0; 3], [0.0; 2]);
                let semi_axes = (0..surface.n_panes())
                    .map(|pane| coefficients.map(|f| f * surface.pane_mean(pane, &bound)));
                Ok(Self::Tresca(semi_axes.collect()))
            }
            FrictionModel::Coulomb { coefficients } => {
                Self::coulomb(CoulombLaw::new(coefficients.clone(), positions), length)
            }
            FrictionModel::CappedCoulomb {
                coefficients,
                pressure_cap,
            } => {
                let law = CoulombLaw::new(coefficients.clone(), positions);
                Self::coulomb(law.capped(*pressure_cap), length)
            }
        }
    }

    fn coulomb(law: CoulombLaw, length: &str) -> Result<Self, Invalid> {
        law_bounds::refuse_unusable(&law, length)?;
        Ok(Self::Coulomb(Box::new(law)))
    }
}

impl CoulombLaw {
    /// A law at the contact nodes.
    #[must_use]
    pub fn new(law: FrictionLaw, positions: Vec<[f64; 3]>) -> Self {
        Self {
            law,
            positions,
            unchanging: OnceLock::new(),
            evaluations: AtomicUsize::new(0),
            factor: 1.0,
            softening: None,
            bound: PressureBound::Uncapped,
        }
    }

    /// The law t F for a factor t > 0, with counters of its own.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            factor: self.factor * factor,
            softening: self.softening,
            bound: self.bound,
            ..Self::new(self.law.clone(), self.positions.clone())
        }
    }

    /// The law with the slip bound min(λ_ν, p_cap) for a p_cap > 0 in Pa.
    #[must_use]
    pub fn capped(self, pressure_cap: f64) -> Self {
        Self {
            bound: PressureBound::Capped(pressure_cap),
            ..self
        }
    }

    /// The law F₀^(1−τ) F^τ between a constant coefficient F₀ > 0 (τ = 0) and this law (τ = 1),
    /// positive and as smooth as this one for every share τ.
    #[must_use]
    pub(crate) fn softened(&self, reference: f64, share: f64) -> Self {
        Self {
            factor: self.factor,
            softening: (share < 1.0).then_some(Softening { reference, share }),
            bound: self.bound,
            ..Self::new(self.law.clone(), self.positions.clone())
        }
    }

    /// (F₁, F₂) at all contact nodes for their slips in m, `[n_contact_nodes]`; no slips mean zero.
    /// A law that does not follow the slip is evaluated only once.
    #[must_use]
    pub(crate) fn at_nodes(&self, slip: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let everywhere = |slip: &[[f64; 2]]| {
            let slip_of = |node: usize| slip.get(node).copied().unwrap_or([0.0; 2]);
            let nodes = 0..self.positions.len();
            nodes
                .map(|node| self.evaluate(node, slip_of(node)))
                .collect()
        };
        if self.depends_on_slip() {
            return everywhere(slip);
        }
        self.unchanging.get_or_init(|| everywhere(&[])).clone()
    }

    /// (F₁, F₂) at a contact node for the slips (|u_t1|, |u_t2|) in m.
    #[must_use]
    pub fn evaluate(&self, contact_node: usize, slip: [f64; 2]) -> [f64; 2] {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let given = self.law.evaluate(self.positions[contact_node], slip);
        let given = given.map(|f| self.factor * f);
        match self.softening {
            Some(softening) => given.map(|f| softening.value(f)),
            None => given,
        }
    }

    /// ∂F_i/∂|u_tk| in 1/m at a contact node.
    #[must_use]
    pub fn derivative(&self, contact_node: usize, slip: [f64; 2]) -> [[f64; 2]; 2] {
        let position = self.positions[contact_node];
        let given = self.law.derivative(position, slip);
        let given = given.map(|row| row.map(|d| self.factor * d));
        let Some(softening) = self.softening else {
            return given;
        };
        // d(F₀^(1−τ) F^τ) = τ F₀^(1−τ) F^τ / F dF.
        let coefficients = self.law.evaluate(position, slip).map(|f| self.factor * f);
        std::array::from_fn(|i| {
            let factor = softening.share * softening.value(coefficients[i]) / coefficients[i];
            given[i].map(|d| factor * d)
        })
    }

    /// The law as a function of place and slip, without the factor of [`Self::scaled`]; its evaluations are not counted.
    #[must_use]
    pub fn law(&self) -> &FrictionLaw {
        &self.law
    }

    /// F of an isotropic law, or F₁ and F₂.
    #[must_use]
    pub fn coefficients(&self) -> &[Coefficient] {
        self.law.coefficients()
    }

    /// The contact nodes in m, `[n_contact_nodes]`.
    #[must_use]
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// The slip bound g in Pa under a pressure λ_ν in Pa; NaN for NaN.
    #[must_use]
    pub fn slip_bound(&self, pressure: f64) -> f64 {
        match self.bound {
            PressureBound::Capped(cap) if pressure > cap => cap,
            PressureBound::Capped(_) | PressureBound::Uncapped => pressure,
        }
    }

    /// dg/dλ_ν; at a cap that of larger pressures, an element of the generalised derivative.
    #[must_use]
    pub(crate) fn slip_bound_slope(&self, pressure: f64) -> f64 {
        match self.bound {
            PressureBound::Capped(cap) if pressure >= cap => 0.0,
            PressureBound::Capped(_) | PressureBound::Uncapped => 1.0,
        }
    }

    /// Whether any coefficient depends on the solution.
    #[must_use]
    pub fn depends_on_slip(&self) -> bool {
        self.law.depends_on_slip()
    }
}

fn positions(surface: &ContactSurface, mesh: &Mesh) -> Vec<[f64; 3]> {
    let nodes = surface.nodes.iter();
    nodes.map(|&node| mesh.coordinates[node]).collect()
}

/// A quantity at points, refused where it is negative or not finite.
fn non_negative(key: &str, quantity: &Quantity, points: &[[f64; 3]]) -> Result<Vec<f64>, Invalid> {
    let values: Vec<f64> = points.iter().map(|x| quantity.at(*x)).collect();
    match values.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
        None => Ok(values),
        Some(at) => Err(Invalid {
            key: key.to_owned(),
            expected: "a value >= 0 at every contact node".into(),
            found: format!("{} at {}", Written(&values[at]), place_words(points[at])),
            help: match values[at] < 0.0 {
                true => "write max(FORMULA, 0), or add a constant to the formula".into(),
                false => UNDEFINED.into(),
            },
        }),
    }
}
