//! `run`, `mesh`, `assemble`, `solve` and `post`.

use std::{path::Path, time::Instant};

use contact3d::{RunStep, adaptation::RefinedLevels, linalg::Factor};

use super::{
    adaptive,
    arguments::{
        AssemblyFileArguments, EngineArguments, FigureArguments, Output, RunArguments,
        SceneArguments,
    },
    exit::Exit,
    override_scene, progress,
    terminal::{self, detail, say, warn},
};
use crate::{
    format::Stage,
    output::Inputs,
    pipeline::{AssemblyFile, Freshness, Session, StageError, StageTiming, StoreWhen},
    report::{self, SolvedRun},
    views::{PictureFolder, are_drawn, draw_run, drawing_of},
};

/// `run`: every stage that is not fresh, then the results.
pub(super) fn run(
    arguments: &RunArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let began = Instant::now();
    let (scene, inputs) = override_scene::read_for_error(
        &arguments.scene,
        arguments.error,
        arguments.quantity.as_deref(),
    )?;
    inputs.refuse(&arguments.file)?;
    progress::on_run_file(&arguments.file);
    let mut session = Session::with_scene(&arguments.file, scene, threads)?;
    session.keep_assembly(arguments.assembly.choice());
    session.hold_factors_with(arguments.engine.engine.clone());
    let is_done = session.is_done()?
        && are_drawn(
            &arguments.figures.folder(&arguments.file),
            &arguments.file,
            session.scene(),
        );
    let pictures = if is_done {
        None
    } else {
        let drawing = drawing_of(session.scene());
        arguments.figures.beside(&arguments.file, drawing, inputs)?
    };
    if arguments.budget.is_some() && session.scene().adapt.is_none() {
        return Err(override_scene::asks_for_no_error("--budget", "5%"));
    }
    session.all_or_nothing(|session| {
        let (adapted, performed) = if session.scene().adapt.is_some() {
            let (adapted, performed) = adaptive::run(session, arguments.deadline(began), output)?;
            warn(output, &session.warnings()?);
            (Some(adapted), performed)
        } else {
            (None, perform_stale(session, output)?)
        };
        session.store_scene()?;
        if arguments.assembly.choice() == AssemblyFile::SelfContained {
            session.embed_assembly()?;
        }
        let drawn = draw_figures(session, pictures.as_ref(), output)?;
        finish(
            session,
            (&arguments.file, output),
            &performed,
            (adapted.as_ref(), drawn),
        )
    })
}

/// Runs the first stage that is not fresh and all after it.
fn perform_stale(session: &mut Session, output: &Output) -> Result<Vec<StageTiming>, StageError> {
    let mut performed = Vec::new();
    session.admit_problem()?;
    if session.holds_other_levels()? {
        let made = "warning: the mesh that --error had refined is replaced by that of the scene; repeat --error to keep one, or read results by `contact3d-pipe post -v`";
        say(output, made);
    }
    for state in session.states()? {
        if state.stage == Stage::Assemble {
            warn(output, &session.warnings()?);
        }
        if let (None, Freshness::Stale(why)) = (&state.stored, &state.freshness) {
            let made = format!("warning: {} is made again: {why}", state.stage.word());
            say(output, &made);
        }
        if state.is_fresh() && performed.is_empty() {
            detail(output, &format!("{:<9} fresh, kept", state.stage.word()));
        } else {
            let commit = StoreWhen::Deferred;
            performed.push(perform(session, state.stage, commit, output)?);
        }
    }
    Ok(performed)
}

/// `mesh`: the mesh of a scene.
pub(super) fn mesh(
    scene: &SceneArguments,
    file: &Path,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(scene)?;
    inputs.refuse(file)?;
    progress::on_run_file(file);
    let mut session = Session::with_scene(file, scene, threads)?;
    session.all_or_nothing(|session| {
        let performed = perform(session, Stage::Mesh, StoreWhen::Now, output)?;
        warn(output, &session.warnings()?);
        print_stages(output, &[performed]);
        Ok(Exit::Done)
    })
}

/// `assemble`: matrices and factor.
pub(super) fn assemble(
    file: &Path,
    overrides: &[String],
    assembly: &AssemblyFileArguments,
    engine: &EngineArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    progress::on_run_file(file);
    let mut session = Session::open(file, threads)?;
    session.keep_assembly(assembly.choice());
    session.hold_factors_with(engine.engine.clone());
    let scene = override_scene::change_table(session.input(), "assemble", overrides)?;
    session.set_assemble(scene.assemble);
    session.all_or_nothing(|session| {
        let commit = StoreWhen::Manual;
        let assembled = perform(session, Stage::Assemble, commit, output)?;
        let loaded = perform(session, Stage::Load, StoreWhen::Now, output)?;
        print_stages(output, &[assembled, loaded]);
        Ok(Exit::Done)
    })
}

/// `solve`: the contact problem, with settings from the flags.
pub(super) fn solve(
    file: &Path,
    overrides: &[String],
    engine: &EngineArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    progress::on_run_file(file);
    let mut session = Session::open(file, threads)?;
    let scene = override_scene::change_table(session.input(), "solve", overrides)?;
    session.set_solve(scene.solve)?;
    session.hold_factors_with(engine.engine.clone());
    session.all_or_nothing(|session| {
        let performed = perform(session, Stage::Solve, StoreWhen::Now, output)?;
        finish(session, (file, output), &[performed], (None, None))
    })
}

