//! `/theory`: the constants of HKL section 3, and what successive approximations really do.

use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Reader, StoreError,
};
use studies::theory::{
    DisplacementNorm, FrictionFunctional, InfSup, LocalContraction, NormConstants, Observed,
    PartNorms, ScaledPoint, Theory, TheoryLevel, TrialSpace,
};
use units::Dimension;

use super::{
    FormatError,
    fields::{Fields, fields},
    require_below,
    stored::stored_as,
};

/// The theory of HKL section 3, measured; computed from the scene alone.
pub const GROUP: Group = Group::new("theory", "theory");

stored_as! {
    /// A space of multipliers, as stored.
    StoredSpace of TrialSpace as "multiplier_space" {
        Cells1 = 0 => "cells_1x1",
        Cells2 = 1 => "cells_2x2",
        Cells4 = 2 => "cells_4x4",
        Linear = 3 => "linear",
    }
}

const LEVEL: &str = "/theory/inf_sup/level";
const SCALED_LEVEL: &str = "/theory/scaled/level";

const NO_BRICK: &str = "absent for mesh files";
const ROWS: &[Extent] = &[Named("n_theory_levels")];
const FINER: &[Extent] = &[Named("n_theory_levels"), Fixed(3)];
/// One column for each norm of displacements.
const PAIRS: &[Extent] = &[Named("n_theory_levels"), Fixed(2)];
const SPACES: &[Extent] = &[Named("n_trial_spaces")];
const SCALES: &[Extent] = &[Named("n_scales")];

pub(super) const LAW: Fields<Theory> = fields! { Theory => GROUP;
    [|theory| theory.findings().to_string()] "/theory/findings", &[], Dimension::Number, "What the figures mean, in a few sentences.";
    (law.smallest) "/theory/law/coefficient_min", &[], Dimension::Number, "Smallest coefficient of friction, HKL (2.4).".symbol("F_min");
    (law.largest) "/theory/law/coefficient_max", &[], Dimension::Number, "Largest coefficient of friction, HKL (2.4).".symbol("F_max");
    (law.lipschitz) "/theory/law/lipschitz", &[], Dimension::PER_LENGTH, "Lipschitz modulus of the coefficients by the slips, HKL (3.10).".symbol("L");
    (law.anisotropy) "/theory/law/anisotropy", &[], Dimension::Number, "Largest ratio of the two coefficients at one place and slip, HKL Lemma 3.5.".symbol("kappa");
    (law.estimated) "/theory/law/estimated", &[], Dimension::Number, "1 where these four are estimates, because a coefficient is a formula.";
};

