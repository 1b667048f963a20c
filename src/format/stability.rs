//! `/stability`: how far the answers of hard cases can be trusted, one row a case.

use contact3d::{
    robustness::{Check, CrossCheck, CrossCheckResult, Invariance, Level},
    solver::Status,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Layout, StoreError, StoredEnum, stored_enum,
};
use units::{Dimension, Units};

use super::solve::StoredStatus;

/// How far the answers of hard cases can be trusted, in a file of its own.
pub const GROUP: Group = Group::new("stability", "stability");

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
    format_version: [1, 0],
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
const MULTIPLIER_ROUNDING: &str = "/stability/multiplier_floor";
const CROSS_CHECK_STATUS: &str = "/stability/rival_status";
const CROSS_CHECK_STEPS: &str = "/stability/rival_steps";
const CROSS_CHECK_RESIDUAL: &str = "/stability/rival_residual";
const DISAGREEMENT: &str = "/stability/disagreement";
const VARIATION: &str = "/stability/variation";
const SECONDS: &str = "/stability/seconds";

const CASES: &[Extent] = &[Named("n_cases")];
const PAIRS: &[Extent] = &[Named("n_cases"), Fixed(2)];
const ZONES: &[Extent] = &[Named("n_cases"), Fixed(3)];
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
    let n = [rows.len()];
    let texts =
        |text: fn(&StabilityRow) -> String| -> Vec<String> { rows.iter().map(text).collect() };
    type Text = fn(&StabilityRow) -> String;
    let columns: [(&str, Text); 6] = [
        (NAME, |r| r.name.clone()),
        (FAMILY, |r| r.family.clone()),
        (SHOWS, |r| r.shows.clone()),
        (SCENE, |r| r.scene.clone()),
        (OPEN, |r| r.open.clone()),
        (FINDINGS, StabilityRow::findings),
    ];
    for (path, column) in columns {
        let column = texts(column);
        let column: Vec<&str> = column.iter().map(String::as_str).collect();
        writer.write_texts(path, &column)?;
    }
    let levels: Vec<_> = rows.iter().map(StabilityRow::stored_level).collect();
    writer.write_enum(VERDICT, &levels, &n)?;
    let checks: Vec<Option<&Check>> = rows.iter().map(|r| r.outcome.as_ref().ok()).collect();
    let status =
        |status: Option<Status>| StoredStatus::from(status.unwrap_or(Status::NumericalError));
    let statuses: Vec<_> = checks.iter().map(|c| status(c.map(|c| c.status))).collect();
    writer.write_enum(STATUS, &statuses, &n)?;
    let cross_checks: Vec<_> = checks
        .iter()
        .flat_map(|c| {
            CrossCheck::ALL.map(|cross_check| {
                status(c.and_then(|c| c.cross_check(cross_check)).map(|r| r.status))
            })
        })
        .collect();
    writer.write_enum(
        CROSS_CHECK_STATUS,
        &cross_checks,
        &[rows.len(), CrossCheck::ALL.len()],
    )?;
    write_counts(writer, &checks)?;
    write_measures(writer, &checks)
}

fn write_counts(writer: &mut GroupWriter<'_>, checks: &[Option<&Check>]) -> Result<(), StoreError> {
    type Counts = fn(&Check) -> Vec<i64>;
    let columns: [(&str, usize, Counts); 7] = [
        (UNKNOWNS, 1, |c| vec![c.n_free as i64]),
        (MULTIPLIERS, 1, |c| vec![c.n_multipliers as i64]),
        (NEWTON_STEPS, 1, |c| vec![c.steps[0] as i64]),
        (OUTER_STEPS, 1, |c| vec![c.steps[1] as i64]),
        (DETERMINANT, 1, |c| {
            vec![i64::from(c.linearisation.determinant)]
        }),
        (ZONE_COUNTS, 3, |c| c.zones.map(|z| z as i64).to_vec()),
        (CROSS_CHECK_STEPS, 4, |c| {
            let steps = |cross_check| c.cross_check(cross_check).map_or(0, |r| r.steps as i64);
            CrossCheck::ALL.map(steps).to_vec()
        }),
    ];
    for (path, width, of) in columns {
        let values: Vec<i64> = checks
            .iter()
            .flat_map(|check| check.map_or_else(|| vec![0; width], of))
            .collect();
        writer.write(path, &values, &shape(checks.len(), width))?;
    }
    Ok(())
}

fn write_measures(
    writer: &mut GroupWriter<'_>,
    checks: &[Option<&Check>],
) -> Result<(), StoreError> {
    type Measures = fn(&Check) -> Vec<f64>;
    let columns: [(&str, usize, Measures); 13] = [
        (ASKED, 1, |c| vec![c.asked]),
        (ACCURACY, 1, |c| vec![c.accuracy]),
        (CERTIFICATE, 1, |c| vec![c.certificate]),
        (CERTIFICATE_ROUNDING, 1, |c| {
            vec![c.rounding_bound.certificate]
        }),
        (STIFFNESS_CONDITION, 1, |c| vec![c.conditioning.stiffness]),
        (SENSITIVITY, 1, |c| vec![c.linearisation.sensitivity]),
        (MULTIPLIER_ROUNDING, 1, |c| {
            vec![c.rounding_bound.multiplier]
        }),
        (SECONDS, 1, |c| vec![c.seconds]),
        (DUAL_EIGENVALUES, 2, |c| {
            vec![c.conditioning.dual.smallest, c.conditioning.dual.largest]
        }),
        (DUAL_BY_AREA, 2, |c| {
            let spectrum = c.conditioning.dual_by_area;
            vec![spectrum.smallest, spectrum.largest]
        }),
        (CROSS_CHECK_RESIDUAL, 4, |c| cross_checks(c, |r| r.residual)),
        (DISAGREEMENT, 4, |c| cross_checks(c, |r| r.disagreement)),
        (VARIATION, 7, variations),
    ];
    for (path, width, of) in columns {
        let values: Vec<f64> = checks
            .iter()
            .flat_map(|check| check.map_or_else(|| vec![f64::NAN; width], of))
            .collect();
        writer.write(path, &values, &shape(checks.len(), width))?;
    }
    Ok(())
}

fn cross_checks(check: &Check, measure: fn(&CrossCheckResult) -> f64) -> Vec<f64> {
    let of = |cross_check| check.cross_check(cross_check).map_or(f64::NAN, measure);
    CrossCheck::ALL.map(of).to_vec()
}

fn variations(check: &Check) -> Vec<f64> {
    let of = |invariance: Invariance| {
        let mut results = check.invariances.iter();
        let found = results.find(|result| result.invariance == invariance);
        found.map_or(f64::NAN, |result| result.difference)
    };
    Invariance::ALL.map(of).to_vec()
}

fn shape(rows: usize, width: usize) -> Vec<usize> {
    if width == 1 {
        vec![rows]
    } else {
        vec![rows, width]
    }
}
