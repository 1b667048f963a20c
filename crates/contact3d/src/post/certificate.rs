//! The certificate: optimality residuals of an answer, dimensionless.

use super::{
    PaneFriction, PaneState, Solved, SolvedContact, largest,
    rounding::{Measure, driving_force},
};
use crate::{
    linalg::{FEW_ROUNDINGS, norm, ratio},
    solver::{FeasibleSet, is_significant, load_stress},
};

/// How well λ and u satisfy the discrete problem; every figure is dimensionless and vanishes for
/// the exact discrete solution. Those of contact are `None` without a contact face, those of friction without friction.
///
/// Displacements count against the local compliance 1/ρ of a pane times a stress, works against
/// Σ λ²/ρ: in a body that nearly floats both are smaller by orders of magnitude than max |u| and lᵀu,
/// and those would hide any violation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Certificate {
    /// ‖A u + Bᵀλ − l‖ / ‖l‖; 0 where both norms are rounding of the sums, as of a body without load that lies where it was left.
    pub equilibrium: f64,
    /// Largest mean penetration (u_ν − d)₊ |Rⁱ| ρ_ν of a pane over the largest pressure.
    pub penetration: Option<f64>,
    /// Largest adhesion (−λ_ν)₊ over the largest pressure.
    pub adhesion: Option<f64>,
    /// Σ |λ_ν (d − u_ν)| |Rⁱ| / Σ λ_ν²/ρ_ν.
    pub complementarity: Option<f64>,
    /// Largest entry of λ − P(λ − ρ r) with the admissible set of the solution itself, for Coulomb's
    /// law g of λ_ν, F = F(u): normal ones over the largest pressure, tangential ones over the
    /// largest tangential stress or semi-axis. The slip of a sticking pane is one of them.
    pub fixed_point: Option<f64>,
    /// Largest excess (‖𝓕⁻¹λ_t‖ − g)₊ over the largest g, with the slip bound g of λ_ν and 𝓕 at the
    /// solution for Coulomb's law; where nothing presses, over the stress that rounding of the displacement would make.
    pub friction_bound: Option<f64>,
    /// Missing frictional work Σ |Rⁱ| |‖(a u_t1, b u_t2)‖ − λ_t·u_t| for the semi-axes (a, b) of a
    /// pane's ellipse, over the frictional work Σ |Rⁱ| ‖(a u_t1, b u_t2)‖ plus Σ |λ_t|²/ρ_t: zero exactly
    /// when every pane slides in the direction that the law prescribes. A slip within the rounding of u is none.
    pub slip_direction: Option<f64>,
}

/// What violations are measured against.
struct ReferenceScale<'a> {
    /// ρ, `[n_multipliers]`, in Pa/m³.
    stiffness: &'a [f64],
    /// The largest pressure, in Pa.
    pressure: f64,
    /// The largest tangential stress or semi-axis, in Pa.
    shear: f64,
    /// Σ λ_ν²/ρ_ν and Σ |λ_t|²/ρ_t, of the stress of rounding at least, in J.
    works: [f64; 2],
    /// The stress that rounding of the displacement would make of the normal and of the tangential multipliers, and that of the load
    /// where these are none beside it, in Pa.
    rounding: [f64; 2],
    /// The slip that is none, in m: elastic displacements and motions of the whole body cancel in slips, of which some eighty roundings
    /// were seen on a pane of 0.3 × 7 m.
    resolution: f64,
}

