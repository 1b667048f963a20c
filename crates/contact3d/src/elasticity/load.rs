//! Load vectors, and loads that do nothing.

use std::ops::{AddAssign, Mul};

use nalgebra::Vector3;

use super::Element;
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::{Mesh, SidePoint, tetrahedron_volume},
    reference::{quadrature, shape::quadratic_tetrahedron},
    scene::{
        BodyForce, Component, InvalidValue, Pressure, Quantity, Scene, Traction, UNDEFINED,
        Warning, Written, place_words,
    },
};

/// The loads of a scene.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loads<'a> {
    /// Surface tractions p.
    pub tractions: &'a [Traction],
    /// Pressures, σν = −p ν.
    pub pressures: &'a [Pressure],
    /// The body force f.
    pub body_force: Option<&'a BodyForce>,
}

impl<'a> Loads<'a> {
    /// All loads of a scene.
    #[must_use]
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            tractions: &scene.tractions,
            pressures: &scene.pressures,
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
        for (i, traction) in self.tractions.iter().enumerate() {
            let key = format!("traction.{i}.value");
            for facet in mesh.facets_on(&traction.face) {
                let (side, curved) = ((mesh, facet), mesh.quadratic_side(facet));
                for (component, value) in traction.value.iter().enumerate() {
                    let norm = |area: Vector3<f64>| area.norm();
                    let shares = side_integrals(side, curved.as_ref(), value, &key, norm)?;
                    for (node, share) in shares {
                        load[node][component] += share;
                    }
                }
            }
        }
        for (i, pressure) in self.pressures.iter().enumerate() {
            let key = format!("pressure.{i}.value");
            for facet in mesh.facets_on(&pressure.face) {
                let (side, curved) = ((mesh, facet), mesh.quadratic_side(facet));
                let value = &pressure.value;
                for (node, share) in side_integrals(side, curved.as_ref(), value, &key, |a| a)? {
                    for c in 0..3 {
                        load[node][c] -= share[c];
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
    let tractions = scene.tractions.iter().enumerate();
    let tractions = tractions.map(|(i, traction)| {
        let alone = Loads {
            tractions: std::slice::from_ref(traction),
            ..Loads::default()
        };
        let components = idle_components(&forces(&alone, mesh), &held).collect();
        (format!("traction.{i}.value"), components)
    });
    let whole = scene.body_force.iter().map(|force| {
        let is_idle = |component: &Component| {
            let c = *component as usize;
            force.value[c] != Quantity::Constant(0.0) && held.iter().all(|held| held[c])
        };
        let components = Component::ALL.into_iter().filter(is_idle).collect();
        ("body_force.value".to_owned(), components)
    });
    let pressures = scene.pressures.iter().enumerate();
    let pressures = pressures.filter_map(|(i, pressure)| {
        let alone = Loads {
            pressures: std::slice::from_ref(pressure),
            ..Loads::default()
        };
        let forces = forces(&alone, mesh);
        let acting = Component::ALL
            .into_iter()
            .filter(|c| acts(&forces, *c))
            .count();
        let idle = idle_components(&forces, &held).count();
        (acting > 0 && idle == acting).then(|| Warning::IdlePressure {
            key: format!("pressure.{i}.value"),
        })
    });
    tractions
        .chain(whole)
        .filter(|(_, components): &(_, Vec<Component>)| !components.is_empty())
        .map(|(key, components)| Warning::IdleLoad { key, components })
        .chain(pressures)
        .collect()
}

/// Nodal forces of a load; none of one that is not finite, which is refused elsewhere.
fn forces(load: &Loads<'_>, mesh: &Mesh) -> Vec<[f64; 3]> {
    load.nodal_forces(mesh).unwrap_or_default()
}

/// The components of nodal forces that act, and on held displacements only.
fn idle_components(forces: &[[f64; 3]], held: &[[bool; 3]]) -> impl Iterator<Item = Component> {
    let limit = UNIT_ROUNDING * largest(forces);
    Component::ALL.into_iter().filter(move |component| {
        let c = *component as usize;
        let mut free = forces.iter().zip(held).filter(|(_, held)| !held[c]);
        acts(forces, *component) && free.all(|(force, _)| force[c].abs() <= limit)
    })
}

fn acts(forces: &[[f64; 3]], component: Component) -> bool {
    let limit = UNIT_ROUNDING * largest(forces);
    let mut along = forces.iter().map(|force| force[component as usize].abs());
    along.any(|force| force > limit)
}

fn largest(forces: &[[f64; 3]]) -> f64 {
    let forces = forces.as_flattened().iter();
    forces.fold(0.0, |most, force| most.max(force.abs()))
}
