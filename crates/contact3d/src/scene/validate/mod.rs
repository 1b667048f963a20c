//! What the model allows (HKL §2, §4); every refusal names the key.

mod body;
mod contact;
mod supports;
mod tools;

use std::fmt;

use super::{InvalidValue, Scene, Written};

/// Refuses `found` at `key` unless `ok`.
pub(super) fn require(
    ok: bool,
    key: impl Into<String>,
    expected: &str,
    found: impl fmt::Display,
    help: &str,
) -> Result<(), InvalidValue> {
    if ok {
        return Ok(());
    }
    Err(InvalidValue {
        key: key.into(),
        expected: expected.to_owned(),
        found: found.to_string(),
        help: help.to_owned(),
    })
}

/// Refuses corners of a box of nodes or triangles that are not in order; a box may be flat.
fn check_box(scene: &Scene, key: String, corners: &[[f64; 3]; 2]) -> Result<(), InvalidValue> {
    let [low, high] = corners;
    require(
        (0..3).all(|c| low[c] <= high[c]),
        key,
        &format!(
            "two corners [min, max], min at most max in x, y and z [{}]",
            scene.units.length()
        ),
        Written(corners),
        "give the lower corner first",
    )
}

impl Scene {
    /// Checks every value of the scene against what the model allows. What needs the mesh (names of
    /// Gmsh groups, flatness, values of formulas) is checked when the mesh is made.
    ///
    /// # Errors
    /// The first offending key.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        self.check_limits()?;
        body::check(self)?;
        supports::check(self)?;
        contact::check(self)?;
        tools::check(self)?;
        if let Some(of) = self.adapt.and_then(|adapt| adapt.of) {
            of.check(self)?;
        }
        supports::check_history(self)
    }
}
