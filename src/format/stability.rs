//! `/stability`: how far the answers of hard cases can be trusted, one row a case.

use contact3d::{
    linalg::Precision,
    robustness::{Check, CrossCheck, CrossCheckResult, Invariance, Level},
    solver::Status,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Layout, StoreError, StoredEnum, stored_enum,
};
use units::{Dimension, Units};

use super::{axes, columns::Columns, outcome::StoredStatus};

/// How far the answers of hard cases can be trusted, in a file of its own.
pub const GROUP: Group = Group::new("stability", "stability");

stored_enum! {
    /// Precision of a factor, as stored.
    enum StoredPrecision as "precision" {
        Double = 0 => "double",
        Single = 1 => "single",
    }
}

stored_enum! {
    /// How a case came out, as stored.
    enum StoredLevel as "verdict" {
        Holds = 0 => "holds",
        AtRounding = 1 => "floor",
        Fails = 2 => "fails",
        Refused = 3 => "refused",
    }
}

/// Every dataset of a stability file.
pub const STABILITY_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe stability",
    linked_filetype: "contact3d-pipe stability stage",
    format_version: [1, 2],
    sealed_since: [1, 2],
    creator: super::LAYOUT.creator,
    units: super::LAYOUT.units,
    groups: &[GROUP],
    tables: &[TABLE],
    extents: &[("n_cases", "cases in the order of the suite")],
};

const NAME: &str = "/stability/name";
const FAMILY: &str = "/stability/family";
const SHOWS: &str = "/stability/shows";
const SCENE: &str = "/stability/scene";
const VERDICT: &str = "/stability/verdict";
const FINDINGS: &str = "/stability/findings";
const OPEN: &str = "/stability/open";
const STATUS: &str = "/stability/status";
const UNKNOWNS: &str = "/stability/unknowns";
const MULTIPLIERS: &str = "/stability/multipliers";
const FACTOR_PRECISION: &str = "/stability/factor_precision";
const NEWTON_STEPS: &str = "/stability/newton_steps";
const OUTER_STEPS: &str = "/stability/outer_steps";
const ZONE_COUNTS: &str = "/stability/zone_counts";
const ASKED: &str = "/stability/asked";
const ACCURACY: &str = "/stability/accuracy";
const CERTIFICATE: &str = "/stability/certificate";
const CERTIFICATE_ROUNDING: &str = "/stability/certificate_floor";
const STIFFNESS_CONDITION: &str = "/stability/stiffness_condition";
const DUAL_EIGENVALUES: &str = "/stability/dual_eigenvalues";
const DUAL_BY_AREA: &str = "/stability/dual_eigenvalues_by_area";
const DETERMINANT: &str = "/stability/determinant_sign";
const SENSITIVITY: &str = "/stability/sensitivity";
const SPECTRAL_RADIUS: &str = "/stability/spectral_radius";
const FOLD_DISTANCE: &str = "/stability/fold_distance";
const MULTIPLIER_ROUNDING: &str = "/stability/multiplier_floor";
const CROSS_CHECK_STATUS: &str = "/stability/rival_status";
const CROSS_CHECK_STEPS: &str = "/stability/rival_steps";
const CROSS_CHECK_RESIDUAL: &str = "/stability/rival_residual";
const DISAGREEMENT: &str = "/stability/disagreement";
const VARIATION: &str = "/stability/variation";
const SECONDS: &str = "/stability/seconds";

const CASES: &[Extent] = &[Named("n_cases")];
const PAIRS: &[Extent] = &[Named("n_cases"), Fixed(2)];
const ZONES: &[Extent] = &[Named("n_cases"), axes::ZONES];
const CROSS_CHECKS: &[Extent] = &[Named("n_cases"), Fixed(4)];
const CHANGES: &[Extent] = &[Named("n_cases"), Fixed(7)];

