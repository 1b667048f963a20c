//! Whether what a file says of its solution follows from its arrays: digests tell only that nothing was changed since they
//! were made.

use std::path::Path;

use contact3d::{
    post::{Certificate, ContactReport},
    scene::SceneFile,
};
use runfile::Reader;

use super::{Freshness, StageError, read_results, states};
use crate::format::{self, LAYOUT, Stage};

/// Difference of two figures of a certificate, each a share of its yardstick, that versions of the program may have by
/// summing in another order; figures of right answers lie below it.
const SUMMED: f64 = 1e-9;

/// The contradictions between the certificate that a file's arrays have, its status, and the certificate it holds, a sentence
/// each. None without a fresh solution.
///
/// # Errors
/// Unreadable datasets.
pub fn contradictions(run_file: &Path) -> Result<Vec<String>, StageError> {
    let reader = Reader::open(run_file, LAYOUT)?;
    if reader.group_record(Stage::Solve.group())?.is_none() {
        return Ok(Vec::new());
    }
    let input: SceneFile = format::read_scene(&reader, run_file)?;
    let states = states(&reader, &input.scene);
    let is_fresh = |upto| {
        let mut stages = states.iter().filter(|state| state.stage <= upto);
        stages.all(|state| state.freshness == Freshness::Fresh)
    };
    if !is_fresh(Stage::Solve) {
        return Ok(Vec::new());
    }
    let results = read_results(run_file, &input)?;
    let report = results.report();
    let mut found: Vec<String> = against_status(&reader, report)?.into_iter().collect();
    if is_fresh(Stage::Post) {
        found.extend(against_stored(&reader, &report.certificate)?);
    }
    let named = |words: String| format!("{}: {words}", run_file.display());
    Ok(found.into_iter().map(named).collect())
}

/// What takes back the claim of a solve whose status says that it is solved.
fn against_status(reader: &Reader, report: &ContactReport) -> Result<Option<String>, StageError> {
    let (stored, _) = format::read_multiplier(reader)?;
    let flaw = report
        .flaw
        .filter(|_| stored.is_solved() && report.is_broken());
    Ok(flaw.map(|flaw| {
        format!(
            "/solve says {}, but its arrays are no solution: {flaw}; run `contact3d-pipe solve` again",
            stored.word()
        )
    }))
}

fn against_stored(reader: &Reader, certificate: &Certificate) -> Result<Vec<String>, StageError> {
    let mut found = Vec::new();
    for (name, value) in certificate.figures() {
        let Some(stored) = format::read_certificate(reader, name)? else {
            continue;
        };
        let fits = (stored - value).abs() <= SUMMED * (1.0 + value.abs());
        if !fits {
            found.push(format!(
                "/post/certificate/{name}: expected {value:.1e}, as the arrays of /solve have it, found {stored:.1e}; run `contact3d-pipe post` again"
            ));
        }
    }
    Ok(found)
}
