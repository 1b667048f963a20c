//! The meshes on which the theory is measured: nested ones of a brick, or those of files.

use std::path::Path;

use super::{
    TheoryLevel, TheoryProgress, TheorySettings,
    inf_sup::{BrickFaceGram, inf_sup},
    problem::TheoryProblem,
};
use crate::accuracy::{AccuracySettings, brick_n_div, nested_bricks, with_brick};
use contact3d::{
    ProblemError,
    scene::{Brick, BrickFace, GmshFile, Invalid, Scene},
};

/// The meshes of several files, or of the scene's own. They are not nested, so panes of one are not panes of another, and no space of
/// multipliers is measured against a finer mesh.
pub(super) fn levels_of_files(
    scene: &Scene,
    folder: &Path,
    files: &[GmshFile],
    observe: &mut dyn FnMut(TheoryProgress),
) -> Result<Vec<TheoryLevel>, ProblemError> {
    let own = scene.body.mesh_file().cloned();
    let files = match files {
        [] => own.into_iter().collect(),
        files => files.to_vec(),
    };
    let mut levels = Vec::new();
    for file in files {
        observe(TheoryProgress(0));
        let mut changed = scene.clone();
        if let Some(own) = changed.body.mesh_file_mut() {
            *own = file;
        }
        levels.push(TheoryProblem::new(changed, folder)?.measure(0)?);
    }
    levels.sort_by_key(|level| level.n_free);
    Ok(levels)
}

pub(super) fn no_file() -> Invalid {
    Invalid {
        key: "body.gmsh".into(),
        expected: "a body from a Gmsh file, of which other files are finer or coarser meshes"
            .into(),
        found: "a brick".into(),
        help: "leave the mesh files out: the coarser meshes of a brick are made of its own cells"
            .into(),
    }
}

/// The finest mesh first, since the stability of all others is measured against it.
pub(super) fn nested_levels(
    scene: &Scene,
    brick: &Brick,
    settings: &TheorySettings,
    observe: &mut dyn FnMut(TheoryProgress),
) -> Result<Vec<TheoryLevel>, ProblemError> {
    let bricks = theory_bricks(scene, brick, settings)?;
    let contact = scene.contacts.first();
    let on = contact.and_then(|c| BrickFace::named(&c.face));
    let mut finest = None;
    let mut levels = Vec::new();
    for brick in bricks.into_iter().rev() {
        observe(TheoryProgress(brick_n_div(&brick)));
        let problem = TheoryProblem::new(with_brick(scene, &brick), Path::new(""))?;
        let mut level = problem.measure(brick_n_div(&brick))?;
        let here = BrickFaceGram {
            brick: &brick,
            face: &problem.face,
            gram: problem.sobolev_gram(),
        };
        let reference =
            finest
                .as_ref()
                .map(|(brick, face, gram)| BrickFaceGram { brick, face, gram });
        level.inf_sup = on.map_or_else(Vec::new, |on| inf_sup(on, &here, reference.as_ref()));
        levels.push(level);
        if finest.is_none() {
            let (face, gram) = problem.into_sobolev_gram();
            finest = Some((brick, face, gram));
        }
    }
    levels.reverse();
    Ok(levels)
}

/// The nested meshes of a brick, coarse to fine.
///
/// # Errors
/// A finest mesh in which the scene's own is not nested.
pub fn theory_bricks(
    scene: &Scene,
    brick: &Brick,
    settings: &TheorySettings,
) -> Result<Vec<Brick>, ProblemError> {
    let settings = AccuracySettings {
        budget: 0.0,
        coarsest: settings.coarsest.min(brick_n_div(brick)),
        finest: settings.finest.or(Some(brick_n_div(brick))),
        sequences: None,
        memory: None,
    };
    nested_bricks(scene, brick, &settings)
}
