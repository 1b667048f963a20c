//! What a scene asks of its contact face: frame, initial gap and law of friction; and what it must not ask of nodes that clamps hold.

use std::{borrow::Cow, sync::Arc};

use super::{ContactFrame, CoulombLaw, Coupling, FaceLaw, law_bounds};
use crate::{
    elasticity::{DofMap, prescribed_displacements},
    linalg::UNIT_ROUNDING,
    mesh::{ContactSurface, DEEPEST_INTERFERENCE, Mesh, SurfaceFace},
    scene::{
        ContactFeatures, FrictionModel, InvalidValue, Quantity, Scene, SlipMeasure, UNDEFINED,
        Warning, Written, place_words,
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
    /// Initial gap d at the contact nodes in m, negative with interference, `[n_contact_nodes]`: the distance from an obstacle plus the gap of
    /// the scene; `None` without both.
    pub gap: Option<Vec<f64>>,
    /// Where the step begins; `None` in the first of a load history, and without a history.
    pub previous: Option<PreviousIncrement>,
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
        let Some(surface) = mesh.contact.as_ref().filter(|_| scene.has_contact()) else {
            return Ok(None);
        };
        let features = scene.contact_features();
        if features.len() != surface.faces.len() {
            return Err(other_faces(features.len(), surface.faces.len()));
        }
        let frame = ContactFrame::new(scene, &features, surface, mesh)?;
        let gap = gap(scene, &features, surface, mesh)?;
        refuse_penetration(scene, mesh, surface, &frame, gap.as_deref())?;
        refuse_dependent(scene, &features, mesh, surface, &frame)?;
        let interface = Self {
            names: features.iter().map(|face| face.name.clone()).collect(),
            previous: None,
            frame,
            gap,
            friction: InterfaceFriction::new(scene, &features, surface, mesh)?,
        };
        for (entry, depth) in interface.depths(scene, surface) {
            refuse_deep(scene, mesh, entry, depth)?;
        }
        Ok(Some(interface))
    }

    /// The contacts with interference, by their places in the scene, whose foundation cuts into the body, with the largest depth in m.
    pub fn depths(
        &self,
        scene: &Scene,
        surface: &ContactSurface,
    ) -> impl Iterator<Item = (usize, f64)> {
        let faces = scene.contact_order().into_iter().zip(&surface.faces);
        let faces = faces.filter(|(entry, _)| scene.contacts[*entry].interference);
        let depths = faces.map(|(entry, face)| {
            let gaps = self
                .gap
                .as_ref()
                .map_or(&[][..], |gap| &gap[face.nodes.clone()]);
            (
                entry,
                gaps.iter().fold(0.0, |deepest: f64, gap| deepest.max(-gap)),
            )
        });
        depths.filter(|(_, depth)| *depth > 0.0)
    }

    /// The face in a later step: slip is counted from where the step begins.
    #[must_use]
    pub fn following(mut self, previous: PreviousIncrement) -> Self {
        if previous.follows == SlipMeasure::PathLength
            && let InterfaceFriction::Coulomb(law) = &mut self.friction
        {
            law.path = Some(Arc::new(previous.path.clone()));
        }
        self.previous = Some(previous);
        self
    }

    /// [`slips`] of a displacement over the free degrees of freedom in m.
    #[must_use]
    pub fn slip_of_displacement(
        &self,
        surface: &ContactSurface,
        dofs: &DofMap,
        displacement: &[f64],
    ) -> Vec<[f64; 2]> {
        let at_row = |row| dofs.at_node(row, displacement);
        let tangential = self.frame.nodal_tangential(surface, dofs, at_row);
        slips(self.previous.as_ref(), &tangential)
    }

    /// The lengths of the path of sliding at the end of a step, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn path_after(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let nodes = tangential.iter().enumerate();
        nodes
            .map(|(node, moved)| {
                let from = self.slip_origin(node);
                let [first, second] = [0, 1].map(|k| (moved[k] - from[k]).abs());
                let previous = self.previous.as_ref();
                let before = previous.map_or([0.0; 3], |previous| previous.path[node]);
                [
                    before[0] + first,
                    before[1] + second,
                    before[2] + first.hypot(second),
                ]
            })
            .collect()
    }

    /// Where the slip of the step is counted from at a contact node, (u_t1, u_t2) in m.
    #[must_use]
    pub fn slip_origin(&self, node: usize) -> [f64; 2] {
        let previous = self.previous.as_ref();
        previous.map_or([0.0; 2], |previous| previous.tangential[node])
    }

    /// What the integrals of (u_ν, u_t1, u_t2) over the panes are counted from: those of the gap, and of where the
    /// step begins, in m³; `[n_multipliers]`, or shorter by what is zero.
    pub(crate) fn offsets(&self, surface: &ContactSurface) -> Vec<f64> {
        let n_panes = surface.n_panes();
        let over =
            |pane: usize, values: &[f64]| surface.pane_area[pane] * surface.pane_mean(pane, values);
        let mut offsets = match &self.gap {
            Some(gap) => (0..n_panes).map(|pane| over(pane, gap)).collect(),
            None => Vec::new(),
        };
        let previous = self.previous.as_ref().filter(|_| self.has_friction());
        let Some(previous) = previous else {
            return offsets;
        };
        offsets.resize(n_panes, 0.0);
        for (mean, area) in previous.pane_tangential.iter().zip(&surface.pane_area) {
            offsets.extend(mean.map(|mean| area * mean));
        }
        offsets
    }

    /// The means of (u_t1, u_t2) over the panes with friction in m, of nodal ones and of the displacements that these come from.
    #[must_use]
    pub fn pane_tangential(
        &self,
        surface: &ContactSurface,
        nodal: &[[f64; 2]],
        at_node: impl Fn(usize) -> [f64; 3],
    ) -> Vec<[f64; 2]> {
        let components = [0, 1].map(|k| nodal.iter().map(|u| u[k]).collect::<Vec<_>>());
        let panes = 0..self.n_friction_panes();
        let mean = |pane: usize| {
            if surface.touches_body(pane) {
                // Nothing of a tool is opposite a body.
                let tool_row = |_| [0.0; 3];
                let [_, first, second] =
                    self.frame.pane_relative(surface, pane, &at_node, tool_row);
                return [first, second];
            }
            components
                .each_ref()
                .map(|values| surface.pane_mean(pane, values))
        };
        panes.map(mean).collect()
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
        self.friction.coulomb()
    }

    /// Whether the coefficients of friction follow the slip.
    #[must_use]
    pub fn follows_slip(&self) -> bool {
        self.coulomb().is_some_and(CoulombLaw::depends_on_slip)
    }
}

