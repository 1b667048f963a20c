//! Derivatives of the projection on an ellipse, and points of its boundary.

use super::Ellipse;

/// First derivatives of the projection p = P_{a,b}(z) on an ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectionDerivative {
    /// ∂p_i/∂z_k, symmetric.
    pub by_point: [[f64; 2]; 2],
    /// ∂p_i/∂(a, b)_k.
    pub by_semi_axes: [[f64; 2]; 2],
}

impl ProjectionDerivative {
    const INSIDE: Self = Self {
        by_point: [[1.0, 0.0], [0.0, 1.0]],
        by_semi_axes: [[0.0; 2]; 2],
    };
}

impl Ellipse {
    /// Derivatives of [`Ellipse::project`], one-sided at its kinks.
    ///
    /// Outside, with p = (a c₁, b c₂), c₁² + c₂² = 1, z = p + t (c₁/a, c₂/b) and the tangent
    /// v = (a c₂, −b c₁), differentiating these equations gives without any cancellation
    /// ∂p/∂z = v vᵀ M,  ∂p₁/∂a = c₁ M (c₁² (b² + t) + 2 t c₂²),  ∂p₂/∂a = c₁² c₂ M (a b − t b/a),
    /// and the mirror images for b, with M = 1/(t + ‖v‖²).
    ///
    /// On the boundary the derivative from inside is taken (the identity). A semi-axis a = 0 < b
    /// takes the limit a → 0 from above; when both vanish, the semi-axes grow together.
    #[must_use]
    pub fn projection_derivative(&self, z: [f64; 2]) -> ProjectionDerivative {
        let [a, b] = self.semi_axes;
        match (a == 0.0, b == 0.0) {
            (false, false) if self.level(z) <= 1.0 => ProjectionDerivative::INSIDE,
            (false, false) => self.outside(z),
            (true, false) => segment(b, z, 1),
            (false, true) => segment(a, z, 0),
            (true, true) => {
                let length = z[0].hypot(z[1]);
                let cosine = z.map(|v| if length > 0.0 { v / length } else { 0.0 });
                ProjectionDerivative {
                    by_point: [[0.0; 2]; 2],
                    by_semi_axes: [[cosine[0], 0.0], [0.0, cosine[1]]],
                }
            }
        }
    }

    /// The derivative at a point outside.
    fn outside(&self, z: [f64; 2]) -> ProjectionDerivative {
        let (_, t) = self.project_with_multiplier(z);
        let scale = self.semi_axes[0].max(self.semi_axes[1]);
        let [a, b] = self.semi_axes.map(|s| s / scale);
        if t == f64::INFINITY {
            return far([a, b], self.far_direction(z));
        }
        let ratio = |axis: f64, z: f64| axis * (z / scale) / (t + axis * axis);
        let (c1, c2) = (ratio(a, z[0]), ratio(b, z[1]));
        let length = c1.hypot(c2);
        let (c1, c2) = (c1 / length, c2 / length);
        let v = [a * c2, -b * c1];
        let m = 1.0 / (t + (v[0] * v[0] + v[1] * v[1]));
        if !m.is_finite() {
            // The smaller semi-axis vanishes beside the larger one in double precision.
            return segment(scale, z, usize::from(a < b));
        }
        let own = |c: f64, other: f64, other_axis: f64| {
            c * (c * c * ((other_axis * other_axis + t) * m) + 2.0 * other * other * (t * m))
        };
        let cross = |c: f64, other: f64, axis: f64, other_axis: f64| {
            c * c * other * (axis * other_axis * m - (t * m) * (other_axis / axis))
        };
        ProjectionDerivative {
            by_point: [
                [v[0] * v[0] * m, v[0] * v[1] * m],
                [v[0] * v[1] * m, v[1] * v[1] * m],
            ],
            by_semi_axes: [
                [own(c1, c2, b), cross(c2, c1, b, a)],
                [cross(c1, c2, a, b), own(c2, c1, a)],
            ],
        }
    }
}

