//! Bases of the rigid motions of a body: those that contact or supports act on, and those that they do not.
//!
//! Where a free motion q separates every pane from the foundation, w_ν(q) < 0, and the load does not work in it, e·q = 0, and it slides no
//! pane with friction, nothing presses, by the balance of forces, Σ λ_ν·w_ν(q) = 0; where it slides some, nothing has to if e = 0. How high the body floats is
//! then free, so that S, G and the pressed panes do not determine it. It is left as low as it can be.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{RigidCoupling, RigidEquilibrium, rigid_coupling::NULL_MODE_SHARE};
use crate::{
    contact::MultiplierLayout,
    elasticity::RigidModes,
    linalg::{FEW_ROUNDINGS, add_scaled, dot, norm},
};

/// What of the contact face a motion moves as a rigid one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    Nothing,
    AlongIt,
    Any,
}

impl Reach {
    /// Takes out of B Z of a motion what is rounding.
    pub(super) fn restrict(self, integrals: &mut [f64], layout: MultiplierLayout) {
        match self {
            Self::Nothing => integrals.fill(0.0),
            Self::AlongIt => integrals[layout.normals()].fill(0.0),
            Self::Any => {}
        }
    }
}

/// Bases of the motions that are active and of those that are not.
pub(super) struct MotionSpaces {
    /// Those that contact or supports act on, in terms of the modes, each with its D in N/m and what it moves.
    pub(super) active: Vec<(Vec<f64>, f64, Reach)>,
    pub(super) null: Vec<Vec<f64>>,
}

impl MotionSpaces {
    /// From B Z, `[n_modes][n_multipliers]`, and D. A motion is active if it moves the contact face, in the mean square over it, or
    /// supports resist it. Where all motions are active and no support resists, the modes themselves.
    pub(super) fn new(
        of_modes: &[Vec<f64>],
        body: &RigidModes,
        areas: &[f64],
        layout: MultiplierLayout,
    ) -> Self {
        let k = of_modes.len();
        let weight = |j: usize| areas[layout.pane_of(j)].sqrt().recip();
        // As many rows as columns at least, so that no vector is missing.
        let n_rows = layout.n_multipliers().max(k);
        let on_face = DMatrix::from_fn(n_rows, k, |j, p| {
            of_modes[p].get(j).map_or(0.0, |value| value * weight(j))
        });
        let least = NULL_MODE_SHARE * on_face.singular_values().max();
        let whole = DMatrix::identity(k, k);
        let Some(support) = &body.support else {
            let (on, off) = active(&on_face, &whole, least);
            let basis = if off.ncols() == 0 { &whole } else { &on };
            return Self {
                active: unresisted(basis),
                null: columns(&off),
            };
        };
        let support = DMatrix::from_fn(k, k, |p, q| support.stiffness[p][q]);
        // What supports resist first: of the rest, contact feels no more motions than it has multipliers.
        let (held, free) = by_support(&support);
        let (free, null) = active(&on_face, &free, least);
        let mut pressing = on_face.clone();
        pressing
            .rows_mut(layout.n_panes(), n_rows - layout.n_panes())
            .fill(0.0);
        let (normal, flat) = active(&pressing, &held, least);
        let (along, off) = active(&on_face, &flat, least);
        let spaces = [
            (off, Reach::Nothing),
            (along, Reach::AlongIt),
            (normal, Reach::Any),
        ];
        let mut active = conjugate(&support, spaces);
        active.extend(unresisted(&free));
        Self {
            active,
            null: columns(&null),
        }
    }

    /// The rows of the inverse of all motions that belong to active ones.
    pub(super) fn coordinates(&self) -> Vec<Vec<f64>> {
        let active = self.active.iter().map(|(modes, ..)| modes);
        let all: Vec<DVector<f64>> = active
            .chain(&self.null)
            .map(|modes| DVector::from_row_slice(modes))
            .collect();
        let inverse = DMatrix::from_columns(&all).try_inverse();
        let inverse = inverse.expect("a basis of the motions");
        let rows = inverse.row_iter().take(self.active.len());
        rows.map(|row| row.iter().copied().collect()).collect()
    }
}

