//! Bodies pressed against a rigid roller or ball and then pulled along it (C. Cattaneo 1938, R. Mindlin 1949; K. L. Johnson,
//! *Contact Mechanics*, Cambridge 1985, §7.2, §7.4): stick zone, stresses, and the energy that a cycle takes.
//!
//! The theory is that of half-spaces on which pressures do not act along the face, and so of ν = 1/2 and of contacts much smaller than
//! the radius of the obstacle. The faces of the block move as a half-space does.

use std::f64::consts::PI;

use super::{
    pulled::{Loaded, Pulled},
    rounded::{
        FRICTION, HALF_SPACE,
        Shape::{self, Ball, Roller},
        TO_AND_FRO,
    },
};

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
    // Panes are 0.23 c wide there, and the edge of the stick zone is known to half of one.
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
#[ignore = "the figures of docs/validation/benchmarks.md"]
fn figures_for_the_page() {
    for n in [10, 20, 30, 40, 60] {
        println!("roller {n} {:.5?}", Errors::measure(Roller, n, "panes"));
    }
    for n in [8, 10, 12, 16] {
        println!("ball {n} {:.5?}", Errors::measure(Ball, n, "panes"));
    }
}
