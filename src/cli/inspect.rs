//! `inspect`: what a mesh file holds, and a scene for it.

use std::path::{Path, PathBuf};

use clap::Args;
use contact3d::mesh::{FaceInspection, MeshInspection};

use super::{
    arguments::Output,
    exit::Exit,
    init,
    terminal::{self, say},
};
use crate::{
    output::Inputs,
    pipeline::StageError,
    report::{self, mesh::six_digits},
};

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// The mesh file, MSH 2.2 or 4.1
    pub mesh: PathBuf,
    /// Write a scene for it; an existing file is not overwritten
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
}

/// `inspect`: prints the figures and writes the scene.
pub(super) fn inspect(arguments: &InspectArguments, output: &Output) -> Result<Exit, StageError> {
    let mesh = MeshInspection::read(&arguments.mesh)?;
    if let Some(scene) = &arguments.scene {
        let inputs = Inputs::of([arguments.mesh.clone()]);
        init::write(vec![(scene.clone(), scene_for(&mesh, arguments))], &inputs)?;
    }
    terminal::print(
        output,
        || report::mesh::json(&mesh),
        || report::mesh::text(&mesh),
    );
    if let Some(scene) = &arguments.scene {
        let (scene, run) = (scene.display(), scene.with_extension("h5"));
        say(
            output,
            &format!(
                "wrote {scene}; look at its faces and loads, then: contact3d-pipe run {scene} {}",
                run.display()
            ),
        );
    }
    Ok(Exit::Done)
}

/// Faces whose mean normal is shorter than this look every way.
const EVERY_WAY: f64 = 0.1;

/// The face that looks up most, or with −1 down most; of equal ones a curved face comes first where it may touch, a flat one where it
/// is held. What the file has no name for comes last.
fn facing(mesh: &MeshInspection, up: f64) -> Option<&FaceInspection> {
    let rank = |face: &FaceInspection| {
        let [x, y, z] = face.mean_normal;
        let length = x.hypot(y).hypot(z);
        let height = if length > EVERY_WAY {
            up * z / length
        } else {
            0.0
        };
        let is_named = face.name != "unnamed";
        let first = if face.normal.is_some() { up } else { -up };
        // Rounding of a mesh file does not rank faces.
        [f64::from(u8::from(is_named)), (1e6 * height).round(), first]
    };
    let ranked = mesh.faces.iter().map(|face| (rank(face), face));
    let best = ranked.reduce(|best, next| if next.0 > best.0 { next } else { best });
    best.map(|(_, face)| face)
}

/// The path of the mesh file as a scene in some folder names it.
fn named_in_scene(arguments: &InspectArguments) -> PathBuf {
    let mesh = &arguments.mesh;
    let of_scene = arguments.scene.as_deref().and_then(Path::parent);
    if mesh.parent() == of_scene {
        return mesh.file_name().map(PathBuf::from).unwrap_or_default();
    }
    std::path::absolute(mesh).unwrap_or_else(|_| mesh.clone())
}

/// A scene that touches with the face that looks down most, on a plane below it, and is held at the one that looks up most.
fn scene_for(mesh: &MeshInspection, arguments: &InspectArguments) -> String {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let all = |names: Vec<&String>| {
        let names: Vec<String> = names.into_iter().map(|name| quoted(name)).collect();
        names.join(", ")
    };
    let (lowest, highest) = (facing(mesh, -1.0), facing(mesh, 1.0));
    let name = |face: Option<&FaceInspection>| quoted(face.map_or("", |face| &face.name));
    let file = arguments.mesh.file_name().unwrap_or_default();
    let [low, high] = mesh.bounds;
    let extent = [0, 1, 2]
        .map(|c| six_digits(high[c] - low[c], 0.0))
        .join(" x ");
    let faces = all(mesh.faces.iter().map(|face| &face.name).collect());
    let parts = all(mesh.parts.iter().map(|(name, ..)| name).collect());
    let plane = format!(
        "obstacle.half_space = {{ point = [0.0, 0.0, {:?}], normal = [0.0, 0.0, 1.0] }}\n# obstacle.sphere",
        low[2]
    );
    let is_curved = lowest.is_some_and(|face| face.normal.is_none());
    let obstacle = if is_curved {
        plane
    } else {
        "# obstacle.sphere".to_owned()
    };
    // In the order of the text.
    let texts = [
        ("\"part from Gmsh\"", quoted(&file.to_string_lossy())),
        (
            "[body]",
            format!("# The mesh is {extent}: is that mm?\n\n[body]"),
        ),
        (
            "\"part.msh\"",
            quoted(&named_in_scene(arguments).to_string_lossy()),
        ),
        (
            "# [[region]] ",
            format!("# Faces: {faces}. Parts: {parts}.\n# [[region]] "),
        ),
        ("\"top\"", name(highest)),
        ("\"bottom\"", name(lowest)),
        ("# obstacle.sphere", obstacle),
    ];
    let (mut scene, mut rest) = (String::new(), init::GMSH);
    for (place, text) in texts {
        let (before, after) = rest.split_once(place).unwrap_or((rest, ""));
        scene += before;
        scene += &text;
        rest = after;
    }
    scene + rest
}
