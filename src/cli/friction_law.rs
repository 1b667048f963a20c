//! `friction-law`: bounds and pictures of a law of friction.

use std::path::PathBuf;

use clap::Args;
use contact3d::{
    contact::{LawBounds, LawExtreme},
    scene::{Coefficient, Friction, FrictionLaw, FrictionModel, Quantity, escape_control},
};
use serde_json::{Map, Value, json};
use units::Dimension;

use super::{
    arguments::{FigureArguments, Output, SceneArguments},
    exit::Exit,
    override_scene,
    terminal::{self, say, warn},
};
use crate::{
    pipeline::StageError,
    report::{Figures, unit_words},
    views::{FaceStudy, LawStudy, MeshSizes, folder_here},
};

/// Arguments of `friction-law`.
#[derive(Debug, Args)]
pub struct FrictionLawArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `friction-law`: bounds and picture of a law of friction; stores no run file.
pub(super) fn friction_law(
    arguments: &FrictionLawArguments,
    output: &Output,
) -> Result<Exit, StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(&arguments.scene)?;
    let study = LawStudy::new(scene)?;
    warn(output, &study.warnings());
    let usual = folder_here(&arguments.scene.scene, "friction-law");
    let folder = arguments.figures.claim(&usual, study.drawing(), inputs)?;
    let files = folder.map_or_else(|| Ok(Vec::new()), |folder| study.draw(&folder))?;
    terminal::print(output, || json(&study, &files), || text(&study));
    for file in files {
        say(output, &format!("figure    {}", file.display()));
    }
    Ok(Exit::Done)
}

/// Most points of a table that are printed.
const MOST_POINTS: usize = 8;

/// The laws of all faces.
fn text(study: &LawStudy) -> String {
    let mut text = format!("{}\n", study.scene.shown_title());
    if study.faces.is_empty() {
        let mut none = Figures::new(study.scene.units);
        none.human_only(
            "law",
            Some("none: the scene has no contact face".to_owned()),
        );
        text += &none.text(2, NAMES);
    }
    for face in &study.faces {
        if study.faces.len() > 1 {
            text += &format!("\nface {}\n", escape_control(&face.name));
        }
        text += &figures(study, face).text(2, NAMES);
    }
    if study.faces.iter().any(|face| face.bounds.is_some()) {
        text += SCALING;
    }
    text
}

/// Width of names.
const NAMES: usize = 22;

/// The laws for programs, that of a single face beside the title; what is not finite is null.
fn json(study: &LawStudy, files: &[PathBuf]) -> Value {
    let mut page = match study.faces.as_slice() {
        [] => json!({ "law": "no_contact", "coefficients": {}, "bounds": null }),
        [only] => figures(study, only).json(),
        several => {
            let faces = several.iter().map(|face| {
                let mut law = figures(study, face).json();
                law["name"] = face.name.as_str().into();
                law
            });
            json!({ "faces": faces.collect::<Value>() })
        }
    };
    page["title"] = study.scene.title.as_str().into();
    page["units"] = unit_words(study.scene.units);
    page["figures"] = json!(files);
    page
}

/// The law of one face.
#[rustfmt::skip]
fn figures(study: &LawStudy, face: &FaceStudy) -> Figures {
    let mut figures = Figures::new(study.scene.units);
    figures.described("law", "law", Some(law_words(face.model.as_ref())), FrictionModel::word(face.model.as_ref()));
    figures.json_only("coefficients", Map::new());
    for (name, words) in coefficients(study, face) {
        figures.described(&format!("coefficients.{name}"), name, Some(words.clone()), words);
    }
    if let Some((name, stress)) = face.model.as_ref().and_then(|law| law.bound.given_stress()) {
        let name = format!("{name} [{}]", study.scene.units.stress());
        figures.human_only(&name, Some(quantity_words(&stress)));
    }
    match &face.bounds {
        None => figures.json_only("bounds", ()),
        Some(bounds) => figures = figures.with(of_bounds(study, face, bounds)),
    }
    figures
}

