use super::{PaneFriction, PaneState, Solved, SolvedContact};
use crate::{contact::FrictionField, linalg::norm, solver::FeasibleSet};

/// How well λ and u satisfy the discrete problem; every figure is dimensionless and vanishes for
/// the exact discrete solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// ‖A u + Bᵀλ − l‖ / ‖l‖.
    pub equilibrium: f64,
    /// The conditions of contact; `None` without a contact face.
    pub contact: Option<ContactCertificate>,
    /// The conditions of friction; `None` without friction.
    pub friction: Option<FrictionCertificate>,
}

/// The conditions of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactCertificate {
    /// Largest mean penetration (u_ν − d)₊ of a pane over the largest displacement component.
    pub penetration: f64,
    /// Largest adhesion (−λ_ν)₊ over the largest |λ|.
    pub adhesion: f64,
    /// Σ |λ_ν (d − u_ν)| |Rⁱ| / (lᵀu).
    pub complementarity: f64,
    /// ‖λ − P(λ − ᾱ r)‖ / ‖λ‖ with the admissible set of the solution itself; for Coulomb's law
    /// g = λ_ν, F = F(u).
    pub fixed_point: f64,
}

/// The conditions of friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionCertificate {
    /// Largest excess (‖𝓕⁻¹λ_t‖ − g)₊ over the largest g, with g = λ_ν and 𝓕 at the solution for
    /// Coulomb's law.
    pub friction_bound: f64,
    /// Missing frictional work Σ |Rⁱ| |‖(a u_t1, b u_t2)‖ − λ_t·u_t| / (lᵀu) for the semi-axes
    /// (a, b) of a pane's ellipse: zero exactly when every pane slides in the direction that the
    /// law prescribes.
    pub slip_direction: f64,
}

impl Certificate {
    pub(super) fn new(
        solved: &Solved<'_>,
        friction: Option<&FrictionField>,
        panes: &[PaneState],
    ) -> Self {
        let products = solved
            .system
            .load
            .iter()
            .zip(&solved.solution.displacement)
            .map(|(l, u)| l * u);
        let work = products.sum::<f64>().abs();
        let contact = solved.contact.as_ref();
        Self {
            equilibrium: equilibrium(solved),
            contact: contact.map(|c| ContactCertificate::new(solved, c, panes, work)),
            friction: contact
                .filter(|c| c.state.interface.has_friction())
                .map(|c| FrictionCertificate::new(solved, c, friction, panes, work)),
        }
    }

    /// The figures that apply, with their names.
    #[must_use]
    pub fn figures(&self) -> Vec<(&'static str, f64)> {
        let mut figures = vec![("equilibrium", self.equilibrium)];
        if let Some(contact) = &self.contact {
            figures.extend([
                ("penetration", contact.penetration),
                ("adhesion", contact.adhesion),
                ("complementarity", contact.complementarity),
            ]);
        }
        if let Some(friction) = &self.friction {
            figures.extend([
                ("friction_bound", friction.friction_bound),
                ("slip_direction", friction.slip_direction),
            ]);
        }
        if let Some(contact) = &self.contact {
            figures.push(("fixed_point", contact.fixed_point));
        }
        figures
    }

    /// The largest figure; NaN if any is.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.figures().into_iter().fold(0.0, |worst, (_, value)| {
            if value.is_nan() || value > worst {
                value
            } else {
                worst
            }
        })
    }
}

impl ContactCertificate {
    fn new(
        solved: &Solved<'_>,
        contact: &SolvedContact<'_>,
        panes: &[PaneState],
        work: f64,
    ) -> Self {
        let normal = &solved.solution.multiplier[..panes.len()];
        let area = &contact.state.surface.pane_area;
        let product: f64 = (0..panes.len())
            .map(|i| (normal[i] * panes[i].gap).abs() * area[i])
            .sum();
        Self {
            penetration: ratio(
                largest(panes.iter().map(|p| (-p.gap).max(0.0))),
                largest(solved.solution.displacement.iter().copied()),
            ),
            adhesion: ratio(
                largest(normal.iter().map(|l| (-l).max(0.0))),
                largest(solved.solution.multiplier.iter().copied()),
            ),
            complementarity: ratio(product, work),
            fixed_point: natural_residual(solved, contact, panes),
        }
    }
}

