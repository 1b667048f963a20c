//! The part of a body or of a contact face in a box, for means over it.

use nalgebra::Vector3;

use crate::{
    mesh::{Mesh, tetrahedron_volume},
    reference::{quadratic_tetrahedron, quadrature},
};

/// A load of resultant one on the part of a body in a box: the derivative of a mean displacement. Curved tetrahedra count as
/// straight ones.
pub(in crate::post) struct BoxLoad {
    /// The direction, of length one.
    direction: Vector3<f64>,
    /// Volume in the box in m³.
    volume: f64,
    /// Points of integration with their shares of the tetrahedron's volume, `[n_tetrahedra]`.
    points: Vec<Vec<([f64; 4], f64)>>,
}

impl BoxLoad {
    /// The load in a direction of length one on a box, given by opposite corners in m, the smaller coordinates first; `None` where the box holds nothing of the body.
    pub(in crate::post) fn new(
        mesh: &Mesh,
        corners: &[[f64; 3]; 2],
        direction: [f64; 3],
    ) -> Option<Self> {
        let tetrahedra = mesh.tetrahedra.iter();
        let parts = tetrahedra.map(|nodes| parts_in_box(&mesh.corners(nodes), corners));
        let points: Vec<_> = parts.map(|parts| points_in(&parts)).collect();
        let volume = mesh.tetrahedra.iter().zip(&points).map(|(nodes, points)| {
            let share: f64 = points.iter().map(|(_, weight)| weight).sum();
            share * tetrahedron_volume(&mesh.corners(nodes))
        });
        let volume = volume.sum();
        (volume > 0.0).then_some(Self {
            direction: direction.into(),
            volume,
            points,
        })
    }

    /// Force on a volume in 1/m³.
    pub(super) fn force(&self) -> Vector3<f64> {
        self.direction / self.volume
    }

    /// Points of integration in a tetrahedron with their shares of its volume.
    pub(super) fn samples(&self, t: usize) -> impl Iterator<Item = (&[f64; 4], f64)> {
        self.points[t].iter().map(|(at, weight)| (at, *weight))
    }

    /// The forces on the nodes, `[n_nodes]`.
    pub(in crate::post) fn nodal_forces(&self, mesh: &Mesh) -> Vec<[f64; 3]> {
        let mut forces = vec![[0.0; 3]; mesh.coordinates.len()];
        for t in 0..mesh.tetrahedra.len() {
            let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
            for (at, weight) in self.samples(t) {
                let shape = match mesh.mid_edges {
                    None => at.to_vec(),
                    Some(_) => quadratic_tetrahedron(at).to_vec(),
                };
                let force = self.force() * (weight * volume);
                for (node, shape) in mesh.tetrahedron_nodes(t).zip(shape) {
                    (0..3).for_each(|c| forces[node][c] += shape * force[c]);
                }
            }
        }
        forces
    }
}

/// Points of integration of degree 5 in parts of a tetrahedron, with their shares of its volume.
fn points_in(parts: &[[[f64; 4]; 4]]) -> Vec<([f64; 4], f64)> {
    let points = parts.iter().flat_map(|part| {
        let edges = [1, 2, 3].map(|k| Vector3::from_fn(|c, _| part[k][c] - part[0][c]));
        let share = nalgebra::Matrix3::from_columns(&edges).determinant().abs();
        quadrature::tetrahedron_5().map(move |(inner, weight)| {
            let at = std::array::from_fn(|c| (0..4).map(|k| inner[k] * part[k][c]).sum());
            (at, weight * share)
        })
    });
    points.collect()
}

/// Cuts a tetrahedron by the sides of a box: the parts inside.
fn parts_in_box(tetrahedron: &[[f64; 3]; 4], corners: &[[f64; 3]; 2]) -> Vec<[[f64; 4]; 4]> {
    let unit = |k: usize| std::array::from_fn(|c| if c == k { 1.0 } else { 0.0 });
    let mut parts: Vec<[[f64; 4]; 4]> = vec![std::array::from_fn(unit)];
    for (axis, bound, sign) in sides(corners) {
        let height = |at: &[f64; 4]| {
            let place: f64 = (0..4).map(|k| at[k] * tetrahedron[k][axis]).sum();
            sign * (place - bound)
        };
        parts = parts.iter().flat_map(|part| cut(part, &height)).collect();
    }
    parts
}

/// Axis, coordinate and the direction inwards of the six sides.
fn sides(corners: &[[f64; 3]; 2]) -> impl Iterator<Item = (usize, f64, f64)> {
    let [low, high] = *corners;
    (0..3).flat_map(move |axis| [(axis, low[axis], 1.0), (axis, high[axis], -1.0)])
}

/// The parts of a tetrahedron where a linear function is positive.
fn cut(part: &[[f64; 4]; 4], height: &impl Fn(&[f64; 4]) -> f64) -> Vec<[[f64; 4]; 4]> {
    let heights = part.map(|corner| height(&corner));
    let (inside, outside): (Vec<usize>, Vec<usize>) = (0..4).partition(|&k| heights[k] > 0.0);
    let between = |i: usize, o: usize| -> [f64; 4] {
        let share = heights[i] / (heights[i] - heights[o]);
        std::array::from_fn(|c| part[i][c] + share * (part[o][c] - part[i][c]))
    };
    let prism = |[a, b, c]: [[f64; 4]; 3], [d, e, f]: [[f64; 4]; 3]| {
        vec![[a, b, c, d], [b, c, d, e], [c, d, e, f]]
    };
    match (inside.as_slice(), outside.as_slice()) {
        ([], _) => Vec::new(),
        (_, []) => vec![*part],
        (&[i], &[o, p, q]) => vec![[part[i], between(i, o), between(i, p), between(i, q)]],
        (&[i, j, k], &[o]) => prism(
            [i, j, k].map(|corner| part[corner]),
            [i, j, k].map(|corner| between(corner, o)),
        ),
        (&[i, j], &[o, p]) => prism(
            [part[i], between(i, o), between(i, p)],
            [part[j], between(j, o), between(j, p)],
        ),
        _ => Vec::new(),
    }
}

/// The part of the contact faces in a box.
#[derive(Debug, Clone, Copy)]
pub(in crate::post) struct BoxedFaces {
    /// The box.
    pub(in crate::post) corners: [[f64; 3]; 2],
    /// Area in m².
    pub(in crate::post) area: f64,
}

impl BoxedFaces {
    /// 1/area in the box, 0 outside, in 1/m².
    pub(super) fn density(&self, at: [f64; 3]) -> f64 {
        let [low, high] = self.corners;
        let is_inside = (0..3).all(|c| (low[c]..=high[c]).contains(&at[c]));
        if is_inside { self.area.recip() } else { 0.0 }
    }
}
