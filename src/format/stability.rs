//! `/stability`: how far the answers of hard cases can be trusted, one row a case.

use contact3d::{linalg::Precision, solver::Status};
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Layout, StoreError,
};
use studies::stability::{Check, CrossCheck, CrossCheckResult, Invariance, Spectrum, VerdictLevel};
use units::{Dimension, Units};

use super::{
    extents,
    fields::{Fields, fields},
    stored::{Absent, stored_as},
};

/// How far the answers of hard cases can be trusted, in a file of its own.
pub const GROUP: Group = Group::new("stability", "stability");

stored_as! {
    /// Precision of a factor, as stored.
    StoredPrecision of Precision as "precision" {
        Double = 0 => "double",
        Single = 1 => "single",
    }
}

stored_as! {
    /// How a case came out, as stored.
    StoredLevel of VerdictLevel as "verdict" {
        Pass = 0 => "pass",
        Limited = 1 => "limited",
        Fail = 2 => "fail",
        Refused = 3 => "refused",
    }
}

/// Every dataset of a stability file.
pub const STABILITY_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe stability",
    linked_filetype: "contact3d-pipe stability stage",
    groups: &[GROUP],
    tables: &[FIELDS.rows],
    extents: &[("n_cases", "cases in the order of the suite")],
    ..super::LAYOUT
};

const CASES: &[Extent] = &[Named("n_cases")];
const PAIRS: &[Extent] = &[Named("n_cases"), Fixed(2)];
const ZONES: &[Extent] = &[Named("n_cases"), extents::ZONES];
const CROSS_CHECKS: &[Extent] = &[Named("n_cases"), Fixed(4)];
const CHANGES: &[Extent] = &[Named("n_cases"), Fixed(5)];

