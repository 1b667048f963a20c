//! `init` and `inspect`: commented scenes to start from, and what a mesh file holds.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use contact3d::mesh::{FaceInspection, MeshInspection};

use super::{
    arguments::{FigureArguments, Output},
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    output::{self, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
    report,
    views::{Drawing, draw_mesh, folder_here},
};

/// A block on a foundation, with the further keys of a scene in comments.
const BRICK: &str = include_str!("scenes/brick.toml");

/// What a scene starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SceneKind {
    /// A block on a foundation
    Brick,
    /// A part from a mesh file of Gmsh
    Gmsh,
    /// A block that is pressed, pulled and pushed
    History,
    /// A block in the file named, and a sweep of two of its keys beside it: NAME-sweep.toml
    Sweep,
}

/// `init`: writes the scene, and what belongs to it.
pub(super) fn init(scene: &Path, kind: SceneKind, printing: &Output) -> Result<Exit, StageError> {
    let path = scene.to_owned();
    let run = format!(
        "run {} {}",
        scene.display(),
        scene.with_extension("h5").display()
    );
    let (files, next) = match kind {
        SceneKind::Brick => (vec![(path, BRICK.to_owned())], run),
        SceneKind::Gmsh => (vec![(path, MeshScene::default().text())], run),
        SceneKind::History => {
            let text = include_str!("scenes/history.toml");
            (vec![(path, text.to_owned())], run)
        }
        SceneKind::Sweep => {
            let sweep = beside(scene, "sweep.toml");
            let name = scene.file_name().unwrap_or_default().to_string_lossy();
            let name = quoted(&name);
            let text = format!(include_str!("scenes/sweep.toml.in"), scene = name);
            let out = beside(scene, "cases");
            let next = format!("sweep {} {}", sweep.display(), out.display());
            (vec![(path, BRICK.to_owned()), (sweep, text)], next)
        }
    };
    let written: Vec<PathBuf> = files.iter().map(|(path, _)| path.clone()).collect();
    write(files, &Inputs::default())?;
    terminal::written(printing, &written);
    say(printing, &format!("go on with: contact3d-pipe {next}"));
    Ok(Exit::Done)
}

/// Text as TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// What a scene around a mesh file says of the file.
pub(super) struct MeshScene {
    pub(super) title: String,
    pub(super) file: String,
    /// The face that is held, and the one that touches.
    pub(super) held: String,
    pub(super) touching: String,
    /// Height of the body, which is pressed by a thousandth of it.
    pub(super) height: f64,
    /// Height of the plane that a curved face touches.
    pub(super) plane: Option<f64>,
    /// Centre and radius of a ball below the body.
    pub(super) ball: ([f64; 3], f64),
    /// Extents of the mesh; names of its faces and of its parts.
    pub(super) found: Option<(String, Vec<String>, Vec<String>)>,
}

impl Default for MeshScene {
    fn default() -> Self {
        Self {
            title: "part from Gmsh".to_owned(),
            file: "part.msh".to_owned(),
            held: "top".to_owned(),
            touching: "bottom".to_owned(),
            height: 100.0,
            plane: None,
            ball: ([0.0, 0.0, -50.0], 50.0),
            found: None,
        }
    }
}

impl MeshScene {
    /// The scene.
    pub(super) fn text(&self) -> String {
        let all = |names: &[String]| {
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            names.join(", ")
        };
        let found = self.found.as_ref();
        let (extent, names) = found.map_or_else(Default::default, |(extent, faces, parts)| {
            (
                format!("# The mesh is {extent}: is that mm?\n\n"),
                format!("# Faces: {}. Parts: {}.\n", all(faces), all(parts)),
            )
        });
        let plane = self.plane.map_or_else(String::new, |z| {
            format!(
                "obstacle.half_space = {{ point = [0.0, 0.0, {z:?}], normal = [0.0, 0.0, 1.0] }}\n"
            )
        });
        let down = units::rounded(-self.height / 1000.0, 2);
        format!(
            include_str!("scenes/gmsh.toml.in"),
            extent = extent,
            names = names,
            down = down,
            plane = plane,
            centre = self.ball.0,
            radius = self.ball.1,
            title = quoted(&self.title),
            file = quoted(&self.file),
            held = quoted(&self.held),
            touching = quoted(&self.touching),
        )
    }
}

/// Writes scenes where there is nothing yet.
pub(super) fn write(files: Vec<(PathBuf, String)>, inputs: &Inputs) -> Result<(), StageError> {
    let files: Vec<OutputFile> = files
        .into_iter()
        .map(|(path, text)| OutputFile {
            path,
            kind: OutputKind::Scene,
            bytes: text.into(),
        })
        .collect();
    Ok(output::write(&files, inputs)?)
}