/// The bounds of a law, each with the slip and the place that it is taken at.
#[rustfmt::skip]
fn of_bounds(study: &LawStudy, face: &FaceStudy, bounds: &LawBounds) -> Figures {
    let units = study.scene.units;
    let (length, per_length) = (units.length(), units.word(Dimension::PER_LENGTH));
    let isotropic = is_isotropic(face.model.as_ref());
    let at = |extreme: &LawExtreme| point_words(isotropic, extreme, length);
    let valued = |extreme: &LawExtreme, unit: &str| {
        format!("{:<12}{}", number(extreme.value) + unit, at(extreme))
    };
    let steepest = &bounds.lipschitz;
    let steepest = match steepest.value {
        0.0 => format!("0 {per_length}"),
        f64::INFINITY => format!("infinite: the law is not Lipschitz {}", at(steepest)),
        _ => valued(steepest, &format!(" {per_length}")),
    };
    let kappa = if isotropic {
        "1".to_owned()
    } else {
        valued(&bounds.anisotropy, "")
    };
    let mut figures = Figures::new(units);
    let largest = bounds.largest_slip;
    let how = if bounds.estimated {
        "estimated by sampling"
    } else {
        "exact"
    };
    let range = format!("0 to {largest} {length}, the extent of the body; {how}");
    figures.described("bounds.largest_slip", "slips considered", Some(range), largest);
    figures.json_only("bounds.estimated", bounds.estimated);
    for (key, words, shown, extreme) in [
        ("f_min", "F_min", valued(&bounds.smallest, ""), &bounds.smallest),
        ("f_max", "F_max", valued(&bounds.largest, ""), &bounds.largest),
        ("lipschitz", "Lipschitz modulus L", steepest, &bounds.lipschitz),
        ("kappa", "kappa(F)", kappa, &bounds.anisotropy),
    ] {
        let value = json!({
            "value": extreme.value,
            "coefficient": name(isotropic, extreme.coefficient),
            "position": extreme.position,
            "slip": extreme.slip,
        });
        figures.described(&format!("bounds.{key}"), words, Some(shown), value);
    }
    let MeshSizes { pane, edge } = face.sizes;
    let sizes = format!("H = {} {length}, h = {} {length}", number(pane), number(edge));
    figures.human_only("pane size, edge", Some(sizes));
    figures.json_only("bounds.pane_size", pane);
    figures.json_only("bounds.edge_length", edge);
    let size = bounds.largest.value / pane.sqrt();
    let key = "bounds.f_max_over_sqrt_pane_size";
    figures.described(key, "F_max/sqrt(H)", Some(number(size)), size);
    let steepness = bounds.lipschitz.value * (2.0 + bounds.anisotropy.value) / (edge * pane).sqrt();
    let key = "bounds.lipschitz_times_2_plus_kappa_over_sqrt_edge_length_pane_size";
    figures.described(key, "L(2+kappa)/sqrt(h H)", Some(number(steepness)), steepness);
    figures
}

/// What the last two numbers of a law mean.
const SCALING: &str = "  The last two numbers scale like the condition of HKL Theorem 3.2 and Remark 3.4 for one solution
  and convergent successive approximations: both small enough. The constants in it are not known
  here, so the numbers compare laws and meshes of one body; they guarantee nothing.
";

fn law_words(model: Option<&FrictionModel>) -> String {
    let Some(model) = model else {
        return "frictionless contact: no tangential stresses, nothing to bound".into();
    };
    let words = model.bound.words();
    match words.condition {
        None => format!("{} {} friction", model.coefficients.shape(), words.name),
        Some(condition) => format!("{} friction {condition}", words.name),
    }
}

/// Whether the law has one coefficient.
fn is_isotropic(model: Option<&FrictionModel>) -> bool {
    model.is_some_and(|law| matches!(law.coefficients, FrictionLaw::Isotropic(_)))
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
            if meanings.is_empty() {
                formula.text().into_owned()
            } else {
                format!("{}  ({} in {length})", formula.text(), meanings.join(", "))
            }
        }
        Coefficient::Function(_) => format!("a Rust function of {slip} in {length}"),
    }
}

fn quantity_words(quantity: &Quantity) -> String {
    match quantity {
        Quantity::Constant(value) => number(*value),
        Quantity::Varying(expression) => expression.text().into_owned(),
        Quantity::Function(_) => "a Rust function of the place".to_owned(),
    }
}

fn name(isotropic: bool, coefficient: usize) -> &'static str {
    if isotropic {
        "F"
    } else {
        ["F1", "F2"][coefficient]
    }
}

/// Which coefficient, at which slip and place.
fn point_words(isotropic: bool, extreme: &LawExtreme, length: &str) -> String {
    let [first, second] = extreme.slip.map(number);
    let mut words = if isotropic {
        format!("at |u_t| = {first} {length}")
    } else {
        let name = name(isotropic, extreme.coefficient);
        format!("{name} at |u_t1| = {first}, |u_t2| = {second} {length}")
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
