//! The distance of two finite element solutions on any two meshes of the same body.
//!
//! ‖u_a − u_b‖_A² = ∫ (ε(u_a) − ε(u_b)) : C : (ε(u_a) − ε(u_b)) + ∫ (u_a − u_b)·K (u_a − u_b) is integrated over the tetrahedra
//! of the reference b and its faces on springs, with the material and the springs of the scene, and the strain of u_a at each point is that of the tetrahedron of mesh a which holds it. Where a
//! is nested in b the rules are exact; elsewhere ε(u_a) jumps inside tetrahedra of b, and a rule sees its jumps only
//! from its points.

use nalgebra::{Matrix3, Vector3, Vector6};
use rayon::prelude::*;

use contact3d::{
    elasticity::{MaterialField, Simplex, quadratic_gradients, visit_springs},
    mesh::{IsoparametricMap, Mesh, is_straight},
    reference::{TETRAHEDRON_EDGES, quadratic_tetrahedron, quadrature},
    scene::{InvalidValue, Scene},
};

/// A displacement on a mesh.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshField<'a> {
    /// The mesh.
    pub(crate) mesh: &'a Mesh,
    /// Displacement of its nodes in m, `[n_nodes]`.
    pub(crate) displacement: &'a [[f64; 3]],
}

/// ‖u_a − u_b‖_A and ‖u_b‖_A in √J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Distance {
    /// ‖u_a − u_b‖_A in √J.
    pub(crate) absolute: f64,
    /// ‖u_b‖_A in √J.
    pub(crate) reference: f64,
}

impl Distance {
    /// ‖u_a − u_b‖_A / ‖u_b‖_A; 0 where both are at rest.
    pub(crate) fn relative(self) -> f64 {
        if self.absolute == 0.0 {
            0.0
        } else {
            self.absolute / self.reference
        }
    }
}

/// A displacement whose strain can be asked for anywhere in the body.
#[derive(Debug)]
struct Searchable<'a> {
    field: MeshField<'a>,
    pieces: Vec<SearchedTetrahedron>,
    tree: Tree,
}

impl<'a> Searchable<'a> {
    fn new(field: MeshField<'a>) -> Self {
        let tetrahedra = (0..field.mesh.tetrahedra.len()).into_par_iter();
        let pieces = tetrahedra.map(|t| SearchedTetrahedron::of(field.mesh, t));
        let pieces: Vec<SearchedTetrahedron> = pieces.collect();
        let boxes = pieces.iter().map(|piece| piece.bounds);
        Self {
            tree: Tree::new(boxes.collect()),
            field,
            pieces,
        }
    }

    /// The tetrahedron that holds a point in m, and where in it; `guess` is looked at first.
    fn find(&self, point: [f64; 3], guess: usize) -> (usize, [f64; 4]) {
        let search = |t: usize| self.pieces[t].nearest(point);
        self.tree.nearest(point, guess, search)
    }

    /// Voigt strain at a point in m, and the tetrahedron it was found in.
    fn strain(&self, point: [f64; 3], guess: usize) -> (Vector6<f64>, usize) {
        let (t, at) = self.find(point, guess);
        (self.pieces[t].strain(self.field, t, &at), t)
    }

    /// Displacement in m at a point in m.
    fn displacement(&self, point: [f64; 3]) -> Vector3<f64> {
        let (t, at) = self.find(point, self.tree.any(point));
        SearchedTetrahedron::displacement(self.field, t, &at)
    }
}

