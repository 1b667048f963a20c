//! A bound of the discretisation error.

use contact3d::post::RelativeBound;
use serde_json::Value;
use units::Units;

use super::{Figures, percent};

/// The bound and its parts, for people.
pub fn text(bound: &RelativeBound, units: Units) -> String {
    figures(bound, units).text(0, 28)
}

/// The same for programs.
pub fn json(bound: &RelativeBound, units: Units) -> Value {
    figures(bound, units).json()
}

/// The bound and its parts.
pub fn figures(bound: &RelativeBound, units: Units) -> Figures {
    let mut figures = Figures::new(units);
    let mut add = |key: &str, words: &str, share: Option<f64>| {
        let shown = share.map(|share| format!("at most {}", percent(rounded_up(share))));
        figures.in_words(key, words, shown, share);
    };
    let whole = "error in the energy norm";
    add("total", whole, bound.total);
    let given = "for these contact stresses";
    add("elements", given, Some(bound.elements));
    if bound.lifting.is_some() {
        add("lifting", "of it penetration", bound.lifting);
        add(
            "complementarity",
            "of it pressure on gaps",
            bound.complementarity,
        );
        add("friction", "of it slip", bound.friction);
    }
    if bound.total.is_none() {
        let why = "none: friction follows the pressure, or a slip bound or gap is a formula";
        figures.said(whole, Some(why.to_owned()));
    }
    figures
}

/// The next larger number of two digits.
fn rounded_up(share: f64) -> f64 {
    let unit = 10_f64.powf(share.log10().floor() - 1.0);
    if unit > 0.0 {
        (share / unit).ceil() * unit
    } else {
        share
    }
}
