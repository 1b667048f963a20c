use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::{Expression, ExpressionError, LawPoint, SlipDerivative};

/// The variables of a [`Formula`]: coordinates and slips in m. `s` is |u_t|, for isotropic laws;
/// `s1`, `s2` are |u_t1|, |u_t2|.
pub const LAW_VARIABLES: &[&str] = &["x", "y", "z", "s", "s1", "s2"];

/// An expression in [`LAW_VARIABLES`] with its derivatives by the slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Formula {
    value: Expression,
    /// By s, s1 and s2.
    derivatives: [Option<Expression>; 3],
}

impl Formula {
    /// Parses and differentiates.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula in [`LAW_VARIABLES`].
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let value = Expression::parse(text, LAW_VARIABLES)?;
        let [own, first, second] = ["s", "s1", "s2"].map(|name| value.derivative(name));
        Ok(Self {
            derivatives: [own?, first?, second?],
            value,
        })
    }

    pub(super) fn evaluate(&self, at: &LawPoint) -> f64 {
        self.value.evaluate(&arguments(at))
    }

    pub(super) fn derivative(&self, at: &LawPoint) -> SlipDerivative {
        let arguments = arguments(at);
        let derivatives = self.derivatives.each_ref();
        let [own, first, second] =
            derivatives.map(|d| d.as_ref().map_or(0.0, |d| d.evaluate(&arguments)));
        SlipDerivative {
            own,
            pair: [first, second],
        }
    }

    pub(super) fn depends_on_slip(&self) -> bool {
        self.derivatives.iter().any(Option::is_some)
    }

    /// The formula as written.
    #[must_use]
    pub fn expression(&self) -> &Expression {
        &self.value
    }
}

impl TryFrom<String> for Formula {
    type Error = ExpressionError;

    fn try_from(text: String) -> Result<Self, ExpressionError> {
        Self::parse(&text)
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
            "description": "An expression in x, y, z and the slips s1 = |u_t1|, s2 = |u_t2| (s = |u_t| for an isotropic law), all in m.",
            "type": "string"
        })
    }
}

/// The values of [`LAW_VARIABLES`].
fn arguments(at: &LawPoint) -> [f64; 6] {
    let [x, y, z] = at.position;
    [x, y, z, at.own_slip, at.slip[0], at.slip[1]]
}