#[rustfmt::skip]
const TABLE: &[DatasetSpec] = &[
    GROUP.row(NAME, Kind::Text, CASES, Dimension::Number, "Name of the case."),
    GROUP.row(FAMILY, Kind::Text, CASES, Dimension::Number, "What the case is one of."),
    GROUP.row(SHOWS, Kind::Text, CASES, Dimension::Number, "What the case shows, and what is expected."),
    GROUP.row(SCENE, Kind::Text, CASES, Dimension::Number, "The scene as TOML."),
    GROUP.row(VERDICT, Kind::Enum(StoredLevel::SPEC), CASES, Dimension::Number, "holds: to 1e-10 or to the bit; floor: to what rounding allows; fails; refused: no discrete problem."),
    GROUP.row(FINDINGS, Kind::Text, CASES, Dimension::Number, "What is to be said about the verdict, else empty."),
    GROUP.row(OPEN, Kind::Text, CASES, Dimension::Number, "Why the suite expects the case to fail, else empty."),
    GROUP.row(STATUS, Kind::Enum(StoredStatus::SPEC), CASES, Dimension::Number, "How the solve ended; numerical_error for a refused case."),
    GROUP.row(UNKNOWNS, Kind::I64, CASES, Dimension::Number, "Free degrees of freedom; 0 in this and other counts of a refused case."),
    GROUP.row(MULTIPLIERS, Kind::I64, CASES, Dimension::Number, "Multipliers."),
    GROUP.row(FACTOR_PRECISION, Kind::Enum(StoredPrecision::SPEC), CASES, Dimension::Number, "Precision of the factor that the case took; double for a refused case."),
    GROUP.row(NEWTON_STEPS, Kind::I64, CASES, Dimension::Number, "Steps of Newton's method."),
    GROUP.row(OUTER_STEPS, Kind::I64, CASES, Dimension::Number, "Steps of successive approximations."),
    GROUP.row(ZONE_COUNTS, Kind::I64, ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes."),
    GROUP.row(ASKED, Kind::F64, CASES, Dimension::Number, "Accuracy that was asked for; NaN in this and other measures of a refused case."),
    GROUP.row(ACCURACY, Kind::F64, CASES, Dimension::Number, "Accuracy that the solver says it reached."),
    GROUP.row(CERTIFICATE, Kind::F64, CASES, Dimension::Number, "Largest figure of the certificate."),
    GROUP.row(CERTIFICATE_ROUNDING, Kind::F64, CASES, Dimension::Number, "Size of the certificate's figures at the best double-precision answer."),
    GROUP.row(STIFFNESS_CONDITION, Kind::F64, CASES, Dimension::Number, "Condition number of A scaled to the diagonal 1."),
    GROUP.row(DUAL_EIGENVALUES, Kind::F64, PAIRS, Dimension::DUAL, "Smallest and largest eigenvalue of S without its empty rows."),
    GROUP.row(DUAL_BY_AREA, Kind::F64, PAIRS, Dimension::COMPLIANCE, "The same of S scaled by the areas of the panes."),
    GROUP.row(DETERMINANT, Kind::I64, CASES, Dimension::Number, "Sign of the determinant of Newton's matrix at the answer.").symbol("sign det R'"),
    GROUP.row(SENSITIVITY, Kind::F64, CASES, Dimension::Number, "Norm of the inverse of Newton's matrix at the answer."),
    GROUP.row(SPECTRAL_RADIUS, Kind::F64, CASES, Dimension::Number, "Spectral radius of the derivative of the mapping Psi at the answer: successive approximations converge to it from nearby where it is below 1; 0 without Coulomb friction.").symbol("rho(Psi')"),
    GROUP.row(FOLD_DISTANCE, Kind::F64, CASES, Dimension::Number, "Least |1 - mu| over the eigenvalues mu of that derivative: 0 where Newton's matrix is singular, as in a fold where two solutions meet; 1 without Coulomb friction.").symbol("min |1 - mu|"),
    GROUP.row(MULTIPLIER_ROUNDING, Kind::F64, CASES, Dimension::Number, "Relative error of the multipliers that rounding alone makes."),
    GROUP.row(CROSS_CHECK_STATUS, Kind::Enum(StoredStatus::SPEC), CROSS_CHECKS, Dimension::Number, "How Newton, the fixed point with Newton, that with GPCG, and the averaged fixed point ended; numerical_error where not run."),
    GROUP.row(CROSS_CHECK_STEPS, Kind::I64, CROSS_CHECKS, Dimension::Number, "Their steps; 0 where not run."),
    GROUP.row(CROSS_CHECK_RESIDUAL, Kind::F64, CROSS_CHECKS, Dimension::Number, "Residuals of the natural map at their answers, relative to the multipliers; NaN where not run."),
    GROUP.row(DISAGREEMENT, Kind::F64, CROSS_CHECKS, Dimension::Number, "Relative difference of their multipliers to the answer; NaN where not run."),
    GROUP.row(VARIATION, Kind::F64, CHANGES, Dimension::Number, "Relative difference of the multipliers after a change of units by powers of two, of decimal units, of loads, of node numbers, of threads, in a mirror, with exchanged axes; NaN where not applicable."),
    GROUP.row(SECONDS, Kind::F64, CASES, Dimension::Time, "Wall-clock time of assembly and solve.").volatile(),
];

/// One case of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityRow {
    /// Name of the case.
    pub name: String,
    /// What it is one of.
    pub family: String,
    /// What it shows and what is expected.
    pub shows: String,
    /// The scene as TOML.
    pub scene: String,
    /// The units it names; the same in all rows of a table.
    pub units: Units,
    /// Why it is expected to fail; empty when it is not.
    pub open: String,
    /// What came of it, or why there is no discrete problem.
    pub outcome: Result<Check, String>,
}