pub(super) const LEVELS: Fields<TheoryLevel> = fields! { TheoryLevel => GROUP;
    (n_div) "/theory/levels/n_div", ROWS, Dimension::Number, "Smallest number of cells along an edge, coarse to fine; 0 for a mesh file.";
    (n_free) "/theory/levels/unknowns", ROWS, Dimension::Number, "Free degrees of freedom.";
    (n_panes) "/theory/levels/panes", ROWS, Dimension::Number, "Panes m, or nodes that carry multipliers.";
    (status) "/theory/levels/status", ROWS, Dimension::Number, "How the solve ended.";
    (face.triangle_size) "/theory/levels/triangle_size", ROWS, Dimension::LENGTH, "Largest diameter of a contact triangle.".symbol("h");
    (face.pane_size) "/theory/levels/pane_size", ROWS, Dimension::LENGTH, "Largest diameter of a pane; h for nodal multipliers.".symbol("H");
    (face.inverse_first) "/theory/levels/inverse_first", ROWS, Dimension::Number, "Inverse inequality (3.7): |psi|_1 <= c/h |psi|_0 on the contact face.".symbol("c_inv(1,0)");
    (face.inverse_fourth) "/theory/levels/inverse_fourth", ROWS, Dimension::Number, "Inverse inequality (3.17): max|psi| <= c/sqrt(h) |psi|_0,4 on the contact face.".symbol("c_inv(inf)");
    (face.axes) "/theory/levels/axes", ROWS, Dimension::Number, "Constant of HKL Lemma 3.2; 1 where the axes of friction do not turn.".symbol("c_t");
    (face.lagrange) "/theory/levels/interpolation_lagrange", ROWS, Dimension::Number, "Constant of (3.3) for Lagrange interpolation of |phi| with phi in Y^h, which is where HKL (3.6) uses it.".symbol("c_r");
    (face.lagrange_finer) "/theory/levels/interpolation_lagrange_finer", FINER, Dimension::Number, "Constant of (3.3) for Lagrange interpolation of linear functions on contact triangles cut in 2^2, 4^2, 8^2.";
    (face.clement_finer) "/theory/levels/interpolation_clement_finer", FINER, Dimension::Number, "The same for Clement's interpolation (3.19).";
    (local?.spectral_radius) "/theory/levels/spectral_radius", ROWS, Dimension::Number, "Largest modulus of an eigenvalue of the derivative of the mapping Psi at the solution; NaN where there is none.".symbol("rho");
    (local?.index) "/theory/levels/fixed_point_index", ROWS, Dimension::Number, "Sign of det(I - Psi') at the solution; those of all solutions add up to 1.";
    (determinant) "/theory/levels/determinant_sign", ROWS, Dimension::Number, "Sign of det R' of the natural map at the solution.";
    (observed.rate) "/theory/levels/observed_rate", ROWS, Dimension::Number, "Geometric mean of the last ten factors by which a small disturbance shrinks in successive approximations with exact inner problems.";
    (observed.rate_steps) "/theory/levels/observed_rate_steps", ROWS, Dimension::Number, "Steps it took to settle.";
    [|level| level.observed.steps_from_zero.unwrap_or(0), |level, steps| level.observed.steps_from_zero = Some(steps).filter(|steps| *steps > 0)] "/theory/levels/steps_from_zero", ROWS, Dimension::Number, "Steps of Algorithm 4.1 from zero with exact inner problems to a change of 1e-11; 0 where 200 do not suffice.";
    (observed.evaluations) "/theory/levels/evaluations", ROWS, Dimension::Number, "Values of Psi for which Lemma 3.3 was checked.";
    (observed.unsolved) "/theory/levels/unsolved", ROWS, Dimension::Number, "Frozen problems without an accurate solution, which were left out.";
    (functional?.difference) "/theory/levels/functional_difference", ROWS, Dimension::Number, "Friction functional of the program, averaged over panes, over that of HKL at the solution, less 1; NaN in this and the next for nodal multipliers.";
    (functional?.excess) "/theory/levels/pointwise_excess", ROWS, Dimension::Number, "Largest |F^-1 lambda_t| / g - 1 at points of pressed panes, where the bound holds for means.";
    [|level| or_infinite(level.thresholds.spectral_radius), |level, scale| level.thresholds.spectral_radius = finite(scale)] "/theory/levels/threshold_spectral_radius", ROWS, Dimension::Number, "Smallest scale of the law at which the spectral radius is 1; infinite if none up to 1e6.";
    [|level| or_infinite(level.thresholds.singular), |level, scale| level.thresholds.singular = finite(scale)] "/theory/levels/threshold_singular", ROWS, Dimension::Number, "Smallest scale of the law at which det R' changes its sign; infinite if none up to 1e6.";
    (each k in norms[k].ellipticity) "/theory/norms/ellipticity", PAIRS, Dimension::Number, "Ellipticity (2.6) on V^h. All columns: norm of H1(Omega)^3 with lengths in the unit of the scene, energy norm; figures in the units of the scene, which HKL's norms mix.".symbol("alpha");
    (each k in norms[k].continuity) "/theory/norms/continuity", PAIRS, Dimension::Number, "Continuity (2.7) on V^h.".symbol("M");
    (each k in norms[k].load) "/theory/norms/load", PAIRS, Dimension::Number, "Dual norm of the load on V^h.".symbol("|l|_*");
    (each k in norms[k].inverse_half) "/theory/norms/inverse_half", PAIRS, Dimension::Number, "Inverse inequality (3.16): |mu|_0 <= c/sqrt(H) |mu|_*,h.".symbol("c_inv(0,-1/2)");
    (each k in norms[k].trace.second) "/theory/norms/trace_second", PAIRS, Dimension::Number, "Trace on the contact face in L2.".symbol("c_tr(2)");
    (each k in norms[k].trace.fourth) "/theory/norms/trace_fourth", PAIRS, Dimension::Number, "Trace on the contact face in L4: the best local maximum, a lower bound.".symbol("c_tr(4)");
    (each k in norms[k].trace.pointwise) "/theory/norms/trace_pointwise", PAIRS, Dimension::Number, "max|v| <= c |v| on the contact face, in place of c_inv(inf) c_tr(4) / sqrt(h).";
    (each k in norms[k].trace.interpolated) "/theory/norms/trace_interpolated", PAIRS, Dimension::Number, "Lagrange's interpolation: |r_h|v_t|| <= c |v|, in place of c_tr(2) (c_inv(1,0) c_r c_t + 1).";
    (each k in norms[k].trace.tangential) "/theory/norms/trace_tangential", PAIRS, Dimension::Number, "|v_t|_0 <= c |v| on the contact face, which also bounds Clement's interpolation.";
    (each k in norms[k].radii.slip) "/theory/norms/slip_radius", PAIRS, Dimension::Number, "Radius of HKL Lemma 3.3 for the slip.".symbol("R_1");
    (each k in norms[k].radii.pressure) "/theory/norms/pressure_radius", PAIRS, Dimension::Number, "Radius of HKL Lemma 3.3 for the pressure.".symbol("R_2");
    (each k in norms[k].bound.paper) "/theory/norms/contraction_bound", PAIRS, Dimension::Number, "Bound (3.13) of the Lipschitz modulus in the norm |phi| + |mu|_*, whose parts have different units.".symbol("q");
    (each k in norms[k].bound.weighted) "/theory/norms/contraction_bound_weighted", PAIRS, Dimension::Number, "The least bound of this kind over all weights of the two parts.";
    (each k in norms[k].bound.sharp) "/theory/norms/contraction_bound_sharp", PAIRS, Dimension::Number, "The same with products of constants replaced by the bounds they stand for.";
    (each k in norms[k].bound.averaged) "/theory/norms/contraction_bound_averaged", PAIRS, Dimension::Number, "The weighted bound for the friction functional of the program, averaged over panes or lumped.";
    (each k in norms[k].bound.by_coefficient) "/theory/norms/share_of_coefficient", PAIRS, Dimension::Number, "Share of the weighted bound that F_max makes; the rest is that of L.";
    (each k in observed.lemma[k][0]) "/theory/norms/lemma_slip", PAIRS, Dimension::Number, "Largest |phi| / R_1 of all values of Psi; HKL Lemma 3.3 says at most 1.";
    (each k in observed.lemma[k][1]) "/theory/norms/lemma_pressure", PAIRS, Dimension::Number, "Largest |lambda_nu|_* / R_2 of all values of Psi; HKL Lemma 3.3 says at most 1.";
    (each k in observed.quotient[k]) "/theory/norms/quotient", PAIRS, Dimension::Number, "Largest quotient |Psi(x) - Psi(y)| / |x - y| of sampled pairs, in the weighted norm that suits the derivative.";
    [paper_norms, |level, norms: [f64; 2]| put_paper_norms(level, norms)] "/theory/norms/jacobian_norm", PAIRS, Dimension::Number, "Norm of the derivative of Psi at the solution, in |phi| + |mu|_*; NaN in this and the next without a solution.".symbol("|Psi'|");
    [|level| parts(level, PartNorms::weighted)] "/theory/norms/jacobian_norm_weighted", PAIRS, Dimension::Number, "The least bound of it over all weights, from the norms of its parts.";
    [|level| parts(level, |part| part.slip_by_slip), |level, norms| put_parts(level, norms, |part| &mut part.slip_by_slip)] "/theory/norms/slip_by_slip", PAIRS, Dimension::Number, "Norm of the part of the derivative of Psi that gives slip from slip.";
    [|level| parts(level, |part| part.slip_by_pressure), |level, norms| put_parts(level, norms, |part| &mut part.slip_by_pressure)] "/theory/norms/slip_by_pressure", PAIRS, Dimension::Number, "Slip from pressure.";
    [|level| parts(level, |part| part.pressure_by_slip), |level, norms| put_parts(level, norms, |part| &mut part.pressure_by_slip)] "/theory/norms/pressure_by_slip", PAIRS, Dimension::Number, "Pressure from slip.";
    [|level| parts(level, |part| part.pressure_by_pressure), |level, norms| put_parts(level, norms, |part| &mut part.pressure_by_pressure)] "/theory/norms/pressure_by_pressure", PAIRS, Dimension::Number, "Pressure from pressure.";
    (each k in thresholds.paper[k]) "/theory/norms/threshold_bound", PAIRS, Dimension::Number, "Scale of the law at which the bound (3.13) is 1.";
    (each k in thresholds.weighted[k]) "/theory/norms/threshold_bound_weighted", PAIRS, Dimension::Number, "Scale at which the weighted bound is 1.";
    (each k in thresholds.sharp[k]) "/theory/norms/threshold_bound_sharp", PAIRS, Dimension::Number, "Scale at which the bound with composed constants is 1.";
    [|level| level.thresholds.norm.map(or_infinite), |level, scales: [f64; 2]| level.thresholds.norm = scales.map(finite)] "/theory/norms/threshold_jacobian_norm", PAIRS, Dimension::Number, "Smallest scale at which the weighted norm of the derivative is 1; infinite if none up to 1e6.";
    [|level| parts(level, PartNorms::weight)] "/theory/norms/weight", PAIRS, Dimension::Number, "The weight of that norm, w |phi| + |mu|_*; 0 where nothing depends on the slip.".symbol("w");
};

