//! Bodies pressed against a rigid roller or ball and then pulled along it (C. Cattaneo 1938, R. Mindlin 1949; K. L. Johnson,
//! *Contact Mechanics*, Cambridge 1985, §7.2, §7.4): stick zone, stresses, and the energy that a cycle takes.
//!
//! The theory is that of half-spaces on which pressures do not act along the face, and so of ν = 1/2 and of contacts much smaller than
//! the radius of the obstacle. The faces of the block move as a half-space does.

use std::f64::consts::PI;

use crate::{
    half_space::HalfSpace,
    planes::Planes,
    pulled::{Loaded, Pulled},
};

const HALF_SPACE: HalfSpace = HalfSpace {
    young: 1.0,
    poisson: 0.499,
    middle: 1.0,
};
const FRICTION: f64 = 0.5;
const RADIUS: f64 = 100.0;

/// b of the roller, a of the ball: an eighth of the way to the other faces.
const SIZE: f64 = 0.125;

/// Shrinks the cells: n of them to the other faces leave n/2 to the edge of the contact.
const GRADING: f64 = 4.0;

/// Q/(μP) of the steps after the first: there, back, and there again.
const TO_AND_FRO: [f64; 3] = [0.75, -0.75, 0.75];

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Roller,
    Ball,
}
use Shape::{Ball, Roller};

impl Shape {
    /// The force P that makes a contact of this size, a length for the roller.
    fn force(self) -> f64 {
        match self {
            Roller => PI * HALF_SPACE.modulus() * SIZE * SIZE / (4.0 * RADIUS),
            Ball => 4.0 * HALF_SPACE.modulus() * SIZE.powi(3) / (3.0 * RADIUS),
        }
    }

    fn size(self, force: f64) -> f64 {
        match self {
            Roller => (4.0 * force * RADIUS / (PI * HALF_SPACE.modulus())).sqrt(),
            Ball => (3.0 * force * RADIUS / (4.0 * HALF_SPACE.modulus())).cbrt(),
        }
    }

    fn peak(self, force: f64) -> f64 {
        let size = self.size(force);
        match self {
            Roller => 2.0 * force / (PI * size),
            Ball => 3.0 * force / (2.0 * PI * size * size),
        }
    }

    /// c over b or a, for t = Q/(μP).
    fn stick(self, t: f64) -> f64 {
        match self {
            Roller => (1.0 - t.abs()).sqrt(),
            Ball => (1.0 - t.abs()).cbrt(),
        }
    }

