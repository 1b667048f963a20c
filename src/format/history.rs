//! `/solve/history` and `/solve/newton`: what each step of the solvers did.

use contact3d::solver::{NewtonStep, OuterStep, StepCounts};
use runfile::{DatasetSpec, Extent, Extent::Named, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{FormatError, columns::Columns, read_index_vec, solve::GROUP};

/// Where the records of successive approximations lie.
pub(super) struct OuterPaths {
    pub(super) change: &'static str,
    pub(super) inner_tolerance: &'static str,
    pub(super) inner_residual: &'static str,
    pub(super) conjugate_gradient: &'static str,
    pub(super) expansion: &'static str,
    pub(super) proportioning: &'static str,
    pub(super) applications: &'static str,
    pub(super) seconds: &'static str,
}

pub(super) const HISTORY: OuterPaths = OuterPaths {
    change: "/solve/history/change",
    inner_tolerance: "/solve/history/inner_tolerance",
    inner_residual: "/solve/history/inner_residual",
    conjugate_gradient: "/solve/history/conjugate_gradient_steps",
    expansion: "/solve/history/expansion_steps",
    proportioning: "/solve/history/proportioning_steps",
    applications: "/solve/history/actions",
    seconds: "/solve/history/seconds",
};

const NEWTON_RESIDUAL: &str = "/solve/newton/residual";
const NEWTON_STEP_LENGTH: &str = "/solve/newton/step_length";
const NEWTON_HALVINGS: &str = "/solve/newton/halvings";
const NEWTON_ZONE_CHANGES: &str = "/solve/newton/zone_changes";
const NEWTON_UNKNOWNS: &str = "/solve/newton/free_unknowns";
const NEWTON_FALLBACK: &str = "/solve/newton/fallback";
const NEWTON_LAW_SHARE: &str = "/solve/newton/law_share";
const NEWTON_SECONDS: &str = "/solve/newton/seconds";
const STEPS: &[Extent] = &[Named("n_outer_steps")];
const NEWTON: &[Extent] = &[Named("n_newton_steps")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(NEWTON_RESIDUAL, Kind::F64, NEWTON, Dimension::Number, "|R| / |lambda| after each Newton step."),
    GROUP.row(NEWTON_STEP_LENGTH, Kind::F64, NEWTON, Dimension::Number, "Share of the Newton step taken."),
    GROUP.row(NEWTON_HALVINGS, Kind::I64, NEWTON, Dimension::Number, "Halvings of the step tried."),
    GROUP.row(NEWTON_ZONE_CHANGES, Kind::I64, NEWTON, Dimension::Number, "Panes that changed between open, stick and slip."),
    GROUP.row(NEWTON_UNKNOWNS, Kind::I64, NEWTON, Dimension::Number, "Unknowns of the dense linear system."),
    GROUP.row(NEWTON_FALLBACK, Kind::U8, NEWTON, Dimension::Number, "1 where the safeguard replaced Newton's step."),
    GROUP.row(NEWTON_LAW_SHARE, Kind::F64, NEWTON, Dimension::Number, "Share of the law of friction in the step: below 1 where the law was approached by continuation.").symbol("tau").optional("absent in files of format 1.2, which had no continuation"),
    GROUP.row(NEWTON_SECONDS, Kind::F64, NEWTON, Dimension::Time, "Wall-clock time of each Newton step.").volatile(),
    GROUP.row(HISTORY.change, Kind::F64, STEPS, Dimension::Number, "Relative change of the multipliers in each outer step.").symbol("err"),
    GROUP.row(HISTORY.inner_tolerance, Kind::F64, STEPS, Dimension::Number, "Tolerance of each inner problem, relative to the norm of h.").symbol("epsilon_lambda"),
    GROUP.row(HISTORY.inner_residual, Kind::F64, STEPS, Dimension::Number, "Norm of the reduced gradient at the end of each inner problem, relative to the norm of h."),
    GROUP.row(HISTORY.conjugate_gradient, Kind::I64, STEPS, Dimension::Number, "Conjugate gradient steps."),
    GROUP.row(HISTORY.expansion, Kind::I64, STEPS, Dimension::Number, "Expansion steps."),
    GROUP.row(HISTORY.proportioning, Kind::I64, STEPS, Dimension::Number, "Proportioning steps."),
    GROUP.row(HISTORY.applications, Kind::I64, STEPS, Dimension::Number, "Applications of the inverse stiffness matrix; the first step includes those that estimate the norm of S."),
    GROUP.row(HISTORY.seconds, Kind::F64, STEPS, Dimension::Time, "Wall-clock time of each outer step.").volatile(),
];

/// Writes one record per Newton step.
pub(super) fn write_newton(
    writer: &mut GroupWriter<'_>,
    steps: &[NewtonStep],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, steps);
    columns.numbers(NEWTON_RESIDUAL, |s| s.residual)?;
    columns.numbers(NEWTON_STEP_LENGTH, |s| s.step_length)?;
    columns.numbers(NEWTON_LAW_SHARE, |s| s.law_share)?;
    columns.numbers(NEWTON_SECONDS, |s| s.seconds)?;
    columns.counts(NEWTON_HALVINGS, |s| s.halvings)?;
    columns.counts(NEWTON_ZONE_CHANGES, |s| s.zone_changes)?;
    columns.counts(NEWTON_UNKNOWNS, |s| s.free_unknowns)?;
    columns.flags(NEWTON_FALLBACK, |s| s.fallback)
}