/// A space of multipliers on a mesh, with its number.
pub(super) const INF_SUP: Fields<(usize, InfSup)> = fields! { (usize, InfSup) => GROUP;
    (0) LEVEL, SPACES, Dimension::Number, "Mesh of each row, from 0.".optional(NO_BRICK);
    (1.space) "/theory/inf_sup/space", SPACES, Dimension::Number, "Multipliers constant on pieces of so many cells, or continuous and linear.".optional(NO_BRICK);
    (1.ratio) "/theory/inf_sup/size_ratio", SPACES, Dimension::Number, "Diameter of a piece over that of a contact triangle.".symbol("H/h").optional(NO_BRICK);
    (1.smallest) "/theory/inf_sup/smallest_eigenvalue", SPACES, Dimension::Number, "Smallest eigenvalue of |mu|_*,h^2 over |mu|_0^2 in the norm of H1; (3.1) holds where it is positive.".optional(NO_BRICK);
    (1.inverse_half) "/theory/inf_sup/inverse_half", SPACES, Dimension::Number, "c_inv(0,-1/2) of (3.16).".symbol("c_inv(0,-1/2)").optional(NO_BRICK);
    (nan 1.inf_sup) "/theory/inf_sup/inf_sup", SPACES, Dimension::Number, "Least |mu|_*,h on this mesh over that on the finest one; NaN on the finest.".symbol("beta").optional(NO_BRICK);
};