impl<'a> ReferenceScale<'a> {
    /// Where nothing presses, the stress of the load takes the place of the pressure, and where little does, that which rounding of the
    /// displacement would make, in works too.
    fn new(
        solved: &Solved<'_>,
        contact: &SolvedContact<'_>,
        panes: &[PaneState],
        stiffness: &'a [f64],
    ) -> Self {
        let multiplier = &solved.solution.multiplier;
        let layout = contact.coupling.layout;
        let moved = largest(solved.solution.displacement.iter().copied());
        let areas = &contact.state.surface.pane_area;
        let rounding = |range: std::ops::Range<usize>| {
            let entries = range.map(|j| stiffness[j] * areas[layout.pane_of(j)]);
            f64::EPSILON.sqrt() * moved * entries.fold(0.0, f64::max)
        };
        let shears = panes.iter().filter_map(|pane| pane.friction.as_ref());
        let shears = shears.flat_map(|pane| {
            let [a, b] = pane.semi_axes;
            [pane.stress[0].hypot(pane.stress[1]), a, b]
        });
        let work = |range: std::ops::Range<usize>, rounding: f64| {
            let loaded = range.filter(|&j| stiffness[j] > 0.0);
            let [own, least] = loaded.fold([0.0; 2], |[own, least], j| {
                let of_stress = |stress: f64| stress.powi(2) / stiffness[j];
                [own + of_stress(multiplier[j]), least + of_stress(rounding)]
            });
            own.max(least)
        };
        let load = load_stress(solved.system, areas.iter().sum());
        let least = |range: std::ops::Range<usize>, stress: f64| {
            let rounding = rounding(range);
            if is_significant(stress, load) {
                rounding
            } else {
                rounding.max(load)
            }
        };
        let pressure = largest(layout.split(multiplier).0.iter().copied());
        let shear = largest(shears);
        let rounding = [
            least(layout.normals(), pressure),
            least(layout.tangentials(), shear),
        ];
        Self {
            stiffness,
            pressure: pressure.max(rounding[0]),
            shear: shear.max(rounding[1]),
            works: [
                work(layout.normals(), rounding[0]),
                work(layout.tangentials(), rounding[1]),
            ],
            rounding,
            resolution: 1024.0 * f64::EPSILON * moved,
        }
    }
}

impl Certificate {
    /// Of a solved problem with its [`terms`](super::rounding::terms), its panes and their local stiffness.
    pub(super) fn new(
        solved: &Solved<'_>,
        terms: &[f64],
        panes: &[PaneState],
        stiffness: &[f64],
    ) -> Self {
        let equilibrium = equilibrium(solved, terms);
        let Some(contact) = &solved.contact else {
            return Self {
                equilibrium,
                ..Self::default()
            };
        };
        let by = &ReferenceScale::new(solved, contact, panes, stiffness);
        let (normal, _) = contact.coupling.layout.split(&solved.solution.multiplier);
        let area = &contact.state.surface.pane_area;
        let product: f64 = (0..panes.len())
            .map(|i| (normal[i] * panes[i].gap).abs() * area[i])
            .sum();
        let penetrations = panes.iter().enumerate();
        let penetrations =
            penetrations.map(|(i, pane)| (-pane.gap).max(0.0) * area[i] * by.stiffness[i]);
        let adhesions = normal.iter().map(|l| (-l).max(0.0));
        let has_friction = contact.state.interface.has_friction();
        let friction = has_friction.then(|| friction(contact, panes, by));
        Self {
            equilibrium,
            penetration: Some(ratio(largest(penetrations), by.pressure)),
            adhesion: Some(ratio(largest(adhesions), by.pressure)),
            complementarity: Some(ratio(product, by.works[0])),
            fixed_point: Some(natural_residual(solved, contact, panes, by)),
            friction_bound: friction.map(|[bound, _]| bound),
            slip_direction: friction.map(|[_, direction]| direction),
        }
    }

    /// The figures that apply, with their names.
    #[must_use]
    pub fn figures(&self) -> Vec<(&'static str, f64)> {
        let all = self.measured().into_iter();
        all.map(|(figure, value, _)| (figure, value)).collect()
    }

    /// The figures that apply, with what each is measured against.
    pub(super) fn measured(&self) -> Vec<(&'static str, f64, Measure)> {
        let all = [
            ("equilibrium", Some(self.equilibrium), Measure::Balance),
            ("penetration", self.penetration, Measure::Stress),
            ("adhesion", self.adhesion, Measure::Stress),
            ("complementarity", self.complementarity, Measure::Work),
            ("friction_bound", self.friction_bound, Measure::Stress),
            ("slip_direction", self.slip_direction, Measure::Work),
            ("fixed_point", self.fixed_point, Measure::Stress),
        ];
        let applies = all.into_iter();
        applies
            .filter_map(|(figure, value, measure)| Some((figure, value?, measure)))
            .collect()
    }

