//! How far apart two multipliers are, in the norm that accuracy is promised in.

use crate::{
    linalg::norm,
    solver::{PaneLaws, conditions::Evaluation},
};

/// The norms ‖λ_ν‖ and max(‖λ_t‖, ‖F λ_ν‖) of a multiplier over Γ_c, in Pa·m.
///
/// Areas weigh the panes, so that the size of a pane does not matter; the tangential stress is
/// compared with what friction could bear, so that a face that hardly holds anything is not asked
/// for digits of nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::solver) struct Sizes {
    normal: f64,
    tangential: f64,
}

impl Sizes {
    /// The sizes at λ, whose ellipses are those of `evaluation`.
    pub(in crate::solver) fn of(
        laws: &PaneLaws,
        multiplier: &[f64],
        evaluation: &Evaluation,
    ) -> Self {
        let [normal, tangential] = parts(laws, multiplier);
        let strengths = evaluation.panes.iter().zip(&laws.area);
        let strengths = strengths.map(|(pane, area)| {
            let [a, b] = pane.ellipse.semi_axes;
            area.sqrt() * a.max(b)
        });
        Self {
            normal,
            tangential: tangential.max(norm(&strengths.collect::<Vec<f64>>())),
        }
    }

    /// The larger of the relative normal and tangential sizes of a difference of multipliers; 0 for
    /// 0/0.
    pub(in crate::solver) fn relative(&self, laws: &PaneLaws, difference: &[f64]) -> f64 {
        let [normal, tangential] = parts(laws, difference);
        let ratio = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
        let (normal, tangential) = (
            ratio(normal, self.normal),
            ratio(tangential, self.tangential),
        );
        if normal.is_nan() || tangential.is_nan() {
            f64::NAN
        } else {
            normal.max(tangential)
        }
    }
}

/// The size of (d₁/a, d₂/b) for the tangential part d of a difference of multipliers and the semi-axes
/// of the panes' ellipses, weighted by areas: (Σ |Rⁱ| |·|² / Σ |Rⁱ|)^½; panes without ellipses do not
/// count.
pub(in crate::solver) fn within_ellipses(
    laws: &PaneLaws,
    evaluation: &Evaluation,
    difference: &[f64],
) -> f64 {
    let areas = &laws.area;
    let (_, pairs) = laws.layout.split(difference);
    let terms = pairs.iter().zip(&evaluation.panes).zip(areas);
    let scaled = terms.flat_map(|((d, pane), area)| {
        let [a, b] = pane.ellipse.semi_axes;
        let part = |d: f64, axis: f64| {
            if axis > 0.0 {
                area.sqrt() * d / axis
            } else {
                0.0
            }
        };
        [part(d[0], a), part(d[1], b)]
    });
    norm(&scaled.collect::<Vec<f64>>()) / areas.iter().sum::<f64>().sqrt()
}

/// (Σ |Rⁱ| λ_ν²)^½ and (Σ |Rⁱ| |λ_t|²)^½.
fn parts(laws: &PaneLaws, multiplier: &[f64]) -> [f64; 2] {
    let areas = &laws.area;
    let (normal, tangential) = laws.layout.split(multiplier);
    let normal = normal.iter().zip(areas).map(|(l, a)| a.sqrt() * l);
    let pairs = tangential.iter().zip(areas);
    let tangential = pairs.flat_map(|(t, a)| [t[0], t[1]].map(|t| a.sqrt() * t));
    [
        norm(&normal.collect::<Vec<f64>>()),
        norm(&tangential.collect::<Vec<f64>>()),
    ]
}
