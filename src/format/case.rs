//! The main results of a run file, as one row of a sweep's table.

use contact3d::adaptation::AdaptiveStatus;
use runfile::Reader;

use super::{
    FormatError, Stage, adapt,
    case_faces::{self, CaseFace},
    fields::read_value,
    solve::read_outcome,
};

/// The figures of a certificate, as `/post/certificate` names them.
pub const CERTIFICATE: [&str; 7] = [
    "equilibrium",
    "penetration",
    "adhesion",
    "complementarity",
    "friction_bound",
    "slip_direction",
    "fixed_point",
];

/// The main results of a case; NaN for what its scene does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseResults {
    /// How the solve ended.
    pub status: String,
    /// Whether the target for the error is met; `None` without one.
    pub adaptation: Option<AdaptiveStatus>,
    /// Which algorithm gave the answer.
    pub method: String,
    /// Outer steps, Newton steps, applications.
    pub counts: [i64; 3],
    /// Seconds of loads, solve and report.
    pub seconds: f64,
    /// Accuracy of the solve.
    pub accuracy: f64,
    /// Open, sticking, slipping panes.
    pub zones: [i64; 3],
    /// Normal force in N.
    pub normal_force: f64,
    /// Tangential forces in N.
    pub tangential_force: [f64; 2],
    /// Force of the foundation in N.
    pub contact_force: [f64; 3],
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
    /// Largest displacement components in m.
    pub largest_displacement: [f64; 3],
    /// Strain energy in J.
    pub strain_energy: f64,
    /// What happens on each of several contact faces; empty for one.
    pub faces: Vec<CaseFace>,
    /// The certificate's figures, in the order of [`CERTIFICATE`].
    pub certificate: [f64; 7],
    /// Digest of the solution.
    pub solve_digest: String,
}

/// Reads the main results of a finished run file; `None` if it has no report yet.
pub fn read_case(reader: &Reader) -> Result<Option<CaseResults>, FormatError> {
    let whole = |stage: Stage| reader.whole_group(stage.group());
    let Some(load) = whole(Stage::Load)? else {
        return Ok(None);
    };
    let Some(solve) = whole(Stage::Solve)? else {
        return Ok(None);
    };
    let Some(post) = whole(Stage::Post)? else {
        return Ok(None);
    };
    let outcome = read_outcome(reader)?;
    let is_solved = outcome.status.is_solved();
    let mut certificate = [f64::NAN; 7];
    for (value, name) in certificate.iter_mut().zip(CERTIFICATE) {
        [*value] = vector(reader, &format!("/post/certificate/{name}"), false)?;
    }
    let resultant = |name: &str| {
        let [value] = vector(reader, &format!("/post/resultants/{name}"), is_solved)?;
        Ok::<f64, FormatError>(value)
    };
    let mut zones = [-1; 3];
    if reader.has("/post/zone_counts") {
        for (zone, count) in zones
            .iter_mut()
            .zip(read_value::<Vec<usize>>(reader, "/post/zone_counts")?)
        {
            *zone = count as i64;
        }
    }
    Ok(Some(CaseResults {
        status: outcome.status.word().to_owned(),
        adaptation: adapt::read_status(reader)?,
        method: outcome.method.to_owned(),
        counts: outcome.counts.map(|count| count as i64),
        seconds: load.record.seconds + solve.record.seconds + post.record.seconds,
        accuracy: outcome.accuracy,
        zones,
        normal_force: resultant("normal_force")?,
        tangential_force: vector(reader, "/post/resultants/tangential_force", is_solved)?,
        contact_force: vector(reader, "/post/resultants/contact_force", is_solved)?,
        largest_pressure: resultant("largest_pressure")?,
        largest_displacement: vector(reader, "/post/resultants/largest_displacement", is_solved)?,
        strain_energy: resultant("strain_energy")?,
        faces: case_faces::read(reader)?,
        certificate,
        solve_digest: solve.digest,
    }))
}

/// A vector of the report, NaN where the file does not have it; finite numbers alone, where `is_finite`.
fn vector<const N: usize>(
    reader: &Reader,
    path: &str,
    is_finite: bool,
) -> Result<[f64; N], FormatError> {
    let mut vector = [f64::NAN; N];
    if reader.has(path) {
        let values = if is_finite {
            reader.read_finite_f64(path)?
        } else {
            reader.read(path)?
        };
        for (target, value) in vector.iter_mut().zip(values) {
            *target = value;
        }
    }
    Ok(vector)
}