    /// The largest figure; NaN if any is.
    #[must_use]
    pub fn worst(&self) -> f64 {
        largest(self.figures().into_iter().map(|(_, value)| value))
    }
}

/// The friction bound and the slip direction.
fn friction(contact: &SolvedContact<'_>, panes: &[PaneState], by: &ReferenceScale<'_>) -> [f64; 2] {
    let area = &contact.state.surface.pane_area;
    let with_friction = || (0..panes.len()).filter_map(|i| Some((i, panes[i].friction.as_ref()?)));
    let works = with_friction().map(|(i, pane)| {
        let [mut s, t, [a, b]] = [pane.slip, pane.stress, pane.semi_axes];
        if s[0].hypot(s[1]) <= by.resolution {
            s = [0.0; 2];
        }
        let work = (a * s[0]).hypot(b * s[1]);
        let missing = (work + t[0] * s[0] + t[1] * s[1]).abs();
        [area[i] * work, area[i] * missing]
    });
    let [work, missing] = works.fold([0.0; 2], |sum, w| [sum[0] + w[0], sum[1] + w[1]]);
    let bound = |pane: &PaneFriction| match pane.coulomb {
        Some(coulomb) => coulomb.slip_bound,
        None => pane.semi_axes[0].max(pane.semi_axes[1]),
    };
    let excess = with_friction().map(|(_, pane)| {
        let g = bound(pane);
        let scaled = match pane.coulomb {
            Some(coulomb) => coulomb.scaled_stress,
            None if g == 0.0 => pane.stress[0].hypot(pane.stress[1]),
            None => {
                g * (pane.stress[0] / pane.semi_axes[0]).hypot(pane.stress[1] / pane.semi_axes[1])
            }
        };
        (scaled - g).max(0.0)
    });
    [
        ratio(
            largest(excess),
            largest(with_friction().map(|(_, pane)| bound(pane))).max(by.rounding[1]),
        ),
        ratio(missing, work + by.works[1]),
    ]
}

fn equilibrium(solved: &Solved<'_>, terms: &[f64]) -> f64 {
    let mut residual = match &solved.contact {
        Some(contact) => contact.coupling.nodal_forces(&solved.solution.multiplier),
        None => vec![0.0; solved.system.load.len()],
    };
    let mut stiffness_u = vec![0.0; residual.len()];
    let displacement = &solved.solution.displacement;
    solved.system.stiffness.mul(displacement, &mut stiffness_u);
    for (i, r) in residual.iter_mut().enumerate() {
        *r += stiffness_u[i] - solved.system.load[i];
    }
    let (residual, load) = (norm(&residual), driving_force(solved));
    let rounding = FEW_ROUNDINGS * f64::EPSILON * norm(terms);
    if residual.max(load) <= rounding {
        0.0
    } else {
        ratio(residual, load)
    }
}

fn natural_residual(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    panes: &[PaneState],
    by: &ReferenceScale<'_>,
) -> f64 {
    let layout = contact.coupling.layout;
    let semi_axes = panes
        .iter()
        .filter_map(|pane| Some(pane.friction?.semi_axes))
        .collect();
    let set = FeasibleSet::new(panes.len(), semi_axes);
    let area = &contact.state.surface.pane_area;
    let multiplier = &solved.solution.multiplier;
    // The gradient r = S λ − h is −(B u) plus the integrated gap.
    let mut step = multiplier.clone();
    for (i, pane) in panes.iter().enumerate() {
        step[i] -= by.stiffness[i] * area[i] * pane.gap;
        if let (Some(friction), Some(pair)) = (&pane.friction, layout.tangential(i)) {
            for (j, slip) in pair.into_iter().zip(friction.slip) {
                step[j] += by.stiffness[j] * area[i] * slip;
            }
        }
    }
    set.project(&mut step);
    let difference = |j: usize| step[j] - multiplier[j];
    let normal = ratio(largest(layout.normals().map(difference)), by.pressure);
    let tangential = ratio(largest(layout.tangentials().map(difference)), by.shear);
    largest([normal, tangential].into_iter())
}
