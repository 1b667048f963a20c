//! A law of friction in words and as JSON; no computing here.

use std::{fmt::Write, path::PathBuf};

use contact3d::{
    contact::{LawBounds, LawExtreme},
    scene::{Coefficient, Friction, FrictionLaw, FrictionModel, Quantity},
};
use serde_json::{Value, json};
use units::Dimension;

use super::results::unit_words;
use crate::views::{LawStudy, MeshSizes};

/// Most points of a table that are printed.
const MOST_POINTS: usize = 8;

/// The page printed for a person.
pub(super) fn text(study: &LawStudy) -> String {
    let units = study.scene.units;
    let (length, per_length) = (units.length(), units.word(Dimension::PER_LENGTH));
    let mut text = format!("{}\n", study.scene.shown_title());
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "  {name:<22} {value}");
    };
    let model = study.model();
    line("law", &law_words(model.as_ref()));
    for (name, words) in coefficients(study) {
        line(name, &words);
    }
    if let Some((name, stress)) = model.as_ref().and_then(FrictionModel::given_stress) {
        let name = format!("{name} [{}]", units.stress());
        line(&name, &quantity_words(&stress));
    }
    let (Some(bounds), Some(sizes)) = (&study.bounds, study.sizes()) else {
        return text;
    };
    let how = if bounds.estimated {
        "estimated by sampling"
    } else {
        "exact"
    };
    let range = format!(
        "0 to {} {length}, the extent of the body; {how}",
        bounds.largest_slip
    );
    line("slips considered", &range);
    let isotropic = is_isotropic(model.as_ref());
    let at = |extreme: &LawExtreme| point_words(isotropic, extreme, length);
    let valued = |extreme: &LawExtreme, unit: &str| {
        format!("{:<12}{}", number(extreme.value) + unit, at(extreme))
    };
    line("F_min", &valued(&bounds.smallest, ""));
    line("F_max", &valued(&bounds.largest, ""));
    match bounds.lipschitz.value {
        0.0 => line("Lipschitz modulus L", &format!("0 {per_length}")),
        f64::INFINITY => line(
            "Lipschitz modulus L",
            &format!(
                "infinite: the law is not Lipschitz {}",
                at(&bounds.lipschitz)
            ),
        ),
        _ => line(
            "Lipschitz modulus L",
            &valued(&bounds.lipschitz, &format!(" {per_length}")),
        ),
    }
    match isotropic {
        true => line("kappa(F)", "1"),
        false => line("kappa(F)", &valued(&bounds.anisotropy, "")),
    }
    line(
        "pane size, edge",
        &format!(
            "H = {} {length}, h = {} {length}",
            number(sizes.pane),
            number(sizes.edge)
        ),
    );
    let [size, steepness] = scaled(bounds, sizes);
    line("F_max/sqrt(H)", &number(size));
    line("L(2+kappa)/sqrt(h H)", &number(steepness));
    text += SCALING;
    text
}

/// What the last two numbers mean.
const SCALING: &str = "  The last two numbers scale like the condition of HKL Theorem 3.2 and Remark 3.4 for one solution
  and convergent successive approximations: both small enough. The constants in it are not known
  here, so the numbers compare laws and meshes of one body; they guarantee nothing.
";

/// F_max/√H and L (2 + κ)/√(h H).
fn scaled(bounds: &LawBounds, sizes: MeshSizes) -> [f64; 2] {
    [
        bounds.largest.value / sizes.pane.sqrt(),
        bounds.lipschitz.value * (2.0 + bounds.anisotropy.value) / (sizes.edge * sizes.pane).sqrt(),
    ]
}

/// The law for programs; what is not finite is null.
pub(super) fn json(study: &LawStudy, files: &[PathBuf]) -> Value {
    let model = study.model();
    let isotropic = is_isotropic(model.as_ref());
    let extreme = |e: &LawExtreme| {
        json!({
            "value": e.value,
            "coefficient": name(isotropic, e.coefficient),
            "position": e.position,
            "slip": e.slip,
        })
    };
    let bounds = study.bounds.as_ref().zip(study.sizes()).map(|(b, sizes)| {
        let [size, steepness] = scaled(b, sizes);
        json!({
            "f_min": extreme(&b.smallest),
            "f_max": extreme(&b.largest),
            "lipschitz": extreme(&b.lipschitz),
            "kappa": extreme(&b.anisotropy),
            "largest_slip": b.largest_slip,
            "estimated": b.estimated,
            "pane_size": sizes.pane,
            "edge_length": sizes.edge,
            "f_max_over_sqrt_pane_size": size,
            "lipschitz_times_2_plus_kappa_over_sqrt_edge_length_pane_size": steepness,
        })
    });
    let coefficients: serde_json::Map<String, Value> = coefficients(study)
        .map(|(name, words)| (name.to_owned(), words.into()))
        .collect();
    json!({
        "title": study.scene.title,
        "units": unit_words(study.scene.units),
        "law": model.as_ref().map_or("no_contact", FrictionModel::word),
        "coefficients": coefficients,
        "bounds": bounds,
        "figures": files,
    })
}

