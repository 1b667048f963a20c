//! Small scenes put together from their parts.

use super::support::Case;

/// The body of most scenes: 12 × 4 × 4 cells of steel, 24 panes, held at x = 0.
pub(crate) const BODY: &str = "
title = 'test'
[body.brick]
size = [3.0, 1.0, 1.0]
cells = [12, 4, 4]
[[clamp]]
face = 'x_min'
";

pub(crate) const STEEL: &str = "
[material.isotropic]
young_modulus = 21.19e10
poisson_ratio = 0.277
";

/// The published loads, with a part along y so that nothing is symmetric.
pub(crate) const LOAD: &str = "
[[traction]]
face = 'x_max'
value = [1e7, 4e6, 2e7]
[[traction]]
face = 'z_max'
value = [0.0, 0.0, -3e7]
";

pub(crate) const CONTACT: &str = "
[contact]
face = 'z_min'
";

/// The published law.
pub(crate) const RAMPS: &str = "
[friction]
coefficient_1.ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 3000.0 }
coefficient_2.ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 1000.0 }
";

/// Steel under the usual loads, with these further tables.
pub(crate) fn steel(tables: &[&str]) -> Case {
    Case::of(&[&[BODY, STEEL, LOAD], tables].concat().concat())
}

/// Steel in contact with a law of friction; `contact` holds further keys of [contact].
pub(crate) fn in_contact(contact: &str, friction: &str) -> Case {
    steel(&[CONTACT, contact, "\n[friction]\n", friction])
}

/// ‖x − y‖ / ‖y‖.
pub(crate) fn distance(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len());
    let difference: f64 = x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum();
    (difference / y.iter().map(|b| b * b).sum::<f64>()).sqrt()
}
