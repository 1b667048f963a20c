//! The face of the admissible set on which a multiplier lies.

use crate::{
    contact::MultiplierLayout,
    dual::DualOperator,
    linalg::{add_scaled, dot, norm},
    solver::{FeasibleSet, StepCounts},
};

/// How the tangential pair of a pane can move on a face of the admissible set.
#[derive(Debug, Clone, Copy)]
enum PairFreedom {
    /// Not at all: the ellipse is a point, or the pair is at the end of a segment.
    Fixed,
    /// Along a line, the tangent of the ellipse or the axis of a segment.
    Line {
        tangent: [f64; 2],
        /// (−r·ν)₊ κ in m³/Pa: what the curvature of the boundary adds to the Hessian.
        stiffness: f64,
    },
    /// In the plane.
    Free,
}

/// The face on which a multiplier lies, as the tangent space there with the Hessian of the energy
/// restricted to the face, H = TᵀST + diag((−r·ν)₊ κ).
///
/// Coordinates are vectors as long as λ: λ_ν of free panes, the coefficient along the tangent in
/// the first slot of a pair on its ellipse, both components of a free pair, 0 elsewhere. So a
/// direction is tangential to the last bit; in plain components the roundings of the normal forces
/// would grow during conjugate gradients.
#[derive(Debug, Clone)]
pub(in crate::solver) struct ActiveFace {
    layout: MultiplierLayout,
    pressed: Vec<bool>,
    pairs: Vec<PairFreedom>,
}

impl ActiveFace {
    /// The face of an admissible multiplier with gradient r = Sλ − h.
    pub(in crate::solver) fn new(set: &FeasibleSet, multiplier: &[f64], gradient: &[f64]) -> Self {
        let (normal, _) = set.layout.split(multiplier);
        let pairs = set.ellipses.iter().enumerate().map(|(pane, ellipse)| {
            let point = set.layout.pair(multiplier, pane);
            let [a, b] = ellipse.semi_axes;
            let inside = |k: usize| point[k].abs() < ellipse.semi_axes[k];
            match (a > 0.0, b > 0.0) {
                (true, true) if !ellipse.on_boundary(point) => PairFreedom::Free,
                (true, true) => {
                    let (normal, curvature) = ellipse.normal_and_curvature(point);
                    let r = set.layout.pair(gradient, pane);
                    let force = -(r[0] * normal[0] + r[1] * normal[1]);
                    PairFreedom::Line {
                        tangent: [normal[1], -normal[0]],
                        stiffness: force.max(0.0) * curvature,
                    }
                }
                (true, false) if inside(0) => PairFreedom::axis([1.0, 0.0]),
                (false, true) if inside(1) => PairFreedom::axis([0.0, 1.0]),
                _ => PairFreedom::Fixed,
            }
        });
        Self {
            layout: set.layout,
            pressed: normal.iter().map(|l| *l > 0.0).collect(),
            pairs: pairs.collect(),
        }
    }

    /// Whether the same blocks are free, held and on a boundary.
    pub(in crate::solver) fn same_as(&self, other: &Self) -> bool {
        let kind = std::mem::discriminant::<PairFreedom>;
        let mut pairs = self.pairs.iter().zip(&other.pairs);
        self.pressed == other.pressed && pairs.all(|(a, b)| kind(a) == kind(b))
    }

    /// Tᵀv, `[n_multipliers]`.
    pub(in crate::solver) fn coordinates(&self, vector: &[f64]) -> Vec<f64> {
        self.map(vector, |tangent, v| {
            [tangent[0] * v[0] + tangent[1] * v[1], 0.0]
        })
    }

    /// T c, `[n_multipliers]`.
    fn direction(&self, coordinates: &[f64]) -> Vec<f64> {
        self.map(coordinates, |tangent, c| tangent.map(|t| c[0] * t))
    }

    /// Solves H d = −g for the coordinates g of the gradient by conjugate gradients, to the
    /// residual `target`, and returns the direction T d in Pa.
    ///
    /// The preconditioner diag(1 + ᾱ (−r·ν)₊ κ) keeps the condition number below that of S however
    /// small an ellipse is. Stops early at a direction without curvature and after `most_steps`.
    pub(in crate::solver) fn newton_direction(
        &self,
        operator: &mut dyn DualOperator,
        gradient: &[f64],
        steplength: f64,
        target: f64,
        most_steps: usize,
        steps: &mut StepCounts,
    ) -> Vec<f64> {
        let stiffness = self.stiffness();
        let precondition = |residual: &[f64]| -> Vec<f64> {
            let pairs = residual.iter().zip(&stiffness);
            pairs.map(|(r, k)| r / (1.0 + steplength * k)).collect()
        };
        let mut solution = vec![0.0; gradient.len()];
        let mut residual: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut scaled = precondition(&residual);
        let mut p = scaled.clone();
        let mut product = dot(&residual, &scaled);
        for _ in 0..most_steps {
            let mut h_p = self.coordinates(&operator.apply(&self.direction(&p)));
            for ((h_p, k), p) in h_p.iter_mut().zip(&stiffness).zip(&p) {
                *h_p += k * p;
            }
            steps.conjugate_gradient += 1;
            let step = product / dot(&p, &h_p);
            if !(step.is_finite() && step > 0.0) {
                break;
            }
            add_scaled(&mut solution, step, &p);
            add_scaled(&mut residual, -step, &h_p);
            if norm(&residual) <= target {
                break;
            }
            scaled = precondition(&residual);
            let next = dot(&residual, &scaled);
            for (p, z) in p.iter_mut().zip(&scaled) {
                *p = z + next / product * *p;
            }
            product = next;
        }
        self.direction(&solution)
    }

    /// The diagonal (−r·ν)₊ κ in coordinates.
    fn stiffness(&self) -> Vec<f64> {
        let of_pair = |freedom: &PairFreedom| match freedom {
            PairFreedom::Line { stiffness, .. } => [*stiffness, 0.0],
            PairFreedom::Fixed | PairFreedom::Free => [0.0; 2],
        };
        let normal = self.pressed.iter().map(|_| 0.0);
        normal.chain(self.pairs.iter().flat_map(of_pair)).collect()
    }

    /// Keeps free components, zeroes held ones, and maps pairs on a line by `along`.
    fn map(&self, vector: &[f64], on_line: impl Fn([f64; 2], [f64; 2]) -> [f64; 2]) -> Vec<f64> {
        let (normal, tangential) = self.layout.split(vector);
        let normal = self.pressed.iter().zip(normal);
        let normal = normal.map(|(pressed, v)| if *pressed { *v } else { 0.0 });
        let pairs = self.pairs.iter().zip(tangential);
        let tangential = pairs.flat_map(|(freedom, v)| match freedom {
            PairFreedom::Fixed => [0.0; 2],
            PairFreedom::Line { tangent, .. } => on_line(*tangent, *v),
            PairFreedom::Free => *v,
        });
        normal.chain(tangential).collect()
    }
}

impl PairFreedom {
    /// Along an axis of a segment.
    fn axis(tangent: [f64; 2]) -> Self {
        Self::Line {
            tangent,
            stiffness: 0.0,
        }
    }
}
