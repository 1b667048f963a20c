//! Laws of friction over the slip.

use std::path::PathBuf;

use contact3d::{contact::FaceLaw, scene::Scene};
use plots::{AxisScale, Chart, ChartAxis, ChartPoint, Series};
use units::{Dimension, Unit, Units};

use super::{Drawing, PictureFolder, picture::endings_of};
use crate::pipeline::StageError;

/// What the names of pictures begin with.
const PICTURE: &str = "friction_law";

/// The names of all pictures with these endings.
pub(super) fn names(endings: &[String]) -> Vec<String> {
    let names = endings.iter().map(|ending| format!("{PICTURE}{ending}"));
    names.collect()
}

/// The pictures of the laws of a scene that may be drawn.
pub fn drawing_of_laws(scene: &Scene) -> Drawing {
    Drawing::Law(endings_of(scene))
}

/// Draws laws below their titles, each with the number of its contact face, for slips up to the extent of the body; returns the files.
pub fn draw_laws<'a>(
    folder: &PictureFolder,
    scene: &Scene,
    laws: impl Iterator<Item = (usize, String, &'a FaceLaw)>,
    extent: f64,
) -> Result<Vec<PathBuf>, StageError> {
    let names = names(&endings_of(scene));
    let charts = laws.map(|(face, title, law)| {
        let chart = chart(law, &title, extent, scene.units);
        (names[face].clone(), chart)
    });
    folder.save_charts(charts)
}

/// Each coefficient over the slip along its axis, without slip along the other one; where it depends on the place, at the contact
/// node nearest to the middle.
fn chart(law: &FaceLaw, title: &str, extent: f64, units: Units) -> Chart {
    let coefficients = law.coefficients();
    let place = middle_node(&law.positions);
    let value = |axis: usize, slip: f64| {
        let slips = [0, 1].map(|k| if k == axis { slip } else { 0.0 });
        coefficients[axis].evaluate(&law.law.point([0.0; 3], axis, place, slips))
    };
    let axes = 0..coefficients.len();
    let (scale, [low, high]) = slips_of_change(axes.clone(), extent, value);
    let series = axes.map(|axis| {
        let at = |k: u32| match (scale, f64::from(k) / 200.0) {
            (AxisScale::Linear, share) => share * high,
            (AxisScale::Logarithmic, share) => low * (high / low).powf(share),
        };
        let kinks = coefficients[axis].kinks(axis)[axis].clone();
        let kinks = kinks.into_iter().filter(|kink| (low..high).contains(kink));
        let mut slips: Vec<f64> = (0..=200).map(at).chain(kinks).collect();
        slips.sort_by(f64::total_cmp);
        let name = match coefficients.len() {
            1 => "F".to_owned(),
            _ => format!("F{}", axis + 1),
        };
        let points = slips.into_iter().map(|x| {
            let y = value(axis, x);
            let text = format!("{name} = {y:.4} at {x:.4e}");
            ChartPoint { x, y, text }
        });
        Series::new(&name, points.collect::<Vec<_>>())
    });
    let mut slip = match coefficients.len() {
        1 => "slip |u_t|",
        _ => "slip |u_t1| or |u_t2|, without the other",
    }
    .to_owned();
    if law.law.depends_on_place() {
        let [x, y, z] = place;
        slip += &format!(" at x, y, z = {x:.4}, {y:.4}, {z:.4}");
    }
    let slip = ChartAxis {
        scale,
        ..ChartAxis::linear(&slip, units.of(Dimension::LENGTH))
    };
    let coefficient = ChartAxis::linear("coefficient of friction", Unit::none());
    Chart::new(title, slip, coefficient, series)
}

/// The slips between which coefficients change, all up to the extent of the body where they do not: by powers of ten over more than two
/// decades.
fn slips_of_change(
    axes: impl Iterator<Item = usize>,
    extent: f64,
    value: impl Fn(usize, f64) -> f64,
) -> (AxisScale, [f64; 2]) {
    // Sixteen slips in each of twelve decades.
    let series = (0..=192).rev();
    let series = series.map(|k| extent * 10_f64.powf(-f64::from(k) / 16.0));
    let slips: Vec<f64> = [0.0].into_iter().chain(series).collect();
    let changes = axes.filter_map(|axis| {
        let values: Vec<f64> = slips.iter().map(|slip| value(axis, *slip)).collect();
        let ends = values.iter().fold([f64::INFINITY, 0.0_f64], |ends, v| {
            [ends[0].min(*v), ends[1].max(*v)]
        });
        // A coefficient within this share of its range of an end is not yet, or no longer, changing.
        let differs = |from: f64| move |v: &f64| (v - from).abs() > 0.05 * (ends[1] - ends[0]);
        let first = values.iter().position(differs(values[0]))?;
        let last = values.iter().rposition(differs(*values.last()?))?;
        let before = slips[first.saturating_sub(1).max(1)];
        Some([before, slips[(last + 1).min(slips.len() - 1)]])
    });
    match changes.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]) {
        None => (AxisScale::Linear, [0.0, extent]),
        Some([first, last]) if last > 100.0 * first => {
            let ends = [first / 3.0, extent.min(3.0 * last)];
            (AxisScale::Logarithmic, ends)
        }
        Some([_, last]) => (AxisScale::Linear, [0.0, extent.min(1.5 * last)]),
    }
}

/// The contact node nearest to the mean of all.
fn middle_node(positions: &[[f64; 3]]) -> [f64; 3] {
    let mean = [0, 1, 2].map(|c| {
        let sum: f64 = positions.iter().map(|x| x[c]).sum();
        sum / positions.len() as f64
    });
    let distance = |x: &[f64; 3]| (0..3).map(|c| (x[c] - mean[c]).powi(2)).sum::<f64>();
    let nearest = positions
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact3d::scene::{Coefficient, Formula, FrictionLaw};

    /// The axis of a law and the ends of its curve.
    fn drawn(text: &str) -> (AxisScale, [f64; 2]) {
        let formula = Coefficient::Expression(Formula::parse(text).unwrap());
        let law = FaceLaw::new("friction", FrictionLaw::Isotropic(formula), vec![[0.0; 3]]);
        let chart = chart(&law, "a law", 3.0, Units::SI);
        let points = &chart.series[0].points;
        (chart.x.scale, [points[0].x, points[points.len() - 1].x])
    }

    #[test]
    fn axes_show_the_change() {
        // exp(-s/c) is within 5 % of its range of the end from 3 c on; samples are 15 % apart.
        let (scale, [low, high]) = drawn("0.2 + 0.1*exp(-s/1e-5)");
        assert_eq!((scale, low), (AxisScale::Linear, 0.0));
        assert!((4.5e-5..6e-5).contains(&high), "{high}");
        let (scale, [low, high]) = drawn("0.3 - 0.1/(1 + 1e-9/(s + 1e-13))");
        assert_eq!(scale, AxisScale::Logarithmic);
        assert!(low < 1e-9 && high > 1e-8, "{low} {high}");
        assert_eq!(drawn("0.3"), (AxisScale::Linear, [0.0, 3.0]));
    }
}
