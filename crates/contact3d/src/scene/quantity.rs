//! Numbers and formulas of place.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use super::{Expression, schema::FORMULA};

/// The variables of a quantity that varies in space: coordinates in m.
pub const POSITION: &[&str] = &["x", "y", "z"];

/// A number, or an expression in the coordinates x, y, z.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The same value everywhere.
    Constant(f64),
    /// A formula in x, y, z.
    #[serde(deserialize_with = "formula_of_place")]
    Varying(Expression),
}

impl Quantity {
    /// The value at a point; not finite outside the formula's domain.
    #[must_use]
    pub fn at(&self, point: [f64; 3]) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Varying(expression) => expression.evaluate(&point),
        }
    }

    /// The derivatives by x, y, z.
    #[must_use]
    pub(crate) fn gradient(&self, point: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Constant(_) => [0.0; 3],
            Self::Varying(expression) => expression.derivatives(&point, [0, 1, 2]),
        }
    }

    /// The quantity times a number.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        match self {
            _ if factor == 1.0 => self.clone(),
            Self::Constant(value) => Self::Constant(factor * value),
            _ if factor == 0.0 => Self::Constant(0.0),
            Self::Varying(formula) => Self::Varying(formula.times(factor)),
        }
    }

    /// Whether it may differ from place to place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Varying(formula) => POSITION.iter().any(|name| formula.uses(name)),
        }
    }

    /// The value, if it is the same everywhere.
    #[must_use]
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Varying(_) => None,
        }
    }
}

impl Default for Quantity {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

fn formula_of_place<'de, D: Deserializer<'de>>(text: D) -> Result<Expression, D::Error> {
    Expression::unbound(&String::deserialize(text)?, POSITION).map_err(D::Error::custom)
}

impl JsonSchema for Quantity {
    fn schema_name() -> Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or an expression in the coordinates x, y, z and the scene's parameters.",
            "anyOf": [{ "type": "number" }, { "type": "string", "format": FORMULA }]
        })
    }
}
