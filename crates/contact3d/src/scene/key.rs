//! The table of keys: what each measures, which part of the problem it belongs to, its limits and its sentence.
//!
//! All of it stands beside the fields of the scene, in their documentation and in `schemars(extend(…))`, and is read from the
//! JSON Schema:
//!
//! | word | what it says |
//! |---|---|
//! | `measures` | a [`Measure`]; a number without unit where it is missing |
//! | `part` | a [`ProblemPart`]; that of the table around it where it is missing |
//! | `minimum`, `exclusiveMinimum`, `maximum`, `exclusiveMaximum` | limits of all numbers of the key |
//! | `examples` | how to write a table that is one kind of several |

use std::{collections::BTreeMap, sync::LazyLock};

use serde::{Deserialize, Serialize};
use serde_json::Value as Schema;
use toml::{Table, Value};
use units::{Dimension, Unit, Units};

use super::{
    InvalidValue, Scene, SolveSettings,
    file::to_toml,
    schema::{SchemaTree, kind},
    source::whole_limit,
};

/// What the numbers of a key measure. Linear elasticity scales with displacements and stresses apart from the size of the body, so
/// lengths of the two kinds are told apart.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Numbers without unit, and texts.
    #[default]
    Number,
    /// Times in s.
    Time,
    /// Coordinates and sizes in m.
    Length,
    /// Displacements, gaps and slips in m.
    Displacement,
    /// Derivatives by slips, in 1/m.
    PerDisplacement,
    /// Stresses in Pa.
    Stress,
    /// Stresses per strain in Pa.
    Modulus,
    /// Forces per volume in N/m³.
    ForceDensity,
    /// Forces in N.
    Force,
    /// Moments in N·m.
    Moment,
    /// Stresses per displacement in Pa/m.
    SpringStiffness,
    /// Small rotations in radians.
    Angle,
}

impl Measure {
    /// Exponents of (length, displacement, stress).
    fn exponents(self) -> [i8; 3] {
        match self {
            Self::Number | Self::Time => [0, 0, 0],
            Self::Length => [1, 0, 0],
            Self::Displacement => [0, 1, 0],
            Self::PerDisplacement => [0, -1, 0],
            Self::Stress => [0, 0, 1],
            Self::Modulus => [1, -1, 1],
            Self::ForceDensity => [-1, 0, 1],
            Self::Force => [2, 0, 1],
            Self::Moment => [3, 0, 1],
            Self::SpringStiffness => [0, -1, 1],
            Self::Angle => [-1, 1, 0],
        }
    }

    /// The dimension, which names the unit.
    #[must_use]
    pub fn dimension(self) -> Dimension {
        match (self, self.exponents()) {
            (Self::Time, _) => Dimension::Time,
            (_, [0, 0, 0]) | (Self::Angle, _) => Dimension::Number,
            (_, [length, displacement, stress]) => Dimension::Product {
                force: stress,
                length: length + displacement - 2 * stress,
            },
        }
    }

    /// The factor of its numbers where lengths, displacements and stresses have these factors.
    #[must_use]
    pub fn factor(self, factors: [f64; 3]) -> f64 {
        let powers = factors.into_iter().zip(self.exponents());
        powers
            .map(|(factor, exponent)| factor.powi(exponent.into()))
            .product()
    }
}

/// What of the discrete problem a key is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProblemPart {
    /// The mesh with the normals and distances of its obstacles.
    Mesh,
    /// A with its springs, and T with the axes of friction.
    Operator,
    /// What loads, moves and opens.
    Loads,
    /// The law of friction.
    Law,
    /// How the problem is solved.
    Solve,
}

/// A key of the scene.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Key {
    /// What its numbers measure.
    #[serde(rename = "measures")]
    pub measure: Measure,
    /// What it is part of; `None` for names, units, and what decides on the mesh.
    pub part: Option<ProblemPart>,
    /// What it is, in a sentence.
    #[serde(rename = "description")]
    pub sentence: String,
    /// The words that it may be; empty for other than words.
    #[serde(skip)]
    pub words: Vec<String>,
    /// Kinds of values: `number`, `integer`, `string`, `boolean`, `object`.
    #[serde(skip)]
    pub(super) kinds: Vec<String>,
    /// How many values it has, where it has a list of a given length.
    #[serde(skip)]
    length: Option<u64>,
    /// Limits of its numbers.
    minimum: Option<f64>,
    exclusive_minimum: Option<f64>,
    maximum: Option<f64>,
    exclusive_maximum: Option<f64>,
}