impl StabilityRow {
    /// The verdict as a word; `refused` without a discrete problem.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match &self.outcome {
            Ok(check) => check.verdict().level.word(),
            Err(_) => "refused",
        }
    }

    /// What is to be said about the verdict.
    #[must_use]
    pub fn findings(&self) -> String {
        match &self.outcome {
            Ok(check) => check.verdict().findings.join("; "),
            Err(reason) => reason.clone(),
        }
    }

    fn stored_level(&self) -> StoredLevel {
        match &self.outcome {
            Err(_) => StoredLevel::Refused,
            Ok(check) => match check.verdict().level {
                Level::Holds => StoredLevel::Holds,
                Level::AtRounding => StoredLevel::AtRounding,
                Level::Fails => StoredLevel::Fails,
            },
        }
    }
}

/// Writes the table.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, rows: &[StabilityRow]) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, rows);
    columns.texts(NAME, |r| &r.name)?;
    columns.texts(FAMILY, |r| &r.family)?;
    columns.texts(SHOWS, |r| &r.shows)?;
    columns.texts(SCENE, |r| &r.scene)?;
    columns.texts(OPEN, |r| &r.open)?;
    columns.texts(FINDINGS, StabilityRow::findings)?;
    columns.members(VERDICT, StabilityRow::stored_level)?;
    let checks: Vec<Option<&Check>> = rows.iter().map(|r| r.outcome.as_ref().ok()).collect();
    let mut columns = Columns::new(writer, &checks);
    write_statuses(&mut columns)?;
    write_counts(&mut columns)?;
    write_measures(&mut columns)
}

/// Columns of what was checked; `None` where there is no discrete problem.
type Checks<'a, 'w, 'c> = Columns<'a, 'w, Option<&'c Check>>;

fn write_statuses(columns: &mut Checks<'_, '_, '_>) -> Result<(), StoreError> {
    let stored =
        |status: Option<Status>| StoredStatus::from(status.unwrap_or(Status::NumericalError));
    columns.members(STATUS, |c| stored(c.map(|c| c.status)))?;
    columns.members(FACTOR_PRECISION, |c| match c.map(|c| c.precision) {
        Some(Precision::Single) => StoredPrecision::Single,
        Some(Precision::Double) | None => StoredPrecision::Double,
    })?;
    columns.member_vectors(CROSS_CHECK_STATUS, |c| {
        CrossCheck::ALL.map(|cross_check| {
            let result = c.and_then(|c| c.cross_check(cross_check));
            stored(result.map(|result| result.status))
        })
    })
}

