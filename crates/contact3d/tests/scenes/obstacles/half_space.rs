//! How a half-space z > 0 moves under forces on its surface, as formulas of a scene (K. L. Johnson, *Contact Mechanics*,
//! Cambridge 1985: lines of force in §2.2 and §2.3, points in §3.2 and §3.6).
//!
//! Faces that are moved so turn a block into the part of a half-space around the contact.

use std::f64::consts::PI;

/// The half-space, and the place (x, 0, 0) of the forces on it.
#[derive(Clone, Copy)]
pub(crate) struct HalfSpace {
    pub(crate) young: f64,
    pub(crate) poisson: f64,
    pub(crate) middle: f64,
}

impl HalfSpace {
    /// E* = E/(1 − ν²) against a rigid body.
    pub(crate) fn modulus(self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    pub(crate) fn shear_modulus(self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// u in plane strain under forces a length `[along x, along z]` on a line along y, plus a shift along x and z.
    pub(crate) fn under_lines(self, forces: [f64; 2], shift: [f64; 2]) -> String {
        let ratio = self.poisson / (1.0 - self.poisson);
        let [along, into] = forces.map(|force| force / (PI * self.modulus()));
        let (x, squared) = self.relative("z^2");
        let angle = format!("{:?}*asin({x}/sqrt({squared}))", 1.0 - ratio);
        let logarithm = format!("ln({squared})");
        let slope = |product: &str| format!("{:?}*{product}/({squared})", 1.0 + ratio);
        let (mixed, own_x, own_z) = (
            slope(&format!("{x}*z")),
            slope(&format!("{x}^2")),
            slope("z^2"),
        );
        let [to_x, to_z] = shift;
        let [x, z] = [
            format!(
                "({into:?})*({mixed} - {angle}) - ({along:?})*({logarithm} + {own_z}) + ({to_x:?})"
            ),
            format!(
                "({along:?})*({mixed} + {angle}) - ({into:?})*({logarithm} + {own_x}) + ({to_z:?})"
            ),
        ];
        format!("['{x}', 0.0, '{z}']")
    }

    /// u under forces `[along x, along z]` at a point, plus a shift along x and z.
    pub(crate) fn under_points(self, forces: [f64; 2], shift: [f64; 2]) -> String {
        let [along, into] = forces.map(|force| force / (4.0 * PI * self.shear_modulus()));
        let (x, squared) = self.relative("y^2 + z^2");
        let r = format!("sqrt({squared})");
        let part = 1.0 - 2.0 * self.poisson;
        let outwards = format!("({into:?})*(z/{r}^3 - {part:?}/({r}*({r} + z)))");
        let [to_x, to_z] = shift;
        let [x, y, z] = [
            format!(
                "{x}*{outwards} + ({along:?})*(1/{r} + {x}^2/{r}^3 + {part:?}*(1/({r} + z) - {x}^2/({r}*({r} + z)^2))) + ({to_x:?})"
            ),
            format!("y*{outwards} + ({along:?})*{x}*y*(1/{r}^3 - {part:?}/({r}*({r} + z)^2))"),
            format!(
                "({into:?})*(z^2/{r}^3 + {:?}/{r}) + ({along:?})*{x}*(z/{r}^3 + {part:?}/({r}*({r} + z))) + ({to_z:?})",
                1.0 + part
            ),
        ];
        format!("['{x}', '{y}', '{z}']")
    }

    /// x from the forces, and the squared distance from them.
    fn relative(self, others: &str) -> (String, String) {
        let x = format!("(x - {:?})", self.middle);
        let squared = format!("{x}^2 + {others}");
        (x, squared)
    }
}