impl Key {
    /// What its values may be.
    fn expected(&self, name: &str, units: Units) -> String {
        let is = |kind: &str| self.kinds.iter().any(|known| known == kind);
        let noun = if self.is_whole() {
            "whole number"
        } else {
            "number"
        };
        let unit = match units.of(self.measure.dimension()) {
            unit if unit.is_none() => String::new(),
            unit => format!(" [{}]", unit.word()),
        };
        let numbers = |adjective: &str| match self.length {
            Some(3) => format!("three {adjective}{noun}s{unit}"),
            Some(_) => format!("{adjective}{noun}s{unit}"),
            None => format!("a {adjective}{noun}{unit}"),
        };
        let words = match (self.minimum, self.exclusive_minimum) {
            (Some(least), _) => match self.maximum {
                Some(most) => numbers("") + &format!(" from {least} to {most}"),
                None if self.is_whole() => numbers("") + &format!(", at least {least}"),
                None if least > 0.0 => {
                    numbers("finite positive ") + &format!(", {least:e} at least")
                }
                None => numbers("finite ") + &format!(" >= {least}"),
            },
            (None, Some(least)) => match self.exclusive_maximum {
                Some(most) => numbers("") + &format!(" with {least} < {name} < {most}"),
                None => numbers("finite positive "),
            },
            (None, None) => numbers("finite "),
        };
        match (is("string"), self.length) {
            (false, _) => words,
            (true, None) => words + " or an expression in x, y, z",
            (true, Some(_)) => words + " or expressions in x, y, z",
        }
    }

    /// Whether a number is within the limits.
    fn holds(&self, value: f64) -> bool {
        value.is_finite()
            && self.minimum.is_none_or(|least| value >= least)
            && self.exclusive_minimum.is_none_or(|least| value > least)
            && self.maximum.is_none_or(|most| value <= most)
            && self.exclusive_maximum.is_none_or(|most| value < most)
    }

    /// Whether its values are whole numbers.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.kinds.iter().any(|kind| kind == "integer")
    }

    fn is_numeric(&self) -> bool {
        self.is_whole() || self.kinds.iter().any(|kind| kind == "number")
    }
}

/// Every key by its path without the numbers of items of lists; of tables whose keys have any name the table alone.
#[must_use]
pub fn keys() -> &'static BTreeMap<String, Key> {
    static KEYS: LazyLock<BTreeMap<String, Key>> = LazyLock::new(|| {
        let schema = SchemaTree::of::<Scene>();
        let mut keys = BTreeMap::new();
        add_keys(&schema, &schema.0, "", None, &mut keys);
        keys
    });
    &KEYS
}

/// What is known of a key such as `pressure.0.value`, or of the one that it is an item of; `None` for a key of no scene.
#[must_use]
pub fn key(path: &str) -> Option<&'static Key> {
    let names = path
        .split('.')
        .filter(|name| name.parse::<usize>().is_err());
    let mut known = names.collect::<Vec<_>>().join(".");
    loop {
        if let Some(key) = keys().get(&known) {
            return Some(key);
        }
        known.truncate(known.rfind('.')?);
    }
}

/// The unit of the numbers of a key; none for a key of no scene.
#[must_use]
pub fn unit_of_key(path: &str, units: Units) -> Unit {
    let measure = key(path).map(|key| key.measure);
    units.of(measure.unwrap_or_default().dimension())
}

/// Adds the keys of a table, and of the tables below it.
fn add_keys(
    schema: &SchemaTree,
    table: &Schema,
    path: &str,
    part: Option<ProblemPart>,
    keys: &mut BTreeMap<String, Key>,
) {
    for option in schema.alternatives(table) {
        let kinds = option["oneOf"].as_array().into_iter().flatten();
        // What stands beside one kind of several is said of its only key.
        let kinds = kinds.filter(|kind| kind["properties"].is_object());
        for (beside, properties) in kinds
            .map(|kind| (kind, &kind["properties"]))
            .chain([(&Schema::Null, &option["properties"])])
        {
            for (name, own) in properties.as_object().into_iter().flatten() {
                let path = format!("{path}.{name}");
                let path = path.trim_start_matches('.');
                let key = Key::new(schema, [own, beside], part);
                let part = key.part;
                keys.insert(path.to_owned(), key);
                add_keys(schema, own, path, part, keys);
            }
        }
        if option["items"].is_object() {
            add_keys(schema, &option["items"], path, part, keys);
        }
    }
}

