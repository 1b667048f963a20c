//! Checks of how a problem is solved, and of how accurate its mesh has to be.

use super::{positive, require};
use crate::scene::{
    ElementOrder, Functional, InvalidValue, SMALLEST_ERROR, Scene, SolveSettings, Written,
};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    if let Some(adapt) = scene.adapt {
        if let Some(of) = adapt.of {
            check_quantity(scene, of)?;
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
    pub fn validate(&self, prefix: &str) -> Result<(), InvalidValue> {
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

/// Refuses a quantity that no answer of the scene has.
fn check_quantity(scene: &Scene, of: Functional) -> Result<(), InvalidValue> {
    let has_volume = of.corners().is_none_or(|[low, high]| {
        let may_be_flat = matches!(of, Functional::MeanPressure { .. });
        let numbers = low.iter().chain(&high).all(|x| x.is_finite());
        numbers && (0..3).all(|c| low[c] < high[c] || may_be_flat && low[c] == high[c])
    });
    let refusal = match of {
        Functional::NormalForce
        | Functional::LargestPressure
        | Functional::ContactArea
        | Functional::MeanPressure { .. }
            if scene.contacts.is_empty() =>
        {
            Some((
                "a quantity of a scene without contact",
                "without a contact face there are the strain energy and displacements",
            ))
        }
        Functional::TangentialForce | Functional::StickArea if !scene.has_friction() => Some((
            "a quantity of a scene without friction",
            "without friction tangential forces are zero and no pane sticks",
        )),
        Functional::TangentialForce if scene.contacts.len() > 1 => Some((
            "a quantity of a scene with several contact faces",
            "tangential forces of several faces, each in axes of its own, have no sum",
        )),
        Functional::NormalForce
        | Functional::TangentialForce
        | Functional::LargestPressure
        | Functional::MeanPressure { .. }
            if scene.body.element == ElementOrder::P1 =>
        {
            Some((
                "a quantity whose error linear tetrahedra show",
                "local errors of linear elements do not reach the contact face: set body.element = \"P2\", with a mesh file of quadratic \
                 tetrahedra (gmsh -order 2), or refine for displacements, the strain energy or areas",
            ))
        }
        Functional::Dissipation => Some((
            "a quantity of one increment or of a static problem",
            "friction takes energy over a load history, whose error gathers over all increments: its adjoint runs backwards \
             through them, which is not available; refine for the energy norm or a force, and compare two targets",
        )),
        _ if !has_volume => Some((
            "a box with the smaller coordinates first and a volume",
            "write box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], for example",
        )),
        _ => None,
    };
    let (expected, help) = refusal.unwrap_or_default();
    require(refusal.is_none(), "adapt.of", expected, of.word(), help)
}
