//! Checks of how a problem is solved, and of how accurate its mesh has to be.

use super::{functional, positive, require};
use crate::scene::{Invalid, SMALLEST_ERROR, Scene, SolveSettings, Written};

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    if let Some(adapt) = scene.adapt {
        if let Some(of) = adapt.of {
            functional::check(scene, of)?;
        }
        require(
            (SMALLEST_ERROR..=1.0).contains(&adapt.error),
            "adapt.error",
            "a share between 1e-8 and 1 of the energy norm, or of the quantity `adapt.of`",
            adapt.error,
            "write 0.03, or --error 3%, for three percent; below 1e-8 rounding hides the error, above 1 any answer would do",
        )?;
    }
    scene.solve.validate("solve")
}

impl SolveSettings {
    /// Checks the settings; `prefix` is put before the key's name in a message.
    ///
    /// # Errors
    /// The first offending key.
    pub fn validate(&self, prefix: &str) -> Result<(), Invalid> {
        let unit_interval = |value: f64| value > 0.0 && value < 1.0;
        let checks = [
            (
                "epsilon",
                unit_interval(self.epsilon()),
                "0 < epsilon < 1",
                self.epsilon(),
            ),
            (
                "r_tol",
                unit_interval(self.r_tol),
                "0 < r_tol < 1",
                self.r_tol,
            ),
            (
                "c_fact",
                unit_interval(self.c_fact),
                "0 < c_fact < 1",
                self.c_fact,
            ),
            ("gamma", positive(self.gamma), "gamma > 0", self.gamma),
        ];
        for (key, ok, expected, found) in checks {
            require(
                ok,
                format!("{prefix}.{key}"),
                expected,
                Written(&found),
                "the paper uses epsilon = 1e-4, r_tol = 0.1, c_fact = 0.99, gamma = 1",
            )?;
        }
        let counts = [
            ("max_outer_steps", self.max_outer_steps),
            ("max_inner_actions", self.max_inner_actions),
        ];
        for (key, count) in counts {
            require(
                count > 0,
                format!("{prefix}.{key}"),
                "at least 1",
                count,
                "leave the key out for the default",
            )?;
        }
        Ok(())
    }
}
