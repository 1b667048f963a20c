//! How far the increments of a history on one mesh lie from the body, by one measure for all of them.

use super::StepRecord;
use crate::{
    post::{FunctionalEstimate, MAX_RELIABLE_ESTIMATE},
    scene::Functional,
};

/// The estimated errors of the increments of a history, all over the largest size in it: an increment that hardly deforms the body, or
/// in which a quantity passes through zero, has a large error over its own size, which says nothing of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryErrors {
    /// Estimate of each increment over the largest size, `[n_increments]`; NaN where it has none.
    pub relative: Vec<f64>,
    /// The largest that each tetrahedron contributes in any increment, `[n_tetrahedra]`: η_T in √J, of a quantity |share| in its unit.
    pub indicator: Vec<f64>,
}

/// The largest ‖u_h‖_A in √J over some increments.
#[must_use]
pub fn largest_norm(records: &[StepRecord]) -> f64 {
    let norms = records.iter().map(|record| 2.0 * record.energies.strain);
    norms.fold(0.0, f64::max).sqrt()
}

impl HistoryErrors {
    /// Those of the displacement in the energy norm, over the largest ‖u_h‖_A, or of a quantity, over its largest size; `None` where
    /// no increment has an estimate. Quantities of a displacement with an error of half of itself have that error.
    #[must_use]
    pub fn new(records: &[StepRecord], of: Option<Functional>) -> Option<Self> {
        let of_displacement = Self::of_displacement(records);
        let is_unreliable = |errors: &Self| errors.largest() >= MAX_RELIABLE_ESTIMATE;
        let Some(of) = of.filter(|_| !of_displacement.as_ref().is_some_and(is_unreliable)) else {
            return of_displacement;
        };
        let found = records.iter().map(|record| record.quantity(of));
        let found: Vec<Option<&FunctionalEstimate>> = found.collect();
        let size = largest(found.iter().flatten().map(|it| it.value.abs()));
        let bar = |it: &Option<&FunctionalEstimate>| {
            it.map_or(f64::NAN, |it| it.relative() * it.value.abs() / size)
        };
        let shares = found.iter().flatten().map(|it| &it.indicator);
        (size > 0.0).then(|| Self {
            relative: found.iter().map(bar).collect(),
            indicator: envelope(shares, f64::abs),
        })
    }

    fn of_displacement(records: &[StepRecord]) -> Option<Self> {
        let errors = records
            .iter()
            .map(|record| record.error_energy.iter().sum::<f64>().sqrt());
        // Of a body at rest that misses its contact the error is all of the solution.
        let size = largest_norm(records).max(largest(errors.clone()));
        let relative = |error: f64| if error == 0.0 { 0.0 } else { error / size };
        let is_estimated = records.iter().any(|record| !record.error_energy.is_empty());
        is_estimated.then(|| Self {
            relative: errors.map(relative).collect(),
            indicator: envelope(records.iter().map(|record| &record.error_energy), f64::sqrt),
        })
    }

    /// The largest estimate of an increment: that of the mesh.
    #[must_use]
    pub fn largest(&self) -> f64 {
        largest(self.relative.iter().copied())
    }
}

/// The largest of some numbers, NaN left out; 0 of none.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// The largest size that each entry has in any of some lists.
fn envelope<'a>(lists: impl Iterator<Item = &'a Vec<f64>>, size: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut most = Vec::new();
    for list in lists {
        most.resize(list.len(), 0.0_f64);
        let both = most.iter_mut().zip(list);
        both.for_each(|(most, value)| *most = most.max(size(*value)));
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::StepEnergies;

    fn record(strain: f64, squares: [f64; 2]) -> StepRecord {
        StepRecord {
            error_energy: squares.to_vec(),
            energies: StepEnergies {
                strain,
                ..StepEnergies::default()
            },
            ..StepRecord::default()
        }
    }

    /// An increment with half its norm as error, but hardly any norm, does not count; the envelope takes the worst of each tetrahedron.
    #[test]
    fn an_increment_of_hardly_any_deformation_does_not_count() {
        let records = [
            record(8.0, [0.16, 0.0]),
            record(8e-6, [0.0, 4e-6]),
            record(4.5, [0.09, 0.16]),
        ];
        let errors = HistoryErrors::new(&records, None).expect("estimates");
        // Roots of numbers that are no binary fractions: some roundings.
        let near = |found: f64, expected: f64| (found - expected).abs() <= 1e-15;
        let expected = [0.1, 5e-4, 0.125];
        let mut pairs = errors.relative.iter().zip(expected);
        assert!(
            pairs.all(|(found, expected)| near(*found, expected)),
            "{errors:?}"
        );
        assert!(near(errors.largest(), 0.125));
        assert_eq!(errors.indicator, [0.4, 0.4]);
        assert_eq!(HistoryErrors::new(&[StepRecord::default()], None), None);
    }

    /// What a quantity is in some increments is measured by its largest value, whatever its sign.
    #[test]
    fn quantities_are_measured_by_their_largest_value() {
        let force = |value: f64, bar: f64, shares: [f64; 2]| StepRecord {
            quantities: vec![FunctionalEstimate {
                functional: Functional::NormalForce,
                value,
                error: bar,
                range: [value - bar, value + bar],
                corners: None,
                kinks: 0,
                indicator: shares.to_vec(),
            }],
            ..StepRecord::default()
        };
        let records = [
            force(0.5, 0.25, [0.25, 0.0]),
            StepRecord::default(),
            force(-4.0, 1.0, [-0.75, -0.25]),
        ];
        let errors = HistoryErrors::new(&records, Some(Functional::NormalForce));
        let errors = errors.expect("estimates");
        assert_eq!(errors.relative[0], 0.0625);
        assert!(errors.relative[1].is_nan());
        assert_eq!(errors.largest(), 0.25);
        assert_eq!(errors.indicator, [0.75, 0.25]);
    }
}
