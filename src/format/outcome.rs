//! How a solve ended, as stored.

use contact3d::solver::{SolvedBy, Status};
use runfile::{Reader, StoredEnum};

use super::{
    FormatError,
    enumeration::{read_member, stored_as},
    history,
    load_history::TIME,
    read_index_vec, read_scalar,
    solve::{ACCURACY, APPLICATIONS, METHOD, STATUS},
};

stored_as! {
    /// How a solve ended, as stored.
    pub(super) StoredStatus of Status as "status" {
        Converged = 0 => "converged",
        MaxOuterSteps = 1 => "max_outer_steps",
        MaxInnerApplications = 2 => "max_inner_actions",
        NumericalError = 3 => "numerical_error",
        RoundingLimit = 4 => "rounding_limit",
        MaxNewtonSteps = 5 => "max_newton_steps",
        Cycling = 6 => "cycling",
        Stopped = 7 => "stopped",
        Inaccurate = 8 => "inaccurate",
        NoEquilibrium = 9 => "no_equilibrium",
    }
}

stored_as! {
    /// Which algorithm gave the answer, as stored.
    pub(super) StoredMethod of SolvedBy as "method" {
        FixedPoint = 0 => "fixed_point",
        Newton = 1 => "newton",
        Minimisation = 2 => "minimisation",
        Direct = 3 => "direct",
    }
}

/// How a solve ended, in words and numbers.
#[derive(Debug)]
pub struct OutcomeWords {
    /// How it ended.
    pub status: Status,
    /// Which algorithm gave the answer.
    pub method: &'static str,
    /// Outer steps, Newton steps, applications.
    pub counts: [usize; 3],
    /// Relative error of the multipliers.
    pub accuracy: f64,
    /// Increments of a load history that were solved, the last one well or not; 0 without a history.
    pub increments: usize,
}

/// Reads how a solve ended, without its fields.
///
/// # Errors
/// Altered or damaged values.
pub fn read_outcome(reader: &Reader) -> Result<OutcomeWords, FormatError> {
    let applications = read_index_vec(reader, APPLICATIONS)?.first().copied();
    Ok(OutcomeWords {
        status: read_member::<StoredStatus>(reader, STATUS)?.into(),
        method: word(read_member::<StoredMethod>(reader, METHOD)?),
        counts: [
            history::read_outer(reader, &history::HISTORY)?.len(),
            history::read_newton(reader)?.len(),
            applications.unwrap_or(0),
        ],
        accuracy: read_scalar(reader, ACCURACY)?,
        increments: match reader.has(TIME) {
            true => reader.read_vec::<f64>(TIME)?.len(),
            false => 0,
        },
    })
}

/// The name of a member in the file.
fn word<E: StoredEnum>(member: E) -> &'static str {
    let mut members = E::SPEC.members.iter();
    let found = members.find(|(_, code)| *code == member.code());
    found.map_or("", |(name, _)| name)
}
