//! `inspect`: what a mesh file holds, and a scene for it.

use std::path::PathBuf;

use clap::Args;
use contact3d::mesh::{FaceInspection, MeshInspection};

use super::{
    arguments::Output,
    exit::Exit,
    init,
    terminal::{self, say},
};
use crate::{output::Inputs, pipeline::StageError, report};

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
    if output.json {
        terminal::json(&report::mesh::json(&mesh));
    } else if !output.quiet {
        terminal::result(&report::mesh::text(&mesh));
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

/// Stands for the name of the held face while that of the other, which may be the same text, is put in.
const HELD: &str = "\u{0}";

/// A scene that touches with the flat face that looks down most and is held at the one that looks up most.
fn scene_for(mesh: &MeshInspection, arguments: &InspectArguments) -> String {
    let up = |face: &&FaceInspection| face.normal.map_or(0.0, |normal| normal[2]);
    let of_scene = arguments.scene.as_deref().and_then(std::path::Path::parent);
    let beside = arguments.mesh.parent() == of_scene;
    let file = if beside {
        arguments
            .mesh
            .file_name()
            .map(PathBuf::from)
            .unwrap_or_default()
    } else {
        std::path::absolute(&arguments.mesh).unwrap_or_else(|_| arguments.mesh.clone())
    };
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let by_height = |a: &&FaceInspection, b: &&FaceInspection| up(a).total_cmp(&up(b));
    let lowest = mesh.faces.iter().min_by(by_height);
    let highest = mesh.faces.iter().max_by(by_height);
    let name = |face: Option<&FaceInspection>| quoted(face.map_or("", |face| &face.name));
    let all = |names: Vec<&String>| {
        names
            .into_iter()
            .map(|n| quoted(n))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let faces = all(mesh.faces.iter().map(|face| &face.name).collect());
    let parts = all(mesh.parts.iter().map(|(name, ..)| name).collect());
    init::GMSH
        .replace("\"part.msh\"", &quoted(&file.to_string_lossy()))
        .replace("\"top\"", HELD)
        .replace("\"bottom\"", &name(lowest))
        .replace(HELD, &name(highest))
        .replace(
            "# [[region]] ",
            &format!("# Faces: {faces}. Parts: {parts}.\n# [[region]] "),
        )
}