/// The limit t → ∞ far outside: only the semi-axes move the projection.
fn far([a, b]: [f64; 2], [c1, c2]: [f64; 2]) -> ProjectionDerivative {
    ProjectionDerivative {
        by_point: [[0.0; 2]; 2],
        by_semi_axes: [
            [c1 * (c1 * c1 + 2.0 * c2 * c2), -c2 * c2 * c1 * (a / b)],
            [-c1 * c1 * c2 * (b / a), c2 * (c2 * c2 + 2.0 * c1 * c1)],
        ],
    }
}

/// The limit of an ellipse that shrinks to the segment |z_k| ≤ `half` of axis k = `along`.
fn segment(half: f64, z: [f64; 2], along: usize) -> ProjectionDerivative {
    let across = 1 - along;
    let mut result = ProjectionDerivative {
        by_point: [[0.0; 2]; 2],
        by_semi_axes: [[0.0; 2]; 2],
    };
    let sine = z[along] / half;
    if sine.abs() < 1.0 {
        result.by_point[along][along] = 1.0;
        if z[across] != 0.0 {
            result.by_semi_axes[across][across] =
                ((1.0 - sine) * (1.0 + sine)).sqrt().copysign(z[across]);
        }
    } else {
        result.by_semi_axes[along][along] = sine.signum();
    }
    result
}

impl Ellipse {
    /// Outer unit normal and curvature κ ≥ 0, the reciprocal of the radius of curvature, at a boundary point of an ellipse with positive
    /// semi-axes.
    ///
    /// At (a c₁, b c₂), c₁² + c₂² = 1, the normal is along v = (b c₁, a c₂), and κ = a b / ‖v‖³; the
    /// tangent is (ν₂, −ν₁).
    pub(crate) fn normal_and_curvature(&self, point: [f64; 2]) -> ([f64; 2], f64) {
        let [a, b] = self.semi_axes;
        let (c1, c2) = (point[0] / a, point[1] / b);
        let length = (a * c2).hypot(b * c1);
        let normal = [b * c1 / length, a * c2 / length];
        (normal, (a / length) * (b / length) / length)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn far_outside_the_derivative_tends_to_its_limit() {
        let ellipse = Ellipse {
            semi_axes: [2.0, 1.0],
        };
        let finite = ellipse.projection_derivative([3e12, 4e12]);
        let limit = far([1.0, 0.5], ellipse.far_direction([3.0, 4.0]));
        for i in 0..2 {
            for k in 0..2 {
                // They differ by O(1/t), and t is above 1e12.
                let difference = finite.by_semi_axes[i][k] - limit.by_semi_axes[i][k];
                assert!(difference.abs() < 1e-11);
                assert!(finite.by_point[i][k].abs() < 1e-11);
            }
        }
    }

    proptest! {
        /// A small step s along the tangent leaves the ellipse by κ s²/2 along the normal.
        #[test]
        fn normal_and_curvature_describe_the_projection_of_a_tangential_step(
            a in 0.2..2.0_f64, b in 0.2..2.0_f64, angle in 0.0..std::f64::consts::TAU,
        ) {
            let ellipse = Ellipse { semi_axes: [a, b] };
            let point = [a * angle.cos(), b * angle.sin()];
            let (normal, curvature) = ellipse.normal_and_curvature(point);
            let tangent = [normal[1], -normal[0]];
            let step = 1e-4 / curvature;
            let beside: [f64; 2] = std::array::from_fn(|i| point[i] + step * tangent[i]);
            let back = ellipse.project(beside);
            let gap = [beside[0] - back[0], beside[1] - back[1]];
            let outward = gap[0] * normal[0] + gap[1] * normal[1];
            let expected = 0.5 * curvature * step * step;
            // The next term is smaller by step times the relative change of κ along the boundary,
            // at most some tens per radius of curvature.
            prop_assert!((outward / expected - 1.0).abs() < 1e-2);
        }
    }

    #[test]
    fn a_disc_has_its_closed_form() {
        let ellipse = Ellipse {
            semi_axes: [2.0, 2.0],
        };
        assert_eq!(ellipse.normal_and_curvature([0.0, 2.0]), ([0.0, 1.0], 0.5));
    }
}
