//! The distance of two finite element solutions on any two meshes of the same body.
//!
//! ‖u_a − u_b‖_A² = ∫ (ε(u_a) − ε(u_b)) : C : (ε(u_a) − ε(u_b)) + ∫ (u_a − u_b)·K (u_a − u_b) is integrated over the tetrahedra
//! of the reference b and its faces on springs, with the material and the springs of the scene, and the strain of u_a at each point is that of the tetrahedron of mesh a which holds it. Where a
//! is nested in b the rules are exact; elsewhere ε(u_a) jumps inside tetrahedra of b, and a rule sees its jumps only
//! from its points.

mod tree;

use nalgebra::{Vector3, Vector6};
use rayon::prelude::*;

use contact3d::{
    elasticity::{MaterialField, visit_springs},
    mesh::Mesh,
    reference::quadrature,
    scene::{Invalid, Scene},
};

use tree::SearchedTetrahedron;
use tree::Tree;

/// A displacement on a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Displacement of its nodes in m, `[n_nodes]`.
    pub displacement: &'a [[f64; 3]],
}

/// How many points each tetrahedron of the reference is integrated by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Points {
    /// 14 points, exact for polynomials of degree 5.
    #[default]
    Fourteen,
    /// 64 points, exact for polynomials of degree 5 too, which see more of the jumps.
    SixtyFour,
}

impl Points {
    fn rule(self) -> Vec<([f64; 4], f64)> {
        match self {
            Self::Fourteen => quadrature::tetrahedron_5().collect(),
            Self::SixtyFour => quadrature::tetrahedron().collect(),
        }
    }
}

/// ‖u_a − u_b‖_A and ‖u_b‖_A in √J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// ‖u_a − u_b‖_A in √J.
    pub absolute: f64,
    /// ‖u_b‖_A in √J.
    pub reference: f64,
}

impl Distance {
    /// ‖u_a − u_b‖_A / ‖u_b‖_A; 0 where both are at rest.
    #[must_use]
    pub fn relative(self) -> f64 {
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
    field: Field<'a>,
    pieces: Vec<SearchedTetrahedron>,
    tree: Tree,
}

impl<'a> Searchable<'a> {
    fn new(field: Field<'a>) -> Self {
        let tetrahedra = (0..field.mesh.tetrahedra.len()).into_par_iter();
        let pieces: Vec<SearchedTetrahedron> = tetrahedra
            .map(|t| SearchedTetrahedron::of(field.mesh, t))
            .collect();
        let boxes = pieces
            .par_iter()
            .map(SearchedTetrahedron::surrounding_box)
            .collect();
        Self {
            field,
            pieces,
            tree: Tree::new(boxes),
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
pub fn distance(
    field: Field<'_>,
    reference: Field<'_>,
    scene: &Scene,
    points: Points,
) -> Result<Distance, Invalid> {
    let material = MaterialField::new(scene, reference.mesh);
    let searchable = Searchable::new(field);
    let rule = points.rule();
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

#[cfg(test)]
mod tests;