impl InterfaceFriction {
    /// Coulomb's law, where it is the law.
    pub(crate) fn coulomb(&self) -> Option<&CoulombLaw> {
        match self {
            Self::Coulomb(law) => Some(law),
            Self::Frictionless | Self::Tresca(_) => None,
        }
    }

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
        if !laws.iter().any(|law| law.bound.follows_pressure()) {
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
            let values = at_least(0.0, &format!("{key}.{name}"), stress, &places)?;
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
    let mut clearance = surface.clearance.clone();
    for (face, has) in surface.faces.iter().zip(features) {
        // What overlaps by less than the mesh leaves of curved faces touches.
        if !scene.contacts[has.entry].interference && !clearance.is_empty() {
            let of_face = clearance[face.nodes.clone()].iter_mut();
            of_face.for_each(|distance| *distance = distance.max(0.0));
        }
    }
    if clearance.iter().all(|distance| *distance == 0.0) && surface.opposite.is_some() {
        clearance.clear();
    }
    if features.iter().all(|face| face.gap.is_none()) {
        return Ok((!clearance.is_empty()).then_some(clearance));
    }
    let mut gaps = Vec::with_capacity(surface.nodes.len());
    for (face, has) in surface.faces.iter().zip(features) {
        match &has.gap {
            None => gaps.resize(face.nodes.end, 0.0),
            Some(gap) => {
                let key = format!("{}.gap", scene.contact_key(has.entry));
                let places = positions(surface, face, mesh);
                let least = match scene.contacts[has.entry].interference {
                    true => f64::NEG_INFINITY,
                    false => 0.0,
                };
                gaps.extend(at_least(least, &key, gap, &places)?);
            }
        }
    }
    for (gap, clearance) in gaps.iter_mut().zip(&clearance) {
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

fn refuse_deep(scene: &Scene, mesh: &Mesh, entry: usize, depth: f64) -> Result<(), InvalidValue> {
    let share = depth / mesh.extent();
    if share <= DEEPEST_INTERFERENCE {
        return Ok(());
    }
    Err(InvalidValue {
        key: format!("{}.interference", scene.contact_key(entry)),
        expected: format!(
            "depths up to {DEEPEST_INTERFERENCE} of the body's size, for displacements are small"
        ),
        found: format!(
            "{} {}, {share:.2} of it",
            Written(&depth),
            scene.units.length()
        ),
        help: "check the place and the size of the obstacle, and the unit of lengths".into(),
    })
}

/// A quantity at points, refused where it is below `least` or not finite.
fn at_least(
    least: f64,
    key: &str,
    quantity: &Quantity,
    points: &[[f64; 3]],
) -> Result<Vec<f64>, InvalidValue> {
    let values: Vec<f64> = points.iter().map(|x| quantity.at(*x)).collect();
    match values.iter().position(|v| !(*v >= least && v.is_finite())) {
        None => Ok(values),
        Some(at) => Err(InvalidValue {
            key: key.to_owned(),
            expected: "a value >= 0 at every contact node".into(),
            found: format!("{} at {}", Written(&values[at]), place_words(points[at])),
            help: if values[at] < 0.0 {
                "write max(FORMULA, 0), or add a constant to the formula; a gap may be negative with interference = true".into()
            } else {
                UNDEFINED.into()
            },
        }),
    }
}

/// Refuses nodes that clamps hold in part, with rows of ν, t₁ and t₂ along their free axes that are more than these: S would be
/// singular, and the stress along the held axis anything.
///
/// # Errors
/// The key of the contact, and the place of the first such node.
fn refuse_dependent(
    scene: &Scene,
    features: &[ContactFeatures],
    mesh: &Mesh,
    surface: &ContactSurface,
    frame: &ContactFrame,
) -> Result<(), InvalidValue> {
    let held = mesh.held_nodes(scene);
    let faces = surface.faces.iter().zip(features);
    let rough = faces.filter(|(face, of)| face.is_nodal && of.friction.is_some());
    for (face, of) in rough {
        for local in face.nodes.clone() {
            let node = surface.nodes[local];
            if surface.carried_by(face, local).is_none() || held[node] == [false; 3] {
                continue;
            }
            let free = || (0..3).filter(|&c| !held[node][c]);
            let [first, second] = *frame.axes_at(local);
            let rows = [frame.normal_at(local), first, second];
            let active = rows
                .iter()
                .filter(|row| free().any(|c| row[c].abs() > UNIT_ROUNDING));
            if active.count() > free().count() {
                return Err(InvalidValue {
                    key: format!("{}.multipliers", scene.contact_key(of.entry)),
                    expected: "nodes that carry no more conditions than they have displacements".into(),
                    found: format!(
                        "the node at {}, which a clamp holds along some axes, and whose normal and axes of friction lie along none of them",
                        place_words(mesh.coordinates[node])
                    ),
                    help: "write multipliers = \"panes\", which have nodes of their own; or give the face axes of friction along those of the clamp".into(),
                });
            }
        }
    }
    Ok(())
}

/// Refuses clamps that push a contact node into the foundation, which gives way to nothing.
///
/// # Errors
/// The place of the first such node; what [`prescribed_displacements`] refuses.
fn refuse_penetration(
    scene: &Scene,
    mesh: &Mesh,
    surface: &ContactSurface,
    frame: &ContactFrame,
    gap: Option<&[f64]>,
) -> Result<(), InvalidValue> {
    let Some(prescribed) = prescribed_displacements(scene, mesh)? else {
        return Ok(());
    };
    let held = mesh.held_nodes(scene);
    for (local, &node) in surface.nodes.iter().enumerate() {
        let normal = frame.normal_at(local);
        let is_held = |node: usize| (0..3).all(|c| normal[c] == 0.0 || held[node][c]);
        let opposite = surface.opposite.as_ref();
        let opposite = || opposite.into_iter().flat_map(|of| of.at_node(local));
        if !is_held(node) || opposite().any(|(node, share)| share != 0.0 && !is_held(node)) {
            continue;
        }
        let part = |node: usize| frame.normal_part(local, prescribed[node]);
        let away: f64 = opposite().map(|(node, share)| share * part(node)).sum();
        let towards = part(node) - away;
        let gap = gap.map_or(0.0, |gap| gap[local]);
        let size = prescribed[node]
            .iter()
            .fold(gap, |most, u| most.max(u.abs()));
        if towards - gap > UNIT_ROUNDING * size {
            return Err(InvalidValue {
                key: "clamp".into(),
                expected: format!(
                    "at most the gap {} as the displacement of held contact nodes towards what they touch",
                    Written(&gap)
                ),
                found: format!("{} {}", Written(&towards), place_words(mesh.coordinates[node])),
                help: "what is held gives way to nothing: give such nodes a gap, move them less, or leave the axis towards each other out of the components of a clamp".into(),
            });
        }
    }
    Ok(())
}

/// The slips φ that coefficients follow at the contact nodes, for the signed (u_t1, u_t2) there, in m, after the increment before, if there
/// was one. A path of sliding from former steps is added by the law.
#[must_use]
pub fn slips(previous: Option<&PreviousIncrement>, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let counted = counted(previous, tangential);
    counted.iter().map(|u| u.map(f64::abs)).collect()
}

/// The derivative of [`slips`] by (u_t1, u_t2) at the same node: the signs of both, 0 for 0.
#[must_use]
pub fn slip_signs(previous: Option<&PreviousIncrement>, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let sign = |u: f64| if u == 0.0 { 0.0 } else { u.signum() };
    let counted = counted(previous, tangential);
    counted.iter().map(|u| u.map(sign)).collect()
}

/// u_t less where the slip is counted from, where the law counts from there.
fn counted<'u>(
    previous: Option<&PreviousIncrement>,
    tangential: &'u [[f64; 2]],
) -> Cow<'u, [[f64; 2]]> {
    match previous {
        Some(previous) if previous.follows != SlipMeasure::TotalSlip => {
            previous.slip(tangential).into()
        }
        _ => tangential.into(),
    }
}

/// The change of slips whose derivatives are signs, with a change of (u_t1, u_t2) at the nodes.
pub fn change_of_slips(signs: &[[f64; 2]], moved: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
    let nodes = signs.iter().enumerate();
    let change = nodes.map(|(node, sign)| {
        let moved = moved(node);
        [sign[0] * moved[0], sign[1] * moved[1]]
    });
    change.collect()
}

/// Where the contact nodes are when a step begins, and how far they have slid.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviousIncrement {
    /// (u_t1, u_t2) that the slip of the step is counted from, `[n_contact_nodes]`, in m.
    pub tangential: Vec<[f64; 2]>,
    /// Their means over the panes with friction, `[n_friction_panes]`, in m.
    pub pane_tangential: Vec<[f64; 2]>,
    /// Lengths of the path of sliding: Σ r_h|Δu_t1|, Σ r_h|Δu_t2| and the sum of the roots of their squares,
    /// `[n_contact_nodes]`, in m.
    pub path: Vec<[f64; 3]>,
    /// The slip that coefficients of friction follow.
    pub follows: SlipMeasure,
}

impl PreviousIncrement {
    /// u_t − u_tⁿ⁻¹ at the contact nodes in m.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let pairs = tangential.iter().zip(&self.tangential);
        pairs
            .map(|(u, from)| [u[0] - from[0], u[1] - from[1]])
            .collect()
    }
}
