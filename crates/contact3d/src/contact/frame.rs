//! The frame (ν, t₁, t₂) of the contact face, fixed or turning from node to node.

use nalgebra::Vector3;

use crate::{
    elasticity::{DofMap, ToolPlace, ToolPoint},
    linalg::{FEW_ROUNDINGS, norm},
    mesh::{ContactSurface, GEOMETRY_TOLERANCE, Mesh},
    scene::{
        Contact, ContactFeatures, InvalidValue, Scene, UNDEFINED, Written, numbers, place_words,
    },
};

/// The orthonormal frame (ν, t₁, t₂) of the contact face, with t₂ = t₁ × ν; normals and the axes of
/// friction may turn from node to node.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFrame {
    /// Outward unit normal ν: one for the whole face, or one for each contact node.
    pub normals: Vec<[f64; 3]>,
    /// (t₁, t₂): one pair for the whole face, or one for each contact node.
    pub axes: Vec<[[f64; 3]; 2]>,
    /// What to draw each face in.
    pub references: Vec<ReferenceFrame>,
    /// What lies opposite each contact node, `[n_contact_nodes]`; empty where nothing of that moves.
    pub opposite: Vec<Counterpart>,
}

/// What lies opposite a contact node.
#[derive(Debug, Clone, PartialEq)]
pub enum Counterpart {
    /// A foundation or an obstacle at rest.
    AtRest,
    /// An obstacle that moves with a tool.
    Tool(ToolPoint),
    /// Another body: its nodes around the opposite point with their shape functions there.
    Body(Vec<(usize, f64)>),
}

/// A frame that does not turn, to draw a contact face in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFrame {
    /// ν itself where it is the same on the whole face, otherwise the direction of the mean over the nodes.
    pub normal: [f64; 3],
    /// The axes themselves where they are the same on the whole face, otherwise those of `normal` in a scene without
    /// `axis_1` and `angle`.
    pub axes: [[f64; 3]; 2],
    /// Whether ν is the same on the whole face.
    pub is_flat: bool,
}

impl ContactFrame {
    /// The frame that a scene asks for, one pair of axes where there is one face whose frame does not turn and whose
    /// normals do not vary; where they do, t₁ is projected on the tangent plane of each node.
    ///
    /// # Errors
    /// An axis that vanishes or is not tangential, an angle that is not finite.
    pub fn new(
        scene: &Scene,
        features: &[ContactFeatures],
        surface: &ContactSurface,
        mesh: &Mesh,
    ) -> Result<Self, InvalidValue> {
        let mut frame = Self {
            normals: surface.normals.clone(),
            axes: Vec::new(),
            references: Vec::new(),
            opposite: Vec::new(),
        };
        let tools = ToolPlace::of_scene(scene, mesh);
        let is_uniform = features.len() == 1 && surface.normals.len() == 1;
        for (face, has) in surface.faces.iter().zip(features) {
            let contact = &scene.contacts[has.entry];
            let key = scene.contact_key(has.entry);
            let normals: Vec<[f64; 3]> = if is_uniform {
                surface.normals.clone()
            } else {
                face.nodes.clone().map(|n| surface.normal_at(n)).collect()
            };
            let varies = normals.iter().any(|normal| normal != &normals[0]);
            // t₂ = t₁ × ν turns round with the side that has the panes; an angle is that of the first of two faces.
            let sense = match mesh.is_on_second_face(contact, surface, face) {
                true => -1.0,
                false => 1.0,
            };
            let axes_at = |local: usize| -> Result<[[f64; 3]; 2], InvalidValue> {
                let normal = Vector3::from(surface.normal_at(local));
                let place = mesh.coordinates[surface.nodes[local]];
                let first = first_axis(contact, (&key, sense), &normal, varies, place)?;
                Ok([first.into(), first.cross(&normal).into()])
            };
            let places = if is_uniform && !has.turning_frame {
                face.nodes.start..face.nodes.end.min(face.nodes.start + 1)
            } else {
                face.nodes.clone()
            };
            let axes = places
                .map(axes_at)
                .collect::<Result<Vec<_>, InvalidValue>>()?;
            let constant = axes.first().filter(|_| !has.turning_frame);
            frame
                .references
                .push(ReferenceFrame::of(&normals, constant.copied()));
            frame.axes.extend(axes);
            let tool = scene.tool_on(has.entry);
            let opposite = |local: usize| {
                let Some(tool) = tool else {
                    let body = surface
                        .opposite
                        .as_ref()
                        .map(|of| of.at_node(local).collect());
                    let body = body.filter(|nodes: &Vec<_>| !nodes.is_empty());
                    return body.map_or(Counterpart::AtRest, Counterpart::Body);
                };
                let at = Vector3::from(mesh.coordinates[surface.nodes[local]]);
                let distance = surface.clearance.get(local).unwrap_or(&0.0);
                let at = at + Vector3::from(surface.normal_at(local)) * *distance;
                let lever = tools[tool].lever(at.into());
                Counterpart::Tool(ToolPoint { tool, lever })
            };
            frame.opposite.extend(face.nodes.clone().map(opposite));
        }
        if tools.is_empty() && surface.opposite.is_none() {
            frame.opposite.clear();
        }
        Ok(frame)
    }