/// The part of a space of motions that moves the rows of a face by more than `least`, and the rest of it.
pub(super) fn active(
    on_face: &DMatrix<f64>,
    space: &DMatrix<f64>,
    least: f64,
) -> (DMatrix<f64>, DMatrix<f64>) {
    if space.ncols() == 0 {
        return (space.clone(), space.clone());
    }
    let svd = (on_face * space).svd(false, true);
    let vectors = space * svd.v_t.expect("asked for").transpose();
    let is_active = |p: &usize| svd.singular_values[*p] > least;
    let (active, null): (Vec<usize>, Vec<usize>) = (0..space.ncols()).partition(is_active);
    (
        vectors.select_columns(&active),
        vectors.select_columns(&null),
    )
}

fn unresisted(space: &DMatrix<f64>) -> Vec<(Vec<f64>, f64, Reach)> {
    let motion = |modes| (modes, 0.0, Reach::Any);
    columns(space).into_iter().map(motion).collect()
}

/// A basis of motions in which D is diagonal, space by space: motions of a later one may take up some of those before, which move less
/// of the face, and none of those after. A motion along the face, which weak springs let go far, is so never part of one that presses it.
fn conjugate(
    support: &DMatrix<f64>,
    spaces: [(DMatrix<f64>, Reach); 3],
) -> Vec<(Vec<f64>, f64, Reach)> {
    let mut basis: Vec<(DVector<f64>, f64, Reach)> = Vec::new();
    for (mut space, reach) in spaces {
        // Twice, for rounding.
        for _ in 0..2 {
            for (known, stiffness, _) in &basis {
                let along = known.transpose() * support * &space / *stiffness;
                space -= known * along;
            }
        }
        if space.ncols() == 0 {
            continue;
        }
        let eigen = (space.transpose() * support * &space).symmetric_eigen();
        let vectors = &space * &eigen.eigenvectors;
        for (vector, stiffness) in vectors.column_iter().zip(&eigen.eigenvalues) {
            basis.push((vector.into_owned(), *stiffness, reach));
        }
    }
    let motion = |(modes, support, reach): (DVector<f64>, f64, Reach)| {
        // What rounding mixes in would leave the plane of a face on a long way along it.
        let least = FEW_ROUNDINGS * f64::EPSILON * modes.amax();
        let modes = modes.map(|w| if w.abs() > least { w } else { 0.0 });
        (modes.data.into(), support, reach)
    };
    basis.into_iter().map(motion).collect()
}

/// Orthonormal bases of the motions that supports resist and of those that they do not.
fn by_support(support: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let eigen = support.clone().symmetric_eigen();
    // Supports that are softer in a motion by so much resist it by rounding only.
    let least = 1e-13 * support.diagonal().max();
    let (held, free): (Vec<usize>, Vec<usize>) =
        (0..support.ncols()).partition(|&p| eigen.eigenvalues[p] > least);
    (
        eigen.eigenvectors.select_columns(&held),
        eigen.eigenvectors.select_columns(&free),
    )
}

fn columns(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let columns = matrix.column_iter();
    columns.map(|c| c.iter().copied().collect()).collect()
}

/// Share of the mean lift that every pane takes part in, at least.
const LIFTED: f64 = 1e-3;

/// The motion that comes nearest to a lift by one, of those that no support resists and the load does not drive; `None` where it does not
/// lift every pane. Of those that no friction feels, where one does so; else, where nothing drives a free motion, of all, and the second is
/// true: friction may hold the body.
pub(super) fn separation_motion(
    coupling: &RigidCoupling,
    resultant: &[f64],
    areas: &[f64],
) -> Option<(Vec<f64>, bool)> {
    let n_supported = coupling.n_supported();
    let free = &coupling.integrals[n_supported..];
    let layout = coupling.layout;
    let rows = |range: Range<usize>, count: usize| {
        DMatrix::from_fn(count.max(free.len()), free.len(), |i, p| {
            let j = range.start + i;
            let weight = |j: usize| areas[layout.pane_of(j)].sqrt();
            if range.contains(&j) {
                free[p][j] / weight(j)
            } else {
                0.0
            }
        })
    };
    let (n, m) = (layout.n_panes(), layout.n_multipliers());
    let (raised, slid) = (-rows(0..n, n), rows(n..m, m - n));
    let undriven = orthogonal_to(&resultant[n_supported..]);
    let least = NULL_MODE_SHARE * raised.amax().max(slid.amax());
    let (_, unfelt) = active(&slid, &undriven, least);
    let at_rest = undriven.ncols() == free.len();
    let all = at_rest.then_some((undriven, true));
    let mut spaces = [(unfelt, false)].into_iter().chain(all);
    spaces.find_map(|(space, slides)| {
        let motion = lift(&raised, &space, areas)?;
        let resisted = std::iter::repeat_n(0.0, n_supported);
        Some((resisted.chain(motion.iter().copied()).collect(), slides))
    })
}