    /// The second moment of stresses √(1 − r²/a²) over their sum, over a².
    fn moment(self) -> f64 {
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
    fn cycle(self, force: f64, t: f64) -> f64 {
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
    fn brick(self, n: usize) -> (String, f64) {
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

    fn scene(self, n: usize, multipliers: &str) -> String {
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

/// Errors after the first pull and of the cycle that follows.
#[derive(Debug)]
struct Errors {
    /// P for its approach, Q/(μP) for the tangential motion, b or a for P.
    force: f64,
    ratio: f64,
    size: f64,
    /// c for P and Q: from the second moment of μp − q, and from the area of the panes that stick.
    stick: f64,
    stuck_area: f64,
    /// Mean of |q| less its closed form over that of |q|; the largest over μp₀.
    stress: [f64; 2],
    /// Energy of a cycle.
    cycle: f64,
}

impl Errors {
    fn measure(shape: Shape, n: usize, multipliers: &str) -> Self {
        let pulled = Pulled::new(&shape.scene(n, multipliers));
        let (panes, share) = (pulled.panes(1), shape.brick(n).1);
        let sum = |of: &dyn Fn(&Loaded) -> f64| -> f64 {
            panes.iter().map(|pane| pane.area * of(pane)).sum::<f64>() / share
        };
        let square = |pane: &Loaded| match shape {
            Roller => pane.along,
            Ball => pane.around,
        };
        let force = sum(&|pane| pane.pressure);
        let t = sum(&|pane| pane.shear) / (FRICTION * force);
        let (size, stick) = (shape.size(force), shape.stick(t) * shape.size(force));
        let radius = |whole: f64, moment: f64| (moment / whole / shape.moment()).sqrt();
        let pressed = sum(&|pane| pane.pressure * square(pane));
        let rest = |pane: &Loaded| FRICTION * pane.pressure - pane.shear.abs();
        let rests = [sum(&rest), sum(&|pane| rest(pane) * square(pane))];
        let stuck = sum(&|pane| f64::from(pane.sticks));
        let from_area = match shape {
            Roller => stuck / 2.0,
            Ball => (stuck / PI).sqrt(),
        };
        let peak = FRICTION * shape.peak(force);
        let dome = |r2: f64, size: f64| (1.0 - r2 / (size * size)).max(0.0).sqrt();
        let off = |pane: &Loaded| {
            let r2 = match shape {
                Roller => pane.x * pane.x,
                Ball => pane.around,
            };
            let expected = peak * (dome(r2, size) - stick / size * dome(r2, stick));
            (pane.shear.abs() - expected).abs()
        };
        let taken = (pulled.dissipation(2) + pulled.dissipation(3)) / share;
        let largest = panes.iter().map(off).fold(0.0, f64::max);
        Self {
            force: force / shape.force() - 1.0,
            ratio: t / TO_AND_FRO[0] - 1.0,
            size: radius(force, pressed) / size - 1.0,
            stick: radius(rests[0], rests[1]) / stick - 1.0,
            stuck_area: from_area / stick - 1.0,
            stress: [sum(&off) / sum(&|pane| pane.shear.abs()), largest / peak],
            cycle: taken / shape.cycle(force, t.abs()) - 1.0,
        }
    }
}

#[test]
fn a_roller_sticks_and_slips_as_cattaneo_and_mindlin_say() {
    let errors = Errors::measure(Roller, 20, "panes");
    // Ten cells to the edge of the contact: c is 1.0 % off, and falls with order 1.8.
    assert!(errors.stick.abs() < 0.02, "{errors:?}");
    // One pane of the edge of the stick zone, of 0.13 c.
    assert!(errors.stuck_area.abs() < 0.13, "{errors:?}");
    // The forces to less than the 0.4 % that faces 8b away owe to lines of force in place of the contact.
    let forces = [errors.force, errors.ratio, errors.size];
    assert!(forces.iter().all(|e| e.abs() < 5e-3), "{errors:?}");
    // q falls to μp with an infinite slope at c: 6 % in the mean at this n, of order 1.6, and 9 % in the pane at the edge.
    assert!(
        errors.stress[0] < 0.08 && errors.stress[1] < 0.12,
        "{errors:?}"
    );
    // 0.8 %; the size of the slip zone is found to a fraction of a pane only.
    assert!(errors.cycle.abs() < 0.02, "{errors:?}");
}

#[test]
fn a_ball_sticks_as_mindlin_says() {
    let errors = Errors::measure(Ball, 8, "panes");
    // Four cells to the edge of the contact: 2.3 %.
    assert!(errors.stick.abs() < 0.05, "{errors:?}");
    // P for the approach is 2.4 % off, Q/(μP) for the tangential motion 0.5 %; both are below 1 % at n = 12.
    assert!(
        errors.force.abs() < 0.03 && errors.ratio.abs() < 0.01,
        "{errors:?}"
    );
}

#[test]
#[ignore = "a fine mesh"]
fn a_ball_on_a_fine_mesh_takes_the_energy_of_mindlin_and_deresiewicz() {
    let errors = Errors::measure(Ball, 12, "panes");
    // Slips across the force, which the theory leaves out, are part of the difference.
    assert!(
        errors.stick.abs() < 0.02 && errors.cycle.abs() < 0.03,
        "{errors:?}"
    );
    let forces = [errors.force, errors.ratio, errors.size];
    assert!(forces.iter().all(|e| e.abs() < 0.01), "{errors:?}");
}

/// The energy of a cycle is what friction takes where it slips: 4 ∫ μp s dx over both sides, where s is the slip of the first way,
/// with ds/dx = 2μp₀ √(x² − c²)/(E* b).
#[test]
fn the_energy_of_a_cycle_is_that_of_its_slip() {
    const N: usize = 100_000;
    let force = Roller.force();
    let (size, peak) = (Roller.size(force), Roller.peak(force));
    for t in [0.3, 0.75, 0.99] {
        let stick = Roller.stick(t) * size;
        let step = (size - stick) / N as f64;
        let (mut slip, mut energy) = (0.0, 0.0);
        for i in 0..N {
            let x = stick + (i as f64 + 0.5) * step;
            let slope = 2.0 * FRICTION * peak / (HALF_SPACE.modulus() * size)
                * (x * x - stick * stick).sqrt();
            slip += 0.5 * slope * step;
            energy += 8.0 * FRICTION * peak * (1.0 - x * x / (size * size)).sqrt() * slip * step;
            slip += 0.5 * slope * step;
        }
        // Midpoints beside a root: N^(−3/2).
        assert!((energy / Roller.cycle(force, t) - 1.0).abs() < 1e-6);
    }
}

#[test]
#[ignore = "the figures of docs/histories.md"]
fn figures_for_the_page() {
    for n in [10, 20, 30, 40, 60] {
        println!("roller {n} {:.5?}", Errors::measure(Roller, n, "panes"));
    }
    for n in [8, 10, 12, 16] {
        println!("ball {n} {:.5?}", Errors::measure(Ball, n, "panes"));
    }
}