const FIELDS: Fields<StabilityRow> = fields! { StabilityRow => GROUP;
    (name) "/stability/name", CASES, Dimension::Number, "Name of the case.";
    (family) "/stability/family", CASES, Dimension::Number, "What the case is one of.";
    (shows) "/stability/shows", CASES, Dimension::Number, "What the case shows, and what is expected.";
    (scene) "/stability/scene", CASES, Dimension::Number, "The scene as TOML.";
    [StabilityRow::level] "/stability/verdict", CASES, Dimension::Number, "pass: to 1e-10 or to the bit; limited: to what rounding allows or was asked for; fail: neither; refused: no discrete problem.";
    [StabilityRow::findings] "/stability/findings", CASES, Dimension::Number, "What is to be said about the verdict, else empty.";
    (open) "/stability/open", CASES, Dimension::Number, "Why the suite expects the case to fail, else empty.";
    [|row| row.outcome.as_ref().map_or(Status::NumericalError, |check| check.status)] "/stability/status", CASES, Dimension::Number, "How the solve ended; numerical_error for a refused case.";
    [|row| of_check(row, |check| check.n_free)] "/stability/unknowns", CASES, Dimension::Number, "Free degrees of freedom; 0 in this and other counts of a refused case.";
    [|row| of_check(row, |check| check.n_multipliers)] "/stability/multipliers", CASES, Dimension::Number, "Multipliers.";
    [|row| row.outcome.as_ref().map_or(Precision::Double, |check| check.precision)] "/stability/factor_precision", CASES, Dimension::Number, "Precision of the factor that the case took; double for a refused case.";
    [|row| of_check(row, |check| check.steps[0])] "/stability/newton_steps", CASES, Dimension::Number, "Steps of Newton's method.";
    [|row| of_check(row, |check| check.steps[1])] "/stability/outer_steps", CASES, Dimension::Number, "Steps of successive approximations.";
    [|row| of_check(row, |check| check.zones)] "/stability/zone_counts", ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes.";
    [|row| of_check(row, |check| check.asked)] "/stability/asked", CASES, Dimension::Number, "Accuracy at which the solver stops; NaN in this and other measures of a refused case.";
    [|row| of_check(row, |check| check.wanted)] "/stability/wanted", CASES, Dimension::Number, "Error that is accepted: solve.epsilon where the scene sets it, else 1e-8.";
    [|row| of_check(row, Check::trusted_digits)] "/stability/trusted_digits", CASES, Dimension::Number, "Decimal digits in which algorithms and descriptions agree and the conditions hold.";
    [|row| of_check(row, |check| check.accuracy)] "/stability/accuracy", CASES, Dimension::Number, "Accuracy that the solver says it reached.";
    [|row| of_check(row, |check| check.certificate)] "/stability/certificate", CASES, Dimension::Number, "Largest figure of the certificate.";
    [|row| of_check(row, |check| check.rounding_bound.certificate)] "/stability/certificate_rounding", CASES, Dimension::Number, "Size of the certificate's figures at the best double-precision answer.";
    [|row| of_check(row, |check| check.conditioning.stiffness)] "/stability/stiffness_condition", CASES, Dimension::Number, "Condition number of A scaled to the diagonal 1.";
    [|row| of_check(row, |check| extremes(&check.conditioning.dual))] "/stability/dual_eigenvalues", PAIRS, Dimension::DUAL, "Smallest and largest eigenvalue of S without its empty rows.";
    [|row| of_check(row, |check| extremes(&check.conditioning.dual_by_area))] "/stability/dual_eigenvalues_by_area", PAIRS, Dimension::COMPLIANCE, "The same of S scaled by the areas of the panes.";
    [|row| of_check(row, |check| check.linearisation.determinant_sign)] "/stability/determinant_sign", CASES, Dimension::Number, "Sign of the determinant of Newton's matrix at the answer.".symbol("sign det R'");
    [|row| of_check(row, |check| check.linearisation.sensitivity)] "/stability/sensitivity", CASES, Dimension::Number, "Norm of the inverse of Newton's matrix at the answer.";
    [|row| of_check(row, |check| check.linearisation.contraction)] "/stability/spectral_radius", CASES, Dimension::Number, "Spectral radius of the derivative of the mapping Psi at the answer: successive approximations converge to it from nearby where it is below 1; 0 without Coulomb friction.".symbol("rho(Psi')");
    [|row| of_check(row, |check| check.linearisation.fold_distance)] "/stability/fold_distance", CASES, Dimension::Number, "Least |1 - mu| over the eigenvalues mu of that derivative: 0 where Newton's matrix is singular, as in a fold where two solutions meet; 1 without Coulomb friction.".symbol("min |1 - mu|");
    [|row| of_check(row, |check| check.rounding_bound.multiplier)] "/stability/multiplier_rounding", CASES, Dimension::Number, "Relative error of the multipliers that rounding alone makes.";
    [|row| cross_checks(row, Status::NumericalError, |result| result.status)] "/stability/rival_status", CROSS_CHECKS, Dimension::Number, "How Newton, the fixed point with Newton, that with GPCG, and the averaged fixed point ended; numerical_error where not run.";
    [|row| cross_checks(row, 0, |result| result.steps)] "/stability/rival_steps", CROSS_CHECKS, Dimension::Number, "Their steps; 0 where not run.";
    [|row| cross_checks(row, f64::NAN, |result| result.residual)] "/stability/rival_residual", CROSS_CHECKS, Dimension::Number, "Residuals of the natural map at their answers, relative to the multipliers; NaN where not run.";
    [|row| cross_checks(row, f64::NAN, |result| result.disagreement)] "/stability/disagreement", CROSS_CHECKS, Dimension::Number, "Relative difference of their multipliers to the answer; NaN where not run.";
    [|row| of_check(row, variations)] "/stability/variation", CHANGES, Dimension::Number, "Relative difference of the multipliers after a change of units by powers of two, of decimal units, of loads, of node numbers, of threads; NaN where not applicable.";
    [|row| of_check(row, |check| check.seconds)] "/stability/seconds", CASES, Dimension::Time, "Wall-clock time of assembly and solve.".volatile();
};

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
        self.level().word()
    }

    /// What is to be said about the verdict.
    #[must_use]
    pub fn findings(&self) -> String {
        match &self.outcome {
            Ok(check) => check.verdict().findings.join("; "),
            Err(reason) => reason.clone(),
        }
    }

    fn level(&self) -> VerdictLevel {
        let check = self.outcome.as_ref();
        check.map_or(VerdictLevel::Refused, |check| check.verdict().level)
    }
}

/// A figure of a check; that of [`Absent`] where there is no discrete problem.
fn of_check<V: Absent>(row: &StabilityRow, of: fn(&Check) -> V) -> V {
    row.outcome.as_ref().map_or_else(|_| V::absent(), of)
}

fn extremes(spectrum: &Spectrum) -> [f64; 2] {
    [spectrum.smallest, spectrum.largest]
}

/// A figure of each algorithm that was compared with the answer.
fn cross_checks<V: Copy>(row: &StabilityRow, not_run: V, of: fn(&CrossCheckResult) -> V) -> [V; 4] {
    let check = row.outcome.as_ref().ok();
    CrossCheck::ALL.map(|algorithm| {
        let result = check.and_then(|check| check.cross_check(algorithm));
        result.map_or(not_run, of)
    })
}

fn variations(check: &Check) -> [f64; 5] {
    let of = |invariance: Invariance| {
        let mut results = check.invariances.iter();
        let found = results.find(|result| result.invariance == invariance);
        found.map_or(f64::NAN, |result| result.difference)
    };
    Invariance::ALL.map(of)
}

/// Writes the table.
pub fn write(writer: &mut GroupWriter<'_>, rows: &[StabilityRow]) -> Result<(), StoreError> {
    FIELDS.write_rows(writer, rows)
}