/// The motion of a space that comes nearest to a lift by one; `None` where it does not lift every pane.
fn lift(raised: &DMatrix<f64>, space: &DMatrix<f64>, areas: &[f64]) -> Option<DVector<f64>> {
    if space.ncols() == 0 {
        return None;
    }
    let raised = raised * space;
    let size = |i| areas.get(i).map_or(0.0, |a: &f64| a.sqrt());
    let wanted = DVector::from_fn(raised.nrows(), |i, _| size(i));
    let svd = raised.clone().svd(true, true);
    let weights = svd
        .solve(&wanted, LIFTED * svd.singular_values.max())
        .ok()?;
    let lifts = &raised * &weights;
    let mut panes = lifts.iter().zip(areas);
    let lifts_all = panes.all(|(by, area)| *by > LIFTED * area.sqrt());
    lifts_all.then(|| space * weights)
}

/// An orthonormal basis of the vectors orthogonal to one, as columns.
fn orthogonal_to(vector: &[f64]) -> DMatrix<f64> {
    let n = vector.len();
    let size = norm(vector);
    if size == 0.0 {
        return DMatrix::identity(n, n);
    }
    // The columns but one of the reflection that takes the vector to an axis.
    let axis = (0..n).max_by(|a, b| vector[*a].abs().total_cmp(&vector[*b].abs()));
    let axis = axis.expect("it is not empty");
    let mut normal = DVector::from_row_slice(vector) / size;
    normal[axis] += normal[axis].signum();
    let square = normal.norm_squared();
    let reflection = DMatrix::identity(n, n) - &normal * normal.transpose() * (2.0 / square);
    reflection.remove_column(axis)
}

impl RigidEquilibrium {
    /// The motions α of a body that nothing presses, without contact forces and as low as the right-hand side h of its face allows;
    /// `None` where the load presses it, or may.
    pub(crate) fn separated(&self, rhs: &[f64]) -> Option<Vec<f64>> {
        let (separation, _) = self.separation_motion.as_ref()?;
        let coupling = &self.coupling;
        let by_load = self.resultant.iter().zip(&coupling.support);
        let by_load = by_load.map(|(e, d)| if *d > 0.0 { e / d } else { 0.0 });
        let mut motion: Vec<f64> = by_load.collect();
        let normals = coupling.layout.normals();
        let lifts = coupling.integrals_of(separation, rhs.len());
        let moved = coupling.integrals_of(&motion, rhs.len());
        // r = −h − G α, of every pane.
        let heights = normals.map(|i| (rhs[i] + moved[i]) / -lifts[i]);
        let height = heights.fold(0.0, f64::max);
        // A millionth higher than needed, so that rounding presses no pane.
        add_scaled(&mut motion, height * (1.0 + 1e-6), separation);
        Some(motion)
    }

    /// D of a motion in the matrix of Newton's method, in N/m, where ρ measures the panes: where panes are lifted nothing else determines
    /// a free motion, which takes 1e-8 of their stiffness. The residual does not know of it.
    pub(crate) fn stiffness_of(&self, motion: usize, steplengths: &[f64]) -> f64 {
        let support = self.coupling.support[motion];
        if support > 0.0 || self.separation_motion.is_none() {
            return support;
        }
        let g = &self.coupling.integrals[motion];
        let moved: Vec<f64> = g.iter().zip(steplengths).map(|(g, rho)| g * rho).collect();
        1e-8 * dot(g, &moved)
    }
}
