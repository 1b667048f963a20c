//! Numbers and formulas of place.

use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::{Expression, PlaceFunction};

/// The variables of a quantity that varies in space: coordinates in m.
pub const POSITION: &[&str] = &["x", "y", "z"];

/// A number, or an expression in the coordinates x, y, z.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// The same value everywhere.
    Constant(f64),
    /// A formula in x, y, z.
    Varying(Expression),
    /// A Rust function of (x, y, z), in scenes built in Rust.
    Function(PlaceFunction),
}

impl Quantity {
    /// The value at a point; not finite outside the formula's domain.
    #[must_use]
    pub fn at(&self, point: [f64; 3]) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Varying(expression) => expression.evaluate(&point),
            Self::Function(function) => function.at(point),
        }
    }

    /// The derivatives by x, y, z: exact for formulas, differences over 2 `step` in m for Rust functions.
    #[must_use]
    pub(crate) fn gradient(&self, point: [f64; 3], step: f64) -> [f64; 3] {
        match self {
            Self::Constant(_) => [0.0; 3],
            Self::Varying(expression) => expression.derivatives(&point, [0, 1, 2]),
            Self::Function(function) => std::array::from_fn(|c| {
                let at = |by: f64| {
                    let mut place = point;
                    place[c] += by;
                    function.at(place)
                };
                (at(step) - at(-step)) / (2.0 * step)
            }),
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
            Self::Function(function) => {
                let function = function.clone();
                Self::function(move |x| factor * function.at(x))
            }
        }
    }

    /// Whether it may differ from place to place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Varying(formula) => POSITION.iter().any(|name| formula.uses(name)),
            Self::Function(_) => true,
        }
    }

    /// The value, if it is the same everywhere.
    #[must_use]
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Varying(_) | Self::Function(_) => None,
        }
    }
}

impl Default for Quantity {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(value) => serializer.serialize_f64(*value),
            Self::Varying(expression) => serializer.serialize_str(&expression.text()),
            Self::Function(function) => function.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Quantity;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or an expression in x, y, z as a string")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Quantity, E> {
                Ok(Quantity::Constant(value))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Quantity, E> {
                Ok(Quantity::Constant(value as f64))
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Quantity, E> {
                Ok(Quantity::Constant(value as f64))
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Quantity, E> {
                Expression::unbound(text, POSITION)
                    .map(Quantity::Varying)
                    .map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for Quantity {
    fn schema_name() -> Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or an expression in the coordinates x, y, z and the scene's parameters.",
            "anyOf": [{ "type": "number" }, { "type": "string" }]
        })
    }
}
