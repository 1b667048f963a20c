//! The report of a run file or of a sweep's folder.

use std::path::Path;

use contact3d::{
    history::StepRecord,
    scene::{Scene, escape_control, escape_control_lines},
    solver::Solution,
};
use plots::{
    Picture,
    html::{Page, PagePart, Section},
};
use runfile::{Reader, StoredGroup, timestamp};

use super::{
    body3d,
    charts::{self, convergence, diagrams, history, work_precision},
    history_charts,
    picture::{self, Drawn},
    sweep,
};
use crate::{
    format::{self, LAYOUT, SWEEP_LAYOUT},
    pipeline::{OpenRun, Results, StageError, StageState, read_results, studies::accuracy_input},
    report::{self, FigureTable, Figures, SolvedRun, studies as tables},
};

/// The report as one HTML page, with drawings or, interactive, with the body in 3D and pictures. Reads only and takes no lock.
///
/// # Errors
/// A file or folder that cannot be read, a body in 3D of a sweep.
pub fn report(path: &Path, interactive: bool) -> Result<String, StageError> {
    let page = if path.is_dir() {
        sweep::page(path, interactive)?
    } else {
        file_page(path, interactive)?
    };
    Ok(page.html())
}

/// Widths in pixels of the pictures of a page with the 3D view: of all panels, and of the error.
const PICTURE_WIDTHS: [u32; 2] = [880, 360];

/// The paper that a user of any result cites, beside the program.
const PAPER: &str = "J. Haslinger, R. Kučera, T. Ligurský, J. Comput. Appl. Math. 235 (2011) 3464–3480, \
                     doi:10.1016/j.cam.2011.02.007";

/// The last line of every page: what made it, from what, when, and what to cite.
pub(super) fn footer(path: &Path) -> String {
    format!(
        "{creator}, from {}, {}. Cite {PAPER}, for the problem, and {creator} for the program.",
        path.file_name().unwrap_or_default().to_string_lossy(),
        timestamp(),
        creator = LAYOUT.creator,
    )
}

fn file_page(path: &Path, interactive: bool) -> Result<Page, StageError> {
    let run = match Reader::open(path, LAYOUT) {
        Err(_) if Reader::open(path, SWEEP_LAYOUT).is_ok() => {
            return sweep::page(path.parent().unwrap_or(path), interactive);
        }
        opened => OpenRun::of(opened?, path)?,
    };
    let (reader, scene) = (&run.reader, &run.input.scene);
    let sizes = format::read_sizes(reader, &|stage| run.is_fresh(stage))?;
    let (mut sections, mut warning) = (Vec::new(), None);
    if run.states.iter().all(StageState::is_fresh) {
        let results = read_results(reader, &run.input)?;
        let ended = run.levels.as_ref().map(|(_, status)| *status);
        let solved = SolvedRun::new(scene, &results).after_levels(ended);
        warning = solved.stamp();
        sections = result_sections(path, &solved, &results, interactive)?;
    }
    sections.push(scene_section(scene, &report::features(scene, &sizes)));
    sections.push(stages_section(reader, scene, &run.states)?);
    let studies = [
        ("levels", "Adaptive levels", Ok(levels_parts(&run))),
        ("branches", "Paths of solutions", branches_parts(reader)),
        ("bound", "A bound of the error", bound_parts(reader, scene)),
        (
            "accuracy",
            "What accuracy costs",
            accuracy_parts(reader, scene),
        ),
    ];
    for (name, heading, parts) in studies {
        sections.extend(parts?.map(|parts| Section::new(name, heading, parts)));
    }
    Ok(Page {
        title: scene.shown_title(),
        subtitle: escape_control(scene.reference.as_deref().unwrap_or_default()),
        warning: warning.unwrap_or_default(),
        footer: footer(path),
        sections,
    })
}

fn scene_section(scene: &Scene, features: &Figures) -> Section {
    let listing = PagePart::Listing(
        "the scene, every default written out".into(),
        escape_control_lines(&format::scene_text(scene)),
    );
    Section::new(
        "scene",
        "Scene",
        vec![PagePart::Table(features.html()), listing],
    )
}