    /// ν at a contact node.
    #[must_use]
    pub fn normal_at(&self, contact_node: usize) -> [f64; 3] {
        match self.normals.as_slice() {
            [everywhere] => *everywhere,
            each => each[contact_node],
        }
    }

    /// (t₁, t₂) at a contact node.
    #[must_use]
    pub fn axes_at(&self, contact_node: usize) -> &[[f64; 3]; 2] {
        match self.axes.as_slice() {
            [everywhere] => everywhere,
            each => &each[contact_node],
        }
    }

    /// The mean of [`Self::vector`] over a pane: the stress that acts on it, since its two tangential
    /// components follow the axes of its nodes.
    #[must_use]
    pub fn pane_vector(
        &self,
        surface: &ContactSurface,
        pane: usize,
        normal: f64,
        tangential: [f64; 2],
    ) -> [f64; 3] {
        let weights = surface.pane_weights(pane);
        weights.fold([0.0; 3], |sum, (node, weight)| {
            let vector = self.vector(node, normal, tangential);
            std::array::from_fn(|c| sum[c] + weight * vector[c])
        })
    }

    /// The angle in radians by which the mean t₁ of a pane is turned from the frame its face is drawn in.
    #[must_use]
    pub fn mean_turn(&self, surface: &ContactSurface, pane: usize) -> f64 {
        if self.axes.len() == 1 {
            return 0.0;
        }
        let reference = &self.references[surface.face_of_pane(pane)];
        let [right, up] = reference.axes.map(Vector3::from);
        let mean: Vector3<f64> = surface
            .pane_weights(pane)
            .map(|(node, weight)| Vector3::from(self.axes_at(node)[0]) * weight)
            .sum();
        mean.dot(&up).atan2(mean.dot(&right))
    }

    /// (u·t₁, u·t₂) of a vector at a contact node.
    #[must_use]
    pub fn tangential(&self, contact_node: usize, vector: [f64; 3]) -> [f64; 2] {
        let u = Vector3::from(vector);
        self.axes_at(contact_node)
            .map(|axis| u.dot(&Vector3::from(axis)))
    }

    /// The displacement u − u_o in m of a contact node, one of the mesh, against the point opposite it, for the displacements of the nodes
    /// and of the rows of all tools in m.
    #[must_use]
    pub fn relative(
        &self,
        contact_node: usize,
        node: usize,
        at_node: impl Fn(usize) -> [f64; 3],
        tool_row: impl Fn(usize) -> [f64; 3],
    ) -> [f64; 3] {
        let own = at_node(node);
        let against = |moved: [f64; 3]| std::array::from_fn(|c| own[c] - moved[c]);
        match self.opposite.get(contact_node) {
            None | Some(Counterpart::AtRest) => own,
            Some(Counterpart::Tool(point)) => against(point.moved(tool_row)),
            Some(Counterpart::Body(nodes)) => against(weighted(nodes, at_node)),
        }
    }

    /// The components of a vector along (ν, t₁, t₂) at a contact node.
    #[must_use]
    pub fn components(&self, contact_node: usize, vector: [f64; 3]) -> [f64; 3] {
        let [first, second] = self.tangential(contact_node, vector);
        [self.normal_part(contact_node, vector), first, second]
    }