/// The file beside another whose name it carries on: `block-sweep.toml` and the folder `block-cases` beside `block.toml`.
fn beside(scene: &Path, ending: &str) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    scene.with_file_name(format!("{stem}-{ending}"))
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// The mesh file, MSH 4.1, or 2.2 in text
    pub mesh: PathBuf,
    /// Write a scene for it; an existing file is not overwritten
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `inspect`: prints the figures, draws the mesh and writes the scene.
pub(super) fn inspect(arguments: &InspectArguments, output: &Output) -> Result<Exit, StageError> {
    let mesh = MeshInspection::read(&arguments.mesh)?;
    let inputs = Inputs::of([arguments.mesh.clone()]);
    let usual = folder_here(&arguments.mesh, "mesh");
    let figures = &arguments.figures;
    let pictures = figures.claim(&usual, Drawing::Mesh, inputs.clone())?;
    if let Some(scene) = &arguments.scene {
        let text = match mesh.mesh.bodies.is_empty() {
            true => scene_for(&mesh, arguments),
            false => scene_of_bodies(&mesh, arguments),
        };
        write(vec![(scene.clone(), text)], &inputs)?;
    }
    let title = arguments.mesh.file_name().unwrap_or_default();
    let files = match &pictures {
        Some(pictures) => draw_mesh(pictures, &title.to_string_lossy(), &mesh)?,
        None => Vec::new(),
    };
    terminal::print(
        output,
        || report::mesh::json(&mesh, &files),
        || report::mesh::text(&mesh),
    );
    for file in files {
        say(output, &format!("figure    {}", file.display()));
    }
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

/// A scene of bodies of one file: held at the face that looks down most, pressed at the one that looks up most, touching where faces meet.
fn scene_of_bodies(mesh: &MeshInspection, arguments: &InspectArguments) -> String {
    let title = arguments.mesh.file_name().unwrap_or_default();
    let file = quoted(&named_in_scene(arguments).to_string_lossy());
    let bodies = mesh.mesh.bodies.iter().zip(&mesh.parts);
    let bodies = bodies.map(|(body, (volume, ..))| {
        let (name, volume) = (quoted(&body.name), quoted(volume));
        format!("[[body]]\nname = {name}\nelement = \"P2\"\ngmsh = {{ file = {file}, volume = {volume} }}\n\n")
    });
    let pairs = mesh.meeting_faces();
    let contacts = pairs.iter().map(|pair| {
        let pair = pair.map(quoted).join(", ");
        format!("\n[[contact]]\nbetween = [{pair}]\n# glued = true                              # bonded; else they may part and slide\n")
    });
    let name = |face: Option<&FaceInspection>| quoted(face.map_or("", |face| &face.name));
    format!(
        include_str!("scenes/bodies.toml.in"),
        title = quoted(&title.to_string_lossy()),
        bodies = bodies.collect::<String>(),
        contacts = contacts.collect::<String>(),
        held = name(facing(mesh, -1.0, &pairs)),
        moved = name(facing(mesh, 1.0, &pairs)),
        down = -(mesh.bounds[1][2] - mesh.bounds[0][2]) / 1000.0,
    )
}

/// The face that looks up most, or with −1 down most; of equal ones a curved face comes first where it may touch, a flat one where it
/// is held. What the file has no name for comes last.
fn facing<'a>(
    mesh: &'a MeshInspection,
    up: f64,
    except: &[[&str; 2]],
) -> Option<&'a FaceInspection> {
    let rank = |face: &FaceInspection| {
        let [x, y, z] = face.mean_normal;
        let length = x.hypot(y).hypot(z);
        // Faces whose mean normal is shorter than this look every way.
        let height = if length > 0.1 { up * z / length } else { 0.0 };
        let is_named = !face.name.ends_with("unnamed");
        let first = if face.normal.is_some() { up } else { -up };
        // Rounding of a mesh file does not rank faces.
        [f64::from(u8::from(is_named)), (1e6 * height).round(), first]
    };
    let faces = mesh.faces.iter();
    let free = faces.filter(|face| !except.as_flattened().contains(&&*face.name));
    let ranked = free.map(|face| (rank(face), face));
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
    let lowest = facing(mesh, -1.0, &[]);
    let name = |face: Option<&FaceInspection>| face.map_or_else(String::new, |f| f.name.clone());
    let [low, high] = mesh.bounds;
    let extent = [0, 1, 2].map(|c| units::rounded(high[c] - low[c], 6).to_string());
    let size = low
        .iter()
        .chain(&high)
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    // To four digits of the size.
    let decimals = (4.0 - size.log10().ceil()).clamp(0.0, 15.0) as usize;
    let rounded = |x: f64| format!("{x:.decimals$}").parse::<f64>().unwrap_or(x) + 0.0;
    let radius = rounded((high[0] - low[0]).max(high[1] - low[1]));
    let is_curved = lowest.is_some_and(|face| face.normal.is_none());
    let file = arguments.mesh.file_name().unwrap_or_default();
    let scene = MeshScene {
        title: file.to_string_lossy().into_owned(),
        file: named_in_scene(arguments).to_string_lossy().into_owned(),
        held: name(facing(mesh, 1.0, &[])),
        touching: name(lowest),
        height: high[2] - low[2],
        plane: is_curved.then_some(low[2]),
        ball: (
            [
                rounded(low[0].midpoint(high[0])),
                rounded(low[1].midpoint(high[1])),
                rounded(low[2] - radius),
            ],
            radius,
        ),
        found: Some((
            extent.join(" x "),
            mesh.faces.iter().map(|face| face.name.clone()).collect(),
            mesh.parts.iter().map(|(name, ..)| name.clone()).collect(),
        )),
    };
    scene.text()
}