fn law_words(model: Option<&FrictionModel>) -> String {
    let Some(model) = model else {
        return "none: the scene has no contact face".into();
    };
    let Some((name, coefficients)) = model.name().zip(model.coefficients()) else {
        return "frictionless contact: no tangential stresses, nothing to bound".into();
    };
    match model.condition() {
        None => format!("{} {name} friction", coefficients.shape()),
        Some(condition) => format!("{name} friction {condition}"),
    }
}

/// Whether the law has one coefficient.
fn is_isotropic(model: Option<&FrictionModel>) -> bool {
    match model.and_then(FrictionModel::coefficients) {
        None | Some(FrictionLaw::Orthotropic(_)) => false,
        Some(FrictionLaw::Isotropic(_)) => true,
    }
}

/// F, or F1 and F2, in words.
fn coefficients(study: &LawStudy) -> impl Iterator<Item = (&'static str, String)> {
    let law = study.scene.friction_on(0);
    let given = law
        .into_iter()
        .flat_map(|(_, friction)| Friction::given(friction));
    let length = study.scene.units.length();
    given.map(move |(key, coefficient)| match key {
        "coefficient_1" => ("F1", coefficient_words(coefficient, "|u_t1|", length)),
        "coefficient_2" => ("F2", coefficient_words(coefficient, "|u_t2|", length)),
        _ => ("F", coefficient_words(coefficient, "|u_t|", length)),
    })
}

fn coefficient_words(coefficient: &Coefficient, slip: &str, length: &str) -> String {
    match coefficient {
        Coefficient::Constant(value) => format!("{value}"),
        Coefficient::Ramp(ramp) => format!(
            "ramp over {slip}: {} up to {} {length}, then with slope {} 1/{length} to {} from {} {length} on",
            ramp.initial,
            number(ramp.onset),
            ramp.rate.copysign(ramp.residual - ramp.initial),
            ramp.residual,
            number(ramp.end()),
        ),
        Coefficient::Table(table) => {
            let points = table.slip.iter().zip(&table.value).take(MOST_POINTS);
            let points: Vec<String> = points
                .map(|(slip, value)| format!("{value} at {} {length}", number(*slip)))
                .collect();
            let more = match table.slip.len().saturating_sub(MOST_POINTS) {
                0 => String::new(),
                more => format!(", and {more} more"),
            };
            format!("table over {slip}: {}{more}", points.join(", "))
        }
        Coefficient::Grid(grid) => {
            let last = |slips: &[f64]| number(slips.last().copied().unwrap_or(0.0));
            format!(
                "grid of {} x {} values over |u_t1| up to {} {length} and |u_t2| up to {} {length}",
                grid.slip_1.len(),
                grid.slip_2.len(),
                last(&grid.slip_1),
                last(&grid.slip_2),
            )
        }
        Coefficient::Expression(formula) => {
            let formula = formula.expression();
            let variables = [("s", "|u_t|"), ("s1", "|u_t1|"), ("s2", "|u_t2|")];
            let used = variables.iter().filter(|(name, _)| formula.uses(name));
            let meanings: Vec<String> = used
                .map(|(name, slip)| format!("{name} = {slip}"))
                .collect();
            match meanings.is_empty() {
                true => formula.text().to_owned(),
                false => format!("{}  ({} in {length})", formula.text(), meanings.join(", ")),
            }
        }
        Coefficient::Function(_) => format!("a Rust function of {slip} in {length}"),
    }
}

fn quantity_words(quantity: &Quantity) -> String {
    match quantity {
        Quantity::Constant(value) => number(*value),
        Quantity::Varying(expression) => expression.text().to_owned(),
        Quantity::Function(_) => "a Rust function of the place".to_owned(),
    }
}

fn name(isotropic: bool, coefficient: usize) -> &'static str {
    match isotropic {
        true => "F",
        false => ["F1", "F2"][coefficient],
    }
}

/// Which coefficient, at which slip and place.
fn point_words(isotropic: bool, extreme: &LawExtreme, length: &str) -> String {
    let [first, second] = extreme.slip.map(number);
    let mut words = match isotropic {
        true => format!("at |u_t| = {first} {length}"),
        false => format!(
            "{} at |u_t1| = {first}, |u_t2| = {second} {length}",
            name(isotropic, extreme.coefficient)
        ),
    };
    if let Some([x, y, z]) = extreme.position.map(|x| x.map(number)) {
        words += &format!(", x = {x}, y = {y}, z = {z} {length}");
    }
    words
}

/// Five significant digits, without trailing zeros.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}
