//! The same problem seen in a mirror, with two axes exchanged, or with nodes in another order.

use contact3d::{
    linalg::CscMatrix,
    mesh::{ContactSurface, Mesh, MidEdgeNodes},
    scene::{
        Brick, Coefficient, Component, Contact, Friction, Invalid, Material, Part, Quantity, Scene,
    },
};

/// A map of space onto itself that takes a brick on z_min to a brick on z_min, and its mesh to the
/// mesh of that brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Symmetry {
    /// y → L_y − y.
    Mirror,
    /// x ↔ y.
    Exchange,
}

/// Names of the faces after each map.
const MIRRORED: [(&str, &str); 2] = [("y_min", "y_max"), ("y_max", "y_min")];
const EXCHANGED: [(&str, &str); 4] = [
    ("x_min", "y_min"),
    ("x_max", "y_max"),
    ("y_min", "x_min"),
    ("y_max", "x_max"),
];

impl Symmetry {
    /// The scene of the image; `None` for bodies from mesh files, for other contact faces, for
    /// meshes whose image is another mesh, for axes of friction given as vectors, and for obstacles without an image.
    ///
    /// # Errors
    /// A step that changes what the scene does not have.
    pub(crate) fn apply(self, scene: &Scene) -> Result<Option<Scene>, Invalid> {
        let Some(brick) = scene.body.as_brick() else {
            return Ok(None);
        };
        let even = brick.cells[1].is_multiple_of(2);
        let below = |contact: &Contact| contact.face == "z_min" && contact.axis_1.is_none();
        if !scene.contacts.iter().all(below) || !(even || self == Self::Exchange) {
            return Ok(None);
        }
        let mut image = scene.clone();
        if let Some(brick) = image.body.as_brick_mut() {
            brick.size = self.positive(brick.size);
            brick.cells = self.positive(brick.cells);
            self.map_planes(brick);
        }
        let width = brick.size[1];
        self.map_body(&mut image, width);
        self.map_loads(&mut image, width)?;
        for contact in &mut image.contacts {
            if let Some(obstacle) = &contact.obstacle {
                // Exchanged axes make y, not x, the axis that is projected on tangent planes.
                let projected = self == Self::Exchange && scene.has_friction();
                let seen = self.obstacle(obstacle, width);
                let Some(seen) = seen.filter(|_| !projected) else {
                    return Ok(None);
                };
                contact.obstacle = Some(seen);
            }
            contact.gap = self.quantity(&contact.gap, width, false);
            if let Some(angle) = &mut contact.angle {
                *angle = self.quantity(angle, width, true);
            }
            if let Some(friction) = &contact.friction {
                contact.friction = Some(self.friction(friction, width));
            }
        }
        if let Some(friction) = &image.friction {
            image.friction = Some(self.friction(friction, width));
        }
        Ok(Some(image))
    }

    /// The point that goes to a point of the image, for a brick of this L_y.
    #[must_use]
    pub(crate) fn point(self, at: [f64; 3], width: f64) -> [f64; 3] {
        match self {
            Self::Mirror => [at[0], width - at[1], at[2]],
            Self::Exchange => [at[1], at[0], at[2]],
        }
    }