fn write_counts(columns: &mut Checks<'_, '_, '_>) -> Result<(), StoreError> {
    columns.counts(UNKNOWNS, |c| c.map_or(0, |c| c.n_free))?;
    columns.counts(MULTIPLIERS, |c| c.map_or(0, |c| c.n_multipliers))?;
    columns.counts(NEWTON_STEPS, |c| c.map_or(0, |c| c.steps[0]))?;
    columns.counts(OUTER_STEPS, |c| c.map_or(0, |c| c.steps[1]))?;
    columns.numbers(DETERMINANT, |c| {
        c.map_or(0, |c| i64::from(c.linearisation.determinant))
    })?;
    columns.vectors(ZONE_COUNTS, |c| {
        c.map_or([0; 3], |c| c.zones.map(|z| z as i64))
    })?;
    columns.vectors(CROSS_CHECK_STEPS, |c| {
        let steps =
            |c: &Check, cross_check| c.cross_check(cross_check).map_or(0, |r| r.steps as i64);
        CrossCheck::ALL.map(|cross_check| c.map_or(0, |c| steps(c, cross_check)))
    })
}

fn write_measures(columns: &mut Checks<'_, '_, '_>) -> Result<(), StoreError> {
    type Measure = fn(&Check) -> f64;
    let measures: [(&str, Measure); 10] = [
        (ASKED, |c| c.asked),
        (ACCURACY, |c| c.accuracy),
        (CERTIFICATE, |c| c.certificate),
        (CERTIFICATE_ROUNDING, |c| c.rounding_bound.certificate),
        (STIFFNESS_CONDITION, |c| c.conditioning.stiffness),
        (SENSITIVITY, |c| c.linearisation.sensitivity),
        (SPECTRAL_RADIUS, |c| c.linearisation.contraction),
        (FOLD_DISTANCE, |c| c.linearisation.fold_distance),
        (MULTIPLIER_ROUNDING, |c| c.rounding_bound.multiplier),
        (SECONDS, |c| c.seconds),
    ];
    for (path, measure) in measures {
        columns.numbers(path, |c| c.map_or(f64::NAN, measure))?;
    }
    columns.vectors(DUAL_EIGENVALUES, |c| {
        c.map_or([f64::NAN; 2], |c| {
            [c.conditioning.dual.smallest, c.conditioning.dual.largest]
        })
    })?;
    columns.vectors(DUAL_BY_AREA, |c| {
        let spectrum = c.map(|c| c.conditioning.dual_by_area);
        spectrum.map_or([f64::NAN; 2], |s| [s.smallest, s.largest])
    })?;
    columns.vectors(CROSS_CHECK_RESIDUAL, |c| {
        c.map_or([f64::NAN; 4], |c| cross_checks(c, |r| r.residual))
    })?;
    columns.vectors(DISAGREEMENT, |c| {
        c.map_or([f64::NAN; 4], |c| cross_checks(c, |r| r.disagreement))
    })?;
    columns.vectors(VARIATION, |c| c.map_or([f64::NAN; 7], variations))
}

fn cross_checks(check: &Check, measure: fn(&CrossCheckResult) -> f64) -> [f64; 4] {
    let of = |cross_check| check.cross_check(cross_check).map_or(f64::NAN, measure);
    CrossCheck::ALL.map(of)
}

fn variations(check: &Check) -> [f64; 7] {
    let of = |invariance: Invariance| {
        let mut results = check.invariances.iter();
        let found = results.find(|result| result.invariance == invariance);
        found.map_or(f64::NAN, |result| result.difference)
    };
    Invariance::ALL.map(of)
}
