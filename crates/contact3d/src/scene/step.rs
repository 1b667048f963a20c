//! Steps of a load history.

use std::{collections::BTreeMap, fmt};

use schemars::JsonSchema;
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, IntoDeserializer, SeqAccess, Visitor, value::SeqAccessDeserializer},
};

use super::{
    Measure, Quantity,
    varying::{Found, Varies, VaryingKey, varies},
};

/// Most increments of a history, over all steps.
pub const MOST_INCREMENTS: usize = 100_000;

/// One step of a load history: what loads, gap and prescribed displacements are when it ends. What a step does
/// not name stays as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// What the step does, for tables and pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The time at its end in s, greater than that of the step before; 1, 2, … where no step has one. Nothing
    /// depends on it but tables, charts and films.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Time))]
    pub time: Option<f64>,
    /// Equal parts of the step, each solved by itself, between which loads change linearly.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1))]
    pub increments: usize,
    /// How many times their values loads, gap and prescribed displacements have, by name or by key.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub factor: BTreeMap<String, f64>,
    /// Other values of theirs, by name or by key; a factor of the same step scales them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub value: BTreeMap<String, StepValue>,
}

/// A value that a step gives, as the key that it replaces has it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum StepValue {
    /// A pressure or a gap.
    Number(Quantity),
    /// A traction, a body force or a prescribed displacement.
    Vector([Quantity; 3]),
}

impl<'de> Deserialize<'de> for StepValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumberOrVector)
    }
}

struct NumberOrVector;

impl<'de> Visitor<'de> for NumberOrVector {
    type Value = StepValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, an expression in x, y, z as a string, or a list of three of them")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<StepValue, E> {
        self.visit_f64(value as f64)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<StepValue, E> {
        Ok(StepValue::Number(Quantity::Constant(value)))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<StepValue, E> {
        Quantity::deserialize(text.into_deserializer()).map(StepValue::Number)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<StepValue, A::Error> {
        let components = <[Quantity; 3]>::deserialize(SeqAccessDeserializer::new(entries));
        components.map(StepValue::Vector)
    }
}

varies!(Step: value);

impl Varies for StepValue {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Found<'s>) {
        self.components_mut()
            .iter_mut()
            .for_each(|it| it.add_varying(at, found));
    }
}

impl StepValue {
    /// Its components, one or three.
    pub(super) fn components(&self) -> &[Quantity] {
        match self {
            Self::Number(value) => std::slice::from_ref(value),
            Self::Vector(value) => value,
        }
    }

    pub(super) fn components_mut(&mut self) -> &mut [Quantity] {
        match self {
            Self::Number(value) => std::slice::from_mut(value),
            Self::Vector(value) => value,
        }
    }
}

impl Default for Step {
    fn default() -> Self {
        Self {
            title: None,
            time: None,
            increments: 1,
            factor: BTreeMap::new(),
            value: BTreeMap::new(),
        }
    }
}

impl Step {
    /// A step that changes nothing yet.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: Some(title.into()),
            ..Self::default()
        }
    }

    /// The step with a factor of what a name or a key stands for.
    #[must_use]
    pub fn with_factor(mut self, key: impl Into<String>, factor: f64) -> Self {
        self.factor.insert(key.into(), factor);
        self
    }

    /// The step in equal parts.
    #[must_use]
    pub fn in_increments(self, increments: usize) -> Self {
        Self { increments, ..self }
    }
}

fn is_one(increments: &usize) -> bool {
    *increments == 1
}
