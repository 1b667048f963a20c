//! The data of a convex contact problem, scaled by local stiffness.

use std::array::from_fn;

use faer::Mat;

use super::cone::Point;
use crate::{
    contact::Ellipse,
    dual::{ExplicitDual, LocalStiffness},
    linalg::dot,
    solver::FeasibleSet,
};

/// Which entries of x a cone of the problem is made of.
#[derive(Debug, Clone, Copy)]
pub(super) enum Block {
    /// x_i ≥ 0.
    Pressure(usize),
    /// ‖(x_i, x_i+1)‖ ≤ 1.
    Pair {
        /// i.
        first: usize,
        /// The semi-axes in the unit of pressures; 0 for one that vanishes.
        axes: [f64; 2],
    },
}

/// Minimise ½ xᵀA x − xᵀb over cones under Gᵀx + D α = q: r = A x − G α − b is in the dual cones.
///
/// A pressure is measured in √(S⁻¹)_ii, so that A has an inverse of unit diagonal, and a pair in its semi-axes. Components
/// that no stiffness moves, and pairs whose ellipse is a point, are left out; they vanish.
pub(in crate::solver) struct ConvexProgram {
    /// A.
    pub(super) matrix: Mat<f64>,
    /// b.
    pub(super) rhs: Vec<f64>,
    pub(super) blocks: Vec<Block>,
    /// G, a column for each motion.
    pub(super) motions: Vec<Vec<f64>>,
    /// q.
    pub(super) resultant: Vec<f64>,
    /// The diagonal of D.
    pub(super) support: Vec<f64>,
    /// A bound for all pressures, √(hᵀS⁻¹h): a component is at most the norm that A gives the solution, since A⁻¹ has unit
    /// diagonal, and that norm is largest where nothing bounds the solution. Where motions α let equilibrium bound it too it is a guess of that size,
    /// and only says how fast the method converges.
    pub(super) pressure_bound: f64,
    /// Multiplier of each x_i, and what one of x_i is there.
    source: Vec<(usize, f64)>,
}

/// What holds the rigid motions α of a body: Gᵀλ + D α = q; nothing where supports hold it.
#[derive(Default)]
pub(in crate::solver) struct Motions {
    /// G, `[n_motions][n_multipliers]`, in m².
    pub(in crate::solver) integrals: Vec<Vec<f64>>,
    /// q, in N.
    pub(in crate::solver) resultant: Vec<f64>,
    /// The diagonal matrix D, not negative, in N/m; zeros where nothing but contact holds the body.
    pub(in crate::solver) support: Vec<f64>,
}

impl ConvexProgram {
    /// The problem of S = `entry(i, j)` and h over a set, with the local stiffness (S⁻¹)_ii of each component and a bound for
    /// √(λᵀSλ), which bounds all pressures.
    pub(in crate::solver) fn new(
        entry: impl Fn(usize, usize) -> f64,
        rhs: &[f64],
        set: &FeasibleSet,
        stiffness: &[f64],
        pressure_bound: f64,
        motions: &Motions,
    ) -> Self {
        let layout = set.layout;
        let mut source = Vec::new();
        let mut blocks = Vec::new();
        for i in layout.normals().filter(|&i| stiffness[i] > 0.0) {
            blocks.push(Block::Pressure(source.len()));
            source.push((i, stiffness[i].sqrt()));
        }
        for (pane, ellipse) in set.ellipses.iter().enumerate() {
            let Some(pair) = layout.tangential(pane) else {
                continue;
            };
            let axes: [f64; 2] = from_fn(|k| match stiffness[pair[k]] {
                0.0 => 0.0,
                rho => ellipse.semi_axes[k] / rho.sqrt(),
            });
            if axes != [0.0; 2] {
                let first = source.len();
                blocks.push(Block::Pair { first, axes });
                source.extend((0..2).map(|k| (pair[k], axes[k] * stiffness[pair[k]].sqrt())));
            }
        }
        let n = source.len();
        let scaled = |values: &[f64]| source.iter().map(|&(j, unit)| unit * values[j]).collect();
        Self {
            matrix: Mat::from_fn(n, n, |i, j| {
                let ((row, by_row), (column, by_column)) = (source[i], source[j]);
                by_row * entry(row, column) * by_column
            }),
            rhs: scaled(rhs),
            blocks,
            motions: motions.integrals.iter().map(|g| scaled(g)).collect(),
            resultant: motions.resultant.clone(),
            support: motions.support.clone(),
            pressure_bound,
            source,
        }
    }

    /// The problem of a dense S written about zero.
    pub(in crate::solver) fn of_dual(
        dual: &ExplicitDual,
        set: &FeasibleSet,
        local: &LocalStiffness,
    ) -> Self {
        let motions = dual.rigid.as_ref().map(|it| Motions {
            integrals: it.coupling.integrals.clone(),
            resultant: it.resultant.clone(),
            support: it.coupling.support.clone(),
        });
        let bonded = local.bonded_start(dual);
        let bonded = dual.multipliers(&bonded);
        let pressure_bound = dot(bonded, &dual.apply(bonded)).max(0.0).sqrt();
        let entry = |i: usize, j: usize| dual.column(j)[i];
        let (rhs, stiffness) = (&dual.rhs, &local.stiffness);
        Self::new(
            entry,
            rhs,
            set,
            stiffness,
            pressure_bound,
            &motions.unwrap_or_default(),
        )
    }