impl Key {
    /// A key by its schema, and by what stands beside that where it says nothing, in a table that is part of something.
    fn new(schema: &SchemaTree, [own, beside]: [&Schema; 2], part: Option<ProblemPart>) -> Self {
        let words = [beside, own].into_iter().filter_map(Schema::as_object);
        let words = words
            .flatten()
            .map(|(word, value)| (word.clone(), value.clone()));
        let mut key =
            Self::deserialize(Schema::Object(words.collect())).expect("words of the table of keys");
        key.part = key.part.or(part);
        let first = key.sentence.split("\n\n").next().unwrap_or_default();
        key.sentence = first.replace('\n', " ");
        key.add_kinds(schema, own);
        key
    }

    fn add_kinds(&mut self, schema: &SchemaTree, of: &Schema) {
        for option in schema.alternatives(of) {
            let words = option["oneOf"].as_array().into_iter().flatten();
            let words = words.filter_map(|word| word["const"].as_str().map(str::to_owned));
            self.words.extend(words);
            match kind(option) {
                "array" => {
                    self.length = self.length.or(option["minItems"].as_u64());
                    self.add_kinds(schema, &option["items"]);
                }
                "object" if option["additionalProperties"].is_object() => {
                    self.add_kinds(schema, &option["additionalProperties"]);
                }
                kind => self.kinds.push(kind.to_owned()),
            }
        }
    }
}

/// Calls `visit` for every key of a table that has a value, with its path; keys for which it returns `false` are taken out, and so are
/// tables and lists of them that become empty.
pub(super) fn retain_keys(
    table: &mut Table,
    path: &str,
    visit: &mut impl FnMut(&str, &mut Value) -> bool,
) {
    table.retain(|name, value| {
        let path = format!("{path}.{name}");
        retain_value(value, path.trim_start_matches('.'), visit)
    });
}

fn retain_value(
    value: &mut Value,
    path: &str,
    visit: &mut impl FnMut(&str, &mut Value) -> bool,
) -> bool {
    match value {
        Value::Table(table) if !table.is_empty() => {
            retain_keys(table, path, visit);
            !table.is_empty()
        }
        Value::Array(items) if items.iter().any(Value::is_table) => {
            // Items stay in their places while any has something.
            let items = items.iter_mut().enumerate();
            items.fold(false, |any, (i, item)| {
                retain_value(item, &format!("{path}.{i}"), visit) || any
            })
        }
        value => visit(path, value),
    }
}

/// Calls `visit` for every number of a value.
pub(super) fn for_each_number(value: &mut Value, visit: &mut impl FnMut(&mut f64)) {
    match value {
        Value::Array(items) => items
            .iter_mut()
            .for_each(|item| for_each_number(item, visit)),
        Value::Float(number) => visit(number),
        Value::Integer(whole) => visit(&mut (*whole as f64)),
        _ => {}
    }
}

impl Scene {
    /// All keys of the scene with their values.
    fn table(&self) -> Result<Table, InvalidValue> {
        Table::try_from(self).map_err(unwritable)
    }

    /// The keys of some parts of the problem with their values, the parameters that their formulas use, and the units.
    ///
    /// # Panics
    /// For whole numbers beyond those of TOML, which no validated scene has.
    #[must_use]
    pub fn part(&self, wanted: &[ProblemPart]) -> Table {
        let is_wanted = |part: Option<ProblemPart>| part.is_some_and(|it| wanted.contains(&it));
        let mut table = self.table().expect("a validated scene");
        retain_keys(&mut table, "", &mut |path, _| {
            path.starts_with("units.") || is_wanted(key(path).and_then(|key| key.part))
        });
        let parameters = self.parameters_used(is_wanted);
        if !parameters.is_empty() {
            let parameters = parameters
                .into_iter()
                .map(|(name, value)| (name, value.into()));
            table.insert("parameters".to_owned(), Value::Table(parameters.collect()));
        }
        table
    }

