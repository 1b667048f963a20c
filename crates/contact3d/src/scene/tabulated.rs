//! Coefficients tabulated over one slip or over both.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Values over increasing slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Slips in m, increasing from 0 on.
    pub slip: Vec<f64>,
    /// Coefficient at each slip.
    pub value: Vec<f64>,
}

/// Values over a grid of both slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Slips |u_t1| in m, increasing from 0 on.
    pub slip_1: Vec<f64>,
    /// Slips |u_t2| in m, increasing from 0 on.
    pub slip_2: Vec<f64>,
    /// Coefficients: one row for each entry of `slip_1`, one column for each of `slip_2`.
    pub value: Vec<Vec<f64>>,
}

impl Table {
    /// Value and slope, taken from the left at a knot.
    pub(super) fn evaluate(&self, slip: f64) -> (f64, f64) {
        interpolate(&self.slip, &self.value, slip)
    }
}

/// The cell of a table that holds ζ, taken from the left, and the relative place in it; `None`
/// outside the table, with the index of the nearest entry.
fn cell(knots: &[f64], slip: f64) -> Result<(usize, f64), usize> {
    let above = knots.partition_point(|&knot| knot < slip);
    if above == 0 {
        Err(0)
    } else if above == knots.len() {
        Err(above - 1)
    } else {
        let (low, high) = (knots[above - 1], knots[above]);
        Ok((above - 1, (slip - low) / (high - low)))
    }
}

/// Value and slope of the piecewise linear function through (knots, values).
fn interpolate(knots: &[f64], values: &[f64], slip: f64) -> (f64, f64) {
    match cell(knots, slip) {
        Err(end) => (values[end], 0.0),
        Ok((i, t)) => {
            let rise = values[i + 1] - values[i];
            (values[i] + t * rise, rise / (knots[i + 1] - knots[i]))
        }
    }
}

impl Grid {
    /// Value and gradient.
    pub(super) fn evaluate(&self, slip: [f64; 2]) -> (f64, [f64; 2]) {
        let along_second = |row: usize| interpolate(&self.slip_2, &self.value[row], slip[1]);
        match cell(&self.slip_1, slip[0]) {
            Err(end) => {
                let (value, slope) = along_second(end);
                (value, [0.0, slope])
            }
            Ok((i, t)) => {
                let (low, high) = (along_second(i), along_second(i + 1));
                let width = self.slip_1[i + 1] - self.slip_1[i];
                (
                    low.0 + t * (high.0 - low.0),
                    [(high.0 - low.0) / width, low.1 + t * (high.1 - low.1)],
                )
            }
        }
    }
}
