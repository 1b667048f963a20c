//! Ranges of numbers in sweep files.

use schemars::JsonSchema;
use serde::Deserialize;

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
    pub scale: Scale,
}

/// Spacing of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal ratios.
    Log,
}

/// Relative rounding of a logarithmic range.
const WHOLE: f64 = 1e-9;

/// Whole numbers up to this one, 2⁵³, are doubles.
const MOST_WHOLE: f64 = 9_007_199_254_740_992.0;

impl Range {
    /// The values of a key that has whole numbers.
    pub(super) fn whole_rows(
        &self,
        key: &str,
    ) -> Result<Vec<Vec<toml::Value>>, (&'static str, String)> {
        let mut rows = self.rows()?;
        for value in rows.iter_mut().flatten() {
            let number = value.as_float().unwrap_or(f64::NAN);
            let whole = number.round();
            if (number - whole).abs() > WHOLE * whole.abs() || whole.abs() > MOST_WHOLE {
                let expected =
                    "ends and a count that make whole numbers, or `values` in place of `range`";
                return Err((expected, format!("{key} = {number}")));
            }
            #[expect(clippy::cast_possible_truncation, reason = "whole and below 2^53")]
            let whole = whole as i64;
            *value = toml::Value::Integer(whole);
        }
        Ok(rows)
    }

    pub(super) fn rows(&self) -> Result<Vec<Vec<toml::Value>>, (&'static str, String)> {
        let Self {
            from,
            to,
            count,
            scale,
        } = *self;
        let positive = from > 0.0 && to > 0.0;
        if !(from.is_finite() && to.is_finite()) || (scale == Scale::Log && !positive) {
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
            match scale {
                Scale::Linear => from + share * (to - from),
                Scale::Log => from * (share * (to / from).ln()).exp(),
            }
        };
        Ok((0..count)
            .map(|index| vec![toml::Value::Float(at(index))])
            .collect())
    }
}
