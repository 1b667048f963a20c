//! What a scene asks of its contact face: frame, initial gap and law of friction.

use super::{
    ClementStars, ContactFrame, CoulombLaw, Coupling, FaceLaw, SlipMap, SlipOperator,
    held_nodes::{refuse_dependent, refuse_penetration},
    law_bounds,
};
use crate::{
    elasticity::DofMap,
    mesh::{ContactSurface, Mesh, SurfaceFace},
    scene::{
        ContactFeatures, FrictionModel, InvalidValue, ModelFeatures, Quantity, Scene,
        SlipInterpolation, UNDEFINED, Warning, Written, place_words,
    },
};

/// The laws of the contact face: frame, initial gap and friction. What a scene does not call for
/// is not there.
#[derive(Debug, Clone)]
pub struct Interface {
    /// Names of the faces, in the order of their multipliers.
    pub names: Vec<String>,
    /// ν and the axes of friction.
    pub frame: ContactFrame,
    /// Initial gap d ≥ 0 at the contact nodes in m, `[n_contact_nodes]`: the distance from an obstacle plus the gap of
    /// the scene; `None` without both.
    pub gap: Option<Vec<f64>>,
    /// How slips are made from displacements.
    pub slip: SlipMap,
    /// The law of tangential stresses.
    pub friction: InterfaceFriction,
}

/// The law of tangential stresses, with the data of the contact face it needs.
#[derive(Debug, Clone)]
pub enum InterfaceFriction {
    /// No tangential stresses, and no tangential multipliers.
    Frictionless,
    /// Tresca's law: the semi-axes g F₁, g F₂ in Pa of each pane with friction, `[n_friction_panes]`.
    Tresca(Vec<[f64; 2]>),
    /// A slip bound that follows the pressure, as Coulomb's law has, on one face at least.
    Coulomb(Box<CoulombLaw>),
}

impl Interface {
    /// The contact face's laws; `None` in a scene without contact.
    ///
    /// # Errors
    /// Formulas that are not finite, a negative gap or slip bound, a coefficient of friction that
    /// is not positive without slip, an axis that is not tangential, a clamp that pushes a contact node into the foundation, or leaves fewer displacements to a node than it has
    /// multipliers.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Option<Self>, InvalidValue> {
        let (Some(first), Some(surface)) = (scene.contacts.first(), &mesh.contact) else {
            return Ok(None);
        };
        let features = ModelFeatures::of(scene).contact;
        if features.len() != surface.faces.len() {
            return Err(other_faces(features.len(), surface.faces.len()));
        }
        let held = mesh.held_nodes(scene);
        let frame = ContactFrame::new(scene, &features, surface, mesh)?;
        let gap = gap(scene, &features, surface, mesh)?;
        refuse_penetration(scene, mesh, surface, &frame, gap.as_deref())?;
        refuse_dependent(scene, &features, mesh, surface, &frame)?;
        Ok(Some(Self {
            names: features.iter().map(|face| face.name.clone()).collect(),
            slip: SlipMap {
                operator: match first.slip_interpolation {
                    SlipInterpolation::Lagrange => SlipOperator::Lagrange,
                    SlipInterpolation::Clement => {
                        let is_held = |node: usize| held[node] == [true; 3];
                        SlipOperator::Clement(ClementStars::new(surface, mesh, is_held))
                    }
                },
                past: None,
            },
            frame,
            gap,
            friction: InterfaceFriction::new(scene, &features, surface, mesh)?,
        }))
    }

    /// Number of panes with friction, which come first.
    #[must_use]
    pub fn n_friction_panes(&self) -> usize {
        match &self.friction {
            InterfaceFriction::Frictionless => 0,
            InterfaceFriction::Tresca(semi_axes) => semi_axes.len(),
            InterfaceFriction::Coulomb(law) => law.n_panes(),
        }
    }

    /// Whether tangential multipliers exist.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        !matches!(self.friction, InterfaceFriction::Frictionless)
    }

    /// What is allowed in the laws and probably not meant, for a body of this extent in the unit of
    /// length called `length`.
    #[must_use]
    pub fn warnings(&self, extent: f64, length: &str) -> Vec<Warning> {
        let faces = self.coulomb().into_iter().flat_map(CoulombLaw::faces);
        faces
            .flat_map(|face| law_bounds::warnings(face, extent, length))
            .collect()
    }

    /// B, with rows of T where there is friction.
    #[must_use]
    pub fn coupling(&self, surface: &ContactSurface, dofs: &DofMap) -> Coupling {
        Coupling::new(surface, &self.frame, self.n_friction_panes(), dofs)
    }

    /// B with rows of T on all panes, with friction or not.
    #[must_use]
    pub fn coupling_everywhere(&self, surface: &ContactSurface, dofs: &DofMap) -> Coupling {
        Coupling::new(surface, &self.frame, surface.n_panes(), dofs)
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
}

