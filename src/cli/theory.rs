//! `theory`: the constants of HKL section 3 and what successive approximations do, stored, drawn and printed.

use std::path::PathBuf;

use clap::Args;
use contact3d::scene::GmshFile;
use studies::theory::{Theory, TheoryLevel, TheorySettings};

use super::{
    arguments::{FigureArguments, Output, SceneArguments, n_div},
    exit::Exit,
    progress, study, terminal,
};
use crate::{
    pipeline::{StageError, measure_theory},
    report,
    views::{Drawing, draw_theory},
};

/// Arguments of `theory`.
#[derive(Debug, Args)]
pub struct TheoryArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// Smallest n_div of the meshes
    #[arg(long, value_name = "N_DIV", default_value_t = 2, value_parser = n_div)]
    pub coarsest: usize,
    /// n_div of the finest mesh, a multiple of the scene's; by default the scene's
    #[arg(long, value_name = "N_DIV", value_parser = n_div)]
    pub finest: Option<usize>,
    /// A Gmsh file of the scene's body, relative to the scene file; given once for each mesh
    #[arg(long, value_name = "FILE", conflicts_with_all = ["coarsest", "finest"])]
    pub mesh: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `theory`: measures on all meshes, stores, draws, and says what it means.
pub(super) fn theory(
    arguments: &TheoryArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, _, pictures) = study::begin(
        &arguments.scene,
        &arguments.file,
        &arguments.figures,
        Drawing::Theory,
    )?;
    let units = scene.scene.units;
    let unit = scene.scene.body.mesh_file().map_or(1.0, |own| own.unit);
    let mesh = |file: &PathBuf| GmshFile {
        file: file.clone(),
        unit,
        digest: None,
    };
    let settings = TheorySettings {
        coarsest: arguments.coarsest,
        finest: arguments.finest,
        meshes: arguments.mesh.iter().map(mesh).collect(),
    };
    let spinner = progress::spinner("theory", output);
    let measured = measure_theory(&arguments.file, scene, settings, threads, &mut |step| {
        progress::show_study(&spinner, output, step);
    });
    spinner.finish_and_clear();
    let theory = measured?;
    study::finish(
        output,
        pictures.as_ref(),
        units,
        |folder| draw_theory(folder, &theory, units),
        || report::theory::json(&theory, units),
        || report::theory::text(&theory, units),
    )?;
    Ok(judge(&theory))
}

/// Not converged where a mesh has no solution, the derivative of Ψ is singular, the rate is not the spectral radius, or a value of Ψ
/// left the set of Lemma 3.3.
fn judge(theory: &Theory) -> Exit {
    let findings = theory.findings();
    let is_solved = |level: &TheoryLevel| level.status.is_solved() && level.local.is_some();
    let mut problems = Vec::new();
    if !theory.levels.iter().all(is_solved) {
        problems.push("a mesh of the study; its local figures are missing");
    }
    if findings.rates_agree() == Some(false) {
        problems.push("the observed rate, which is not the spectral radius");
    }
    if findings.lemma_fails {
        problems.push("HKL Lemma 3.3, which a value of the mapping contradicts");
    }
    for problem in &problems {
        terminal::message(&format!("NOT CONVERGED: {problem}"));
    }
    Exit::of(problems.is_empty())
}
