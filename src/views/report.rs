//! The report of a run file or of a sweep's folder.

use std::path::Path;

use contact3d::{
    history::StepRecord,
    scene::{Scene, SceneFile, shown, shown_lines},
    solver::Solution,
};
use plots::html::{Page, Part, Section};
use runfile::{Reader, timestamp};

use super::{
    accuracy_tables,
    charts::{convergence, history, ways_against_seconds, ways_against_unknowns, work_precision},
    history_charts,
    picture::{self, Drawn},
    report_tables as tables, sweep_report, theory_report,
};
use crate::{
    format::{self, LAYOUT},
    pipeline::{Freshness, StageError, StageState, accuracy_input, read_results, states},
};

/// The report as one HTML page. Reads only and takes no lock.
///
/// # Errors
/// A file or folder that cannot be read.
pub fn report(path: &Path) -> Result<String, StageError> {
    let page = if path.is_dir() {
        sweep_report::page(path)?
    } else {
        file_page(path)?
    };
    Ok(page.html())
}

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

fn file_page(path: &Path) -> Result<Page, StageError> {
    let reader = Reader::open(path, LAYOUT)?;
    let input = format::read_scene(&reader, path)?;
    let scene = &input.scene;
    let states = states(&reader, scene);
    let mut sections = vec![scene_section(scene)];
    let is_fresh = states.iter().all(|s| s.freshness == Freshness::Fresh);
    if is_fresh {
        sections.extend(result_sections(&reader, &input)?);
    }
    sections.push(stages_section(&reader, &states)?);
    sections.extend(accuracy_section(&reader, scene)?);
    sections.extend(theory_report::section(&reader, scene)?);
    Ok(Page {
        title: scene.shown_title(),
        subtitle: shown(scene.reference.as_deref().unwrap_or_default()),
        footer: footer(path),
        sections,
    })
}

fn scene_section(scene: &Scene) -> Section {
    Section {
        name: "scene",
        heading: "Scene".into(),
        parts: vec![
            Part::Table(tables::features(scene)),
            Part::Listing(
                "the scene, every default written out".into(),
                shown_lines(&format::scene_text(scene)),
            ),
        ],
    }
}

/// Results, six panels, convergence and certificate of a file whose stages are all fresh.
fn result_sections(reader: &Reader, input: &SceneFile) -> Result<Vec<Section>, StageError> {
    let results = read_results(reader.path(), input)?;
    let (mesh, solution, report) = (results.mesh(), results.solution(), results.report());
    let scene = &input.scene;
    let mut sections = vec![Section {
        name: "results",
        heading: "Results".into(),
        parts: vec![
            Part::Table(tables::results(scene.units, mesh, solution, report)),
            Part::Table(tables::forces(scene.units, report)),
        ],
    }];
    if let Some(faces) = tables::faces(scene, report) {
        sections[0].parts.push(Part::Table(faces));
    }
    if let Some(flaw) = report.flaw.filter(|_| report.is_broken()) {
        let warning = format!("The solve failed and nothing is drawn: {flaw}.");
        sections[0].parts.insert(0, Part::Warning(warning));
        return Ok(sections);
    }
    let frame = results.interface().map(|interface| &interface.frame);
    let refuse = |source| StageError::Figure {
        file: reader.path().to_owned(),
        source,
    };
    let drawn = |face| Drawn {
        scene,
        mesh,
        frame,
        report,
        face,
    };
    let error = picture::error_page(&drawn(0)).map_err(refuse)?;
    let mut parts = vec![Part::Text("Point at a pane to see its values.".into())];
    for face in 0..scene.contacts.len().max(1) {
        let page = drawn(face).page().map_err(refuse)?;
        parts.push(Part::Figure(page.svg()));
    }
    sections.push(Section {
        name: "panels",
        heading: "Contact face and body".into(),
        parts,
    });
    sections.push(Section {
        name: "discretisation-error",
        heading: "Where the discretisation error sits".into(),
        parts: vec![
            Part::Text(
                "An estimate, not a bound: the error of the mesh in the energy norm, around each node.".into(),
            ),
            Part::Figure(error.svg()),
        ],
    });
    sections.extend(load_history_section(scene, results.increments()));
    sections.extend(history_section(solution));
    sections.push(Section {
        name: "certificate",
        heading: "Certificate".into(),
        parts: vec![
            Part::Text("Each is dimensionless and zero for the exact discrete solution.".into()),
            Part::Table(tables::certificate(report)),
        ],
    });
    Ok(sections)
}

fn load_history_section(scene: &Scene, records: &[StepRecord]) -> Option<Section> {
    if records.is_empty() {
        return None;
    }
    let charts = history_charts::charts(records, scene.units);
    let mut parts = vec![Part::Text(
        "The other sections show the last increment. Works and dissipation are those of each increment.".into(),
    )];
    parts.extend(charts.map(|(_, chart)| Part::Figure(chart.figure().svg())));
    parts.push(Part::Table(tables::increments(scene, records)));
    Some(Section {
        name: "load-history",
        heading: "Load history".into(),
        parts,
    })
}

fn history_section(solution: &Solution) -> Option<Section> {
    let steps = solution.history.len() + solution.newton.len();
    (steps > 0).then(|| Section {
        name: "convergence",
        heading: "Convergence history".into(),
        parts: vec![Part::Figure(history(solution).figure().svg())],
    })
}

fn stages_section(reader: &Reader, states: &[StageState]) -> Result<Section, StageError> {
    let stale = states.iter().find(|s| s.freshness != Freshness::Fresh);
    let warning = stale.filter(|_| states.iter().any(|s| s.stored.is_some()));
    let mut parts: Vec<Part> = warning
        .map(|state| {
            Part::Warning(format!(
                "Results are left out: {} is needed, but {}.",
                state.stage.word(),
                state.freshness.why()
            ))
        })
        .into_iter()
        .collect();
    parts.push(Part::Table(tables::timings(reader, states)?));
    Ok(Section {
        name: "timings",
        heading: "Stages and timings".into(),
        parts,
    })
}

fn accuracy_section(reader: &Reader, scene: &Scene) -> Result<Option<Section>, StageError> {
    let Some(stored) = reader.whole_group(format::ACCURACY)? else {
        return Ok(None);
    };
    let accuracy = format::read_accuracy(reader)?;
    let mut parts = Vec::new();
    if stored.record.input_digest != accuracy_input(scene) {
        parts.push(Part::Warning(
            "Measured for another scene than the one above; run `accuracy` again.".into(),
        ));
    }
    parts.extend(format::read_advice(reader)?.map(Part::Advice));
    if let Some(ladder) = &accuracy.discretisation {
        parts.push(Part::Figure(convergence(ladder).figure().svg()));
        parts.push(Part::Table(accuracy_tables::levels(ladder, stored.units)));
    }
    if let Some(ways) = &accuracy.ways {
        parts.push(Part::Advice(format!("Cheapest way to {}.", ways.advice())));
        parts.push(Part::Figure(ways_against_seconds(ways).figure().svg()));
        parts.push(Part::Figure(ways_against_unknowns(ways).figure().svg()));
        parts.push(Part::Table(accuracy_tables::ways(ways)));
    }
    if let Some(ladder) = &accuracy.algebraic {
        parts.push(Part::Figure(work_precision(ladder).figure().svg()));
        parts.push(Part::Table(accuracy_tables::entries(ladder)));
    }
    Ok(Some(Section {
        name: "accuracy",
        heading: "What accuracy costs".into(),
        parts,
    }))
}
