//! Checks of the rigid obstacle.

use super::{holds, positive, require};
use crate::scene::{Height, Invalid, Obstacle, POSITION, Quantity, Scene, Written};

/// Checks the obstacle of the contact face under a key.
pub(super) fn check(obstacle: &Obstacle, scene: &Scene, face: &str) -> Result<(), Invalid> {
    let key = |name: &str| format!("{face}.obstacle.{}.{name}", obstacle.word());
    let length = scene.units.length();
    let point = |name: &str, at: &[f64; 3]| {
        require(
            at.iter().all(|x| x.is_finite()),
            key(name),
            &format!("three finite numbers [{length}]"),
            Written(at),
            "give the coordinates x, y, z of a point",
        )
    };
    let direction = |name: &str, along: &[f64; 3]| {
        require(
            along.iter().all(|c| c.is_finite()) && along.iter().any(|c| *c != 0.0),
            key(name),
            "a non-zero vector of three finite numbers",
            Written(along),
            "only its direction counts, for example [0.0, 0.0, 1.0]",
        )
    };
    let radius = |radius: f64| {
        require(
            positive(radius),
            key("radius"),
            &format!("a number > 0 [{length}]"),
            radius,
            "side = \"inside\" makes the hollow of a sphere or cylinder the obstacle",
        )
    };
    match obstacle {
        Obstacle::HalfSpace(half) => {
            point("point", &half.point)?;
            direction("normal", &half.normal)
        }
        Obstacle::Sphere(sphere) => {
            point("centre", &sphere.centre)?;
            radius(sphere.radius)
        }
        Obstacle::Cylinder(cylinder) => {
            point("point", &cylinder.point)?;
            direction("direction", &cylinder.direction)?;
            radius(cylinder.radius)
        }
        Obstacle::Height(height) => check_height(height, &key("value"), length),
    }
}

/// A height is a function of the two coordinates across its direction.
fn check_height(height: &Height, key: &str, length: &str) -> Result<(), Invalid> {
    let own = POSITION[height.direction.axis().0];
    let uses_own = match &height.value {
        Quantity::Varying(formula) => formula.uses(own),
        Quantity::Constant(_) | Quantity::Function(_) => false,
    };
    require(
        holds(&height.value, f64::is_finite) && !uses_own,
        key,
        &format!("a finite number [{length}] or an expression without {own}"),
        Written(&height.value),
        &format!("the height is {own} itself as a function of the two other coordinates"),
    )
}
