//! Whether the figures of a solution are numbers that double precision can compute with.

use std::fmt;

use super::{ContactReport, Solved};
use crate::solver::Status;

/// A figure that is not finite, or so large or small that sums of its squares are not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfRange {
    /// Which figure.
    pub figure: &'static str,
    /// Its value: for fields the largest magnitude, or what is not finite.
    pub value: f64,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, value } = self;
        if value.is_finite() {
            write!(
                f,
                "the {figure} {value:.1e} is outside the range in which double precision can square and sum; choose units in which loads, stiffness and sizes are moderate"
            )
        } else {
            write!(
                f,
                "the {figure} is not finite; check loads, material and sizes, and choose units in which they are moderate"
            )
        }
    }
}

impl ContactReport {
    /// The status of the solve that this report is about: one whose figures are out of range has
    /// failed.
    #[must_use]
    pub fn judged(&self, status: Status) -> Status {
        match self.out_of_range {
            Some(_) => Status::NumericalError,
            None => status,
        }
    }

    /// The first figure that is out of range.
    pub(super) fn find_out_of_range(&self, solved: &Solved<'_>) -> Option<OutOfRange> {
        self.fields(solved)
            .into_iter()
            .find_map(|(figure, largest)| field(figure, largest, solved.mesh.coordinates.len()))
            .or_else(|| self.find_not_finite(solved))
            .or_else(|| self.find_lost_energy())
    }

    /// The largest magnitude of every field; NaN if any value is.
    fn fields(&self, solved: &Solved<'_>) -> Vec<(&'static str, f64)> {
        let slips = self.panes.iter().filter_map(|pane| pane.friction);
        vec![
            ("load", largest(&solved.system.load)),
            ("displacement", largest(&solved.solution.displacement)),
            ("multiplier", largest(&solved.solution.multiplier)),
            ("stress", largest(self.stress.as_flattened())),
            ("von Mises stress", largest(&self.von_mises)),
            (
                "slip",
                slips.fold(0.0, |most, pane| more(most, largest(&pane.slip))),
            ),
        ]
    }

    /// The first figure that is infinite or no number.
    fn find_not_finite(&self, solved: &Solved<'_>) -> Option<OutOfRange> {
        let r = &self.resultants;
        let forces = [&r.applied_force, &r.clamp_force].into_iter().flatten();
        let panes = self.panes.iter();
        let semi_axes = panes.clone().filter_map(|pane| pane.friction);
        let mut figures: Vec<(&'static str, f64)> = vec![
            ("accuracy", solved.solution.accuracy),
            ("strain energy", r.strain_energy),
            ("work of the loads", r.load_work),
            ("imbalance of forces", r.force_imbalance),
            ("imbalance of moments", r.moment_imbalance),
        ];
        figures.extend(forces.map(|force| ("sum of forces", *force)));
        figures.extend(r.moments.as_flattened().iter().map(|m| ("moment", *m)));
        figures.extend(panes.map(|pane| ("gap", pane.gap)));
        figures.extend(semi_axes.map(|pane| ("friction bound", largest(&pane.semi_axes))));
        if let Some(contact) = &r.contact {
            figures.extend(contact.contact_force.map(|force| ("contact force", force)));
            let tangential = contact.tangential_force.into_iter().flatten();
            figures.extend(tangential.map(|force| ("tangential contact force", force)));
        }
        figures.extend(self.certificate.figures());
        let mut found = figures.into_iter().filter(|(_, value)| !value.is_finite());
        found
            .next()
            .map(|(figure, value)| OutOfRange { figure, value })
    }

    /// A body that moves stores energy; where that underflows, so does every figure made of
    /// products.
    fn find_lost_energy(&self) -> Option<OutOfRange> {
        let value = self.resultants.strain_energy;
        let moves = self.resultants.largest_displacement != [0.0; 3];
        (moves && value.abs() < f64::MIN_POSITIVE).then_some(OutOfRange {
            figure: "strain energy",
            value,
        })
    }
}

/// A field whose norm, the root of a sum of squares over all nodes, overflows or underflows.
fn field(figure: &'static str, value: f64, nodes: usize) -> Option<OutOfRange> {
    let square = value * value;
    let holds = value == 0.0
        || square >= f64::MIN_POSITIVE && square <= f64::MAX / (100 * nodes.max(1)) as f64;
    (!holds).then_some(OutOfRange { figure, value })
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| more(most, *value))
}

/// max(most, |value|), and NaN if either is.
fn more(most: f64, value: f64) -> f64 {
    let value = value.abs();
    if value > most || value.is_nan() {
        value
    } else {
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_that_overflow_underflow_or_are_no_numbers_are_found() {
        assert!(largest(&[1.0, f64::NAN, -3.0]).is_nan());
        assert_eq!(largest(&[1.0, -3.0]), 3.0);
        for value in [1e-320, 1e-160, 1e153, 1e200, f64::INFINITY, f64::NAN] {
            assert!(field("load", value, 100_000).is_some(), "{value}");
        }
        for value in [0.0, 1e-150, 1e-9, 1.0, 1e150] {
            assert_eq!(field("load", value, 100_000), None, "{value}");
        }
    }
}