/// Pictures, the first screen, details, convergence and certificate of a file whose stages are all fresh.
fn result_sections(
    path: &Path,
    run: &SolvedRun<'_>,
    results: &Results,
    interactive: bool,
) -> Result<Vec<Section>, StageError> {
    let (scene, report) = (run.scene, &results.report);
    let table = |figures: &Figures| PagePart::Table(figures.html());
    if let Some(failure) = report.failed_check.filter(|_| report.is_broken()) {
        let failure = format!("The solve failed and nothing is drawn: {failure}.");
        let parts = vec![PagePart::Warning(failure), table(&run.figures())];
        return Ok(vec![Section::new("results", "Results", parts)]);
    }
    let marks = picture::marks_of(scene, results);
    let drawn = |face| Drawn {
        scene,
        results,
        marks: &marks,
        face,
    };
    let stamp = run.stamp();
    let part = |picture: Picture, name: &str, width| {
        let picture = picture.stamped(stamp.as_deref());
        let png = || {
            picture
                .png(width)
                .map(|png| PagePart::Picture(name.into(), png))
        };
        match interactive {
            false => Ok(PagePart::Figure(picture.svg())),
            true => png().map_err(|source| StageError::Figure {
                file: path.to_owned(),
                source,
            }),
        }
    };
    let mut sections = Vec::new();
    let mut parts = Vec::new();
    if interactive {
        let body = vec![PagePart::Body(body3d::view(scene, results))];
        sections.push(Section::new("view3d", "The body in 3D", body));
    } else {
        parts.push(PagePart::Text("Point at a pane to see its values.".into()));
    }
    let name = "contact face and body, a picture";
    for face in 0..scene.contact_order().len().max(1) {
        parts.push(part(drawn(face).page(), name, PICTURE_WIDTHS[0])?);
    }
    sections.push(Section::new("panels", "Contact face and body", parts));
    let summary = vec![table(&run.summary_with_warnings())];
    sections.push(Section::new("results", "Results", summary));
    let name = "von Mises stress, a picture";
    let stress = part(picture::stress_page(&drawn(0)), name, PICTURE_WIDTHS[1])?;
    sections.push(Section::new("stress", "Von Mises stress", vec![stress]));
    let name = "estimated discretisation error, a picture";
    let error = part(picture::error_page(&drawn(0)), name, PICTURE_WIDTHS[1])?;
    let caution =
        "An estimate, not a bound: the error of the mesh in the energy norm, around each node.";
    let parts = vec![PagePart::Text(caution.into()), error];
    let heading = "Where the discretisation error sits";
    sections.push(Section::new("discretisation-error", heading, parts));
    sections.extend(load_history_section(run, &results.increments));
    let mut parts = vec![table(&run.details()), PagePart::Table(run.forces().html())];
    if !report.faces.is_empty() {
        parts.push(PagePart::Table(run.faces().html()));
    }
    sections.push(Section::new("details", "Details", parts));
    sections.extend(history_section(&results.solution));
    let meaning = "Each is dimensionless and zero for the exact discrete solution.";
    let parts = vec![PagePart::Text(meaning.into()), table(&run.certificate())];
    sections.push(Section::new("certificate", "Certificate", parts));
    Ok(sections)
}

fn load_history_section(run: &SolvedRun<'_>, records: &[StepRecord]) -> Option<Section> {
    if records.is_empty() {
        return None;
    }
    let charts = history_charts::charts(records, run.scene.units);
    let mut parts = vec![PagePart::Text(
        "The other sections show the last increment.".into(),
    )];
    parts.extend(charts.map(|(_, chart)| PagePart::chart(&chart)));
    parts.extend([run.peaks().html(), run.increments().html()].map(PagePart::Table));
    Some(Section::new("load-history", "Load history", parts))
}

fn history_section(solution: &Solution) -> Option<Section> {
    let steps = solution.trace.history.len() + solution.trace.newton.len();
    let parts = || vec![PagePart::chart(&history(solution))];
    (steps > 0).then(|| Section::new("convergence", "Convergence history", parts()))
}

