//! Formulas of place and slip, for laws of friction.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::{
    Expression, ExpressionError, LawPoint, SlipDerivative,
    expression::{Branch, OnBranch},
};

/// The variables of a [`Formula`]: coordinates and slips in m. `s` is |u_t|, for isotropic laws;
/// `s1`, `s2` are |u_t1|, |u_t2|.
pub const LAW_VARIABLES: &[&str] = &["x", "y", "z", "s", "s1", "s2"];

/// An expression in [`LAW_VARIABLES`], with derivatives by the slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Formula {
    value: Expression,
}

/// The places of s, s1 and s2 in [`LAW_VARIABLES`].
const SLIPS: [usize; 3] = [3, 4, 5];

impl Formula {
    /// Parses a formula without parameters.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula in [`LAW_VARIABLES`].
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let value = Expression::parse(text, LAW_VARIABLES)?;
        Ok(Self { value })
    }

    /// Another formula with the parameters of this one.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub(crate) fn rewritten(&self, text: &str) -> Result<Self, ExpressionError> {
        let value = self.value.rewritten(text)?;
        Ok(Self { value })
    }

    pub(super) fn evaluate(&self, at: &LawPoint) -> f64 {
        self.value.evaluate(&arguments(at))
    }

    pub(super) fn derivative(&self, at: &LawPoint) -> SlipDerivative {
        let [own, first, second] = self.value.derivatives(&arguments(at), SLIPS);
        SlipDerivative {
            own,
            pair: [first, second],
        }
    }

    /// The branch that the formula takes at a point.
    pub(crate) fn branch(&self, at: &LawPoint) -> Branch {
        self.value.branch(&arguments(at), SLIPS)
    }

    /// The formula on a branch; slopes are by the own slip, by |u_t1| and by |u_t2|.
    pub(crate) fn on_branch(&self, at: &LawPoint, branch: Branch) -> OnBranch {
        self.value.on_branch(&arguments(at), SLIPS, branch)
    }

    pub(super) fn depends_on_slip(&self) -> bool {
        SLIPS.iter().any(|&k| self.value.uses(LAW_VARIABLES[k]))
    }

    /// The formula as written.
    #[must_use]
    pub fn expression(&self) -> &Expression {
        &self.value
    }

    pub(super) fn expression_mut(&mut self) -> &mut Expression {
        &mut self.value
    }
}

impl TryFrom<String> for Formula {
    type Error = ExpressionError;

    fn try_from(text: String) -> Result<Self, ExpressionError> {
        let value = Expression::unbound(&text, LAW_VARIABLES)?;
        Ok(Self { value })
    }
}

impl From<Formula> for String {
    fn from(formula: Formula) -> Self {
        formula.value.text().to_owned()
    }
}

impl JsonSchema for Formula {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An expression in x, y, z, the slips s1 = |u_t1|, s2 = |u_t2| (s = |u_t| for an isotropic law), all in m, and the scene's parameters.",
            "type": "string"
        })
    }
}

/// The values of [`LAW_VARIABLES`].
fn arguments(at: &LawPoint) -> [f64; 6] {
    let [x, y, z] = at.position;
    [x, y, z, at.own_slip, at.slip[0], at.slip[1]]
}