/// The distance of a displacement from a reference, in the energy norm of a scene: that of its materials and springs.
///
/// Points of the reference that lie in no tetrahedron of the other mesh, as near curved sides, take the strain of the
/// nearest place of one. The result does not depend on the number of threads.
///
/// # Errors
/// Springs whose stiffness is not finite and positive semidefinite somewhere.
pub(crate) fn distance(
    field: MeshField<'_>,
    reference: MeshField<'_>,
    scene: &Scene,
) -> Result<Distance, InvalidValue> {
    let material = MaterialField::new(scene, reference.mesh);
    let searchable = Searchable::new(field);
    let rule: Vec<_> = quadrature::tetrahedron_5().collect();
    let tetrahedra = (0..reference.mesh.tetrahedra.len()).into_par_iter();
    let energies: Vec<[f64; 2]> = tetrahedra
        .map(|t| {
            let piece = SearchedTetrahedron::of(reference.mesh, t);
            let tensor = material.tensor(t);
            let mut guess = None;
            let mut sum = [0.0; 2];
            for (at, weight) in &rule {
                let (place, volume) = piece.place(at);
                let own = piece.strain(reference, t, at);
                let first = guess.unwrap_or_else(|| searchable.tree.any(place));
                let (other, found) = searchable.strain(place, first);
                guess = Some(found);
                for (sum, strain) in sum.iter_mut().zip([other - own, own]) {
                    *sum += weight * volume * strain.dot(&(tensor * strain));
                }
            }
            sum
        })
        .collect();
    let mut of_springs = [0.0; 2];
    visit_springs(scene, reference.mesh, &mut |point, stiffness| {
        let own = point.value(reference.displacement);
        let other = searchable.displacement(point.at);
        for (sum, moved) in of_springs.iter_mut().zip([other - own, own]) {
            *sum += point.area * moved.dot(&(stiffness * moved));
        }
    })?;
    let total = |k: usize| {
        let sum = energies.iter().map(|e| e[k]).sum::<f64>() + of_springs[k];
        sum.max(0.0).sqrt()
    };
    Ok(Distance {
        absolute: total(0),
        reference: total(1),
    })
}

/// Smallest and largest coordinates in m.
type Bounds = [[f64; 3]; 2];

/// A node of the tree: all bodies between two places in the order.
#[derive(Debug)]
struct TreeNode {
    bounds: Bounds,
    /// Its bodies as a range of the order.
    bodies: [usize; 2],
    /// Its two parts; `None` for a leaf.
    parts: Option<[usize; 2]>,
}

/// Bodies in boxes.
#[derive(Debug)]
struct Tree {
    boxes: Vec<Bounds>,
    /// Bodies in the order of the leaves.
    order: Vec<usize>,
    /// The first is the root.
    branches: Vec<TreeNode>,
}

impl Tree {
    /// Halves the bodies, at least one, along the longest side of their box until few are left.
    fn new(boxes: Vec<Bounds>) -> Self {
        let mut tree = Self {
            order: (0..boxes.len()).collect(),
            boxes,
            branches: Vec::new(),
        };
        tree.add(0, tree.order.len());
        tree
    }

    fn add(&mut self, from: usize, to: usize) -> usize {
        let bodies = &mut self.order[from..to];
        let bounds = around(bodies.iter().flat_map(|body| self.boxes[*body]));
        let number = self.branches.len();
        self.branches.push(TreeNode {
            bounds,
            bodies: [from, to],
            parts: None,
        });
        // Most bodies of a leaf.
        if to - from > 4 {
            let length = |c: usize| bounds[1][c] - bounds[0][c];
            let axis = (0..3).fold(0, |best, c| if length(c) > length(best) { c } else { best });
            let middle = |body: &usize| self.boxes[*body][0][axis] + self.boxes[*body][1][axis];
            let half = (to - from) / 2;
            bodies.select_nth_unstable_by(half, |a, b| {
                middle(a).total_cmp(&middle(b)).then(a.cmp(b))
            });
            let parts = [self.add(from, from + half), self.add(from + half, to)];
            self.branches[number].parts = Some(parts);
        }
        number
    }

    /// Some body whose branch is near a point, to begin a search with.
    fn any(&self, point: [f64; 3]) -> usize {
        let mut branch = &self.branches[0];
        while let Some([first, second]) = branch.parts {
            let [near, far] = [first, second].map(|part| &self.branches[part]);
            let is_far = outside(&far.bounds, point) < outside(&near.bounds, point);
            branch = if is_far { far } else { near };
        }
        self.order[branch.bodies[0]]
    }

