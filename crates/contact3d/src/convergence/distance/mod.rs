//! The distance of two finite element solutions on any two meshes of the same body.
//!
//! ‖u_a − u_b‖_A² = ∫ (ε(u_a) − ε(u_b)) : C : (ε(u_a) − ε(u_b)) is integrated over the tetrahedra of the reference b,
//! with its material, and the strain of u_a at each point is that of the tetrahedron of mesh a which holds it. Where a
//! is nested in b the rules are exact; elsewhere ε(u_a) jumps inside tetrahedra of b, and a rule sees its jumps only
//! from its points.

mod piece;
mod tree;

use nalgebra::Vector6;
use rayon::prelude::*;

use crate::{elasticity::MaterialField, mesh::Mesh, reference::quadrature};

use piece::Piece;
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
    pieces: Vec<Piece>,
    tree: Tree,
}

impl<'a> Searchable<'a> {
    fn new(field: Field<'a>) -> Self {
        let tetrahedra = (0..field.mesh.tetrahedra.len()).into_par_iter();
        let pieces: Vec<Piece> = tetrahedra.map(|t| Piece::of(field.mesh, t)).collect();
        let boxes = pieces.par_iter().map(Piece::surrounding_box).collect();
        Self {
            field,
            pieces,
            tree: Tree::new(boxes),
        }
    }

    /// Voigt strain at a point in m, and the tetrahedron it was found in; `guess` is looked at first.
    fn strain(&self, point: [f64; 3], guess: usize) -> (Vector6<f64>, usize) {
        let search = |t: usize| self.pieces[t].nearest(point);
        let (t, at) = self.tree.nearest(point, guess, search);
        (self.pieces[t].strain(self.field, t, &at), t)
    }
}

/// The distance of a displacement from a reference, whose material decides.
///
/// Points of the reference that lie in no tetrahedron of the other mesh, as near curved sides, take the strain of the
/// nearest place of one. The result does not depend on the number of threads.
#[must_use]
pub fn distance(
    field: Field<'_>,
    reference: Field<'_>,
    material: &MaterialField<'_>,
    points: Points,
) -> Distance {
    let searchable = Searchable::new(field);
    let rule = points.rule();
    let tetrahedra = (0..reference.mesh.tetrahedra.len()).into_par_iter();
    let energies: Vec<[f64; 2]> = tetrahedra
        .map(|t| {
            let piece = Piece::of(reference.mesh, t);
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
    let total = |k: usize| energies.iter().map(|e| e[k]).sum::<f64>().max(0.0).sqrt();
    Distance {
        absolute: total(0),
        reference: total(1),
    }
}

#[cfg(test)]
mod tests;