/// A law times a factor on a mesh, with its number.
pub(super) const SCALED: Fields<(usize, ScaledPoint)> = fields! { (usize, ScaledPoint) => GROUP;
    (0) SCALED_LEVEL, SCALES, Dimension::Number, "Mesh of each row, from 0.";
    (1.scale) "/theory/scaled/scale", SCALES, Dimension::Number, "Factor of the law of friction.".symbol("t");
    (1.solved) "/theory/scaled/solved", SCALES, Dimension::Number, "1 where a solution was found; 0 where not, and its figures are NaN and 0.";
    (1.spectral_radius) "/theory/scaled/spectral_radius", SCALES, Dimension::Number, "Spectral radius of the derivative of Psi at the solution found.".symbol("rho");
    (1.norm) "/theory/scaled/jacobian_norm_weighted", &[Named("n_scales"), Fixed(2)], Dimension::Number, "Its weighted norm, with the norm of H1 and with the energy norm.";
    (1.determinant) "/theory/scaled/determinant_sign", SCALES, Dimension::Number, "Sign of det R' of the natural map there.";
};

fn or_infinite(scale: Option<f64>) -> f64 {
    scale.unwrap_or(f64::INFINITY)
}

fn finite(scale: f64) -> Option<f64> {
    Some(scale).filter(|scale| scale.is_finite())
}