    /// The nearest body to a point and what the search says of it, where `search` gives the distance of a body, at least
    /// that of its box, with something to keep. A body that holds the point ends the search; `guess` is asked first.
    fn nearest<T>(
        &self,
        point: [f64; 3],
        guess: usize,
        search: impl Fn(usize) -> (f64, T),
    ) -> (usize, T) {
        let (mut least, kept) = search(guess);
        let mut best = (guess, kept);
        let mut waiting = vec![0];
        while let Some(branch) = waiting.pop().map(|number: usize| &self.branches[number]) {
            if least == 0.0 {
                break;
            }
            if outside(&branch.bounds, point) >= least {
                continue;
            }
            if let Some([first, second]) = branch.parts {
                let away = |part: usize| outside(&self.branches[part].bounds, point);
                // The nearer part is looked at first.
                let mut parts = [first, second];
                if away(first) <= away(second) {
                    parts.reverse();
                }
                waiting.extend(parts);
                continue;
            }
            for &body in &self.order[branch.bodies[0]..branch.bodies[1]] {
                if outside(&self.boxes[body], point) >= least {
                    continue;
                }
                let (found, kept) = search(body);
                if found < least {
                    least = found;
                    best = (body, kept);
                }
            }
        }
        best
    }
}

/// The box around points.
fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Bounds {
    let nothing = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    points.into_iter().fold(nothing, |[low, high], x| {
        [
            std::array::from_fn(|c| low[c].min(x[c])),
            std::array::from_fn(|c| high[c].max(x[c])),
        ]
    })
}

/// The distance of a point from a box in m, 0 inside.
fn outside([low, high]: &Bounds, point: [f64; 3]) -> f64 {
    let beyond = |c: usize| (low[c] - point[c]).max(point[c] - high[c]).max(0.0);
    (0..3).map(|c| beyond(c).powi(2)).sum::<f64>().sqrt()
}

/// A tetrahedron of a mesh.
#[derive(Debug, Clone)]
struct SearchedTetrahedron {
    /// Its corners in m.
    corners: [[f64; 3]; 4],
    /// Volume and gradients on straight sides.
    simplex: Simplex,
    /// The map through its ten nodes, on curved sides.
    map: Option<Box<IsoparametricMap>>,
    /// A box around it.
    bounds: Bounds,
}

impl SearchedTetrahedron {
    fn of(mesh: &Mesh, t: usize) -> Self {
        let corners = mesh.corners(&mesh.tetrahedra[t]);
        let middles = mesh.mid_edges.as_ref();
        let middles = middles.map(|known| mesh.corners(&known.tetrahedra[t]));
        let curved = middles.filter(|middles| !is_straight(&corners, &TETRAHEDRON_EDGES, middles));
        // The quadratic map is a convex combination of corners and of 2 m − (a + b)/2 for edges a b with middle m.
        let controls = curved.iter().flat_map(|middles| {
            let edges = TETRAHEDRON_EDGES.into_iter().zip(middles);
            edges.map(|([a, b], middle)| {
                std::array::from_fn(|c| 2.0 * middle[c] - 0.5 * (corners[a][c] + corners[b][c]))
            })
        });
        Self {
            bounds: around(corners.into_iter().chain(controls)),
            simplex: Simplex::new(&corners),
            map: curved.map(|middles| Box::new(IsoparametricMap::new(&corners, &middles))),
            corners,
        }
    }

    /// The place in m of a point in barycentric coordinates, and the volume in m³ of a straight tetrahedron with the
    /// Jacobian there.
    fn place(&self, at: &[f64; 4]) -> ([f64; 3], f64) {
        match &self.map {
            None => (quadrature::point(&self.corners, at), self.simplex.volume),
            Some(map) => (map.place(at), map.geometry(at).0),
        }
    }

