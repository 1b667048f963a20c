//! The closed forms of bodies pulled along a roller or a ball, and the scenes that follow them.

use std::f64::consts::PI;

use super::{half_space::HalfSpace, planes::Planes};

pub(crate) const HALF_SPACE: HalfSpace = HalfSpace {
    young: 1.0,
    poisson: 0.499,
    middle: 1.0,
};
pub(crate) const FRICTION: f64 = 0.5;
const RADIUS: f64 = 100.0;

/// b of the roller, a of the ball: an eighth of the way to the other faces.
const SIZE: f64 = 0.125;

/// Shrinks the cells: n of them to the other faces leave n/2 to the edge of the contact.
const GRADING: f64 = 4.0;

/// Q/(μP) of the steps after the first: there, back, and there again.
pub(crate) const TO_AND_FRO: [f64; 3] = [0.75, -0.75, 0.75];

/// What the body is pulled along.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    Roller,
    Ball,
}
use Shape::{Ball, Roller};

impl Shape {
    /// The force P that makes a contact of this size, a length for the roller.
    pub(crate) fn force(self) -> f64 {
        match self {
            Roller => PI * HALF_SPACE.modulus() * SIZE * SIZE / (4.0 * RADIUS),
            Ball => 4.0 * HALF_SPACE.modulus() * SIZE.powi(3) / (3.0 * RADIUS),
        }
    }

    pub(crate) fn size(self, force: f64) -> f64 {
        match self {
            Roller => (4.0 * force * RADIUS / (PI * HALF_SPACE.modulus())).sqrt(),
            Ball => (3.0 * force * RADIUS / (4.0 * HALF_SPACE.modulus())).cbrt(),
        }
    }

    pub(crate) fn peak(self, force: f64) -> f64 {
        let size = self.size(force);
        match self {
            Roller => 2.0 * force / (PI * size),
            Ball => 3.0 * force / (2.0 * PI * size * size),
        }
    }

    /// c over b or a, for t = Q/(μP).
    pub(crate) fn stick(self, t: f64) -> f64 {
        match self {
            Roller => (1.0 - t.abs()).sqrt(),
            Ball => (1.0 - t.abs()).cbrt(),
        }
    }

    /// The second moment of stresses √(1 − r²/a²) over their sum, over a².
    pub(crate) fn moment(self) -> f64 {
        match self {
            Roller => 0.25,
            Ball => 0.4,
        }
    }

    /// How far points whose displacement tends to zero (on lines of force: to that of the logarithm) are pressed and pulled.
    fn shift(self, t: f64) -> [f64; 2] {
        let (force, stick) = (self.force(), self.stick(t));
        match self {
            Roller => {
                // ∫ p ln|x| over the force, for p = p₀ √(1 − x²/b²).
                let mean = |size: f64| (size / 2.0).ln() - 0.5;
                let scale = 2.0 * force / (PI * HALF_SPACE.modulus());
                let ratio = HALF_SPACE.poisson / (1.0 - HALF_SPACE.poisson);
                let pulled = mean(SIZE) - stick * stick * mean(stick * SIZE);
                [
                    FRICTION * scale * pulled * t.signum(),
                    scale * (mean(SIZE) + 0.5 + 0.5 * ratio),
                ]
            }
            Ball => {
                let scale = 3.0 * FRICTION * force * (2.0 - HALF_SPACE.poisson)
                    / (16.0 * HALF_SPACE.shear_modulus() * SIZE);
                [
                    -scale * (1.0 - stick * stick) * t.signum(),
                    -SIZE * SIZE / RADIUS,
                ]
            }
        }
    }

    /// Values of the clamps that hold the outer faces, for t = Q/(μP).
    fn walls(self, t: f64) -> String {
        let force = self.force();
        let forces = [t * FRICTION * force, force];
        match self {
            Roller => HALF_SPACE.under_lines(forces, self.shift(t)),
            Ball => HALF_SPACE.under_points(forces, self.shift(t)),
        }
    }

