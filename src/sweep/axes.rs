//! A sweep file: a scene and the axes along which its keys change.

use std::path::{Path, PathBuf};

use contact3d::scene::{Invalid, parse_toml, shown};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{StageError, index_file::read as read_index, range::Range, size};
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

/// Refuses a scene in the place of a sweep file, and names the file beside it that is a sweep of it.
fn no_sweep(scene: &Path) -> Invalid {
    let name = scene.file_name().unwrap_or_default();
    let is_sweep = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).ok();
        let table = text.and_then(|text| text.parse::<toml::Table>().ok());
        let of = table.and_then(|table| Some(PathBuf::from(table.get("scene")?.as_str()?)));
        of.is_some_and(|of| of.file_name() == Some(name))
    };
    let folder = scene
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let files = std::fs::read_dir(folder.unwrap_or(Path::new(".")))
        .into_iter()
        .flatten();
    let files = files.filter_map(|file| Some(file.ok()?.path()));
    let mut sweeps: Vec<PathBuf> = files
        .filter(|path| path.extension().is_some_and(|end| end == "toml") && is_sweep(path))
        .collect();
    sweeps.sort();
    Invalid {
        key: shown(&scene.display().to_string()),
        expected: "a sweep file".into(),
        found: "a scene".into(),
        help: match sweeps.first() {
            Some(sweep) => format!("did you mean {}?", shown(&sweep.display().to_string())),
            None => format!(
                "write a file with scene = {:?} and axes, as docs/reference/sweep.md shows",
                name.to_string_lossy()
            ),
        },
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
        Ok(parse_toml(
            &path.display().to_string(),
            &text,
            "docs/reference/sweep.md",
        )?)
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
        size::check(&self.axes, file)?;
        let mut merged: Vec<(Option<&str>, Steps)> = Vec::new();
        for (index, axis) in self.axes.iter().enumerate() {
            let refuse = |expected: &str, found: String| StageError::Axis {
                file: file.to_owned(),
                place: format!("axis {index}"),
                expected: expected.to_owned(),
                found,
            };
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
        Ok(merged.into_iter().map(|(_, steps)| steps).collect())
    }
}

impl SweepAxis {
    /// How many steps the axis asks for.
    pub(super) fn length(&self) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(text: &str) -> Result<Vec<Steps>, StageError> {
        let file: SweepFile = toml::from_str(&format!("scene = \"s.toml\"\n{text}")).unwrap();
        let scene = "n = 1\nm = [1, 2]\nx = 1.0".parse().unwrap();
        file.steps(Path::new("sweep.toml"), &scene)
    }

    fn values(range: &str, key: &str) -> Vec<String> {
        let axes = steps(&format!("[[axis]]\nkey = \"{key}\"\nrange = {range}")).unwrap();
        axes[0].rows.iter().map(|row| row[0].to_string()).collect()
    }

    #[test]
    fn ranges_of_whole_numbers_are_whole_where_the_key_is() {
        let linear = "{ from = 4, to = 12, count = 3 }";
        assert_eq!(values(linear, "n"), ["4", "8", "12"]);
        assert_eq!(values(linear, "m.1"), ["4", "8", "12"]);
        assert_eq!(values(linear, "x"), ["4.0", "8.0", "12.0"]);
        let logarithmic = "{ from = 3, to = 3000, count = 4, scale = \"log\" }";
        assert_eq!(values(logarithmic, "n"), ["3", "30", "300", "3000"]);
        for range in [
            "{ from = 4, to = 12, count = 4 }",
            "{ from = 0.5, to = 1.5, count = 2 }",
            "{ from = 1, to = 1e300, count = 2 }",
        ] {
            let error = steps(&format!("[[axis]]\nkey = \"n\"\nrange = {range}")).unwrap_err();
            assert!(
                error
                    .to_string()
                    .contains("axis 0: expected ends and a count"),
                "{error}"
            );
        }
    }

    #[test]
    fn ranges_end_exactly_and_keep_their_ratios() {
        let axes = steps(
            "[[axis]]\nkey = \"f\"\nrange = { from = 0.05, to = 1.6, count = 6, scale = \"log\" }",
        )
        .unwrap();
        let values: Vec<f64> = axes[0]
            .rows
            .iter()
            .map(|r| r[0].as_float().unwrap())
            .collect();
        assert_eq!((values[0], values[5]), (0.05, 1.6));
        for pair in values.windows(2) {
            // Ratio 2, one exponential and one logarithm: a few roundings.
            assert!((pair[1] / pair[0] - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn zipped_axes_become_one() {
        let axes = steps(
            "[[axis]]\nkey = \"a\"\nvalues = [1, 2]\nzip = \"z\"\n\
             [[axis]]\nkey = \"b\"\nvalues = [7]\n\
             [[axis]]\nkeys = [\"c\", \"d\"]\nrows = [[3, 4], [5, 6]]\nzip = \"z\"",
        )
        .unwrap();
        assert_eq!(axes.len(), 2);
        assert_eq!(axes[0].keys, ["a", "c", "d"]);
        let numbers: Vec<i64> = axes[0].rows[1]
            .iter()
            .map(|v| v.as_integer().unwrap())
            .collect();
        assert_eq!(numbers, [2, 5, 6]);
    }

    #[test]
    fn axes_that_make_no_sense_are_refused() {
        for text in [
            "[[axis]]\nkey = \"a\"",
            "[[axis]]\nkey = \"a\"\nvalues = []",
            "[[axis]]\nkey = \"a\"\nvalues = [1]\nrange = { from = 1, to = 2, count = 2 }",
            "[[axis]]\nkey = \"a\"\nrange = { from = 0.0, to = 2, count = 2, scale = \"log\" }",
            "[[axis]]\nkey = \"a\"\nrange = { from = 1, to = 2, count = 1 }",
            "[[axis]]\nkeys = [\"a\", \"b\"]\nrows = [[1]]",
            "[[axis]]\nkey = \"a\"\nvalues = [1, 2]\nzip = \"z\"\n[[axis]]\nkey = \"b\"\nvalues = [1]\nzip = \"z\"",
        ] {
            assert!(steps(text).is_err(), "{text}");
        }
    }
}