    /// λ and α of x and α, `[n_multipliers + n_motions]`.
    pub(in crate::solver) fn unknowns(&self, x: &[f64], motion: &[f64], n: usize) -> Vec<f64> {
        let mut unknowns = vec![0.0; n];
        for (&(j, unit), x) in self.source.iter().zip(x) {
            unknowns[j] = unit * x;
        }
        unknowns.extend(motion);
        unknowns
    }

    /// A x − G α − b.
    pub(super) fn gradient(&self, x: &[f64], motion: &[f64]) -> Vec<f64> {
        let mut gradient: Vec<f64> = self.rhs.iter().map(|b| -b).collect();
        for (j, x) in x.iter().enumerate() {
            for (r, a) in gradient.iter_mut().zip(self.matrix.col(j).iter()) {
                *r += a * x;
            }
        }
        for (g, alpha) in self.motions.iter().zip(motion) {
            for (r, g) in gradient.iter_mut().zip(g) {
                *r -= alpha * g;
            }
        }
        gradient
    }

    /// Whether nothing presses the faces, moves them along or is to be carried: x = 0 and α = 0 is the solution.
    pub(super) fn is_solved_by_zero(&self) -> bool {
        let is_at_rest = |block: &Block| {
            let [pressed, along @ ..] = block.part(&self.rhs);
            pressed <= 0.0 && along == [0.0; 2]
        };
        self.resultant.iter().all(|q| *q == 0.0) && self.blocks.iter().all(is_at_rest)
    }

    /// q − Gᵀx − D α.
    pub(super) fn imbalance(&self, x: &[f64], motion: &[f64]) -> Vec<f64> {
        let rows = self.motions.iter().zip(&self.support).zip(&self.resultant);
        let rows = rows.zip(motion);
        rows.map(|(((g, d), q), alpha)| q - dot(g, x) - d * alpha)
            .collect()
    }

    /// The components that blocks take of a vector made cone by cone.
    pub(super) fn of_blocks(&self, point: impl Fn(&Block) -> Point) -> Vec<f64> {
        let mut values = vec![0.0; self.rhs.len()];
        for block in &self.blocks {
            block.add_to(&mut values, point(block));
        }
        values
    }
}

impl Block {
    /// Its components of a vector; the first of a pair is zero.
    pub(super) fn part(&self, values: &[f64]) -> Point {
        match *self {
            Self::Pressure(i) => [values[i], 0.0, 0.0],
            Self::Pair { first, .. } => [0.0, values[first], values[first + 1]],
        }
    }

    /// Its point of the cone at x.
    pub(super) fn point(&self, x: &[f64]) -> Point {
        match *self {
            Self::Pressure(_) => self.part(x),
            Self::Pair { first, .. } => [1.0, x[first], x[first + 1]],
        }
    }

    /// Adds the components that x has.
    pub(super) fn add_to(&self, values: &mut [f64], point: Point) {
        for (i, k) in self.components() {
            values[i] += point[k];
        }
    }

    /// The entries of x and their components of the cone.
    pub(super) fn components(&self) -> impl Iterator<Item = (usize, usize)> + Clone + use<> {
        let (first, range) = match *self {
            Self::Pressure(i) => (i, 0..1),
            Self::Pair { first, .. } => (first, 1..3),
        };
        range.enumerate().map(move |(at, k)| (first + at, k))
    }

    /// What one of its dual variable z₀ is as a pressure.
    pub(super) fn unit(&self) -> f64 {
        match *self {
            Self::Pressure(_) => 1.0,
            Self::Pair { axes, .. } => axes[0].max(axes[1]),
        }
    }

    /// The largest component of x, in the unit of pressures.
    pub(super) fn size(&self, x: &[f64]) -> f64 {
        match *self {
            Self::Pressure(i) => x[i].abs(),
            Self::Pair { first, axes } => {
                (axes[0] * x[first].abs()).max(axes[1] * x[first + 1].abs())
            }
        }
    }

    /// The largest component of a gradient, likewise.
    pub(super) fn size_of_gradient(&self, values: &[f64]) -> f64 {
        let part = self.part(values);
        match *self {
            Self::Pressure(_) => part[0].abs(),
            Self::Pair { axes, .. } => (0..2)
                .filter(|&k| axes[k] > 0.0)
                .map(|k| (part[k + 1] / axes[k]).abs())
                .fold(0.0, f64::max),
        }
    }

    /// How far the block is from being either at its bound or free of force, as a pressure: the natural map of its point and its dual z,
    /// in units in which ρ = 1. Of a pair that is the angle between z and the normal at its bound, too, which is only as small as the
    /// root of s·z.
    pub(super) fn indecision(&self, s: Point, z: Point) -> f64 {
        match *self {
            Self::Pressure(_) => s[0].min(z[0]),
            Self::Pair { axes, .. } => {
                let point = [axes[0] * s[1], axes[1] * s[2]];
                let trial = from_fn(|k| match axes[k] {
                    0.0 => 0.0,
                    axis => point[k] - z[k + 1] / axis,
                });
                let next = Ellipse { semi_axes: axes }.project(trial);
                (point[0] - next[0]).abs().max((point[1] - next[1]).abs())
            }
        }
    }
}
