//! The natural map of the dense dual problem.

use crate::{
    dual::{ExplicitDual, RigidEquilibrium, friction_stiffness},
    linalg::{FEW_ROUNDINGS, difference, norm},
    solver::conditions::{Bound, Conditions, Evaluation},
};

/// The natural map R(x) of `Conditions` for a dense S: x = λ with r = S λ − h, or x = (λ, α) with r = S λ − G α − h where there are
/// rigid motions. Its zeros solve the contact problem.
pub struct NaturalMap<'a> {
    pub(in crate::solver) dual: &'a ExplicitDual,
    pub(in crate::solver) conditions: Conditions<'a>,
}

impl<'a> NaturalMap<'a> {
    /// With ρ = 1/S_ii for normal components, and for tangential ones 1 over the mean of a pair's two.
    pub(in crate::solver) fn new(dual: &'a ExplicitDual, bound: Bound<'a>) -> Self {
        let layout = dual.layout;
        let inverse = |value: f64| if value > 0.0 { 1.0 / value } else { 0.0 };
        let diagonal = |j: usize| dual.diagonal(j);
        let normal = layout.normals().map(|i| inverse(diagonal(i)));
        let pairs = (0..layout.n_panes()).filter_map(|pane| layout.tangential(pane));
        let tangential = pairs.flat_map(|pair| {
            let [first, second] = pair.map(diagonal);
            [first, second].map(|own| match own {
                0.0 => 0.0,
                _ => inverse(0.5 * (first + second)),
            })
        });
        let mut steplengths = normal.chain(tangential).collect::<Vec<_>>();
        friction_stiffness(&mut steplengths, layout, &dual.rhs);
        Self::with_steplengths(dual, bound, steplengths)
    }

    /// With given ρ of the multipliers in Pa/m³, `[n_multipliers]`.
    pub fn with_steplengths(
        dual: &'a ExplicitDual,
        bound: Bound<'a>,
        mut steplengths: Vec<f64>,
    ) -> Self {
        steplengths.extend(dual.rigid.iter().flat_map(RigidEquilibrium::steplengths));
        Self {
            dual,
            conditions: Conditions {
                contact_springs: dual.contact_springs.clone(),
                ..Conditions::new(bound, dual.layout, steplengths)
            },
        }
    }

    /// R at λ, `[n_unknowns]`, with what its derivative needs.
    #[must_use]
    pub fn evaluate(&self, unknowns: &[f64]) -> Evaluation {
        let gradient = self.dual.gradient(unknowns);
        let displacement = self.tangential_displacement(unknowns);
        self.conditions.evaluate(unknowns, &gradient, &displacement)
    }

    /// λ at unknowns; with contact springs P(z), which is zero on open panes where μ − σ r has rounding.
    pub(in crate::solver) fn stresses(&self, unknowns: &[f64]) -> Vec<f64> {
        let stresses = self.dual.stresses(unknowns);
        match self.dual.contact_springs {
            None => stresses.into_owned(),
            Some(_) => difference(&stresses, &self.evaluate(unknowns).residual),
        }
    }

    /// 𝓕⁻¹ on the panes at λ; empty for frozen ellipses.
    pub(in crate::solver) fn friction_inverse(&self, unknowns: &[f64]) -> Vec<[f64; 2]> {
        let displacement = self.tangential_displacement(unknowns);
        self.conditions.friction(&displacement).0
    }

    /// What a law that follows the slip reads; empty for others.
    fn tangential_displacement(&self, unknowns: &[f64]) -> Vec<[f64; 2]> {
        if self.conditions.follows_slip() {
            self.dual.tangential_displacement(unknowns)
        } else {
            Vec::new()
        }
    }

    /// ‖λ‖, beside the forces D α that weak supports take, as stresses ρ D α: what ‖R‖ is measured by.
    pub(in crate::solver) fn size(&self, unknowns: &[f64]) -> f64 {
        let mut stresses = self.dual.stresses(unknowns).into_owned();
        if let Some(equilibrium) = &self.dual.rigid {
            let motions = self.dual.motion(unknowns).iter();
            let carried = motions
                .zip(&equilibrium.coupling.support)
                .map(|(a, d)| a * d);
            let rho = self.dual.motion(&self.conditions.steplengths);
            stresses.extend(carried.zip(rho).map(|(force, rho)| rho * force));
        }
        norm(&stresses)
    }

    /// The ‖R‖ over [`Self::size`] that rounding explains at most: that of S λ, n ε_M max ρ_i S_ii, nothing where the problem is written about
    /// an anchor; and that of G α where weak springs let the body move far, on panes that are pressed or stick.
    pub(super) fn rounding(&self, unknowns: &[f64], evaluation: &Evaluation) -> f64 {
        let rho = self.dual.multipliers(&self.conditions.steplengths);
        let of_products = match self.dual.anchor {
            Some(_) => 0.0,
            None => {
                let rows = rho.iter().enumerate();
                let sizes = rows.map(|(j, rho)| rho * self.dual.diagonal(j));
                self.dual.rounding() * sizes.fold(0.0, f64::max)
            }
        };
        let Some(equilibrium) = self.dual.rigid.as_ref().filter(|it| it.is_supported()) else {
            return of_products;
        };
        let motion = self.dual.motion(unknowns);
        let rounded = |j: usize| {
            FEW_ROUNDINGS * f64::EPSILON * rho[j] * equilibrium.size_of_motion(j, motion)
        };
        let layout = self.dual.layout;
        let stresses = evaluation.panes.iter().enumerate().flat_map(|(i, pane)| {
            let along = layout.tangential(i).map(|pair| pair.map(rounded));
            let sticks = |[a, b]: &[f64; 2]| {
                let [first, second] = pane.ellipse.semi_axes;
                let [x, y] = pane.trial;
                x.hypot(y) <= first.max(second) + a.hypot(*b)
            };
            let along = along.filter(sticks).into_iter().flatten();
            along.chain(pane.pressed.then(|| rounded(layout.normal(i))))
        });
        of_products.max(norm(&stresses.collect::<Vec<f64>>()) / self.size(unknowns))
    }
}
