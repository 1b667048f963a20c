//! The theory's section of the report.

use contact3d::{scene::Scene, theory::TheoryLevel};
use plots::html::{Part, Section, Table};
use runfile::Reader;

use super::theory_charts::{constants, scaled, thresholds};
use crate::{
    format,
    pipeline::{StageError, accuracy_input},
};

/// What a run file holds of the theory; `None` without it.
pub(super) fn section(reader: &Reader, scene: &Scene) -> Result<Option<Section>, StageError> {
    let Some(stored) = reader.whole_group(format::THEORY)? else {
        return Ok(None);
    };
    let theory = format::read_theory(reader)?;
    let mut parts = Vec::new();
    if stored.record.input_digest != accuracy_input(scene) {
        parts.push(Part::Warning(
            "Measured for another scene than the one above; run `theory` again.".into(),
        ));
    }
    parts.push(Part::Advice(theory.findings().to_string()));
    for chart in [
        thresholds(&theory, stored.units),
        scaled(&theory),
        constants(&theory, stored.units),
    ] {
        parts.push(Part::Figure(chart.figure().svg()));
    }
    parts.push(Part::Table(truth(&theory.levels)));
    Ok(Some(Section {
        name: "theory",
        heading: "The theory, measured".into(),
        parts,
    }))
}

fn truth(levels: &[TheoryLevel]) -> Table {
    let reached =
        |scale: Option<f64>| scale.map_or("none up to 1e6".to_owned(), |t| format!("{t:.4}"));
    let rows = levels.iter().map(|level| {
        let local = level.local.as_ref();
        vec![
            level.n_div.to_string(),
            level.n_free.to_string(),
            format!("{:.3e}", level.norms[1].bound.weighted),
            format!("{:.3e}", level.norms[1].bound.sharp),
            local.map_or("-".into(), |l| format!("{:.5}", l.parts[1].weighted())),
            local.map_or("-".into(), |l| format!("{:.5}", l.spectral_radius)),
            format!("{:.5}", level.observed.rate),
            format!("{:.3e}", level.thresholds.weighted[1]),
            reached(level.thresholds.norm[1]),
            reached(level.thresholds.spectral_radius),
            reached(level.thresholds.singular),
            level.status.word().to_owned(),
        ]
    });
    let head = [
        "n_div",
        "unknowns",
        "bound q",
        "bound q, composed",
        "norm of the derivative",
        "spectral radius",
        "observed rate",
        "t where q = 1",
        "t where the norm is 1",
        "t where the radius is 1",
        "t where det R\u{2032} = 0",
        "status",
    ];
    Table {
        caption: "Energy norm, best weight between slip and pressure; t scales the law of friction"
            .into(),
        head: head.map(str::to_owned).into(),
        rows: rows.collect(),
    }
}
