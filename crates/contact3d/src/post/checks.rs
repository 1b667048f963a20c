//! The checks that every solution passes: no figure is out of range, or contradicts the accuracy that the solve claims.

use std::fmt;

use super::{ContactReport, Rounding, Solved, largest, rounding::Measure};
use crate::{
    linalg::dot,
    mesh::Mesh,
    solver::{Assessment, Solution},
};

/// A solution with a residual above this is none, whatever rounding explains: nothing of it can be relied on.
const MAX_RESIDUAL: f64 = 1e-3;

/// The same of the balance of forces: displacements are solved to rounding whatever λ is, and where ten digits are missing the supports
/// are softer beside the body, or beside each other, than double precision can tell.
const MAX_IMBALANCE: f64 = 1e-6;

/// Why a solution cannot be what its solve took it for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CheckFailure {
    /// A figure that is not finite, or so large or small that sums of its squares are not.
    OutOfRange {
        /// Which figure.
        figure: &'static str,
        /// Its value: for fields the largest magnitude, or what is not finite.
        value: f64,
    },
    /// A residual larger than the accuracy of the answer and rounding explain.
    Contradiction {
        /// Which figure of the certificate, or of the balance of forces.
        figure: &'static str,
        /// Its value, without unit.
        value: f64,
        /// The largest that fits.
        allowed: f64,
        /// The largest with which it is an answer.
        most: f64,
    },
}

impl fmt::Display for CheckFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { figure, value } if value.is_finite() => write!(
                f,
                "the {figure} {value:.1e} is outside the range in which double precision can square and sum; choose units in which loads, stiffness and sizes are moderate"
            ),
            Self::OutOfRange { figure, .. } => write!(
                f,
                "the {figure} is not finite; check loads, material and sizes, and choose units in which they are moderate"
            ),
            Self::Contradiction {
                figure,
                value,
                allowed,
                ..
            } => write!(
                f,
                "the answer does not satisfy its equations: {figure} is {}, and at most {allowed:.1e} would fit; check what holds the body, and that sizes and moduli of its parts are of similar magnitude",
                // Of what exceeds all that acts no digit tells anything.
                if *value > 1.0 {
                    "more than 1".to_owned()
                } else {
                    format!("{value:.1e}")
                }
            ),
        }
    }
}

impl Solution {
    /// Whether panes alone let a mechanism be: some contact node moves into the foundation or the other body in it, which the mean displacements of its
    /// panes do not show, so that it proves nothing of the body.
    #[must_use]
    pub fn is_mechanism_of_panes(&self, mesh: &Mesh) -> bool {
        let mechanism = self
            .rigid
            .as_ref()
            .and_then(|rigid| rigid.mechanism.as_ref());
        let (Some(motion), Some(surface)) = (mechanism, &mesh.contact) else {
            return false;
        };
        if motion.len() > mesh.coordinates.len() {
            // With tools it is the motion against them that counts.
            return false;
        }
        let mut nodes = surface.nodes.iter().enumerate();
        nodes.any(|(contact_node, node)| {
            let normal = surface.normal_at(contact_node);
            let opposite = surface.opposite.as_ref();
            let opposite = opposite.into_iter().flat_map(|of| of.at_node(contact_node));
            let away = opposite.map(|(node, share)| share * dot(&normal, &motion[node]));
            // The largest component of the motion is one.
            dot(&normal, &motion[*node]) - away.sum::<f64>() > 1e-3
        })
    }
}

impl ContactReport {
    /// Holds a solution against this report of it: the one place where a figure may take back what a solve claims.
    ///
    /// Figures out of range make it a `numerical_error`. A residual that contradicts the accuracy is its accuracy from then on,
    /// and `converged` becomes `machine_precision`; above a thousandth the answer is `inaccurate`, and none.
    pub fn classify(&self, solution: &mut Solution) {
        solution.assess(self.left_of(solution.assessment()));
    }

    /// What the failed check leaves of an assessment.
    pub(crate) fn left_of(&self, claimed: Assessment) -> Assessment {
        match self.failed_check {
            None => claimed,
            Some(CheckFailure::OutOfRange { .. }) => claimed.out_of_range(),
            Some(CheckFailure::Contradiction { value, .. }) => {
                claimed.with_residual(value, self.is_broken())
            }
        }
    }

