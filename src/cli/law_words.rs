//! Laws of friction in words and as JSON; no computing here.

use std::{fmt::Write, path::PathBuf};

use contact3d::{
    contact::{LawBounds, LawExtreme},
    scene::{Coefficient, Friction, FrictionLaw, FrictionModel, Quantity, shown},
};
use serde_json::{Value, json};
use units::Dimension;

use super::results_json::unit_words;
use crate::views::{FaceStudy, LawStudy, MeshSizes};

/// Most points of a table that are printed.
const MOST_POINTS: usize = 8;

/// The page printed for a person.
pub(super) fn text(study: &LawStudy) -> String {
    let mut text = format!("{}\n", study.scene.shown_title());
    match study.faces.as_slice() {
        [] => text += &line("law", "none: the scene has no contact face"),
        [only] => text += &face_text(study, only),
        several => {
            for face in several {
                let _ = write!(
                    text,
                    "\nface {}\n{}",
                    shown(&face.name),
                    face_text(study, face)
                );
            }
        }
    }
    if study.faces.iter().any(|face| face.bounds.is_some()) {
        text += SCALING;
    }
    text
}

fn line(name: &str, value: &str) -> String {
    format!("  {name:<22} {value}\n")
}

/// The law of one face.
fn face_text(study: &LawStudy, face: &FaceStudy) -> String {
    let units = study.scene.units;
    let (length, per_length) = (units.length(), units.word(Dimension::PER_LENGTH));
    let mut text = String::new();
    let mut line = |name: &str, value: &str| text += &line(name, value);
    line("law", &law_words(&face.model));
    for (name, words) in coefficients(study, face) {
        line(name, &words);
    }
    if let Some((name, stress)) = face.model.given_stress() {
        let name = format!("{name} [{}]", units.stress());
        line(&name, &quantity_words(&stress));
    }
    let Some(bounds) = &face.bounds else {
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
    let isotropic = is_isotropic(&face.model);
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
            number(face.sizes.pane),
            number(face.sizes.edge)
        ),
    );
    let [size, steepness] = scaled(bounds, face.sizes);
    line("F_max/sqrt(H)", &number(size));
    line("L(2+kappa)/sqrt(h H)", &number(steepness));
    text
}

/// What the last two numbers of a law mean.
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

/// The laws for programs, that of a single face beside the title; what is not finite is null.
pub(super) fn json(study: &LawStudy, files: &[PathBuf]) -> Value {
    let mut page = match study.faces.as_slice() {
        [] => json!({ "law": "no_contact", "coefficients": {}, "bounds": null }),
        [only] => face_json(study, only),
        several => {
            let faces = several.iter().map(|face| {
                let mut law = face_json(study, face);
                law["name"] = face.name.as_str().into();
                law
            });
            json!({ "faces": faces.collect::<Vec<_>>() })
        }
    };
    page["title"] = study.scene.title.as_str().into();
    page["units"] = unit_words(study.scene.units);
    page["figures"] = json!(files);
    page
}

fn face_json(study: &LawStudy, face: &FaceStudy) -> Value {
    let isotropic = is_isotropic(&face.model);
    let extreme = |e: &LawExtreme| {
        json!({
            "value": e.value,
            "coefficient": name(isotropic, e.coefficient),
            "position": e.position,
            "slip": e.slip,
        })
    };
    let bounds = face.bounds.as_ref().map(|b| {
        let [size, steepness] = scaled(b, face.sizes);
        json!({
            "f_min": extreme(&b.smallest),
            "f_max": extreme(&b.largest),
            "lipschitz": extreme(&b.lipschitz),
            "kappa": extreme(&b.anisotropy),
            "largest_slip": b.largest_slip,
            "estimated": b.estimated,
            "pane_size": face.sizes.pane,
            "edge_length": face.sizes.edge,
            "f_max_over_sqrt_pane_size": size,
            "lipschitz_times_2_plus_kappa_over_sqrt_edge_length_pane_size": steepness,
        })
    });
    let coefficients: serde_json::Map<String, Value> = coefficients(study, face)
        .map(|(name, words)| (name.to_owned(), words.into()))
        .collect();
    json!({
        "law": face.model.word(),
        "coefficients": coefficients,
        "bounds": bounds,
    })
}

fn law_words(model: &FrictionModel) -> String {
    let Some((name, coefficients)) = model.name().zip(model.coefficients()) else {
        return "frictionless contact: no tangential stresses, nothing to bound".into();
    };
    match model.condition() {
        None => format!("{} {name} friction", coefficients.shape()),
        Some(condition) => format!("{name} friction {condition}"),
    }
}

/// Whether the law has one coefficient.
fn is_isotropic(model: &FrictionModel) -> bool {
    match model.coefficients() {
        None | Some(FrictionLaw::Orthotropic(_)) => false,
        Some(FrictionLaw::Isotropic(_)) => true,
    }
}

/// F, or F1 and F2, in words.
fn coefficients<'a>(
    study: &'a LawStudy,
    face: &FaceStudy,
) -> impl Iterator<Item = (&'static str, String)> + use<'a> {
    let law = study.scene.friction_on(face.entry);
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