    /// The components (along t₁, t₂) that a tangential stress of the image had.
    #[must_use]
    pub(crate) fn tangential(self, pair: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Mirror => [pair[0], -pair[1]],
            Self::Exchange => [pair[1], pair[0]],
        }
    }

    /// Extents, which have no sign.
    fn positive<T>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Mirror => [x, y, z],
            Self::Exchange => [y, x, z],
        }
    }

    /// Where the planes between the cells of a brick go.
    fn map_planes(self, brick: &mut Brick) {
        let (grading, planes) = (&mut brick.grading, &mut brick.coordinates);
        match self {
            Self::Mirror => {
                std::mem::swap(&mut grading.y_min, &mut grading.y_max);
                if let Some(given) = &mut planes.y {
                    let width = brick.size[1];
                    given.reverse();
                    given.iter_mut().for_each(|y| *y = width - *y);
                }
            }
            Self::Exchange => {
                std::mem::swap(&mut grading.x_min, &mut grading.y_min);
                std::mem::swap(&mut grading.x_max, &mut grading.y_max);
                std::mem::swap(&mut planes.x, &mut planes.y);
            }
        }
    }

    fn face(self, face: &mut String) {
        let names: &[(&str, &str)] = match self {
            Self::Mirror => &MIRRORED,
            Self::Exchange => &EXCHANGED,
        };
        if let Some((_, image)) = names.iter().find(|(name, _)| name == face) {
            *face = (*image).to_owned();
        }
    }

    fn map_body(self, scene: &mut Scene, width: f64) {
        let corners = |corners: &mut [[f64; 3]; 2]| {
            let [a, b] = corners.map(|corner| self.point(corner, width));
            *corners = [
                std::array::from_fn(|c| a[c].min(b[c])),
                std::array::from_fn(|c| a[c].max(b[c])),
            ];
        };
        for contact in &mut scene.contacts {
            if let Some(part) = &mut contact.corners {
                corners(part);
            }
        }
        for clamp in &mut scene.clamps {
            if let Some(face) = &mut clamp.face {
                self.face(face);
            }
            if let Some(part) = &mut clamp.corners {
                corners(part);
            }
            for component in &mut clamp.components {
                *component = match (self, *component) {
                    (Self::Exchange, Component::X) => Component::Y,
                    (Self::Exchange, Component::Y) => Component::X,
                    (_, same) => same,
                };
            }
        }
        self.map_material(&mut scene.material);
        for region in &mut scene.regions {
            self.map_material(&mut region.material);
            if let Part::Box(part) = &mut region.part {
                corners(part);
            }
        }
    }

    fn map_material(self, material: &mut Material) {
        match material {
            Material::Isotropic(_) => {}
            Material::Orthotropic(constants) => {
                constants.axes = constants.axes.map(|axis| match self {
                    Self::Mirror => [axis[0], -axis[1], axis[2]],
                    Self::Exchange => [axis[1], axis[0], axis[2]],
                });
            }
            Material::Voigt(voigt) => {
                let old = voigt.stiffness;
                // The components xx, yy, zz, yz, xz, xy of a strain seen in the image.
                let (places, signs) = match self {
                    Self::Mirror => ([0, 1, 2, 3, 4, 5], [1.0, 1.0, 1.0, -1.0, 1.0, -1.0]),
                    Self::Exchange => ([1, 0, 2, 4, 3, 5], [1.0; 6]),
                };
                voigt.stiffness = std::array::from_fn(|i| {
                    std::array::from_fn(|j| signs[i] * signs[j] * old[places[i]][places[j]])
                });
            }
        }
    }

    fn map_loads(self, scene: &mut Scene, width: f64) -> Result<(), Invalid> {
        for clamp in &mut scene.clamps {
            clamp.value = self.vector(clamp.value.each_ref(), width);
        }
        for spring in &mut scene.springs {
            self.face(&mut spring.face);
            for along in [&mut spring.normal, &mut spring.tangential] {
                for value in along.iter_mut() {
                    *value = self.quantity(value, width, false);
                }
            }
            if let Some(tensor) = &mut spring.tensor {
                *tensor = self.tensor(tensor, width);
            }
        }
        for traction in &mut scene.tractions {
            self.face(&mut traction.face);
            traction.value = self.vector(traction.value.each_ref(), width);
        }
        for pressure in &mut scene.pressures {
            self.face(&mut pressure.face);
            pressure.value = self.quantity(&pressure.value, width, false);
        }
        if let Some(force) = &mut scene.body_force {
            force.value = self.vector(force.value.each_ref(), width);
        }
        scene.map_step_values(|_, values| match values {
            [x, y, z] => self.vector([x, y, z], width).to_vec(),
            numbers => {
                let numbers = numbers.iter();
                let images = numbers.map(|number| self.quantity(number, width, false));
                images.collect()
            }
        })
    }

    fn vector(self, [x, y, z]: [&Quantity; 3], width: f64) -> [Quantity; 3] {
        self.positive([
            self.quantity(x, width, false),
            self.quantity(y, width, self == Self::Mirror),
            self.quantity(z, width, false),
        ])
    }

    /// M K Mᵀ for the map M of vectors.
    fn tensor(self, tensor: &[[Quantity; 3]; 3], width: f64) -> [[Quantity; 3]; 3] {
        let mirrored = |c: usize| self == Self::Mirror && c == 1;
        let mut image = tensor.clone();
        let order = self.positive([0, 1, 2]);
        for (i, row) in image.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                let negative = mirrored(i) != mirrored(j);
                *value = self.quantity(&tensor[order[i]][order[j]], width, negative);
            }
        }
        image
    }

    /// A quantity of the place, or its negative.
    pub(super) fn quantity(self, quantity: &Quantity, width: f64, negative: bool) -> Quantity {
        quantity
            .seen_from(&self.places(width), move |at| self.point(at, width))
            .times(if negative { -1.0 } else { 1.0 })
    }

    pub(super) fn places(self, width: f64) -> Vec<(&'static str, String)> {
        match self {
            Self::Mirror => vec![("y", format!("{width:e} - y"))],
            Self::Exchange => vec![("x", "y".to_owned()), ("y", "x".to_owned())],
        }
    }

    fn friction(self, friction: &Friction, width: f64) -> Friction {
        let coefficient = |given: &Option<Coefficient>| {
            let given = given.as_ref();
            given.map(|given| self.coefficient(given, width))
        };
        let along = [&friction.coefficient_1, &friction.coefficient_2].map(coefficient);
        let [coefficient_1, coefficient_2] = self.slips(along);
        let bound = friction.slip_bound.as_ref();
        Friction {
            slip_bound: bound.map(|bound| self.quantity(bound, width, false)),
            pressure_cap: friction.pressure_cap,
            coefficient: coefficient(&friction.coefficient),
            coefficient_1,
            coefficient_2,
            follows: friction.follows,
        }
    }
}