fn stages_section(
    reader: &Reader,
    scene: &Scene,
    states: &[StageState],
) -> Result<Section, StageError> {
    let stale = states.iter().find(|state| !state.is_fresh());
    let warning = stale.filter(|_| states.iter().any(|s| s.stored.is_some()));
    let warning = warning.map(|state| {
        let (stage, why) = (state.stage.word(), state.freshness.why());
        format!("Results are left out: {stage} is needed, but {why}.")
    });
    let mut parts: Vec<PagePart> = warning.map(PagePart::Warning).into_iter().collect();
    let stages = report::stages(reader, scene, states)?;
    parts.push(PagePart::Table(stages.html()));
    Ok(Section::new("timings", "Stages and timings", parts))
}

/// What a section shows of the errors of solvers and meshes; `None` where they were not measured, as in the other sections.
fn accuracy_parts(reader: &Reader, scene: &Scene) -> Result<Option<Vec<PagePart>>, StageError> {
    let Some(stored) = reader.group_record(format::ACCURACY)? else {
        return Ok(None);
    };
    let accuracy = format::read_accuracy(reader)?;
    let mut parts = outdated(&stored, scene, "accuracy");
    parts.extend(format::read_advice(reader)?.map(PagePart::Advice));
    let (study, units) = (&accuracy.discretisation, stored.units);
    parts.push(PagePart::chart(&convergence(study, units)));
    let of_meshes = [
        tables::levels(study, units),
        tables::quantities(study, units),
        tables::limits(study, units),
    ];
    parts.extend(of_meshes.iter().flat_map(table_parts));
    if let Some(study) = &accuracy.algebraic {
        parts.push(PagePart::chart(&work_precision(study)));
        parts.extend(table_parts(&tables::entries(study, stored.units)));
    }
    Ok(Some(parts))
}

/// The levels of an adaptive mesh; `None` where the scene asks for none, or none is stored.
fn levels_parts(run: &OpenRun) -> Option<Vec<PagePart>> {
    let scene = &run.input.scene;
    let (target, (adaptation, _)) = (scene.adapt?.error, run.levels.as_ref()?);
    let charts = charts::adaptation(&adaptation.levels, target);
    let table = report::adaptation_table(scene, adaptation, target);
    let charts = charts.iter().map(PagePart::chart);
    Some(charts.chain(table_parts(&table)).collect())
}

/// The paths of solutions; `None` where none were followed.
fn branches_parts(reader: &Reader) -> Result<Option<Vec<PagePart>>, StageError> {
    let Some(stored) = reader.group_record(format::BRANCHES)? else {
        return Ok(None);
    };
    let branches = format::read_branches(reader)?;
    let diagrams = diagrams(&branches, stored.units).map(|chart| PagePart::chart(&chart));
    let tables = tables::branches_tables(&branches, stored.units);
    let tables = tables.iter().flat_map(table_parts);
    Ok(Some(diagrams.into_iter().chain(tables).collect()))
}

/// The bound of the error; `None` where it was not computed.
fn bound_parts(reader: &Reader, scene: &Scene) -> Result<Option<Vec<PagePart>>, StageError> {
    let Some(stored) = reader.group_record(format::BOUND)? else {
        return Ok(None);
    };
    let bound = format::read_bound(reader)?;
    let mut parts = outdated(&stored, scene, "bound");
    parts.push(PagePart::Table(tables::bound(&bound, scene, None).html()));
    Ok(Some(parts))
}

/// A warning where what a command measured is not of the scene.
fn outdated(stored: &StoredGroup, scene: &Scene, command: &str) -> Vec<PagePart> {
    if stored.record.input_digest == accuracy_input(scene) {
        return Vec::new();
    }
    let again = format!("run `{command}` again");
    let warning = format!("Measured for another scene than the one above; {again}.");
    vec![PagePart::Warning(warning)]
}

/// A table, and what is to be said below it.
fn table_parts(table: &FigureTable) -> Vec<PagePart> {
    let notes = table
        .note
        .lines()
        .map(|line| PagePart::Text(line.to_owned()));
    [PagePart::Table(table.html())]
        .into_iter()
        .chain(notes)
        .collect()
}