    /// The faces that the scene names, each after its key.
    pub(crate) fn named_faces(&self) -> Vec<(String, String)> {
        let mut faces = Vec::new();
        let mut table = self.table().unwrap_or_default();
        retain_keys(&mut table, "", &mut |path, value| {
            // Faces of bodies, not that of the mesh of an obstacle.
            let is_face = [".face", ".between", ".panes_on"]
                .iter()
                .any(|end| path.ends_with(end) && !path.ends_with("surface.face"));
            let names = value.as_array().into_iter().flatten().chain([&*value]);
            let names = names.filter(|_| is_face).filter_map(Value::as_str);
            faces.extend(names.map(|name| (path.to_owned(), name.to_owned())));
            true
        });
        faces
    }

    /// Refuses a number beyond the limits of its key.
    pub(super) fn check_limits(&self) -> Result<(), InvalidValue> {
        check_limits(self.table()?, self.units)
    }
}

/// A scene with a number that TOML cannot hold.
pub(super) fn unwritable(error: toml::ser::Error) -> InvalidValue {
    InvalidValue {
        key: "scene".to_owned(),
        expected: whole_limit(),
        found: error.to_string(),
        help: "give smaller numbers".to_owned(),
    }
}

impl SolveSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// The first offending key.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        let settings = Value::try_from(self).expect("numbers and words");
        check_limits(
            Table::from_iter([("solve".to_owned(), settings)]),
            Units::SI,
        )
    }
}

