//! `friction-law`: bounds and pictures of the laws of friction of a scene, from its mesh alone.

use contact3d::{
    contact::{CoulombLaw, FaceLaw, Interface, LawBounds, LawExtreme},
    scene::{ContactFeatures, FrictionModel, escape_control},
};
use serde_json::json;
use units::{Dimension, Units, in_digits};

use super::{
    arguments::{FigureArguments, Output, SceneArguments},
    exit::Exit,
    override_scene,
    terminal::{self, say, warn},
};
use crate::{
    pipeline::{StageError, mesh_of, pin_mesh_file},
    report::{Figures, unit_words},
    views::{draw_laws, drawing_of_laws, folder_here},
};

/// `friction-law`: bounds and draws the law of each contact face; stores no run file.
pub(super) fn friction_law(
    arguments: &SceneArguments,
    figures: &FigureArguments,
    output: &Output,
) -> Result<Exit, StageError> {
    let (mut input, inputs) = override_scene::read_with_inputs(arguments)?;
    pin_mesh_file(&mut input)?;
    let mesh = mesh_of(&input, &[])?;
    let scene = &input.scene;
    let interface = Interface::new(scene, &mesh).map_err(|invalid| input.refuse(invalid))?;
    let mut warnings = scene.warnings();
    let laws = interface.iter().flat_map(|interface| {
        warnings.extend(interface.warnings(mesh.extent(), scene.units.length()));
        interface.coulomb().map_or(&[][..], CoulombLaw::faces)
    });
    let laws: Vec<&FaceLaw> = laws.collect();
    warn(output, &warnings);
    let usual = folder_here(&arguments.scene, "friction-law");
    let folder = figures.claim(&usual, drawing_of_laws(scene), inputs)?;
    // Those with friction come first, and those beside Coulomb's law with a given slip bound have no bounds.
    let faces = scene.contact_features();
    let bounded = |(number, face): (usize, &ContactFeatures)| {
        let model = face.friction.as_ref()?;
        let law = *laws.get(number)?;
        model.bound.follows_pressure().then_some(law)
    };
    let law_of: Vec<Option<&FaceLaw>> = faces.iter().enumerate().map(bounded).collect();
    let title_of = |face: &ContactFeatures| match faces.len() {
        1 => scene.shown_title(),
        _ => format!("{}: {}", scene.shown_title(), escape_control(&face.name)),
    };
    let drawn = faces.iter().zip(&law_of).enumerate();
    let drawn = drawn.filter_map(|(k, (face, law))| Some((k, title_of(face), (*law)?)));
    let files = match &folder {
        Some(folder) => draw_laws(folder, scene, drawn, mesh.extent())?,
        None => Vec::new(),
    };
    let figures = faces.iter().zip(&law_of).map(|(face, law)| {
        let bounds = law.map(|law| LawBounds::new(law, mesh.extent()));
        figures_of(face, bounds.as_ref(), mesh.extent(), scene.units)
    });
    let figures: Vec<Figures> = figures.collect();
    terminal::print(
        output,
        || {
            let faces: Vec<_> = figures.iter().map(Figures::json).collect();
            json!({ "title": scene.title, "faces": faces, "units": unit_words(scene.units), "figures": files })
        },
        || {
            let faces = figures.iter().map(|face| face.text(2, 22));
            let faces: Vec<String> = faces.collect();
            format!("{}\n{}", scene.shown_title(), faces.join("\n"))
        },
    );
    for file in files {
        say(output, &format!("figure    {}", file.display()));
    }
    Ok(Exit::Done)
}

/// The law of a face and its bounds, each with the slip and the place that it is taken at.
#[rustfmt::skip]
fn figures_of(face: &ContactFeatures, bounds: Option<&LawBounds>, largest_slip: f64, units: Units) -> Figures {
    let model = face.friction.as_ref();
    let mut figures = Figures::new(units);
    figures.described("name", "face", Some(escape_control(&face.name)), face.name.as_str());
    figures.described("law", "law", Some(law_words(model)), FrictionModel::word(model));
    let Some(bounds) = bounds else {
        figures.json_only("bounds", ());
        return figures;
    };
    let length = units.length();
    let how = if bounds.estimated { "estimated by sampling" } else { "exact" };
    let range = format!("0 to {largest_slip} {length}, the extent of the body; {how}");
    figures.described("bounds.largest_slip", "slips considered", Some(range), largest_slip);
    figures.json_only("bounds.estimated", bounds.estimated);
    let per_length = format!(" {}", units.word(Dimension::PER_LENGTH));
    for (key, words, unit, extreme) in [
        ("f_min", "F_min", "", &bounds.smallest),
        ("f_max", "F_max", "", &bounds.largest),
        ("lipschitz", "Lipschitz modulus L", per_length.as_str(), &bounds.lipschitz),
        ("kappa", "kappa(F)", "", &bounds.anisotropy),
    ] {
        let name = coefficient_name(model, extreme.coefficient);
        let shown = format!("{:<12}{name} {}", number(extreme.value) + unit, place_words(extreme, length));
        let value = json!({
            "value": extreme.value,
            "coefficient": name,
            "position": extreme.position,
            "slip": extreme.slip,
        });
        figures.described(&format!("bounds.{key}"), words, Some(shown), value);
    }
    figures
}

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

fn coefficient_name(model: Option<&FrictionModel>, coefficient: usize) -> &'static str {
    match model.map_or(1, |law| law.coefficients.coefficients().len()) {
        1 => "F",
        _ => ["F1", "F2"][coefficient],
    }
}

/// The slips along both axes, or the whole slip and 0, and the place.
fn place_words(extreme: &LawExtreme, length: &str) -> String {
    let [first, second] = extreme.slip.map(number);
    let mut words = format!("at slip {first}, {second} {length}");
    if let Some([x, y, z]) = extreme.position.map(|x| x.map(number)) {
        words += &format!(", x = {x}, y = {y}, z = {z} {length}");
    }
    words
}

/// Five significant digits, without trailing zeros.
fn number(value: f64) -> String {
    in_digits(value, 5, 1e6)
}