impl FrictionCertificate {
    fn new(
        solved: &Solved<'_>,
        contact: &SolvedContact<'_>,
        friction: Option<&FrictionField>,
        panes: &[PaneState],
        work: f64,
    ) -> Self {
        let area = &contact.state.surface.pane_area;
        let with_friction =
            || (0..panes.len()).filter_map(|i| Some((i, panes[i].friction.as_ref()?)));
        let missing: f64 = with_friction()
            .map(|(i, pane)| {
                let [s, t, [a, b]] = [pane.slip, pane.stress, pane.semi_axes];
                area[i] * ((a * s[0]).hypot(b * s[1]) + t[0] * s[0] + t[1] * s[1]).abs()
            })
            .sum();
        let bound = |i: usize, pane: &PaneFriction| match friction {
            Some(_) => solved.solution.multiplier[i],
            None => pane.semi_axes[0].max(pane.semi_axes[1]),
        };
        let excess = with_friction().map(|(i, pane)| {
            let g = bound(i, pane);
            let scaled = match pane.coulomb {
                Some((_, scaled)) => scaled,
                None if g == 0.0 => pane.stress[0].hypot(pane.stress[1]),
                None => {
                    g * (pane.stress[0] / pane.semi_axes[0])
                        .hypot(pane.stress[1] / pane.semi_axes[1])
                }
            };
            (scaled - g).max(0.0)
        });
        Self {
            friction_bound: ratio(
                largest(excess),
                largest(with_friction().map(|(i, pane)| bound(i, pane))),
            ),
            slip_direction: ratio(missing, work),
        }
    }
}

fn equilibrium(solved: &Solved<'_>) -> f64 {
    let mut residual = match &solved.contact {
        Some(contact) => contact.coupling.nodal_forces(&solved.solution.multiplier),
        None => vec![0.0; solved.system.load.len()],
    };
    let mut stiffness_u = vec![0.0; residual.len()];
    solved
        .system
        .stiffness
        .mul(&solved.solution.displacement, &mut stiffness_u);
    for (i, r) in residual.iter_mut().enumerate() {
        *r += stiffness_u[i] - solved.system.load[i];
    }
    ratio(norm(&residual), norm(&solved.system.load))
}

fn natural_residual(solved: &Solved<'_>, contact: &SolvedContact<'_>, panes: &[PaneState]) -> f64 {
    let m = panes.len();
    let semi_axes = panes
        .iter()
        .filter_map(|pane| Some(pane.friction?.semi_axes))
        .collect();
    let set = FeasibleSet::new(m, semi_axes, &contact.state.interface.projections);
    let area = &contact.state.surface.pane_area;
    let alpha = solved.solution.steplength;
    // The gradient r = S λ − h is −(B u) plus the integrated gap.
    let mut step = solved.solution.multiplier.to_vec();
    for (i, pane) in panes.iter().enumerate() {
        step[i] -= alpha * area[i] * pane.gap;
        if let Some(friction) = &pane.friction {
            step[m + 2 * i] += alpha * area[i] * friction.slip[0];
            step[m + 2 * i + 1] += alpha * area[i] * friction.slip[1];
        }
    }
    set.project(&mut step);
    let difference: Vec<f64> = step
        .iter()
        .zip(&solved.solution.multiplier)
        .map(|(a, b)| a - b)
        .collect();
    ratio(norm(&difference), norm(&solved.solution.multiplier))
}

/// The quotient, and 0 for 0/0.
fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// max |v|.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, v| most.max(v.abs()))
}
