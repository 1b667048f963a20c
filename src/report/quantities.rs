//! Quantities of an answer with their error bars.

use contact3d::{post::FunctionalEstimate, scene::Functional};
use serde_json::{Value, json};
use units::{Dimension, Units};

use super::percent;
use crate::format::dimension_of_quantity as dimension;

/// The name of a quantity and what it is by the estimate, for people.
pub(super) fn words(units: Units, it: &FunctionalEstimate) -> (String, String) {
    let unit = units.of(dimension(it.functional));
    let name = match (it.functional, it.corners) {
        (Functional::LargestDisplacement, Some(_)) => "mean displacement near peak".to_owned(),
        (Functional::LargestPressure, Some(_)) => "mean pressure near its peak".to_owned(),
        (of, _) => format!("{}, error bar", of.word().replace('_', " ")),
    };
    let value = match it.functional {
        Functional::ContactArea | Functional::StickArea => {
            let [low, high] = it.range;
            format!("{low:.4e} to {high:.4e} {}", unit.word())
        }
        _ => format!(
            "{:.4e} {} ± {}{}",
            it.value,
            unit.word(),
            percent(it.relative()),
            cautions(units, it)
        ),
    };
    (name, value)
}

/// The box of a mean, and panes at kinks.
fn cautions(units: Units, it: &FunctionalEstimate) -> String {
    let mean = it.corners.map_or_else(String::new, |[low, high]| {
        let unit = units.of(Dimension::LENGTH);
        let corner = |[x, y, z]: [f64; 3]| format!("({x:.4}, {y:.4}, {z:.4})");
        format!(
            ", mean from {} to {} {}",
            corner(low),
            corner(high),
            unit.word()
        )
    });
    let kinks = match it.kinks {
        0 => String::new(),
        1 => ", 1 pane at a kink".into(),
        many => format!(", {many} panes at kinks"),
    };
    mean + &kinks
}

/// The quantities for programs.
pub(super) fn json(units: Units, found: &[FunctionalEstimate]) -> Value {
    let row = |it: &FunctionalEstimate| {
        json!({
            "name": it.functional.word(),
            "unit": units.of(dimension(it.functional)).word(),
            "value": it.value,
            "error": it.error,
            "range": it.range,
            "box": it.corners,
            "kinks": it.kinks,
        })
    };
    found.iter().map(row).collect()
}
