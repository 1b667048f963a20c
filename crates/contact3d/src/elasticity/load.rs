//! Load vectors, and loads that do nothing.

use std::ops::{AddAssign, Mul};

use nalgebra::Vector3;

use super::Element;
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::{Mesh, SidePoint, tetrahedron_volume},
    reference::{quadratic_tetrahedron, quadrature},
    scene::{
        BodyForce, Component, FaceLoad, InvalidValue, Quantity, Scene, UNDEFINED, Warning, Written,
        place_words,
    },
};

/// Loads of a scene.
#[derive(Debug, Clone, Default)]
pub struct Loads<'a> {
    /// Those on faces.
    pub faces: Vec<FaceLoad<'a>>,
    /// The body force f.
    pub body_force: Option<&'a BodyForce>,
}

impl<'a> From<FaceLoad<'a>> for Loads<'a> {
    fn from(load: FaceLoad<'a>) -> Self {
        Self {
            faces: vec![load],
            body_force: None,
        }
    }
}

impl<'a> Loads<'a> {
    /// All loads of a scene.
    #[must_use]
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            faces: scene.face_loads().collect(),
            body_force: scene.body_force.as_ref(),
        }
    }

    /// Consistent nodal forces ∫_{Γ_p} φ p + ∫_Ω φ f in N, `[n_nodes]`.
    ///
    /// Constants are integrated exactly on straight sides, formulas by Gauss points of degree 6 on
    /// triangles and 5 in tetrahedra.
    ///
    /// # Errors
    /// A formula that is not finite somewhere.
    pub fn nodal_forces(&self, mesh: &Mesh) -> Result<Vec<[f64; 3]>, InvalidValue> {
        let mut load = vec![[0.0; 3]; mesh.coordinates.len()];
        for face_load in &self.faces {
            let key = face_load.key() + ".value";
            for facet in mesh.facets_on(face_load.face()) {
                let (side, curved) = ((mesh, facet), mesh.quadratic_side(facet));
                match face_load {
                    FaceLoad::Traction(_, traction) => {
                        for (component, value) in traction.value.iter().enumerate() {
                            let norm = |area: Vector3<f64>| area.norm();
                            let shares = side_integrals(side, curved.as_ref(), value, &key, norm)?;
                            for (node, share) in shares {
                                load[node][component] += share;
                            }
                        }
                    }
                    FaceLoad::Pressure(_, pressure) => {
                        let value = &pressure.value;
                        let shares = side_integrals(side, curved.as_ref(), value, &key, |a| a)?;
                        for (node, share) in shares {
                            for c in 0..3 {
                                load[node][c] -= share[c];
                            }
                        }
                    }
                }
            }
        }
        if let Some(force) = self.body_force {
            add_body_force(force, mesh, &mut load)?;
        }
        Ok(load)
    }
}

/// ∫ φ_k value dA over a boundary triangle, straight or curved, with the node of each φ_k; `measure` makes dA of the outward
/// normal times area, in m².
fn side_integrals<V: Copy + AddAssign + Mul<f64, Output = V>>(
    (mesh, facet): (&Mesh, usize),
    curved: Option<&([usize; 6], Vec<SidePoint>)>,
    value: &Quantity,
    key: &str,
    measure: impl Fn(Vector3<f64>) -> V,
) -> Result<Vec<(usize, V)>, InvalidValue> {
    let Some((nodes, points)) = curved else {
        let nodes = mesh.facets[facet];
        let corners = mesh.corners(&nodes);
        let area = measure(area_vector(&corners));
        let means = hat_means(value, &corners, quadrature::triangle, key)?;
        return Ok(nodes
            .into_iter()
            .zip(means.map(|mean| area * mean))
            .collect());
    };
    let mut shares = [measure(Vector3::zeros()); 6];
    for point in points {
        let weighted = measure(point.area) * finite_at(value, point.at, key)?;
        for (share, shape) in shares.iter_mut().zip(point.shape) {
            *share += weighted * shape;
        }
    }
    Ok(nodes.iter().copied().zip(shares).collect())
}

fn add_body_force(
    force: &BodyForce,
    mesh: &Mesh,
    load: &mut [[f64; 3]],
) -> Result<(), InvalidValue> {
    const KEY: &str = "body_force.value";
    for (t, corner_nodes) in mesh.tetrahedra.iter().enumerate() {
        let corners = mesh.corners(corner_nodes);
        let element = Element::of(mesh, t);
        let shares_of = |value| match &element {
            Element::Linear(_) => {
                let volume = tetrahedron_volume(&corners);
                let means = hat_means(value, &corners, quadrature::tetrahedron, KEY)?;
                Ok(means.map(|mean| volume * mean).to_vec())
            }
            Element::Quadratic(simplex) => {
                let place = |at: &[f64; 4]| (quadrature::point(&corners, at), simplex.volume);
                quadratic_shares(value, place, KEY)
            }
            Element::Curved(curved) => quadratic_shares(value, |at| curved.place(at), KEY),
        };
        for (component, value) in force.value.iter().enumerate() {
            for (node, share) in mesh.tetrahedron_nodes(t).zip(shares_of(value)?) {
                load[node][component] += share;
            }
        }
    }
    Ok(())
}

/// ∫ φ_k value of the ten quadratic shape functions; `place` gives the point in m and the volume
/// of the whole tetrahedron as its Jacobian there says.
fn quadratic_shares(
    value: &Quantity,
    place: impl Fn(&[f64; 4]) -> ([f64; 3], f64),
    key: &str,
) -> Result<Vec<f64>, InvalidValue> {
    let mut shares = vec![0.0; 10];
    for (barycentric, weight) in quadrature::tetrahedron() {
        let (at, volume) = place(&barycentric);
        let weighted = finite_at(value, at, key)? * weight * volume;
        for (share, shape) in shares.iter_mut().zip(quadratic_tetrahedron(&barycentric)) {
            *share += weighted * shape;
        }
    }
    Ok(shares)
}