    /// What friction takes in a cycle between ±Q: 8 (½ Q δ − ∫ δ dQ) along the first way δ(Q), since both ways back are that
    /// way twice as large (Johnson (7.57); the roller's in the same way from its tangential compliance).
    pub(crate) fn cycle(self, force: f64, t: f64) -> f64 {
        let limit = FRICTION * force;
        let rest = 1.0 - t;
        match self {
            Roller => {
                let scale = 2.0 * limit * limit / (PI * HALF_SPACE.modulus());
                scale * (2.0 * rest * rest.ln() + 2.0 * t - t * t)
            }
            Ball => {
                let compliance = (2.0 - HALF_SPACE.poisson) / HALF_SPACE.shear_modulus();
                let scale = 0.9 * limit * limit * compliance / self.size(force);
                let power = rest.powf(2.0 / 3.0);
                scale * (1.0 - rest * power - 5.0 / 6.0 * t * (1.0 + power))
            }
        }
    }

    /// Half of a block with n cells from the contact to the other faces, or a slice of one cell, and what its forces are parts of.
    pub(crate) fn brick(self, n: usize) -> (String, f64) {
        let planes = Planes { n, k: GRADING };
        match self {
            Roller => {
                let width = 2.0 * planes.beyond(0.0);
                (planes.half(Some(width)), width)
            }
            Ball => (planes.half(None), 0.5),
        }
    }

    fn contact(self, n: usize) -> String {
        match self {
            Roller => format!(
                "obstacle.cylinder = {{ point = [1.0, 0.0, {:?}], direction = [0.0, 1.0, 0.0], radius = {RADIUS:?} }}",
                -RADIUS
            ),
            Ball => {
                let reach = Planes { n, k: GRADING }.beyond(1.5 * SIZE);
                format!(
                    "box = [[{:?}, 0.0, 0.0], [{:?}, {reach:?}, 0.0]]\n\
                     obstacle.sphere = {{ centre = [1.0, 0.0, {:?}], radius = {RADIUS:?} }}",
                    1.0 - reach,
                    1.0 + reach,
                    -RADIUS
                )
            }
        }
    }

    pub(crate) fn scene(self, n: usize, multipliers: &str) -> String {
        // Symmetry for the ball, plane strain for the roller.
        let (moving, along) = match self {
            Roller => (["x_min", "x_max", "z_max"].as_slice(), "'x', 'z'"),
            Ball => (
                ["x_min", "x_max", "y_max", "z_max"].as_slice(),
                "'x', 'y', 'z'",
            ),
        };
        let rollers = match self {
            Roller => ["y_min", "y_max"].as_slice(),
            Ball => ["y_min"].as_slice(),
        };
        let rollers = rollers
            .iter()
            .map(|face| format!("[[clamp]]\nface = '{face}'\ncomponents = ['y']\n"));
        let walls = self.walls(0.0);
        let clamps = moving.iter().map(|face| {
            format!(
                "[[clamp]]\nname = '{face}'\nface = '{face}'\ncomponents = [{along}]\nvalue = {walls}\n"
            )
        });
        let steps = TO_AND_FRO.map(|t| {
            let walls = self.walls(t);
            let values = moving
                .iter()
                .map(|face| format!("value.{face} = {walls}\n"));
            format!("[[step]]\n{}", values.collect::<String>())
        });
        format!(
            "title = 'pulled'\nassemble.factor = 'double'\n[body]\nelement = 'P2'\n[body.brick]\n{}\
             [material.isotropic]\nyoung_modulus = {:?}\npoisson_ratio = {:?}\n{}{}\
             [contact]\nface = 'z_min'\nmultipliers = '{multipliers}'\n{}\n\
             [friction]\ncoefficient.constant = {FRICTION:?}\n[[step]]\n{}",
            self.brick(n).0,
            HALF_SPACE.young,
            HALF_SPACE.poisson,
            rollers.collect::<String>(),
            clamps.collect::<String>(),
            self.contact(n),
            steps.concat()
        )
    }
}