    /// The mean over a pane of the components of u − u_o in m, for displacements as in [`Self::relative`]; zero where it is no more than
    /// rounding of its terms, as of bodies that stick.
    #[must_use]
    pub fn pane_relative(
        &self,
        surface: &ContactSurface,
        pane: usize,
        at_node: impl Fn(usize) -> [f64; 3],
        tool_row: impl Fn(usize) -> [f64; 3],
    ) -> [f64; 3] {
        let (mut mean, mut size) = ([0.0; 3], 0.0);
        let mut add = |weight: f64, local: usize, u: [f64; 3]| {
            let parts = self.components(local, u).map(|part| weight * part);
            mean = std::array::from_fn(|c| mean[c] + parts[c]);
            size += norm(&parts);
        };
        for (local, weight) in surface.pane_weights(pane) {
            let node = surface.nodes[local];
            let u = if surface.touches_body(pane) {
                at_node(node)
            } else {
                self.relative(local, node, &at_node, &tool_row)
            };
            add(weight, local, u);
        }
        for (local, node, integral) in surface.products(pane) {
            add(-integral / surface.pane_area[pane], *local, at_node(*node));
        }
        let least = FEW_ROUNDINGS * f64::EPSILON * size;
        mean.map(|part| if part.abs() > least { part } else { 0.0 })
    }

    /// Signed (u·t₁, u·t₂) against the obstacle at every contact node, `[n_contact_nodes]`, of vectors at the rows of a [`DofMap`].
    #[must_use]
    pub fn nodal_tangential(
        &self,
        surface: &ContactSurface,
        dofs: &DofMap,
        at_row: impl Fn(usize) -> [f64; 3],
    ) -> Vec<[f64; 2]> {
        let tools: Vec<[f64; 3]> = (dofs.n_nodes..dofs.dof.len()).map(&at_row).collect();
        let nodes = surface.nodes.iter().enumerate();
        nodes
            .map(|(local, &node)| {
                let u = self.relative(local, node, &at_row, |row| tools[row]);
                self.tangential(local, u)
            })
            .collect()
    }

    /// The derivatives of the displacement of a contact node against its opposite along a direction by the free degrees of freedom.
    pub(crate) fn terms(
        &self,
        surface: &ContactSurface,
        dofs: &DofMap,
        contact_node: usize,
        direction: [f64; 3],
    ) -> impl Iterator<Item = (usize, f64)> {
        let own = dofs.terms(surface.nodes[contact_node], direction);
        let opposite = self.opposite.get(contact_node);
        let tool = match opposite {
            Some(Counterpart::Tool(point)) => Some(*point),
            _ => None,
        };
        let body = match opposite {
            Some(Counterpart::Body(nodes)) => nodes.as_slice(),
            _ => &[],
        };
        let against = tool.map(|point| dofs.tool_terms(point, direction.map(|part| -part)));
        let of_body = body
            .iter()
            .flat_map(move |(node, share)| dofs.terms(*node, direction.map(|part| -share * part)));
        own.chain(against.into_iter().flatten()).chain(of_body)
    }

    /// The displacement of a contact node against its opposite in m where both are held; zero for free components.
    #[must_use]
    pub fn held(&self, surface: &ContactSurface, dofs: &DofMap, contact_node: usize) -> [f64; 3] {
        let tool_row = |row| dofs.held_at(dofs.n_nodes + row);
        let node = surface.nodes[contact_node];
        self.relative(contact_node, node, |node| dofs.held_at(node), tool_row)
    }

    /// The component of a vector along ν at a contact node.
    #[must_use]
    pub fn normal_part(&self, contact_node: usize, vector: [f64; 3]) -> f64 {
        Vector3::from(vector).dot(&Vector3::from(self.normal_at(contact_node)))
    }

    /// λ_ν ν + λ_t1 t₁ + λ_t2 t₂ at a contact node.
    #[must_use]
    pub fn vector(&self, contact_node: usize, normal: f64, tangential: [f64; 2]) -> [f64; 3] {
        let [first, second] = self.axes_at(contact_node).map(Vector3::from);
        let outward = Vector3::from(self.normal_at(contact_node));
        let sum = outward * normal + first * tangential[0] + second * tangential[1];
        sum.into()
    }
}