/// `post`: report, pictures, ParaView group.
pub(super) fn post(
    file: &Path,
    figures: &FigureArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    progress::on_run_file(file);
    let mut session = Session::open(file, threads)?;
    let drawing = drawing_of(session.scene());
    let pictures = figures.beside(file, drawing, Inputs::default())?;
    session.all_or_nothing(|session| {
        let performed = perform(session, Stage::Post, StoreWhen::Now, output)?;
        let drawn = draw_figures(session, pictures.as_ref(), output)?;
        finish(session, (file, output), &[performed], (None, drawn))
    })
}

fn perform(
    session: &mut Session,
    stage: Stage,
    commit: StoreWhen,
    output: &Output,
) -> Result<StageTiming, StageError> {
    let spinner = progress::spinner(stage.word(), output);
    let mut observe = |step: RunStep<'_>| progress::show(&spinner, output, step);
    let performed = session.perform(stage, commit, &mut observe);
    spinner.finish_and_clear();
    let performed = performed?;
    detail(output, &progress::stage_line(&performed));
    if let (Stage::Assemble, Some(assembly), Some((estimate, dense))) =
        (stage, session.assembly(), session.operator_estimate())
    {
        let factor = &assembly.factor;
        let line = progress::operator_line(&estimate, dense, factor.precision());
        detail(output, &line);
        if let Factor::Remote(factor) = &**factor {
            detail(output, &progress::engine_line(factor));
        }
    }
    Ok(performed)
}

/// Draws the pictures, and says how many went where.
fn draw_figures(
    session: &mut Session,
    pictures: Option<&PictureFolder>,
    output: &Output,
) -> Result<Option<String>, StageError> {
    let Some(folder) = pictures else {
        return Ok(None);
    };
    let results = session.results()?;
    let report = &results.report;
    if let Some(failure) = report.failed_check.filter(|_| report.is_broken()) {
        say(output, &format!("figures   none: {failure}"));
        return Ok(None);
    }
    let files = draw_run(folder, session.scene(), &results)?;
    let folder = folder.path().display();
    Ok(Some(format!("{} pictures in {folder}", files.len())))
}

/// Prints the results and turns the status into an exit code.
fn finish(
    session: &mut Session,
    (file, output): (&Path, &Output),
    performed: &[StageTiming],
    (adapted, drawn): (Option<&RefinedLevels>, Option<String>),
) -> Result<Exit, StageError> {
    let results = session.results()?;
    let scene = session.scene();
    let target = scene.adapt.map_or(f64::NAN, |adapt| adapt.error);
    let (solution, report, increments) = (&results.solution, &results.report, &results.increments);
    let run = SolvedRun::new(scene, &results).after_levels(adapted.map(|it| it.status));
    let features = || report::features(scene, &run.sizes());
    if output.json {
        let mut json = run.json(session.assembly());
        json["units"] = report::unit_words(scene.units);
        json["effects"] = features().json();
        json["stages"] = report::performed(performed);
        if !increments.is_empty() {
            json["history"] = run.increments().json();
        }
        if let Some(adapted) = adapted {
            json["adaptation"] = report::adaptation_json(scene, adapted, target);
        }
        terminal::json(&json);
    } else if !output.quiet {
        let levels =
            adapted.map(|it| report::adaptation_table(scene, &it.adaptation, target).text());
        let told = if output.verbose {
            format!(
                "model features\n{}results\n{}{}",
                features().text(2, 28),
                run.figures().with(run.certificate()).text(2, 27),
                run.history_text(true),
            )
        } else {
            let mut lines = run.summary();
            let mut files = vec![file.display().to_string()];
            files.extend(session.linked_files());
            files.extend(drawn);
            lines.human_only("files", Some(files.join(", ")));
            let next = || report::next_command(file, performed.last().map(|it| it.stage));
            lines.human_only("next", solution.status.is_solved().then(next));
            lines.text(2, 20) + &run.history_text(false)
        };
        let levels = levels.unwrap_or_default();
        terminal::result(&format!("{}\n{told}{levels}", scene.shown_title()));
    }
    for words in &run.cautions {
        say(output, &format!("warning: {words}"));
    }
    if let Some(failure) = report.failed_check.filter(|_| report.is_broken()) {
        terminal::message(&format!("NOT CONVERGED: {failure}"));
        return Ok(Exit::NotConverged);
    }
    if solution.status.is_success(&scene.solve) {
        let unmet = adapted.and_then(|adapted| adaptive::unmet(adapted, target));
        return Ok(unmet.map_or(Exit::Done, |unmet| {
            terminal::message(&unmet);
            Exit::NotConverged
        }));
    }
    let failed = results
        .increments
        .last()
        .map_or_else(String::new, |record| {
            let [step, number] = [record.increment.step + 1, record.increment.number];
            format!("load step {step}, increment {number}, ends the history: ")
        });
    terminal::message(&(failed + &report::status(solution, scene, results.mesh())));
    Ok(Exit::NotConverged)
}

fn print_stages(output: &Output, performed: &[StageTiming]) {
    if output.json {
        let stages = report::performed(performed);
        terminal::json(&serde_json::json!({ "stages": stages }));
    } else if !output.verbose {
        for stage in performed {
            say(output, &progress::stage_line(stage));
        }
    }
}