/// Means of value · φ_a over a simplex for its K hat functions φ_a.
fn hat_means<const K: usize, I: Iterator<Item = ([f64; K], f64)>>(
    value: &Quantity,
    corners: &[[f64; 3]; K],
    rule: fn() -> I,
    key: &str,
) -> Result<[f64; K], InvalidValue> {
    if let Some(constant) = value.constant() {
        return Ok([constant / K as f64; K]);
    }
    let mut means = [0.0; K];
    for (barycentric, weight) in rule() {
        let found = finite_at(value, quadrature::point(corners, &barycentric), key)?;
        for (mean, hat) in means.iter_mut().zip(barycentric) {
            *mean += weight * found * hat;
        }
    }
    Ok(means)
}

/// The value at a place in m.
fn finite_at(value: &Quantity, at: [f64; 3], key: &str) -> Result<f64, InvalidValue> {
    let found = value.at(at);
    if found.is_finite() {
        return Ok(found);
    }
    Err(InvalidValue {
        key: key.to_owned(),
        expected: "a formula that is finite on the whole face or body".into(),
        found: format!("{} at {}", Written(&found), place_words(at)),
        help: UNDEFINED.into(),
    })
}

/// Outward normal times area.
fn area_vector(corners: &[[f64; 3]; 3]) -> Vector3<f64> {
    let [a, b, c] = corners.map(Vector3::from);
    (b - a).cross(&(c - a)) / 2.0
}

/// The loads of a scene, or their components, that act on held displacements only.
#[must_use]
pub fn idle_loads(scene: &Scene, mesh: &Mesh) -> Vec<Warning> {
    let held = mesh.held_nodes(scene);
    let on_faces = scene.face_loads().filter_map(|load| {
        // One that is not finite is refused elsewhere.
        let forces = Loads::from(load).nodal_forces(mesh).unwrap_or_default();
        let acting = acting_components(&forces);
        let idle = acting.iter().copied();
        let idle = idle.filter(|component| is_held(&forces, &held, *component));
        let components: Vec<Component> = idle.collect();
        let key = load.key() + ".value";
        match load {
            _ if components.is_empty() => None,
            FaceLoad::Traction(..) => Some(Warning::IdleLoad { key, components }),
            // A part of it alone cannot be left out.
            FaceLoad::Pressure(..) => {
                (components.len() == acting.len()).then_some(Warning::IdlePressure { key })
            }
        }
    });
    let whole = scene.body_force.iter().filter_map(|force| {
        let is_idle = |component: &Component| {
            let c = *component as usize;
            force.value[c] != Quantity::Constant(0.0) && held.iter().all(|held| held[c])
        };
        let components: Vec<Component> = Component::ALL.into_iter().filter(is_idle).collect();
        let key = "body_force.value".to_owned();
        (!components.is_empty()).then_some(Warning::IdleLoad { key, components })
    });
    on_faces.chain(whole).collect()
}

/// The loads on faces whose integrals over triangles change where these are cut in four: the quadrature does not see all of what formulas
/// do inside.
#[must_use]
pub fn unresolved_loads(scene: &Scene, mesh: &Mesh) -> Vec<Warning> {
    let told = scene.face_loads().filter_map(|load| {
        let (mut apart, mut whole) = (0.0, 0.0);
        for facet in mesh.facets_on(load.face()) {
            let corners = mesh.corners(&mesh.facets[facet]);
            let area = area_vector(&corners);
            let normal = area.normalize().into();
            let mean = |corners: &[[f64; 3]; 3]| -> Vector3<f64> {
                let points = quadrature::triangle();
                let terms = points.map(|(share, weight)| {
                    let at = quadrature::point(corners, &share);
                    Vector3::from(load.at(at, normal)) * weight
                });
                terms.sum()
            };
            let [a, b, c] = corners;
            let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| f64::midpoint(p[k], q[k]));
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]];
            let fine: Vector3<f64> = quarters.iter().map(mean).sum::<Vector3<f64>>() / 4.0;
            apart += area.norm() * (mean(&corners) - fine).norm();
            whole += area.norm() * fine.norm();
        }
        let (key, share) = (load.key() + ".value", apart / whole);
        // A part of a hundredth is less than what a mesh of usual size misses of the solution.
        (share > 0.01).then_some(Warning::UnresolvedLoad { key, share })
    });
    told.collect()
}

/// The components of nodal forces that are more than roundings of a face's normal.
fn acting_components(forces: &[[f64; 3]]) -> Vec<Component> {
    let limit = UNIT_ROUNDING * largest(forces);
    let acts = |component: &Component| {
        let mut along = forces.iter().map(|force| force[*component as usize].abs());
        along.any(|force| force > limit)
    };
    Component::ALL.into_iter().filter(acts).collect()
}

/// Whether a component of nodal forces acts on held displacements only.
fn is_held(forces: &[[f64; 3]], held: &[[bool; 3]], component: Component) -> bool {
    let (c, limit) = (component as usize, UNIT_ROUNDING * largest(forces));
    let mut free = forces.iter().zip(held).filter(|(_, held)| !held[c]);
    free.all(|(force, _)| force[c].abs() <= limit)
}

fn largest(forces: &[[f64; 3]]) -> f64 {
    let forces = forces.as_flattened().iter();
    forces.fold(0.0, |most, force| most.max(force.abs()))
}
