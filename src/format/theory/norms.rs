//! `/theory/norms`: what depends on the norm of displacements, one column for each.

use contact3d::theory::{
    ContractionBound, DisplacementNorm, NormConstants, PartNorms, Radii, TheoryLevel,
    TraceConstants,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{GROUP, known, require_rows};
use crate::format::{FormatError, columns::Columns};

const ROWS: &[Extent] = &[Named("n_theory_levels"), Fixed(2)];

/// A figure of a mesh in one norm, with where it stands.
struct Figure {
    path: &'static str,
    symbol: &'static str,
    meaning: &'static str,
    of: fn(&TheoryLevel, usize) -> f64,
}

const fn figure(
    path: &'static str,
    symbol: &'static str,
    meaning: &'static str,
    of: fn(&TheoryLevel, usize) -> f64,
) -> Figure {
    Figure {
        path,
        symbol,
        meaning,
        of,
    }
}

fn part(level: &TheoryLevel, k: usize, of: fn(&PartNorms) -> f64) -> f64 {
    level
        .local
        .as_ref()
        .map_or(f64::NAN, |local| of(&local.parts[k]))
}

fn paper_norm(level: &TheoryLevel, k: usize) -> f64 {
    let norms = level.local.as_ref().and_then(|local| local.paper.as_ref());
    norms.map_or(f64::NAN, |norms| norms[k])
}

const N_FIGURES: usize = 30;

#[rustfmt::skip]
const FIGURES: [Figure; N_FIGURES] = [
    figure("/theory/norms/ellipticity", "alpha", "Ellipticity (2.6) on V^h. All columns: norm of H1(Omega)^3 with lengths in the unit of the scene, energy norm; figures in the units of the scene, which HKL's norms mix.", |l, k| l.norms[k].ellipticity),
    figure("/theory/norms/continuity", "M", "Continuity (2.7) on V^h.", |l, k| l.norms[k].continuity),
    figure("/theory/norms/load", "|l|_*", "Dual norm of the load on V^h.", |l, k| l.norms[k].load),
    figure("/theory/norms/inverse_half", "c_inv(0,-1/2)", "Inverse inequality (3.16): |mu|_0 <= c/sqrt(H) |mu|_*,h.", |l, k| l.norms[k].inverse_half),
    figure("/theory/norms/trace_second", "c_tr(2)", "Trace on the contact face in L2.", |l, k| l.norms[k].trace.second),
    figure("/theory/norms/trace_fourth", "c_tr(4)", "Trace on the contact face in L4: the best local maximum, a lower bound.", |l, k| l.norms[k].trace.fourth),
    figure("/theory/norms/trace_pointwise", "", "max|v| <= c |v| on the contact face, in place of c_inv(inf) c_tr(4) / sqrt(h).", |l, k| l.norms[k].trace.pointwise),
    figure("/theory/norms/trace_interpolated", "", "Lagrange's interpolation: |r_h|v_t|| <= c |v|, in place of c_tr(2) (c_inv(1,0) c_r c_t + 1).", |l, k| l.norms[k].trace.interpolated),
    figure("/theory/norms/trace_tangential", "", "|v_t|_0 <= c |v| on the contact face, which also bounds Clement's interpolation.", |l, k| l.norms[k].trace.tangential),
    figure("/theory/norms/slip_radius", "R_1", "Radius of HKL Lemma 3.3 for the slip.", |l, k| l.norms[k].radii.slip),
    figure("/theory/norms/pressure_radius", "R_2", "Radius of HKL Lemma 3.3 for the pressure.", |l, k| l.norms[k].radii.pressure),
    figure("/theory/norms/contraction_bound", "q", "Bound (3.13) of the Lipschitz modulus in the norm |phi| + |mu|_*, whose parts have different units.", |l, k| l.norms[k].bound.paper),
    figure("/theory/norms/contraction_bound_weighted", "", "The least bound of this kind over all weights of the two parts.", |l, k| l.norms[k].bound.weighted),
    figure("/theory/norms/contraction_bound_sharp", "", "The same with products of constants replaced by the bounds they stand for.", |l, k| l.norms[k].bound.sharp),
    figure("/theory/norms/contraction_bound_averaged", "", "The weighted bound for the friction functional of the program, averaged over panes or lumped.", |l, k| l.norms[k].bound.averaged),
    figure("/theory/norms/share_of_coefficient", "", "Share of the weighted bound that F_max makes; the rest is that of L.", |l, k| l.norms[k].bound.by_coefficient),
    figure("/theory/norms/lemma_slip", "", "Largest |phi| / R_1 of all values of Psi; HKL Lemma 3.3 says at most 1.", |l, k| l.observed.lemma[k][0]),
    figure("/theory/norms/lemma_pressure", "", "Largest |lambda_nu|_* / R_2 of all values of Psi; HKL Lemma 3.3 says at most 1.", |l, k| l.observed.lemma[k][1]),
    figure("/theory/norms/quotient", "", "Largest quotient |Psi(x) - Psi(y)| / |x - y| of sampled pairs, in the weighted norm that suits the derivative.", |l, k| l.observed.quotient[k]),
    figure("/theory/norms/jacobian_norm", "|Psi'|", "Norm of the derivative of Psi at the solution, in |phi| + |mu|_*; NaN in this and the next without a solution.", paper_norm),
    figure("/theory/norms/jacobian_norm_weighted", "", "The least bound of it over all weights, from the norms of its parts.", |l, k| part(l, k, |p| p.weighted())),
    figure("/theory/norms/slip_by_slip", "", "Norm of the part of the derivative of Psi that gives slip from slip.", |l, k| part(l, k, |p| p.slip_by_slip)),
    figure("/theory/norms/slip_by_pressure", "", "Slip from pressure.", |l, k| part(l, k, |p| p.slip_by_pressure)),
    figure("/theory/norms/pressure_by_slip", "", "Pressure from slip.", |l, k| part(l, k, |p| p.pressure_by_slip)),
    figure("/theory/norms/pressure_by_pressure", "", "Pressure from pressure.", |l, k| part(l, k, |p| p.pressure_by_pressure)),
    figure("/theory/norms/threshold_bound", "", "Scale of the law at which the bound (3.13) is 1.", |l, k| l.thresholds.paper[k]),
    figure("/theory/norms/threshold_bound_weighted", "", "Scale at which the weighted bound is 1.", |l, k| l.thresholds.weighted[k]),
    figure("/theory/norms/threshold_bound_sharp", "", "Scale at which the bound with composed constants is 1.", |l, k| l.thresholds.sharp[k]),
    figure("/theory/norms/threshold_jacobian_norm", "", "Smallest scale at which the weighted norm of the derivative is 1; infinite if none up to 1e6.", |l, k| l.thresholds.norm[k].unwrap_or(f64::INFINITY)),
    figure("/theory/norms/weight", "w", "The weight of that norm, w |phi| + |mu|_*; 0 where nothing depends on the slip.", |l, k| part(l, k, |p| p.weight())),
];

const fn rows() -> [DatasetSpec; N_FIGURES] {
    let first = row(&FIGURES[0]);
    let mut table = [first; N_FIGURES];
    let mut k = 1;
    while k < N_FIGURES {
        table[k] = row(&FIGURES[k]);
        k += 1;
    }
    table
}

const fn row(figure: &Figure) -> DatasetSpec {
    GROUP
        .row(
            figure.path,
            Kind::F64,
            ROWS,
            Dimension::Number,
            figure.meaning,
        )
        .symbol(figure.symbol)
}

pub(in crate::format) const TABLE: &[DatasetSpec] = &rows();

pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    levels: &[TheoryLevel],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, levels);
    for figure in &FIGURES {
        columns.vectors(figure.path, |level| [0, 1].map(|k| (figure.of)(level, k)))?;
    }
    Ok(())
}

