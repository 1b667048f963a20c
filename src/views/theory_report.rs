//! The theory's section of the report.

use contact3d::scene::Scene;
use plots::html::{Part, Section};
use runfile::Reader;

use super::theory_charts::{constants, scaled, thresholds};
use crate::{
    format,
    pipeline::{StageError, accuracy_input},
    report::theory::{thresholds as limits, truth},
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
        parts.push(Part::chart(&chart));
    }
    for table in [truth, limits].map(|table| table(&theory, stored.units)) {
        parts.push(Part::Table(table.html()));
    }
    Ok(Some(Section::new("theory", "The theory, measured", parts)))
}