impl InterfaceFriction {
    /// The friction of all faces. Given slip bounds alone are ellipses known beforehand; beside a law that follows the
    /// pressure they are part of it.
    fn new(
        scene: &Scene,
        features: &[ContactFeatures],
        surface: &ContactSurface,
        mesh: &Mesh,
    ) -> Result<Self, InvalidValue> {
        let faces = surface.faces.iter().zip(features);
        let laws = faces.filter_map(|(face, has)| {
            let (key, _) = scene.friction_on(has.entry)?;
            let model = has.friction.as_ref()?;
            Some(face_law(key, model, face, surface, mesh))
        });
        let laws: Vec<FaceLaw> = laws.collect::<Result<_, InvalidValue>>()?;
        if laws.is_empty() {
            return Ok(Self::Frictionless);
        }
        if !laws.iter().any(FaceLaw::follows_pressure) {
            return Ok(Self::Tresca(
                laws.iter().flat_map(FaceLaw::given_semi_axes).collect(),
            ));
        }
        let length = scene.units.length();
        for law in &laws {
            law_bounds::refuse_unusable(law, length)?;
        }
        Ok(Self::Coulomb(Box::new(CoulombLaw::new(laws))))
    }
}

/// The law of a face under its key.
fn face_law(
    key: String,
    model: &FrictionModel,
    face: &SurfaceFace,
    surface: &ContactSurface,
    mesh: &Mesh,
) -> Result<FaceLaw, InvalidValue> {
    let places = positions(surface, face, mesh);
    let of_panes = match model.bound.place_dependent() {
        None => Vec::new(),
        Some((name, stress)) => {
            let values = non_negative(&format!("{key}.{name}"), stress, &places)?;
            // Means are taken over the nodes of this face.
            let mean = |pane: usize| -> f64 {
                let weights = surface.pane_weights(pane);
                weights
                    .map(|(node, weight)| weight * values[node - face.nodes.start])
                    .sum()
            };
            face.panes.clone().map(mean).collect()
        }
    };
    let law = FaceLaw::new(key, model.coefficients.clone(), places);
    let mut law = law.placed(face.nodes.start, face.panes.clone());
    (law.bound, law.of_panes) = (model.bound.clone(), of_panes);
    Ok(law)
}

/// The initial gaps of all faces, the distances from obstacles included; 0 where a face has none, `None` where none has
/// one.
fn gap(
    scene: &Scene,
    features: &[ContactFeatures],
    surface: &ContactSurface,
    mesh: &Mesh,
) -> Result<Option<Vec<f64>>, InvalidValue> {
    if features.iter().all(|face| face.gap.is_none()) {
        let clearance = &surface.clearance;
        return Ok((!clearance.is_empty()).then(|| clearance.clone()));
    }
    let mut gaps = Vec::with_capacity(surface.nodes.len());
    for (face, has) in surface.faces.iter().zip(features) {
        match &has.gap {
            None => gaps.resize(face.nodes.end, 0.0),
            Some(gap) => {
                let key = format!("{}.gap", scene.contact_key(has.entry));
                gaps.extend(non_negative(&key, gap, &positions(surface, face, mesh))?);
            }
        }
    }
    for (gap, clearance) in gaps.iter_mut().zip(&surface.clearance) {
        *gap += clearance;
    }
    Ok(Some(gaps))
}

/// A mesh with other contact faces than the scene's.
fn other_faces(expected: usize, found: usize) -> InvalidValue {
    InvalidValue {
        key: "contact".into(),
        expected: format!("a mesh with {expected} contact faces, as the scene has"),
        found: format!("one with {found}"),
        help: "make the mesh of this scene anew".into(),
    }
}

fn positions(surface: &ContactSurface, face: &SurfaceFace, mesh: &Mesh) -> Vec<[f64; 3]> {
    let nodes = surface.nodes[face.nodes.clone()].iter();
    nodes.map(|&node| mesh.coordinates[node]).collect()
}

/// A quantity at points, refused where it is negative or not finite.
fn non_negative(
    key: &str,
    quantity: &Quantity,
    points: &[[f64; 3]],
) -> Result<Vec<f64>, InvalidValue> {
    let values: Vec<f64> = points.iter().map(|x| quantity.at(*x)).collect();
    match values.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
        None => Ok(values),
        Some(at) => Err(InvalidValue {
            key: key.to_owned(),
            expected: "a value >= 0 at every contact node".into(),
            found: format!("{} at {}", Written(&values[at]), place_words(points[at])),
            help: if values[at] < 0.0 {
                "write max(FORMULA, 0), or add a constant to the formula".into()
            } else {
                UNDEFINED.into()
            },
        }),
    }
}