/// A stride near the golden section of any number scatters neighbours far apart.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// The mesh with scattered node numbers and its tetrahedra in reverse; panes keep their numbers.
pub(super) fn renumbered(mesh: &Mesh) -> Mesh {
    let new = scattered(mesh.coordinates.len());
    let mut coordinates = mesh.coordinates.clone();
    for (old, place) in mesh.coordinates.iter().zip(&new) {
        coordinates[*place] = *old;
    }
    Mesh {
        coordinates,
        tetrahedra: mesh
            .tetrahedra
            .iter()
            .rev()
            .map(|t| t.map(|n| new[n]))
            .collect(),
        tetrahedron_region: mesh.tetrahedron_region.iter().rev().copied().collect(),
        facets: mesh.facets.iter().map(|f| f.map(|n| new[n])).collect(),
        facet_face: mesh.facet_face.clone(),
        face_names: mesh.face_names.clone(),
        mid_edges: mesh.mid_edges.as_ref().map(|middles| MidEdgeNodes {
            tetrahedra: middles
                .tetrahedra
                .iter()
                .rev()
                .map(|m| m.map(|n| new[n]))
                .collect(),
            facets: middles.facets.iter().map(|m| m.map(|n| new[n])).collect(),
        }),
        contact: mesh
            .contact
            .as_ref()
            .map(|surface| reordered(surface, &new)),
    }
}

/// A permutation of 0…n−1 without order.
fn scattered(n: usize) -> Vec<usize> {
    let divides_both = |stride: usize| {
        let (mut a, mut b) = (n, stride);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let first = ((n as f64 * GOLDEN) as usize).max(1);
    let stride = (first..).find(|&stride| divides_both(stride) == 1);
    (0..n).map(|i| i * stride.unwrap_or(1) % n).collect()
}

fn reordered(surface: &ContactSurface, new: &[usize]) -> ContactSurface {
    let mut order: Vec<usize> = (0..surface.nodes.len()).collect();
    for face in &surface.faces {
        order[face.nodes.clone()].sort_by_key(|&local| new[surface.nodes[local]]);
    }
    let mut place = vec![0; order.len()];
    for (next, &local) in order.iter().enumerate() {
        place[local] = next;
    }
    let old = &surface.pane_average;
    let mut average = CscMatrix {
        indices: Vec::new(),
        data: Vec::new(),
        ..old.clone()
    };
    for pane in 0..surface.n_panes() {
        let weights = surface.pane_weights(pane);
        let mut column: Vec<_> = weights
            .map(|(local, weight)| (place[local], weight))
            .collect();
        column.sort_by_key(|(local, _)| *local);
        average
            .indices
            .extend(column.iter().map(|(local, _)| *local));
        average
            .data
            .extend(column.iter().map(|(_, weight)| *weight));
    }
    ContactSurface {
        normals: match surface.normals.as_slice() {
            [everywhere] => vec![*everywhere],
            each => order.iter().map(|&local| each[local]).collect(),
        },
        clearance: if surface.clearance.is_empty() {
            Vec::new()
        } else {
            order
                .iter()
                .map(|&local| surface.clearance[local])
                .collect()
        },
        nodes: order
            .iter()
            .map(|&local| new[surface.nodes[local]])
            .collect(),
        pane_average: average,
        ..surface.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::scattered;

    #[test]
    fn scattered_numbers_are_a_permutation() {
        for n in 1..60 {
            let mut numbers = scattered(n);
            assert!(n < 4 || numbers[1] > 1, "{n}");
            numbers.sort_unstable();
            assert_eq!(numbers, (0..n).collect::<Vec<_>>());
        }
    }
}
