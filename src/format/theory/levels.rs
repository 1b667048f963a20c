//! `/theory/levels`: one row a mesh, without what depends on a norm of displacements.

use contact3d::theory::{
    FaceConstants, FrictionFunctional, LocalContraction, Observed, TheoryLevel, Thresholds,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{GROUP, known, require_rows};
use crate::format::{FormatError, columns::Columns, outcome::StoredStatus, read_index_vec};

const N_DIV: &str = "/theory/levels/n_div";
const UNKNOWNS: &str = "/theory/levels/unknowns";
const PANES: &str = "/theory/levels/panes";
const STATUS: &str = "/theory/levels/status";
const TRIANGLE_SIZE: &str = "/theory/levels/triangle_size";
const PANE_SIZE: &str = "/theory/levels/pane_size";
const INVERSE_FIRST: &str = "/theory/levels/inverse_first";
const INVERSE_FOURTH: &str = "/theory/levels/inverse_fourth";
const AXES: &str = "/theory/levels/axes";
const LAGRANGE: &str = "/theory/levels/interpolation_lagrange";
const LAGRANGE_FINER: &str = "/theory/levels/interpolation_lagrange_finer";
const CLEMENT_FINER: &str = "/theory/levels/interpolation_clement_finer";
const SPECTRAL_RADIUS: &str = "/theory/levels/spectral_radius";
const INDEX: &str = "/theory/levels/fixed_point_index";
const DETERMINANT: &str = "/theory/levels/determinant_sign";
const RATE: &str = "/theory/levels/observed_rate";
const RATE_STEPS: &str = "/theory/levels/observed_rate_steps";
const STEPS_FROM_ZERO: &str = "/theory/levels/steps_from_zero";
const EVALUATIONS: &str = "/theory/levels/evaluations";
const UNSOLVED: &str = "/theory/levels/unsolved";
const FUNCTIONAL: &str = "/theory/levels/functional_difference";
const EXCESS: &str = "/theory/levels/pointwise_excess";
const THRESHOLD_RADIUS: &str = "/theory/levels/threshold_spectral_radius";
const THRESHOLD_SINGULAR: &str = "/theory/levels/threshold_singular";

const ROWS: &[Extent] = &[Named("n_theory_levels")];
const FINER: &[Extent] = &[Named("n_theory_levels"), Fixed(3)];

const fn row(path: &'static str, kind: Kind, meaning: &'static str) -> DatasetSpec {
    GROUP.row(path, kind, ROWS, Dimension::Number, meaning)
}

#[rustfmt::skip]
pub(in crate::format) const TABLE: &[DatasetSpec] = &[
    row(N_DIV, Kind::I64, "Smallest number of cells along an edge, coarse to fine; 0 for a mesh file."),
    row(UNKNOWNS, Kind::I64, "Free degrees of freedom."),
    row(PANES, Kind::I64, "Panes m, or nodes that carry multipliers."),
    row(STATUS, Kind::Enum(StoredStatus::SPEC), "How the solve ended."),
    GROUP.row(TRIANGLE_SIZE, Kind::F64, ROWS, Dimension::LENGTH, "Largest diameter of a contact triangle.").symbol("h"),
    GROUP.row(PANE_SIZE, Kind::F64, ROWS, Dimension::LENGTH, "Largest diameter of a pane; h for nodal multipliers.").symbol("H"),
    row(INVERSE_FIRST, Kind::F64, "Inverse inequality (3.7): |psi|_1 <= c/h |psi|_0 on the contact face.").symbol("c_inv(1,0)"),
    row(INVERSE_FOURTH, Kind::F64, "Inverse inequality (3.17): max|psi| <= c/sqrt(h) |psi|_0,4 on the contact face.").symbol("c_inv(inf)"),
    row(AXES, Kind::F64, "Constant of HKL Lemma 3.2; 1 where the axes of friction do not turn.").symbol("c_t"),
    row(LAGRANGE, Kind::F64, "Constant of (3.3) for Lagrange interpolation of |phi| with phi in Y^h, which is where HKL (3.6) uses it.").symbol("c_r"),
    GROUP.row(LAGRANGE_FINER, Kind::F64, FINER, Dimension::Number, "Constant of (3.3) for Lagrange interpolation of linear functions on contact triangles cut in 2^2, 4^2, 8^2."),
    GROUP.row(CLEMENT_FINER, Kind::F64, FINER, Dimension::Number, "The same for Clement's interpolation (3.19)."),
    row(SPECTRAL_RADIUS, Kind::F64, "Largest modulus of an eigenvalue of the derivative of the mapping Psi at the solution; NaN where there is none.").symbol("rho"),
    row(INDEX, Kind::I64, "Sign of det(I - Psi') at the solution; those of all solutions add up to 1."),
    row(DETERMINANT, Kind::I64, "Sign of det R' of the natural map at the solution."),
    row(RATE, Kind::F64, "Geometric mean of the last ten factors by which a small disturbance shrinks in successive approximations with exact inner problems."),
    row(RATE_STEPS, Kind::I64, "Steps it took to settle."),
    row(STEPS_FROM_ZERO, Kind::I64, "Steps of Algorithm 4.1 from zero with exact inner problems to a change of 1e-11; 0 where 200 do not suffice."),
    row(EVALUATIONS, Kind::I64, "Values of Psi for which Lemma 3.3 was checked."),
    row(UNSOLVED, Kind::I64, "Frozen problems without an accurate solution, which were left out."),
    row(FUNCTIONAL, Kind::F64, "Friction functional of the program, averaged over panes, over that of HKL at the solution, less 1; NaN in this and the next for nodal multipliers."),
    row(EXCESS, Kind::F64, "Largest |F^-1 lambda_t| / g - 1 at points of pressed panes, where the bound holds for means."),
    row(THRESHOLD_RADIUS, Kind::F64, "Smallest scale of the law at which the spectral radius is 1; infinite if none up to 1e6."),
    row(THRESHOLD_SINGULAR, Kind::F64, "Smallest scale of the law at which det R' changes its sign; infinite if none up to 1e6."),
];

pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    levels: &[TheoryLevel],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, levels);
    columns.counts(N_DIV, |l| l.n_div)?;
    columns.counts(UNKNOWNS, |l| l.n_free)?;
    columns.counts(PANES, |l| l.n_panes)?;
    columns.members(STATUS, |l| StoredStatus::from(l.status))?;
    type Figure = fn(&TheoryLevel) -> f64;
    let figures: [(&str, Figure); 12] = [
        (TRIANGLE_SIZE, |l| l.face.triangle_size),
        (PANE_SIZE, |l| l.face.pane_size),
        (INVERSE_FIRST, |l| l.face.inverse_first),
        (INVERSE_FOURTH, |l| l.face.inverse_fourth),
        (AXES, |l| l.face.axes),
        (LAGRANGE, |l| l.face.lagrange),
        (SPECTRAL_RADIUS, |l| {
            l.local.as_ref().map_or(f64::NAN, |c| c.spectral_radius)
        }),
        (RATE, |l| l.observed.rate),
        (FUNCTIONAL, |l| {
            l.functional.map_or(f64::NAN, |f| f.difference)
        }),
        (EXCESS, |l| l.functional.map_or(f64::NAN, |f| f.excess)),
        (THRESHOLD_RADIUS, |l| {
            l.thresholds.spectral_radius.unwrap_or(f64::INFINITY)
        }),
        (THRESHOLD_SINGULAR, |l| {
            l.thresholds.singular.unwrap_or(f64::INFINITY)
        }),
    ];
    for (path, figure) in figures {
        columns.numbers(path, figure)?;
    }
    columns.vectors(LAGRANGE_FINER, |l| l.face.lagrange_finer)?;
    columns.vectors(CLEMENT_FINER, |l| l.face.clement_finer)?;
    columns.numbers(INDEX, |l| {
        l.local.as_ref().map_or(0, |c| i64::from(c.index))
    })?;
    columns.numbers(DETERMINANT, |l| i64::from(l.determinant))?;
    columns.counts(RATE_STEPS, |l| l.observed.rate_steps)?;
    columns.counts(STEPS_FROM_ZERO, |l| l.observed.steps_from_zero.unwrap_or(0))?;
    columns.counts(EVALUATIONS, |l| l.observed.evaluations)?;
    columns.counts(UNSOLVED, |l| l.observed.unsolved)
}