/// Fills in what the rows of the meshes left out.
pub(super) fn read(reader: &Reader, levels: &mut [TheoryLevel]) -> Result<(), FormatError> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for figure in &FIGURES {
        let column: Vec<f64> = reader.read_vec(figure.path)?;
        require_rows(figure.path, &column, 2 * levels.len())?;
        columns.push(column);
    }
    for (row, level) in levels.iter_mut().enumerate() {
        let values = |k: usize| -> Vec<f64> { columns.iter().map(|c| c[2 * row + k]).collect() };
        fill(level, [values(0), values(1)]);
    }
    Ok(())
}

/// Takes the figures of one mesh in both norms, in the order of [`FIGURES`].
fn fill(level: &mut TheoryLevel, figures: [Vec<f64>; 2]) {
    for (k, v) in figures.iter().enumerate() {
        level.norms.push(NormConstants {
            norm: DisplacementNorm::ALL[k],
            ellipticity: v[0],
            continuity: v[1],
            load: v[2],
            inverse_half: v[3],
            trace: TraceConstants {
                second: v[4],
                fourth: v[5],
                pointwise: v[6],
                interpolated: v[7],
                tangential: v[8],
            },
            radii: Radii {
                slip: v[9],
                pressure: v[10],
            },
            bound: ContractionBound {
                paper: v[11],
                weighted: v[12],
                sharp: v[13],
                averaged: v[14],
                by_coefficient: v[15],
            },
        });
        level.observed.lemma.push([v[16], v[17]]);
        level.observed.quotient.push(v[18]);
        if let Some(local) = &mut level.local {
            local.paper.get_or_insert_default().extend(known(v[19]));
            local.parts.push(PartNorms {
                slip_by_slip: v[21],
                slip_by_pressure: v[22],
                pressure_by_slip: v[23],
                pressure_by_pressure: v[24],
            });
        }
        let thresholds = &mut level.thresholds;
        (
            thresholds.paper[k],
            thresholds.weighted[k],
            thresholds.sharp[k],
        ) = (v[25], v[26], v[27]);
        thresholds.norm[k] = Some(v[28]).filter(|scale| scale.is_finite());
    }
}
