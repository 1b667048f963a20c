//! A sweep file: a scene and the axes along which its keys change.

use std::{
    io::{Error, ErrorKind},
    path::{Path, PathBuf},
};

use contact3d::scene::{InvalidValue, LONGEST_SCENE, Source, escape_control, read_bounded};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{StageError, SweepError};
use crate::format::get_key;

/// A sweep file: a scene and the axes along which its keys change.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// The scene that all cases change, relative to the sweep file.
    pub scene: PathBuf,
    /// Keys of the scene with the values they have in all cases.
    #[serde(default)]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Whether a case starts from the multipliers of its predecessor on the last axis.
    #[serde(default)]
    pub warm_start: bool,
    /// The axes; the cases are their product, the last axis changes fastest.
    #[serde(rename = "axis", default)]
    pub axes: Vec<SweepAxis>,
}

/// Values of one key, or of several keys together.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepAxis {
    /// The key of the scene, such as `friction.coefficient_1.constant` or `traction.0.value`.
    pub key: Option<String>,
    /// Its values.
    #[schemars(with = "Option<Vec<serde_json::Value>>")]
    pub values: Option<Vec<toml::Value>>,
    /// Its values as a range of numbers; whole numbers where the key has such.
    pub range: Option<Range>,
    /// Several keys that change together, in place of `key`.
    pub keys: Option<Vec<String>>,
    /// For each step of the axis the values of all `keys`.
    #[schemars(with = "Option<Vec<Vec<serde_json::Value>>>")]
    pub rows: Option<Vec<Vec<toml::Value>>>,
    /// Axes with the same name here advance together.
    pub zip: Option<String>,
}

/// The values that all keys of an axis take, step by step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Steps {
    pub(super) keys: Vec<String>,
    pub(super) rows: Vec<Vec<toml::Value>>,
}

/// Refuses a scene in the place of a sweep file.
fn no_sweep(scene: &Path) -> InvalidValue {
    let name = scene.file_name().unwrap_or_default().to_string_lossy();
    InvalidValue {
        key: escape_control(&scene.display().to_string()),
        expected: "a sweep file".into(),
        found: "a scene".into(),
        help: format!(
            "write a file with scene = {name:?} and axes, as `contact3d-pipe help sweep` shows"
        ),
    }
}

impl SweepFile {
    /// Reads a sweep file.
    pub fn read(path: &Path) -> Result<Self, StageError> {
        let text = read_index(path, "read the sweep")?;
        if let Ok(table) = text.parse::<toml::Table>()
            && table.contains_key("body")
            && !table.contains_key("scene")
        {
            return Err(StageError::Setting(no_sweep(path)));
        }
        let name = path.display().to_string();
        let (sweep, _) = Source::read(&name, &text, "sweep")?;
        Ok(sweep)
    }

    /// The JSON Schema of sweep files, for editors.
    #[must_use]
    pub fn json_schema() -> String {
        let schema = schemars::schema_for!(Self);
        serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
    }

    /// The axes with those of the same `zip` merged, in the order of their first members; `scene` is
    /// the scene that they change.
    ///
    /// Their number is checked before anything is made of them.
    pub(super) fn steps(&self, file: &Path, scene: &toml::Table) -> Result<Vec<Steps>, StageError> {
        let refuse_at = |place: String, expected: &str, found: String| {
            StageError::from(SweepError::Axis {
                file: file.to_owned(),
                place,
                expected: expected.to_owned(),
                found,
            })
        };
        let few = format!("at most {MOST_CASES} cases in a sweep");
        let mut merged: Vec<(Option<&str>, Steps)> = Vec::new();
        for (index, axis) in self.axes.iter().enumerate() {
            let refuse =
                |expected: &str, found| refuse_at(format!("axis {index}"), expected, found);
            if axis.length() > MOST_CASES {
                return Err(refuse(&few, axis.length().to_string()));
            }
            let steps = axis
                .steps(scene)
                .map_err(|(expected, found)| refuse(expected, found))?;
            let partner = merged
                .iter_mut()
                .find(|(zip, _)| zip.is_some() && *zip == axis.zip.as_deref());
            let Some((_, partner)) = partner else {
                merged.push((axis.zip.as_deref(), steps));
                continue;
            };
            if partner.rows.len() != steps.rows.len() {
                let found = format!("{} and {}", partner.rows.len(), steps.rows.len());
                return Err(refuse("as many values as the other axes of its zip", found));
            }
            partner.keys.extend(steps.keys);
            for (row, more) in partner.rows.iter_mut().zip(steps.rows) {
                row.extend(more);
            }
        }
        let steps: Vec<Steps> = merged.into_iter().map(|(_, steps)| steps).collect();
        let mut lengths = steps.iter().map(|steps| steps.rows.len());
        let product = lengths.try_fold(1_usize, usize::checked_mul);
        if product.is_some_and(|cases| cases <= MOST_CASES) {
            return Ok(steps);
        }
        let lengths: Vec<String> = steps.iter().map(|it| it.rows.len().to_string()).collect();
        let found = format!("{} of them", lengths.join(" x "));
        Err(refuse_at("the axes together".into(), &few, found))
    }
}

impl SweepAxis {
    /// How many steps the axis asks for.
    fn length(&self) -> usize {
        let values = self.values.as_ref().map(Vec::len);
        let rows = self.rows.as_ref().map(Vec::len);
        let range = self.range.map(|range| range.count);
        values.or(range).or(rows).unwrap_or_default()
    }

