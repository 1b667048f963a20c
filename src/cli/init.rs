//! `init`: commented scenes to start from.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    output::{self, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
};

/// A block on a foundation, with the further keys of a scene in comments.
const BRICK: &str = include_str!("scenes/brick.toml");

/// Arguments of `init`.
#[derive(Debug, Args)]
pub struct InitArguments {
    /// The scene to write; an existing file is not overwritten
    #[arg(default_value = "scene.toml")]
    pub scene: PathBuf,
    /// What to start from
    #[arg(long, value_enum, default_value_t = SceneKind::Brick)]
    pub kind: SceneKind,
}

/// What a scene starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SceneKind {
    /// A block on a foundation
    Brick,
    /// A part from a mesh file of Gmsh
    Gmsh,
    /// A block that is pressed, pulled and pushed
    History,
    /// A block, and a sweep of two of its keys in a second file
    Sweep,
}

/// `init`: writes the scene, and what belongs to it.
pub(super) fn init(arguments: &InitArguments, printing: &Output) -> Result<Exit, StageError> {
    let scene = &arguments.scene;
    let run = format!(
        "run {} {}",
        scene.display(),
        scene.with_extension("h5").display()
    );
    let (files, next) = match arguments.kind {
        SceneKind::Brick => (vec![(scene.clone(), BRICK.to_owned())], run),
        SceneKind::Gmsh => (vec![(scene.clone(), MeshScene::default().text())], run),
        SceneKind::History => {
            let text = include_str!("scenes/history.toml");
            (vec![(scene.clone(), text.to_owned())], run)
        }
        SceneKind::Sweep => {
            let sweep = beside(scene, "sweep.toml");
            let name = scene.file_name().unwrap_or_default().to_string_lossy();
            let name = quoted(&name);
            let text = format!(include_str!("scenes/sweep.toml.in"), scene = name);
            let out = beside(scene, "cases");
            let next = format!("sweep {} --out {}", sweep.display(), out.display());
            (vec![(scene.clone(), BRICK.to_owned()), (sweep, text)], next)
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
        format!(
            include_str!("scenes/gmsh.toml.in"),
            extent = extent,
            names = names,
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