    /// Whether the answer has a figure that makes it none.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        match self.failed_check {
            Some(CheckFailure::OutOfRange { .. }) => true,
            Some(CheckFailure::Contradiction { value, most, .. }) => value > most,
            None => false,
        }
    }

    /// The first check that fails.
    pub(super) fn first_failed_check(
        &self,
        solved: &Solved<'_>,
        rounding: &Rounding,
        rounding_energy: f64,
    ) -> Option<CheckFailure> {
        self.check_range(solved)
            .or_else(|| self.check_energy(solved, rounding_energy))
            .or_else(|| self.check_residuals(solved.solution, rounding))
            .or_else(|| {
                let value = self.discretisation_error.relative();
                let claimed = solved.solution.status.is_solved();
                (claimed && !value.is_finite()).then_some(CheckFailure::OutOfRange {
                    figure: "estimated discretisation error",
                    value,
                })
            })
    }

    /// The residual that most exceeds what accuracy and rounding explain; of a solve that failed none, since it claims nothing.
    fn check_residuals(&self, solution: &Solution, rounding: &Rounding) -> Option<CheckFailure> {
        if !solution.status.is_solved() {
            return None;
        }
        let accuracy = solution.accuracy;
        let rigid_compliance_ratio = rounding.rigid_compliance_ratio();
        let found = self.residuals().map(|(figure, value, measure, broken)| {
            let moves = match measure {
                Measure::Balance => 1.0,
                Measure::Stress | Measure::Work => rigid_compliance_ratio,
            };
            // Residuals are largest entries, accuracies are means over the face: they may differ by about a hundred.
            let by_accuracy = 100.0 * accuracy * moves;
            // Rounding of λ alone moves bodies that nearly float by so much that residuals of 1e-10 are met in right solutions.
            let allowed = (by_accuracy + rounding.of(measure)).max(f64::EPSILON.sqrt());
            // What only rounding explains is no answer either.
            let most = broken.max(by_accuracy);
            let allowed = allowed.min(most);
            (figure, value, allowed, most)
        });
        found
            .filter(|(_, value, allowed, _)| value > allowed)
            .max_by(|a, b| {
                let is_broken = |it: &(&str, f64, f64, f64)| it.1 > it.3;
                let worse = (a.1 / a.2).total_cmp(&(b.1 / b.2));
                is_broken(a).cmp(&is_broken(b)).then(worse)
            })
            .map(
                |(figure, value, allowed, most)| CheckFailure::Contradiction {
                    figure,
                    value,
                    allowed,
                    most,
                },
            )
    }

    /// Every residual.
    fn residuals(&self) -> impl Iterator<Item = (&'static str, f64, Measure, f64)> {
        let r = &self.resultants;
        let balance = [
            ("force imbalance", r.force_imbalance),
            ("moment imbalance", r.moment_imbalance),
        ];
        let balance =
            balance.map(|(figure, value)| (figure, value, Measure::Balance, MAX_IMBALANCE));
        let certificate = self.certificate.measured();
        let certificate = certificate.into_iter();
        let certificate =
            certificate.map(|(figure, value, measure)| (figure, value, measure, MAX_RESIDUAL));
        balance.into_iter().chain(certificate)
    }

    /// The first figure that is out of range.
    fn check_range(&self, solved: &Solved<'_>) -> Option<CheckFailure> {
        self.fields(solved)
            .into_iter()
            .find_map(|(figure, largest)| field(figure, largest, solved.mesh.coordinates.len()))
            .or_else(|| self.check_finite(solved))
    }

    /// The largest magnitude of every field; NaN if any value is.
    fn fields(&self, solved: &Solved<'_>) -> Vec<(&'static str, f64)> {
        let size = |values: &[f64]| largest(values.iter().copied());
        let slips = self.panes.iter().filter_map(|pane| pane.friction);
        vec![
            ("load", size(&solved.system.load)),
            ("displacement", size(&solved.solution.displacement)),
            ("multiplier", size(&solved.solution.multiplier)),
            ("stress", size(self.stress.as_flattened())),
            ("von Mises stress", size(&self.von_mises)),
            ("slip", largest(slips.flat_map(|pane| pane.slip))),
        ]
    }

    /// The first figure that is infinite or no number.
    fn check_finite(&self, solved: &Solved<'_>) -> Option<CheckFailure> {
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
        figures
            .extend(semi_axes.map(|pane| ("friction bound", largest(pane.semi_axes.into_iter()))));
        if let Some(contact) = &r.contact {
            figures.extend(contact.contact_force.map(|force| ("contact force", force)));
            let tangential = contact.tangential_force.into_iter().flatten();
            figures.extend(tangential.map(|force| ("tangential multiplier force", force)));
        }
        figures.extend(self.certificate.figures());
        let mut found = figures.into_iter().filter(|(_, value)| !value.is_finite());
        found
            .next()
            .map(|(figure, value)| CheckFailure::OutOfRange { figure, value })
    }

    /// A body that moves stores energy, at least by rounding; where that underflows, so does every figure made of products. One that no
    /// force acts on may lie anywhere.
    fn check_energy(&self, solved: &Solved<'_>, rounding: f64) -> Option<CheckFailure> {
        let mut forces = solved.system.load.iter().chain(&solved.solution.multiplier);
        if solved.system.rigid_modes.is_some() && forces.all(|force| *force == 0.0) {
            return None;
        }
        let value = self.resultants.strain_energy;
        let moves = self.resultants.largest_displacement_along != [0.0; 3];
        let is_lost = value.abs().max(rounding) < f64::MIN_POSITIVE;
        (moves && is_lost).then_some(CheckFailure::OutOfRange {
            figure: "strain energy",
            value,
        })
    }
}

/// A field whose norm, the root of a sum of squares over all nodes, overflows or underflows.
fn field(figure: &'static str, value: f64, nodes: usize) -> Option<CheckFailure> {
    let square = value * value;
    let holds = value == 0.0
        || square >= f64::MIN_POSITIVE && square <= f64::MAX / (100 * nodes.max(1)) as f64;
    (!holds).then_some(CheckFailure::OutOfRange { figure, value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_that_overflow_underflow_or_are_no_numbers_are_found() {
        assert!(largest([1.0, f64::NAN, -3.0].into_iter()).is_nan());
        assert_eq!(largest([1.0, -3.0].into_iter()), 3.0);
        for value in [1e-320, 1e-160, 1e153, 1e200, f64::INFINITY, f64::NAN] {
            assert!(field("load", value, 100_000).is_some(), "{value}");
        }
        for value in [0.0, 1e-150, 1e-9, 1.0, 1e150] {
            assert_eq!(field("load", value, 100_000), None, "{value}");
        }
    }
}