/// The rows, with empty lists in place of what other tables hold.
pub(super) fn read(reader: &Reader) -> Result<Vec<TheoryLevel>, FormatError> {
    let n_div = read_index_vec(reader, N_DIV)?;
    let rows = n_div.len();
    let counts = |path: &'static str| -> Result<Vec<usize>, FormatError> {
        let column = read_index_vec(reader, path)?;
        require_rows(path, &column, rows)?;
        Ok(column)
    };
    let numbers = |path: &'static str| -> Result<Vec<f64>, FormatError> {
        let column: Vec<f64> = reader.read_vec(path)?;
        require_rows(path, &column, rows)?;
        Ok(column)
    };
    let signs = |path: &'static str| -> Result<Vec<i8>, FormatError> {
        let column: Vec<i64> = reader.read_vec(path)?;
        require_rows(path, &column, rows)?;
        Ok(column.into_iter().map(|sign| sign.signum() as i8).collect())
    };
    let triples = |path: &'static str| -> Result<Vec<[f64; 3]>, FormatError> {
        let column: Vec<f64> = reader.read_vec(path)?;
        require_rows(path, &column, 3 * rows)?;
        Ok(column.as_chunks().0.to_vec())
    };
    let status = reader
        .read_enum::<StoredStatus>(STATUS)?
        .into_raw_vec_and_offset()
        .0;
    require_rows(STATUS, &status, rows)?;
    let (unknowns, panes) = (counts(UNKNOWNS)?, counts(PANES)?);
    let (triangle_size, pane_size) = (numbers(TRIANGLE_SIZE)?, numbers(PANE_SIZE)?);
    let (inverse_first, inverse_fourth) = (numbers(INVERSE_FIRST)?, numbers(INVERSE_FOURTH)?);
    let (axes, lagrange) = (numbers(AXES)?, numbers(LAGRANGE)?);
    let (lagrange_finer, clement_finer) = (triples(LAGRANGE_FINER)?, triples(CLEMENT_FINER)?);
    let (radius, index, determinant) = (
        numbers(SPECTRAL_RADIUS)?,
        signs(INDEX)?,
        signs(DETERMINANT)?,
    );
    let (rate, rate_steps) = (numbers(RATE)?, counts(RATE_STEPS)?);
    let (from_zero, evaluations, unsolved) = (
        counts(STEPS_FROM_ZERO)?,
        counts(EVALUATIONS)?,
        counts(UNSOLVED)?,
    );
    let (at_radius, at_singular) = (numbers(THRESHOLD_RADIUS)?, numbers(THRESHOLD_SINGULAR)?);
    let (difference, excess) = (numbers(FUNCTIONAL)?, numbers(EXCESS)?);
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    let level = |k: usize| TheoryLevel {
        n_div: n_div[k],
        n_free: unknowns[k],
        n_panes: panes[k],
        status: status[k].into(),
        face: FaceConstants {
            triangle_size: triangle_size[k],
            pane_size: pane_size[k],
            inverse_first: inverse_first[k],
            inverse_fourth: inverse_fourth[k],
            axes: axes[k],
            lagrange: lagrange[k],
            lagrange_finer: lagrange_finer[k],
            clement_finer: clement_finer[k],
        },
        norms: Vec::new(),
        inf_sup: Vec::new(),
        local: known(radius[k]).map(|spectral_radius| LocalContraction {
            spectral_radius,
            index: index[k],
            parts: Vec::new(),
            paper: None,
        }),
        determinant: determinant[k],
        observed: Observed {
            rate: rate[k],
            rate_steps: rate_steps[k],
            steps_from_zero: Some(from_zero[k]).filter(|steps| *steps > 0),
            lemma: Vec::new(),
            quotient: Vec::new(),
            evaluations: evaluations[k],
            unsolved: unsolved[k],
        },
        functional: known(difference[k]).map(|difference| FrictionFunctional {
            difference,
            excess: excess[k],
        }),
        scaled: Vec::new(),
        thresholds: Thresholds {
            paper: [f64::NAN; 2],
            weighted: [f64::NAN; 2],
            sharp: [f64::NAN; 2],
            norm: [None; 2],
            spectral_radius: finite(at_radius[k]),
            singular: finite(at_singular[k]),
        },
    };
    Ok((0..rows).map(level).collect())
}
