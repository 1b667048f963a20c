//! Springs on faces.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Quantity;

/// Springs between a face and points that do not move: σν = −K u with a stiffness K per area. Either `tensor` or at least
/// one of `normal` and `tangential` is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// The face on springs.
    pub face: String,
    /// Stiffness along the normal in Pa/m: a number, or an expression in x, y, z; none when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<Quantity>,
    /// Stiffness along the face, the same in all its directions, in Pa/m: a number, or an expression in x, y, z; none when
    /// not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<Quantity>,
    /// Symmetric positive semidefinite stiffness over the axes x, y, z in Pa/m: rows of numbers, or expressions in x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tensor: Option<[[Quantity; 3]; 3]>,
}

/// The stiffness per area of a spring.
#[derive(Debug, Clone, Copy)]
pub enum SpringStiffness<'a> {
    /// Along the normal and along the face; `None` for none.
    OfFace([Option<&'a Quantity>; 2]),
    /// Over the axes x, y, z.
    Tensor(&'a [[Quantity; 3]; 3]),
}

impl Spring {
    /// A spring that holds a face along its normal, with a stiffness in Pa/m.
    #[must_use]
    pub fn normal(face: impl Into<String>, stiffness: impl Into<Quantity>) -> Self {
        Self {
            normal: Some(stiffness.into()),
            ..Self::without_stiffness(face)
        }
    }

    /// A spring with a stiffness over the axes x, y, z in Pa/m.
    #[must_use]
    pub fn tensor(face: impl Into<String>, stiffness: [[impl Into<Quantity>; 3]; 3]) -> Self {
        Self {
            tensor: Some(stiffness.map(|row| row.map(Into::into))),
            ..Self::without_stiffness(face)
        }
    }

    /// The same with a stiffness along the face in Pa/m.
    #[must_use]
    pub fn with_tangential(mut self, stiffness: impl Into<Quantity>) -> Self {
        self.tangential = Some(stiffness.into());
        self
    }

    fn without_stiffness(face: impl Into<String>) -> Self {
        Self {
            face: face.into(),
            normal: None,
            tangential: None,
            tensor: None,
        }
    }

    /// Its stiffness.
    #[must_use]
    pub fn stiffness(&self) -> SpringStiffness<'_> {
        match &self.tensor {
            Some(tensor) => SpringStiffness::Tensor(tensor),
            None => SpringStiffness::OfFace([self.normal.as_ref(), self.tangential.as_ref()]),
        }
    }

    /// All that may vary.
    pub(crate) fn quantities_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut Quantity)> {
        let normal = self.normal.iter_mut().map(|value| ("normal", value));
        let tangential = self
            .tangential
            .iter_mut()
            .map(|value| ("tangential", value));
        let tensor = self.tensor.iter_mut().flatten().flatten();
        normal
            .chain(tangential)
            .chain(tensor.map(|value| ("tensor", value)))
    }
}