    /// The displacement at a point in barycentric coordinates in m.
    fn displacement(field: MeshField<'_>, t: usize, at: &[f64; 4]) -> Vector3<f64> {
        let sum = |shape: &[f64]| {
            let nodes = field.mesh.tetrahedron_nodes(t).zip(shape);
            nodes
                .map(|(n, w)| Vector3::from(field.displacement[n]) * *w)
                .sum()
        };
        match field.mesh.mid_edges {
            None => sum(at),
            Some(_) => sum(&quadratic_tetrahedron(at)),
        }
    }

    /// Voigt strain (xx, yy, zz, 2yz, 2xz, 2xy) of a displacement at a point in barycentric coordinates.
    fn strain(&self, field: MeshField<'_>, t: usize, at: &[f64; 4]) -> Vector6<f64> {
        let slope = |gradients: &[Vector3<f64>]| -> Matrix3<f64> {
            let nodes = field.mesh.tetrahedron_nodes(t).zip(gradients);
            nodes
                .map(|(n, g)| Vector3::from(field.displacement[n]) * g.transpose())
                .sum()
        };
        let gradients = &self.simplex.gradients;
        let slope = match (&self.map, &field.mesh.mid_edges) {
            (Some(map), _) => slope(&map.geometry(at).1),
            (None, Some(_)) => slope(&quadratic_gradients(gradients, at)),
            (None, None) => slope(gradients),
        };
        let shear = |i: usize, j: usize| slope[(i, j)] + slope[(j, i)];
        let [x, y, z] = [0, 1, 2].map(|c| slope[(c, c)]);
        Vector6::new(x, y, z, shear(1, 2), shear(0, 2), shear(0, 1))
    }

    /// The distance in m from a point to the piece, 0 inside, and the barycentric coordinates of the place in it that
    /// the point is taken for: its own, with the negative ones cut off.
    fn nearest(&self, point: [f64; 3]) -> (f64, [f64; 4]) {
        let found = self.barycentric(point);
        if !found.iter().all(|l| l.is_finite()) {
            // Newton's method leads nowhere from far outside a curved tetrahedron.
            return (f64::INFINITY, [0.25; 4]);
        }
        let least = found.iter().copied().fold(f64::INFINITY, f64::min);
        let inside = found.map(|l| l.max(0.0));
        let sum: f64 = inside.iter().sum();
        let inside = inside.map(|l| l / sum);
        // Barycentric coordinates down to minus this belong to a tetrahedron: roundings of places on its sides.
        if least >= -1e-10 {
            return (0.0, inside);
        }
        let off = Vector3::from(self.place(&inside).0) - Vector3::from(point);
        (off.norm(), inside)
    }

    fn barycentric(&self, point: [f64; 3]) -> [f64; 4] {
        let point = Vector3::from(point);
        match &self.map {
            None => {
                let arm = point - Vector3::from(self.corners[0]);
                let [_, b, c, d] = self.simplex.gradients.map(|gradient| gradient.dot(&arm));
                [1.0 - b - c - d, b, c, d]
            }
            Some(map) => {
                let mut at = [0.25; 4];
                // Steps of Newton's method for a place in a curved tetrahedron; few are needed, and more help no point outside.
                for _ in 0..12 {
                    let arm = point - Vector3::from(map.place(&at));
                    let (_, slopes) = map.geometry(&at);
                    // λ_k is 1 at corner k and ½ in the middle of its edges.
                    let step: [f64; 4] = std::array::from_fn(|k| {
                        let own = TETRAHEDRON_EDGES.iter().zip(&slopes[4..]);
                        let own = own.filter(|(ends, _)| ends.contains(&k));
                        let halves: Vector3<f64> = own.map(|(_, slope)| slope * 0.5).sum();
                        (slopes[k] + halves).dot(&arm)
                    });
                    at = std::array::from_fn(|k| at[k] + step[k]);
                    // Steps below this size in barycentric coordinates are roundings.
                    if step.iter().all(|s| s.abs() < 1e-13) {
                        break;
                    }
                }
                at
            }
        }
    }
}

mod tests;