/// Writes one record per step of successive approximations.
pub(super) fn write_outer(
    writer: &mut GroupWriter<'_>,
    paths: &OuterPaths,
    history: &[OuterStep],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, history);
    columns.numbers(paths.change, |s| s.change)?;
    columns.numbers(paths.inner_tolerance, |s| s.inner_tolerance)?;
    columns.numbers(paths.inner_residual, |s| s.inner_residual)?;
    columns.numbers(paths.seconds, |s| s.seconds)?;
    columns.counts(paths.conjugate_gradient, |s| s.steps.conjugate_gradient)?;
    columns.counts(paths.expansion, |s| s.steps.expansion)?;
    columns.counts(paths.proportioning, |s| s.steps.proportioning)?;
    columns.counts(paths.applications, |s| s.applications)
}

/// Reads the records of Newton steps.
pub(super) fn read_newton(reader: &Reader) -> Result<Vec<NewtonStep>, FormatError> {
    let residual: Vec<f64> = reader.read_vec(NEWTON_RESIDUAL)?;
    let step_length: Vec<f64> = reader.read_vec(NEWTON_STEP_LENGTH)?;
    let seconds: Vec<f64> = reader.read_vec(NEWTON_SECONDS)?;
    let halvings = read_index_vec(reader, NEWTON_HALVINGS)?;
    let zone_changes = read_index_vec(reader, NEWTON_ZONE_CHANGES)?;
    let free_unknowns = read_index_vec(reader, NEWTON_UNKNOWNS)?;
    let fallback: Vec<u8> = reader.read_vec(NEWTON_FALLBACK)?;
    let law_share: Vec<f64> = match reader.has(NEWTON_LAW_SHARE) {
        true => reader.read_vec(NEWTON_LAW_SHARE)?,
        false => vec![1.0; residual.len()],
    };
    let steps = (0..residual.len()).map(|k| NewtonStep {
        residual: residual[k],
        step_length: step_length[k],
        halvings: halvings[k],
        zone_changes: zone_changes[k],
        free_unknowns: free_unknowns[k],
        fallback: fallback[k] != 0,
        law_share: law_share[k],
        seconds: seconds[k],
    });
    Ok(steps.collect())
}

/// Reads the records of successive approximations.
pub(super) fn read_outer(
    reader: &Reader,
    paths: &OuterPaths,
) -> Result<Vec<OuterStep>, FormatError> {
    let changes: Vec<f64> = reader.read_vec(paths.change)?;
    let tolerances: Vec<f64> = reader.read_vec(paths.inner_tolerance)?;
    let residuals: Vec<f64> = reader.read_vec(paths.inner_residual)?;
    let seconds: Vec<f64> = reader.read_vec(paths.seconds)?;
    let applications = read_index_vec(reader, paths.applications)?;
    let conjugate_gradient = read_index_vec(reader, paths.conjugate_gradient)?;
    let expansion = read_index_vec(reader, paths.expansion)?;
    let proportioning = read_index_vec(reader, paths.proportioning)?;
    let steps = (0..changes.len()).map(|k| OuterStep {
        change: changes[k],
        inner_tolerance: tolerances[k],
        inner_residual: residuals[k],
        steps: StepCounts {
            conjugate_gradient: conjugate_gradient[k],
            expansion: expansion[k],
            proportioning: proportioning[k],
        },
        applications: applications[k],
        seconds: seconds[k],
    });
    Ok(steps.collect())
}
