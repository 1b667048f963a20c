//! The table of a sweep: one column for each setting and each figure of its datasets.

use std::collections::BTreeMap;

use contact3d::scene::{Functional, escape_control};
use runfile::{DatasetSpec, Extent, Kind, Reader, StoreError};
use serde_json::Value;
use units::{Unit, Units};

use crate::format::{CASES, SWEEP_LAYOUT, dimension_of_quantity};

/// Datasets that are no figures of the cases: the keys of the settings, and the faces that cases with several have.
const KEYS: &str = "/cases/keys";
const SETTINGS: &str = "/cases/settings";
const FACE_NAMES: &str = "/cases/face_names";
/// Names of the quantities that cases have error bars of.
const QUANTITY_NAMES: &str = "/cases/quantity_names";

/// What one case has in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A word or a message.
    Text(String),
    /// A value of a key of the scene; null where it has none.
    Setting(Value),
    /// A count; `None` without a result.
    Count(Option<i64>),
    /// A measure; NaN without a result.
    Number(f64),
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in `summary.csv`.
    pub name: String,
    /// Whether it tells what cases were set to.
    pub is_setting: bool,
    /// The unit of its numbers.
    pub unit: Unit,
    /// One cell for each case.
    pub cells: Vec<Cell>,
}

/// The table of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepTable {
    /// Its columns, those of contact faces and of quantities with error bars last.
    pub columns: Vec<Column>,
    /// Its cases.
    pub n_cases: usize,
    /// The units of all numbers.
    pub units: Units,
}

impl Cell {
    /// The number, where it is one.
    pub fn number(&self) -> Option<f64> {
        let number = match self {
            Self::Text(_) => None,
            Self::Setting(value) => value.as_f64(),
            Self::Count(count) => count.map(|count| count as f64),
            Self::Number(number) => Some(*number),
        };
        number.filter(|number| number.is_finite())
    }

    /// Whether it holds something that is no number.
    pub(crate) fn is_word(&self) -> bool {
        match self {
            Self::Text(_) => true,
            Self::Setting(value) => !value.is_null() && !value.is_number(),
            Self::Count(_) | Self::Number(_) => false,
        }
    }

    /// The text that reads back to the same bits; empty where there is nothing.
    pub fn text(&self) -> String {
        match self {
            Self::Text(text) | Self::Setting(Value::String(text)) => escape_control(text),
            Self::Setting(Value::Null) | Self::Count(None) => String::new(),
            Self::Setting(value) => escape_control(&value.to_string()),
            Self::Count(Some(count)) => count.to_string(),
            Self::Number(number) if number.is_nan() => String::new(),
            Self::Number(number) => format!("{number:?}"),
        }
    }
}

impl Column {
    /// The name with the unit, for people.
    pub fn title(&self) -> String {
        if self.unit.is_none() {
            self.name.clone()
        } else {
            format!("{} [{}]", self.name, self.unit.word())
        }
    }
}