    /// The steps, or what was expected and what was found.
    fn steps(&self, scene: &toml::Table) -> Result<Steps, (&'static str, String)> {
        let steps = match (&self.key, &self.values, self.range, &self.keys, &self.rows) {
            (Some(key), Some(values), None, None, None) => Steps {
                keys: vec![key.clone()],
                rows: values.iter().map(|value| vec![value.clone()]).collect(),
            },
            (Some(key), None, Some(range), None, None) => Steps {
                keys: vec![key.clone()],
                rows: match get_key(scene, key) {
                    Some(toml::Value::Integer(_)) => range.whole_rows(key)?,
                    _ => range.rows()?,
                },
            },
            (None, None, None, Some(keys), Some(rows)) => {
                if let Some(row) = rows.iter().find(|row| row.len() != keys.len()) {
                    let found = format!("{} keys and a row of {}", keys.len(), row.len());
                    return Err(("one value for each key in every row", found));
                }
                Steps {
                    keys: keys.clone(),
                    rows: rows.clone(),
                }
            }
            _ => {
                return Err((
                    "key with values, key with range, or keys with rows",
                    "another combination".into(),
                ));
            }
        };
        if steps.rows.is_empty() || steps.keys.is_empty() {
            return Err(("at least one value", "none".into()));
        }
        Ok(steps)
    }
}

/// Numbers from one end to the other, both included.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// First number.
    pub from: f64,
    /// Last number.
    pub to: f64,
    /// How many.
    pub count: usize,
    /// How they are spaced.
    #[serde(default)]
    pub scale: Spacing,
}

/// Spacing of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Scale")]
pub enum Spacing {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal ratios.
    Log,
}

impl Range {
    /// The values of a key that has whole numbers.
    fn whole_rows(&self, key: &str) -> Result<Vec<Vec<toml::Value>>, (&'static str, String)> {
        let mut rows = self.rows()?;
        for value in rows.iter_mut().flatten() {
            let number = value.as_float().unwrap_or(f64::NAN);
            let whole = number.round();
            // Relative rounding of a logarithmic range.
            // Whole numbers up to this one, 2⁵³, are doubles.
            if (number - whole).abs() > 1e-9 * whole.abs() || whole.abs() > 9_007_199_254_740_992.0
            {
                let expected =
                    "ends and a count that make whole numbers, or `values` in place of `range`";
                return Err((expected, format!("{key} = {number}")));
            }
            *value = toml::Value::Integer(whole as i64);
        }
        Ok(rows)
    }

    fn rows(&self) -> Result<Vec<Vec<toml::Value>>, (&'static str, String)> {
        let Self {
            from,
            to,
            count,
            scale,
        } = *self;
        let positive = from > 0.0 && to > 0.0;
        if !(from.is_finite() && to.is_finite()) || (scale == Spacing::Log && !positive) {
            let expected = "finite ends, both positive for scale = \"log\"";
            return Err((expected, format!("from {from} to {to}")));
        }
        if count == 0 || (count == 1 && from != to) {
            return Err(("a count of at least 2", count.to_string()));
        }
        let at = |index: usize| {
            if index == 0 {
                return from;
            }
            if index + 1 == count {
                return to;
            }
            let share = index as f64 / (count - 1) as f64;
            let ratio = (to / from).ln();
            let (value, size) = match scale {
                Spacing::Linear => (from + share * (to - from), from.abs().max(to.abs())),
                Spacing::Log => {
                    let value = from * (share * ratio).exp();
                    (value, value * (1.0 + ratio.abs()))
                }
            };
            // Rounding of these lines.
            shortest_decimal(value, 4.0 * f64::EPSILON * size)
        };
        Ok((0..count)
            .map(|index| vec![toml::Value::Float(at(index))])
            .collect())
    }
}

/// The number with the fewest digits that differs from `value` by `rounding` at most: 0.3 for 0.30000000000000004.
fn shortest_decimal(value: f64, rounding: f64) -> f64 {
    if value.abs() <= rounding {
        return 0.0;
    }
    let mut shorter = (0..17).filter_map(|digits| format!("{value:.digits$e}").parse().ok());
    let found = shorter.find(|shorter: &f64| (shorter - value).abs() <= rounding);
    found.unwrap_or(value)
}

/// Most cases of one sweep: each is a file of the folder, and a plan holds the scene of each, some
/// kilobytes.
pub const MOST_CASES: usize = 100_000;

/// The text of a file that lists scenes, a sweep or a suite, which may come through a pipe and be
/// as long as a scene.
///
/// # Errors
/// `Io` for what cannot be read, is longer or no UTF-8 text.
pub fn read_index(path: &Path, action: &'static str) -> Result<String, StageError> {
    let text = read_bounded(path, LONGEST_SCENE).and_then(|bytes| {
        if bytes.len() as u64 > LONGEST_SCENE {
            let found = format!("expected at most {LONGEST_SCENE} bytes, found more");
            return Err(Error::new(ErrorKind::InvalidData, found));
        }
        String::from_utf8(bytes).map_err(|error| {
            let byte = error.utf8_error().valid_up_to();
            let found = format!("expected UTF-8 text, found something else at byte {byte}");
            Error::new(ErrorKind::InvalidData, found)
        })
    });
    text.map_err(|source| StageError::Io {
        action,
        file: path.to_owned(),
        source,
    })
}
