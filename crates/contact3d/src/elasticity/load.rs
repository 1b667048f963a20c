//! Consistent nodal forces of tractions, pressures and body forces.

use nalgebra::Vector3;

use super::quadrature;
use crate::{
    mesh::{Mesh, tetrahedron_volume, triangle_area},
    scene::{
        BodyForce, Invalid, Pressure, Quantity, Scene, Traction, UNDEFINED, Written, place_words,
    },
};

/// The loads of a scene.
#[derive(Debug, Clone, Copy)]
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
    /// Constants are integrated exactly, formulas by Gauss points of degree 6 on triangles and 5
    /// in tetrahedra.
    ///
    /// # Errors
    /// A formula that is not finite somewhere.
    pub fn nodal_forces(&self, mesh: &Mesh) -> Result<Vec<[f64; 3]>, Invalid> {
        let mut load = vec![[0.0; 3]; mesh.coordinates.len()];
        for (i, traction) in self.tractions.iter().enumerate() {
            let key = format!("traction.{i}.value");
            for facet in mesh.facets_on(&traction.face) {
                let nodes = &mesh.facets[facet];
                let corners = mesh.corners(nodes);
                let area = triangle_area(&corners);
                for (component, value) in traction.value.iter().enumerate() {
                    let shares = hat_means(value, &corners, quadrature::triangle, &key)?;
                    for (node, share) in nodes.iter().zip(shares) {
                        load[*node][component] += area * share;
                    }
                }
            }
        }
        for (i, pressure) in self.pressures.iter().enumerate() {
            let key = format!("pressure.{i}.value");
            for facet in mesh.facets_on(&pressure.face) {
                let nodes = &mesh.facets[facet];
                let corners = mesh.corners(nodes);
                let area = area_vector(&corners);
                let shares = hat_means(&pressure.value, &corners, quadrature::triangle, &key)?;
                for (node, share) in nodes.iter().zip(shares) {
                    for c in 0..3 {
                        load[*node][c] -= area[c] * share;
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

fn add_body_force(force: &BodyForce, mesh: &Mesh, load: &mut [[f64; 3]]) -> Result<(), Invalid> {
    for nodes in &mesh.tetrahedra {
        let corners = mesh.corners(nodes);
        let volume = tetrahedron_volume(&corners);
        for (component, value) in force.value.iter().enumerate() {
            let shares = hat_means(value, &corners, quadrature::tetrahedron, "body_force.value")?;
            for (node, share) in nodes.iter().zip(shares) {
                load[*node][component] += volume * share;
            }
        }
    }
    Ok(())
}

/// Means of value · φ_a over a simplex for its K hat functions φ_a.
fn hat_means<const K: usize, I: Iterator<Item = ([f64; K], f64)>>(
    value: &Quantity,
    corners: &[[f64; 3]; K],
    rule: fn() -> I,
    key: &str,
) -> Result<[f64; K], Invalid> {
    if let Some(constant) = value.constant() {
        return Ok([constant / K as f64; K]);
    }
    let mut means = [0.0; K];
    for (barycentric, weight) in rule() {
        let at = quadrature::point(corners, &barycentric);
        let found = value.at(at);
        if !found.is_finite() {
            return Err(not_finite(key, value, at));
        }
        for (mean, hat) in means.iter_mut().zip(barycentric) {
            *mean += weight * found * hat;
        }
    }
    Ok(means)
}

fn not_finite(key: &str, value: &Quantity, at: [f64; 3]) -> Invalid {
    Invalid {
        key: key.to_owned(),
        expected: "a formula that is finite on the whole face or body".into(),
        found: format!("{} at {}", Written(&value.at(at)), place_words(at)),
        help: UNDEFINED.into(),
    }
}

/// Outward normal times area.
fn area_vector(corners: &[[f64; 3]; 3]) -> Vector3<f64> {
    let [a, b, c] = corners.map(Vector3::from);
    (b - a).cross(&(c - a)) / 2.0
}
