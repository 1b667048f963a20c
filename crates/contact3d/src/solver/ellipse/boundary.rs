//! The geometry of an ellipse at its boundary.

use super::Ellipse;

/// The geometry of an ellipse at a point of its boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::solver) struct BoundaryFrame {
    /// Unit tangent.
    pub(in crate::solver) tangent: [f64; 2],
    /// Outer unit normal.
    pub(in crate::solver) normal: [f64; 2],
    /// Curvature κ ≥ 0 of the boundary, the reciprocal of the radius of curvature.
    pub(in crate::solver) curvature: f64,
}

impl Ellipse {
    /// Tangent, normal and curvature at a boundary point of an ellipse with positive semi-axes.
    ///
    /// At (a c₁, b c₂), c₁² + c₂² = 1, the tangent is along v = (a c₂, −b c₁), the normal along
    /// (b c₁, a c₂), and κ = a b / ‖v‖³.
    pub(in crate::solver) fn boundary_frame(&self, point: [f64; 2]) -> BoundaryFrame {
        let [a, b] = self.semi_axes;
        let (c1, c2) = (point[0] / a, point[1] / b);
        let length = (a * c2).hypot(b * c1);
        let normal = [b * c1 / length, a * c2 / length];
        BoundaryFrame {
            tangent: [normal[1], -normal[0]],
            normal,
            curvature: (a / length) * (b / length) / length,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A small step s along the tangent leaves the ellipse by κ s²/2 along the normal.
        #[test]
        fn the_frame_describes_the_projection_of_a_tangential_step(
            a in 0.2..2.0_f64, b in 0.2..2.0_f64, angle in 0.0..std::f64::consts::TAU,
        ) {
            let ellipse = Ellipse { semi_axes: [a, b] };
            let point = [a * angle.cos(), b * angle.sin()];
            let frame = ellipse.boundary_frame(point);
            let step = 1e-4 / frame.curvature;
            let beside: [f64; 2] = std::array::from_fn(|i| point[i] + step * frame.tangent[i]);
            let back = ellipse.project(beside);
            let gap = [beside[0] - back[0], beside[1] - back[1]];
            let outward = gap[0] * frame.normal[0] + gap[1] * frame.normal[1];
            let expected = 0.5 * frame.curvature * step * step;
            // The next term is smaller by step times the relative change of κ along the boundary,
            // at most some tens per radius of curvature.
            prop_assert!((outward / expected - 1.0).abs() < 1e-2);
        }
    }

    #[test]
    fn a_disc_has_its_closed_form() {
        let frame = Ellipse {
            semi_axes: [2.0, 2.0],
        }
        .boundary_frame([0.0, 2.0]);
        assert_eq!(frame.tangent, [1.0, 0.0]);
        assert_eq!(frame.normal, [0.0, 1.0]);
        assert_eq!(frame.curvature, 0.5);
    }
}