fn check_limits(mut table: Table, units: Units) -> Result<(), InvalidValue> {
    let mut beyond = None;
    retain_keys(&mut table, "", &mut |path, value| {
        let Some(key) = key(path).filter(|key| beyond.is_none() && key.is_numeric()) else {
            return true;
        };
        let mut hold = true;
        for_each_number(value, &mut |number| hold &= key.holds(*number));
        if !hold {
            let name = path.rsplit('.').find(|name| name.parse::<usize>().is_err());
            beyond = Some(InvalidValue {
                key: path.to_owned(),
                expected: key.expected(name.unwrap_or(path), units),
                found: to_toml(value),
                help: key.sentence.clone(),
            });
        }
        true
    });
    beyond.map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::scene::varying::Varying;

    /// Keys that no stage depends on: names, words for units, what formulas use, and what decides on the mesh.
    const OF_NO_PART: [&str; 7] = [
        "adapt.error",
        "adapt.start",
        "parameters",
        "reference",
        "title",
        "units.force",
        "units.length",
    ];

    fn is_leaf(path: &str) -> bool {
        let below = format!("{path}.");
        !keys().keys().any(|other| other.starts_with(&below))
    }

    #[test]
    fn every_key_is_part_of_something() {
        let leaves = keys().iter().filter(|(path, _)| is_leaf(path));
        let of_none = leaves.filter(|(_, key)| key.part.is_none());
        assert_eq!(
            of_none.map(|(path, _)| path).collect::<Vec<_>>(),
            OF_NO_PART
        );
    }

    /// A sentence says in which unit its numbers are, and which sign they have.
    #[test]
    fn sentences_tell_units_and_signs() {
        let units = ["m", "1/m", "Pa", "N/m³", "Pa/m", "s", "N", "N·m"];
        for (path, key) in keys() {
            let expected = match key.measure {
                Measure::Number | Measure::Angle => None,
                Measure::Time => Some("s"),
                Measure::Length | Measure::Displacement => Some("m"),
                Measure::PerDisplacement => Some("1/m"),
                Measure::Stress | Measure::Modulus => Some("Pa"),
                Measure::ForceDensity => Some("N/m³"),
                Measure::Force => Some("N"),
                Measure::Moment => Some("N·m"),
                Measure::SpringStiffness => Some("Pa/m"),
            };
            let words: Vec<&str> = key
                .sentence
                .split(' ')
                .map(|word| word.trim_matches([',', '.', ':', ';']))
                .collect();
            let told = words
                .windows(2)
                .find(|pair| pair[0] == "in" && units.contains(&pair[1]));
            let is_formula = path.ends_with(".expression");
            assert!(
                told.map(|pair| pair[1]) == expected || is_formula,
                "{path}: {}",
                key.sentence
            );
            let is_positive = key.exclusive_minimum == Some(0.0) && key.exclusive_maximum.is_none();
            assert!(
                !is_positive || key.sentence.contains("> 0"),
                "{path}: {}",
                key.sentence
            );
        }
    }

    #[test]
    fn keys_have_units_and_limits() {
        let unit = |path: &str| unit_of_key(path, Units::SI).word().to_owned();
        for (path, expected) in [
            ("pressure.0.value", "Pa"),
            ("material.isotropic.young_modulus", "Pa"),
            ("contact.0.friction.slip_bound", "Pa"),
            ("friction.pressure_cap", "Pa"),
            ("contact.gap", "m"),
            ("body.brick.size.0", "m"),
            ("region.1.part.box", "m"),
            ("friction.coefficient_1.table.slip.1", "m"),
            ("friction.coefficient.ramp.rate", "1/m"),
            ("body_force.value.2", "N/m^3"),
            ("force.0.value.2", "N"),
            ("force.0.moment.2", "N m"),
            ("spring.0.normal", "N/m^3"),
            ("step.2.time", "s"),
            ("friction.coefficient.constant", "1"),
            ("no.such.key", "1"),
        ] {
            assert_eq!(unit(path), expected, "{path}");
        }
        for (path, expected) in [
            ("solve.epsilon", "a number with 0 < epsilon < 1"),
            ("solve.max_outer_steps", "a whole number, at least 1"),
            ("body.brick.size", "three finite positive numbers [m]"),
            (
                "friction.slip_bound",
                "a finite number [Pa] >= 0 or an expression in x, y, z",
            ),
            ("parameters.mu", "a finite number"),
            (
                "clamp.0.value",
                "three finite numbers [m] or expressions in x, y, z",
            ),
        ] {
            let name = path.rsplit('.').next().unwrap_or_default();
            assert_eq!(
                key(path).unwrap().expected(name, Units::SI),
                expected,
                "{path}"
            );
        }
    }

    /// A scene with every value that may vary; no body has all of it.
    const EVERYTHING: &str = r#"
        title = "everything"
        body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
        material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }
        body_force.value = [0, 0, 1]
        friction.slip_bound = 1
        friction.coefficient.constant = 0.3
        friction.coefficient_1.expression = "s1"
        friction.coefficient_2.ramp = { initial = 1, residual = 1, onset = 1, rate = 1 }
        [[clamp]]
        value = [1, 0, 0]
        [[spring]]
        face = "x_min"
        normal = 1
        tangential = 1
        tensor = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        [[traction]]
        face = "x_min"
        value = [1, 0, 0]
        [[pressure]]
        face = "x_min"
        value = 1
        [[force]]
        face = "x_min"
        value = [1, 0, 0]
        moment = [1, 0, 0]
        [[tool]]
        face = "x_min"
        displacement = [1, 0, 0]
        turn = [1, 0, 0]
        force = [1, 0, 0]
        moment = [1, 0, 0]
        [[contact]]
        face = "x_min"
        gap = 1
        axis_1 = [1, 0, 0]
        angle = 1
        obstacle.height.value = 1
        friction.slip_bound = 1
        friction.coefficient.table = { slip = [0], value = [1] }
        friction.coefficient_1.grid = { slip_1 = [0], slip_2 = [0], value = [[1]] }
        friction.coefficient_2.constant = 0.3
        [[contact]]
        face = "x_max"
        [[step]]
        value.body_force = [0, 0, 2]
    "#;

    /// Every key that may be a formula is walked over, and no other.
    #[test]
    fn every_key_that_varies_is_known() {
        let mut scene: Scene = toml::from_str(EVERYTHING).expect("a scene");
        let mut visited = BTreeSet::new();
        for (at, value) in scene.varying_mut() {
            let path = match value {
                Varying::Quantity(_) => at.path.as_str(),
                Varying::Coefficient(_) => at.path.rsplit_once('.').unwrap().0,
            };
            let known = key(path).expect("a key");
            let place = keys().iter().find(|(_, key)| std::ptr::eq(*key, known));
            visited.insert(place.expect("a key").0.as_str());
        }
        let varies = |(path, key): &(&String, &Key)| {
            let has = |kind: &str| key.kinds.iter().any(|known| known == kind);
            let name = path.rsplit('.').next().unwrap_or_default();
            has("number") && has("string") || name.starts_with("coefficient")
        };
        let expected: BTreeSet<&str> = keys()
            .iter()
            .filter(varies)
            .map(|(p, _)| p.as_str())
            .collect();
        assert_eq!(visited, expected);
    }
}
