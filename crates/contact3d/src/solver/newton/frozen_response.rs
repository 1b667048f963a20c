//! How the minimiser of a frozen problem moves with its ellipses.

use faer::{MatMut, MatRef, prelude::Solve};

use super::natural_map::NaturalMap;
use crate::{
    dual::{ExplicitDual, LocalStiffness},
    solver::{
        CoulombState, PaneLaws,
        conditions::{Bound, PaneEvaluation},
    },
};

/// The derivative of the frozen problem's minimiser λ by the slip bounds g and by 𝓕⁻¹, column-major, `[n_multipliers,
/// n_multipliers]`: the columns follow [`crate::contact::MultiplierLayout`], m derivatives by g_i, then m pairs by the
/// two diagonal entries of 𝓕_i⁻¹, in Pa. With R(λ; x) = 0 for the natural map of frozen x it is −R_λ⁻¹ R_x.
///
/// At kinks it is one-sided; where g_i = 0 it is that of a growing bound, which moves λ_t along F² u_t. `None` where R_λ is
/// singular, or without friction.
#[must_use]
pub fn frozen_response(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    laws: &PaneLaws,
    state: &CoulombState,
    multiplier: &[f64],
) -> Option<Vec<f64>> {
    let set = laws.feasible_set(Some(state));
    let steplengths = local.stiffness.clone();
    let map = NaturalMap::with_steplengths(dual, Bound::Frozen(&set), steplengths);
    let evaluation = map.evaluate(multiplier);
    let n = multiplier.len();
    let mut response = vec![0.0; n * n];
    for (pane, at) in evaluation.panes.iter().enumerate() {
        let rows = dual.layout.tangential(pane)?;
        let inverse = state.friction.pane_inverse[pane];
        let columns = [dual.layout.normal(pane), rows[0], rows[1]];
        for (column, moved) in columns.into_iter().zip(by_state(at, inverse)) {
            for (row, value) in rows.into_iter().zip(moved) {
                response[column * n + row] = value;
            }
        }
    }
    let matrix = map.derivative(&evaluation);
    let lu = MatRef::from_column_major_slice(&matrix, n, n).partial_piv_lu();
    lu.solve_in_place(MatMut::from_column_major_slice_mut(&mut response, n, n));
    // The rows of open panes are those of the identity, but for what elimination rounds.
    let open = evaluation
        .panes
        .iter()
        .enumerate()
        .filter(|(_, at)| !at.pressed);
    for row in open.map(|(pane, _)| dual.layout.normal(pane)) {
        response
            .iter_mut()
            .skip(row)
            .step_by(n)
            .for_each(|value| *value = 0.0);
    }
    response.iter().all(|v| v.is_finite()).then_some(response)
}

/// ∂P/∂g, ∂P/∂𝓕⁻¹₁ and ∂P/∂𝓕⁻¹₂ of the projection on the ellipse with semi-axes g / 𝓕⁻¹.
fn by_state(at: &PaneEvaluation, inverse: [f64; 2]) -> [[f64; 2]; 3] {
    let axes = at.ellipse.semi_axes;
    if axes == [0.0; 2] {
        return [support(at.trial, inverse), [0.0; 2], [0.0; 2]];
    }
    let by_axes = at.ellipse.projection_derivative(at.trial).by_semi_axes;
    let by_axis = |k: usize| [by_axes[0][k], by_axes[1][k]];
    let by_inverse = |k: usize| by_axis(k).map(|d| -d * axes[k] / inverse[k]);
    let by_bound = [0, 1].map(|row| by_axes[row][0] / inverse[0] + by_axes[row][1] / inverse[1]);
    [by_bound, by_inverse(0), by_inverse(1)]
}

/// The point of the ellipse with semi-axes 1 / 𝓕⁻¹ that lies furthest along z: the projection on an ellipse that begins to grow.
fn support(z: [f64; 2], inverse: [f64; 2]) -> [f64; 2] {
    let scaled = [z[0] / inverse[0], z[1] / inverse[1]];
    match scaled[0].hypot(scaled[1]) {
        0.0 => [0.0; 2],
        length => [0, 1].map(|k| scaled[k] / inverse[k] / length),
    }
}