/// Norms of parts of Ψ′ in both norms of displacements; NaN without a solution.
fn parts(level: &TheoryLevel, of: fn(PartNorms) -> f64) -> [f64; 2] {
    let local = level.local.as_ref();
    [0, 1].map(|k| local.map_or(f64::NAN, |local| of(local.parts[k])))
}

fn put_parts(level: &mut TheoryLevel, norms: [f64; 2], of: fn(&mut PartNorms) -> &mut f64) {
    let parts = level.local.iter_mut().flat_map(|local| &mut local.parts);
    parts.zip(norms).for_each(|(part, norm)| *of(part) = norm);
}

fn paper_norms(level: &TheoryLevel) -> [f64; 2] {
    let local = level.local.as_ref();
    let norms = local.and_then(|local| local.paper.as_ref());
    [0, 1].map(|k| norms.map_or(f64::NAN, |norms| norms[k]))
}

fn put_paper_norms(level: &mut TheoryLevel, norms: [f64; 2]) {
    if let Some(local) = &mut level.local {
        local.paper = Some(norms.to_vec()).filter(|norms| norms.iter().all(|n| !n.is_nan()));
    }
}

/// Writes all that was measured.
pub fn write(writer: &mut GroupWriter<'_>, theory: &Theory) -> Result<(), StoreError> {
    let levels = &theory.levels;
    LAW.write_one(writer, theory)?;
    LEVELS.write_rows(writer, levels)?;
    let spaces = numbered(levels, |level| &level.inf_sup);
    if !spaces.is_empty() {
        INF_SUP.write_rows(writer, &spaces)?;
    }
    SCALED.write_rows(writer, &numbered(levels, |level| &level.scaled))
}

/// The rows of all meshes, each with the number of its mesh.
fn numbered<T: Copy>(levels: &[TheoryLevel], of: fn(&TheoryLevel) -> &Vec<T>) -> Vec<(usize, T)> {
    let levels = levels.iter().enumerate();
    let rows = levels.flat_map(|(k, level)| of(level).iter().map(move |row| (k, *row)));
    rows.collect()
}

/// Reads all that was measured.
pub fn read(reader: &Reader) -> Result<Theory, FormatError> {
    let mut theory = Theory::default();
    LAW.read_one(reader, &mut theory, true)?;
    let mut levels = LEVELS.read_rows(reader, blank_level)?;
    for level in &mut levels {
        level.local.take_if(|local| local.spectral_radius.is_nan());
        level.functional.take_if(|f| f.difference.is_nan());
    }
    if INF_SUP.is_there(reader) {
        let spaces = INF_SUP.read_rows(reader, Default::default)?;
        require_below(LEVEL, spaces.iter().map(|(k, _)| k), levels.len())?;
        for (k, row) in spaces {
            levels[k].inf_sup.push(row);
        }
    }
    let scaled = SCALED.read_rows(reader, Default::default)?;
    require_below(SCALED_LEVEL, scaled.iter().map(|(k, _)| k), levels.len())?;
    for (k, row) in scaled {
        levels[k].scaled.push(row);
    }
    Ok(Theory { levels, ..theory })
}

/// A mesh with room for all figures.
fn blank_level() -> TheoryLevel {
    let norms = DisplacementNorm::ALL.map(|norm| NormConstants {
        norm,
        ..NormConstants::default()
    });
    TheoryLevel {
        norms: norms.to_vec(),
        local: Some(LocalContraction {
            parts: vec![PartNorms::default(); 2],
            ..LocalContraction::default()
        }),
        observed: Observed {
            lemma: vec![[0.0; 2]; 2],
            quotient: vec![0.0; 2],
            ..Observed::default()
        },
        functional: Some(FrictionFunctional::default()),
        ..TheoryLevel::default()
    }
}