/// Σ_k ψ_k u_k.
fn weighted(nodes: &[(usize, f64)], at_node: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    nodes.iter().fold([0.0; 3], |sum, (node, share)| {
        let u = at_node(*node);
        std::array::from_fn(|c| sum[c] + share * u[c])
    })
}

impl ReferenceFrame {
    /// For the normals of a face and the axes at its first node, where the scene does not turn them.
    fn of(normals: &[[f64; 3]], constant: Option<[[f64; 3]; 2]>) -> Self {
        let normal = mean_direction(normals);
        let is_flat = normals.iter().all(|n| *n == normals[0]);
        let axes = constant.filter(|_| is_flat).unwrap_or_else(|| {
            let first = default_axis(&normal);
            [first.into(), first.cross(&normal).into()]
        });
        Self {
            normal: normal.into(),
            axes,
            is_flat,
        }
    }
}

fn first_axis(
    contact: &Contact,
    (key, sense): (&str, f64),
    normal: &Vector3<f64>,
    varies: bool,
    place: [f64; 3],
) -> Result<Vector3<f64>, InvalidValue> {
    if let Some(axis) = &contact.axis_1 {
        let given = Vector3::from(axis.each_ref().map(|a| a.at(place)));
        // Only the direction counts; squares of very large or small components would overflow or vanish. A power of
        // two leaves every digit as it is.
        let given = match given.amax() {
            size if size > 0.0 && size.is_finite() => {
                given * 2.0_f64.powi((-size.log2() as i32).clamp(-1000, 1000))
            }
            _ => given,
        };
        let along = given.dot(normal);
        // Where normals vary no constant vector is tangential everywhere.
        let tangential = if varies {
            along.abs() < (1.0 - GEOMETRY_TOLERANCE) * given.norm()
        } else {
            along.abs() <= GEOMETRY_TOLERANCE * given.norm()
        };
        let flat = given - normal * along;
        return match flat.try_normalize(0.0) {
            Some(first) if tangential && first.iter().all(|v| v.is_finite()) => Ok(first),
            _ => Err(InvalidValue {
                key: format!("{key}.axis_1"),
                expected: if varies {
                    "a non-zero vector that is nowhere along the normal"
                } else {
                    "a non-zero vector in the plane of the contact face"
                }
                .into(),
                found: format!(
                    "({}) at {}, where the normal is ({})",
                    numbers(given.as_slice()),
                    place_words(place),
                    numbers(normal.as_slice())
                ),
                help: "t1 must be tangential, for example [1.0, 0.0, 0.0] on z_min".into(),
            }),
        };
    }
    let first = default_axis(normal);
    let Some(angle) = &contact.angle else {
        return Ok(first);
    };
    let (sine, cosine) = (sense * angle.at(place)).to_radians().sin_cos();
    if !sine.is_finite() {
        return Err(InvalidValue {
            key: format!("{key}.angle"),
            expected: "a finite angle in degrees on the whole face".into(),
            found: format!("{} at {}", Written(&angle.at(place)), place_words(place)),
            help: UNDEFINED.into(),
        });
    }
    Ok(first * cosine + first.cross(normal) * sine)
}

/// The direction of the mean of unit vectors; that of a single one is itself. Where the mean vanishes, as on a
/// closed surface, the direction of z.
fn mean_direction(normals: &[[f64; 3]]) -> Vector3<f64> {
    if let Some(everywhere) = normals.first()
        && normals.iter().all(|normal| normal == everywhere)
    {
        return Vector3::from(*everywhere);
    }
    let sum: Vector3<f64> = normals.iter().map(|n| Vector3::from(*n)).sum();
    let least = GEOMETRY_TOLERANCE * normals.len() as f64;
    sum.try_normalize(least).unwrap_or_else(Vector3::z)
}

/// The x axis projected on the face; the y axis where the face is perpendicular to x.
fn default_axis(normal: &Vector3<f64>) -> Vector3<f64> {
    let project = |axis: Vector3<f64>| (axis - normal * axis.dot(normal)).normalize();
    if normal.x.abs() > 1.0 - GEOMETRY_TOLERANCE {
        project(Vector3::y())
    } else {
        project(Vector3::x())
    }
}
