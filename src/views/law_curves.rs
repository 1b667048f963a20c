//! Curves and maps of the coefficients of a law over the slips.

use contact3d::scene::FrictionLaw;
use plots::{OverSlip, SlipCoefficientMap, SlipCurve, SlipRange};

/// Decades of slips below the extent of the body that are looked at, and samples in each.
const DECADES: i32 = 12;
const PER_DECADE: i32 = 16;
/// Samples of a curve, and cells along each axis of a map.
const SAMPLES: u32 = 400;
const CELLS: usize = 60;

/// Samples a law at one place over the slips at which it changes.
pub(super) fn over_slip(law: &FrictionLaw, place: [f64; 3], extent: f64) -> OverSlip {
    let coefficients = law.coefficients();
    let value =
        |axis: usize, slip: [f64; 2]| coefficients[axis].evaluate(&law.point(axis, place, slip));
    let change = |axis: usize, k: usize| SlipInterval::of(extent, k, |slip| value(axis, slip));
    let curve = |axis: usize, range: SlipRange| {
        let samples = (0..=SAMPLES).map(|i| range.at(f64::from(i) / f64::from(SAMPLES)));
        let mut slips: Vec<f64> = coefficients[axis].kinks(axis)[axis].clone();
        slips.retain(|slip| (range.at(0.0)..range.at(1.0)).contains(slip));
        slips.extend(samples);
        slips.sort_by(f64::total_cmp);
        let point = |slip: f64| {
            let mut slips = [0.0; 2];
            slips[axis] = slip;
            [slip, value(axis, slips)]
        };
        SlipCurve {
            range,
            points: slips.into_iter().map(point).collect(),
        }
    };
    if coefficients.len() == 1 {
        return OverSlip::Own(vec![curve(0, SlipInterval::range(change(0, 0), extent))]);
    }
    let couples = (0..2).any(|axis| coefficients[axis].slips_used(axis)[1 - axis]);
    if !couples {
        let range = SlipInterval::range(SlipInterval::joined(change(0, 0), change(1, 1)), extent);
        return OverSlip::Own(Vec::from([0, 1].map(|axis| curve(axis, range))));
    }
    let ranges = [0, 1]
        .map(|k| SlipInterval::range(SlipInterval::joined(change(0, k), change(1, k)), extent));
    OverSlip::Both([0, 1].map(|axis| {
        let centre = |cell: usize| (cell as f64 + 0.5) / CELLS as f64;
        let slip = |cell: usize| {
            [
                ranges[0].at(centre(cell % CELLS)),
                ranges[1].at(centre(cell / CELLS)),
            ]
        };
        SlipCoefficientMap {
            ranges,
            cells: CELLS,
            values: (0..CELLS * CELLS)
                .map(|cell| value(axis, slip(cell)))
                .collect(),
        }
    }))
}

/// The slips between which a coefficient changes.
#[derive(Clone, Copy)]
struct SlipInterval {
    first: f64,
    last: f64,
}

impl SlipInterval {
    /// Along slip k, for slips of the other axis of every decade; `None` for no change.
    fn of(extent: f64, k: usize, value: impl Fn([f64; 2]) -> f64) -> Option<Self> {
        let series = |per_decade: i32| {
            let exponents = (0..=DECADES * per_decade).rev();
            let slip = move |e: i32| extent * 10f64.powf(-f64::from(e) / f64::from(per_decade));
            std::iter::once(0.0).chain(exponents.map(slip))
        };
        let slips: Vec<f64> = series(PER_DECADE).collect();
        let lines: Vec<Vec<f64>> = series(1)
            .map(|other| {
                let at = |&slip: &f64| value(if k == 0 { [slip, other] } else { [other, slip] });
                slips.iter().map(at).collect()
            })
            .collect();
        let all = lines.iter().flatten().copied();
        let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        // Share of the range of a coefficient within which it counts as not yet, or no longer, changing.
        let still = 0.05 * (high - low);
        let changes = lines.iter().filter_map(|line| {
            let differs = |from: f64| move |v: &f64| (v - from).abs() > still;
            let first = line.iter().position(differs(line[0]))?;
            let last = line.iter().rposition(differs(line[line.len() - 1]))?;
            Some(Self {
                first: slips[first.saturating_sub(1).max(1)],
                last: slips[(last + 1).min(slips.len() - 1)],
            })
        });
        changes.reduce(Self::with)
    }

    fn with(self, other: Self) -> Self {
        Self {
            first: self.first.min(other.first),
            last: self.last.max(other.last),
        }
    }

    fn joined(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        match (first, second) {
            (Some(first), Some(second)) => Some(first.with(second)),
            (one, other) => one.or(other),
        }
    }

    /// The axis that shows a change; the whole range of slips where there is none.
    fn range(change: Option<Self>, extent: f64) -> SlipRange {
        match change {
            None => SlipRange::Linear(extent),
            // Changes over a larger ratio of slips are shown by powers of ten.
            Some(Self { first, last }) if last > 100.0 * first => {
                SlipRange::Logarithmic(first / 3.0, extent.min(3.0 * last))
            }
            Some(Self { last, .. }) => SlipRange::Linear(extent.min(1.5 * last)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact3d::scene::{Coefficient, Formula};

    fn range_of(text: &str) -> SlipRange {
        let formula = Coefficient::Expression(Formula::parse(text).unwrap());
        match over_slip(&FrictionLaw::Isotropic(formula), [0.0; 3], 3.0) {
            OverSlip::Own(curves) if curves.len() == 1 => curves[0].range,
            _ => panic!("an isotropic law is one curve"),
        }
    }

    #[test]
    fn axes_show_the_change() {
        // exp(-s/c) is within 5 % of its range of the end from 3 c on; samples are 15 % apart.
        let SlipRange::Linear(high) = range_of("0.2 + 0.1*exp(-s/1e-5)") else {
            panic!("a change over less than two decades");
        };
        assert!((4.5e-5..6e-5).contains(&high), "{high}");
        let SlipRange::Logarithmic(low, high) = range_of("0.3 - 0.1/(1 + 1e-9/(s + 1e-13))") else {
            panic!("a change over many decades");
        };
        assert!(low < 1e-9 && high > 1e-8, "{low} {high}");
        assert_eq!(range_of("0.3"), SlipRange::Linear(3.0));
    }
}
