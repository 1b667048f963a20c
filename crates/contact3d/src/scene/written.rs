//! Values as a scene writes them.

use std::fmt;

use serde::Serialize;

/// A value as a scene writes it, in one line of TOML; numbers in their shortest form.
pub struct Written<'a, T>(pub &'a T);

impl<T: Serialize> fmt::Display for Written<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match toml::Value::try_from(self.0) {
            Ok(value) => write!(f, "{}", line(&value)),
            Err(error) => write!(f, "{error}"),
        }
    }
}

fn line(value: &toml::Value) -> String {
    let joined = |items: Vec<String>| items.join(", ");
    match value {
        toml::Value::Float(value) if value.is_nan() => "nan".to_owned(),
        toml::Value::Float(value) => format!("{value:?}"),
        toml::Value::Array(items) => format!("[{}]", joined(items.iter().map(line).collect())),
        toml::Value::Table(table) => {
            let pairs = table.iter();
            let pairs = pairs.map(|(key, value)| format!("{key} = {}", line(value)));
            format!("{{ {} }}", joined(pairs.collect()))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Coefficient, Formula, Part, Quantity, Ramp};

    #[test]
    fn values_are_written_as_in_scenes() {
        let ramp = Coefficient::Ramp(Ramp {
            initial: 0.3,
            residual: f64::NAN,
            onset: 0.0,
            rate: 1.0,
        });
        let formula = Coefficient::Expression(Formula::parse("0.3 + s").unwrap());
        for (found, expected) in [
            (Written(&Quantity::Constant(f64::NAN)).to_string(), "nan"),
            (Written(&[1.0, -2.5e-300]).to_string(), "[1.0, -2.5e-300]"),
            (Written(&"z_min").to_string(), "\"z_min\""),
            (
                Written(&ramp).to_string(),
                "{ ramp = { initial = 0.3, residual = nan, onset = 0.0, rate = 1.0 } }",
            ),
            (
                Written(&formula).to_string(),
                "{ expression = \"0.3 + s\" }",
            ),
            (
                Written(&Part::Box([[0.0; 3], [1.0; 3]])).to_string(),
                "{ box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]] }",
            ),
        ] {
            assert_eq!(found, expected);
        }
    }
}