impl SweepTable {
    /// Reads the datasets of `summary.h5`.
    pub fn read(reader: &Reader) -> Result<Self, StoreError> {
        let stored = reader.group_record(CASES)?;
        let settings = reader.read_texts(SETTINGS)?;
        let mut table = Self {
            columns: Vec::new(),
            n_cases: settings.len(),
            units: stored.map_or(Units::SI, |stored| stored.units),
        };
        let named = |path: &'static str| match reader.has(path) {
            true => reader.read_texts(path),
            false => Ok(Vec::new()),
        };
        let (faces, quantities) = (named(FACE_NAMES)?, named(QUANTITY_NAMES)?);
        let n_parts = faces.len() + quantities.len();
        let mut of_parts: Vec<Vec<Column>> = vec![Vec::new(); n_parts];
        for spec in SWEEP_LAYOUT.datasets() {
            let of_cases = spec.shape.first() == Some(&Extent::Named("n_cases"));
            if !of_cases || !reader.has(spec.path) {
                continue;
            }
            match spec.shape[1..] {
                [
                    Extent::Named(part @ ("n_case_faces" | "n_case_quantities")),
                    ref rest @ ..,
                ] => {
                    let is_quantity = part == "n_case_quantities";
                    let (parts, first) = match is_quantity {
                        false => (&faces, 0),
                        true => (&quantities, faces.len()),
                    };
                    let name = spec.name().trim_start_matches("face_");
                    let columns = table.figures(reader, spec, name, rest, parts.len())?;
                    let width = columns.len() / parts.len();
                    for (k, column) in columns.into_iter().enumerate() {
                        let part = k / width;
                        let name = escape_control(&format!("{}_{}", column.name, parts[part]));
                        let mut named = Functional::NAMED.into_iter();
                        let of = named.find(|of| is_quantity && of.word() == parts[part]);
                        let unit = of.map(|of| table.units.of(dimension_of_quantity(of)));
                        let unit = unit.unwrap_or_else(|| column.unit.clone());
                        of_parts[first + part].push(Column {
                            name,
                            unit,
                            ..column
                        });
                    }
                }
                _ if spec.path == SETTINGS => {
                    table.add_settings(&reader.read_texts(KEYS)?, &settings)
                }
                // These are among the settings, as values of their keys.
                [Extent::Named(_)] => {}
                ref rest => {
                    let columns = table.figures(reader, spec, spec.name(), rest, 1)?;
                    table.columns.extend(columns);
                }
            }
        }
        table.columns.extend(of_parts.into_iter().flatten());
        Ok(table)
    }

    /// How each case ended.
    pub fn statuses(&self) -> Vec<String> {
        let mut columns = self.columns.iter();
        let status = columns.find(|column| column.name == "status");
        status.map_or_else(Vec::new, |it| it.cells.iter().map(Cell::text).collect())
    }

    /// How many cases ended how.
    pub fn counts(&self) -> BTreeMap<String, usize> {
        let mut counts = BTreeMap::new();
        for status in self.statuses() {
            *counts.entry(status).or_default() += 1;
        }
        counts
    }

    /// The same in words.
    pub fn counts_in_words(&self) -> String {
        let counts = self.counts().into_iter();
        let counts: Vec<String> = counts.map(|(status, n)| format!("{n} {status}")).collect();
        format!("{} cases: {}", self.n_cases, counts.join(", "))
    }

    /// The columns of one dataset, `repeats` times those of one face or of the whole case.
    fn figures(
        &self,
        reader: &Reader,
        spec: &DatasetSpec,
        name: &str,
        components: &[Extent],
        repeats: usize,
    ) -> Result<Vec<Column>, StoreError> {
        let cells: Vec<Cell> = match spec.kind {
            Kind::Text => reader
                .read_texts(spec.path)?
                .into_iter()
                .map(Cell::Text)
                .collect(),
            Kind::F64 => reader
                .read_vec(spec.path)?
                .into_iter()
                .map(Cell::Number)
                .collect(),
            Kind::U8 => {
                let flags = reader.read_vec::<u8>(spec.path)?.into_iter();
                flags.map(|flag| Cell::Count(Some(flag.into()))).collect()
            }
            _ => {
                let counts = reader.read_vec::<i64>(spec.path)?.into_iter();
                counts
                    .map(|count| Cell::Count(Some(count).filter(|n| *n >= 0)))
                    .collect()
            }
        };
        let names = names(name, components);
        let width = repeats * names.len();
        let column = |k: usize| Column {
            name: names[k % names.len()].clone(),
            is_setting: false,
            unit: self.units.of(spec.dimension),
            cells: cells.iter().skip(k).step_by(width).cloned().collect(),
        };
        Ok((0..width).map(column).collect())
    }

    /// A column for each key of the axes; `settings` are JSON objects.
    fn add_settings(&mut self, keys: &[String], settings: &[String]) {
        let settings = settings.iter().map(|text| serde_json::from_str(text));
        let settings: Vec<Value> = settings.map(Result::unwrap_or_default).collect();
        self.columns.extend(keys.iter().map(|key| {
            Column {
                name: escape_control(key),
                is_setting: true,
                unit: Unit::none(),
                cells: settings
                    .iter()
                    .map(|row| Cell::Setting(row[key].clone()))
                    .collect(),
            }
        }));
    }
}

/// The names of a dataset's columns: its own, and those of its components.
fn names(name: &str, components: &[Extent]) -> Vec<String> {
    match components {
        [Extent::Labelled(axis)] => {
            let labels = axis.labels.iter();
            let named = |label: &&str| match axis.name {
                "zone" => (*label).to_owned(),
                "friction_axis" => format!("{name}_{}", label.trim_start_matches('t')),
                _ => format!("{name}_{label}"),
            };
            labels.map(named).collect()
        }
        [Extent::Fixed(n)] => (1..=*n).map(|k| format!("{name}_{k}")).collect(),
        _ => vec![name.to_owned()],
    }
}
