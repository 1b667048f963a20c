//! Problems with frozen friction: cones in place of the coupling of slip and normal velocity.

use std::sync::atomic::AtomicUsize;

use super::{
    Candidate, DelassusError, DelassusProblem,
    scaled::{Scaled, SparseOperator},
};
use crate::{
    contact::{Interface, MultiplierLayout},
    dual::{ContactSystem, DualOperator, ExplicitDual, OperatorForm, PrimalSystem, pane_stiffness},
    linalg::{CscMatrix, norm, power_of_two_near_largest},
    mesh::ContactSurface,
    solver::{
        FeasibleSet, Gpcg, fixed_point::relative_change, inner::projected_gradient_steplength,
    },
};

/// Frozen friction in the order and units in which other programs take it.
///
/// At each pane i of area a, with the coefficients F₁, F₂ that act on it at the solution, r = aλ in N and u = Sλ/a − h/a in m are
/// divided by what makes them numbers of order one: r = t D r', u = t D⁻¹ u' with D = s diag(1, F₁, F₂) and μ' = 1 where the
/// coefficients differ, D = s and μ' = F where both are the same on all panes, and one s for each contact. Coulomb's law with the
/// ellipse F₁, F₂ for (r, u) is that with the circle μ' for (r', u'), exactly: ‖F⁻¹r_t‖ ≤ r_N, and r_t ∥ −F² u_t where it slides.
#[derive(Debug, Clone, PartialEq)]
pub struct FrozenScaling {
    /// μ', `[n_panes]`; 0 on panes without friction.
    pub mu: Vec<f64>,
    /// D, components N, T1, T2 pane after pane, `[3 n_panes]`, in (m/N)^(-1/2).
    pub scale: Vec<f64>,
    /// t in (N m)^(1/2).
    pub unit: f64,
    /// a in m², `[n_panes]`.
    pub area: Vec<f64>,
}

/// The problem in the unknowns of the body: M v = H r' + f, u' = Hᵀv + w.
#[derive(Debug, Clone, PartialEq)]
pub struct FrozenGlobal {
    /// M = c² A, `[n_free, n_free]`.
    pub matrix: CscMatrix,
    /// H = −c Bᵀ a⁻¹ D, components N, T1, T2 pane after pane, `[n_free, 3 n_panes]`.
    pub contact: CscMatrix,
    /// f = c l / t, `[n_free]`.
    pub load: Vec<f64>,
    /// w = D (∫gap − B u_c) / (a t), `[3 n_panes]`.
    pub distance: Vec<f64>,
    /// c in (m/N)^(1/2): displacements are u = c t v.
    pub displacement_scale: f64,
    /// How μ', r' and u' are scaled.
    pub scaling: FrozenScaling,
}

impl FrozenScaling {
    /// For panes of some areas with (F₁, F₂), `None` without friction, where S has a diagonal and h some size; both follow the
    /// layout with tangential pairs on all panes.
    fn new(area: &[f64], friction: &[Option<[f64; 2]>], diagonal: &[f64], h: &[f64]) -> Self {
        let layout = MultiplierLayout::new(area.len(), area.len());
        let is_isotropic = friction
            .iter()
            .flatten()
            .all(|[first, second]| first == second);
        let mut scale = Vec::with_capacity(3 * area.len());
        let mut offset: Vec<f64> = Vec::with_capacity(scale.len());
        for (pane, area) in area.iter().enumerate() {
            let ellipse = match friction[pane] {
                Some([first, second]) if !is_isotropic => [1.0, first, second],
                Some(_) | None => [1.0; 3],
            };
            let places = components(layout, pane);
            let entries = places.iter().zip(ellipse);
            let sum: f64 = entries
                .map(|(&j, d)| diagonal[j] * (d / area).powi(2))
                .sum();
            let contact_scale = if sum > 0.0 {
                (-0.5 * (sum / 3.0).log2()).round().exp2()
            } else {
                1.0
            };
            let own = ellipse.map(|d| contact_scale * d);
            offset.extend(places.iter().zip(own).map(|(&j, d)| d * h[j] / area));
            scale.extend(own);
        }
        Self {
            mu: friction
                .iter()
                .map(|friction| match friction {
                    None => 0.0,
                    Some([only, _]) if is_isotropic => *only,
                    Some(_) => 1.0,
                })
                .collect(),
            scale,
            unit: power_of_two_near_largest(&offset).unwrap_or(1.0),
            area: area.to_vec(),
        }
    }

    /// r' of multipliers with pairs on the first panes.
    #[must_use]
    pub fn forces(&self, layout: MultiplierLayout, multiplier: &[f64]) -> Vec<f64> {
        let mut forces = Vec::with_capacity(self.scale.len());
        for (pane, area) in self.area.iter().enumerate() {
            let [first, second] = layout.pair(multiplier, pane);
            let stresses = [multiplier[layout.normal(pane)], first, second];
            let own = &self.scale[3 * pane..];
            forces.extend((0..3).map(|k| area * stresses[k] / (self.unit * own[k])));
        }
        forces
    }
}

/// The places of N, T1 and T2 of a pane in a layout with pairs on all panes.
fn components(layout: MultiplierLayout, pane: usize) -> [usize; 3] {
    let [first, second] = layout.tangential(pane).expect("a pair on every pane");
    [layout.normal(pane), first, second]
}

/// W' = D a⁻¹ S a⁻¹ D and q' = −D a⁻¹ h / t of a dense S with pairs on all panes, for panes of some areas in m² with the
/// frozen coefficients (F₁, F₂), `None` without friction.
///
/// # Errors
/// [`DelassusError`] for arrays that are not finite.
pub fn frozen_local(
    dual: &ExplicitDual,
    area: &[f64],
    friction: &[Option<[f64; 2]>],
) -> Result<(DelassusProblem, FrozenScaling), DelassusError> {
    let n = dual.dimension();
    let diagonal: Vec<f64> = (0..n).map(|j| dual.column(j)[j]).collect();
    let scaling = FrozenScaling::new(area, friction, &diagonal, &dual.rhs);
    let order: Vec<usize> = (0..area.len())
        .flat_map(|pane| components(dual.layout, pane))
        .collect();
    let factor = |k: usize| scaling.scale[k] / area[k / 3];
    let mut matrix = CscMatrix {
        rows: n,
        cols: n,
        indptr: (0..=n).map(|j| j * n).collect(),
        indices: (0..n).flat_map(|_| 0..n).collect(),
        data: Vec::with_capacity(n * n),
    };
    for (k, &j) in order.iter().enumerate() {
        let column = dual.column(j);
        let entries = order.iter().enumerate();
        // One product on either side of the diagonal, so that W' is as symmetric as S.
        matrix
            .data
            .extend(entries.map(|(l, &i)| factor(k.min(l)) * (column[i] * factor(k.max(l)))));
    }
    let components = order.iter().enumerate();
    let offset = components.map(|(k, &j)| -factor(k) * dual.rhs[j] / scaling.unit);
    let offset = offset.collect();
    let problem = DelassusProblem::new(matrix, offset, scaling.mu.clone())?;
    Ok((problem, scaling))
}

/// The same with the unknowns of the body; S is not formed, and its diagonal estimated by that of single nodes.
#[must_use]
pub fn frozen_global(
    primal: &PrimalSystem,
    surface: &ContactSurface,
    interface: &Interface,
    friction: &[Option<[f64; 2]>],
) -> FrozenGlobal {
    let area = &surface.pane_area;
    let coupling = interface.coupling_everywhere(surface, &primal.dofs);
    let layout = coupling.layout;
    let stiffness = pane_stiffness(primal, &coupling);
    let diagonal: Vec<f64> = stiffness
        .iter()
        .map(|rho| if *rho > 0.0 { rho.recip() } else { 0.0 })
        .collect();
    let system = ContactSystem {
        coupling,
        form: OperatorForm::Implicit(Vec::new()),
        balance: None,
    };
    let nothing = vec![0.0; primal.dofs.n_free];
    let closing = system.closing(&nothing, &primal.dofs, surface, interface);
    let mean = primal.stiffness.mean_diagonal();
    let c = (-0.5 * mean.log2()).round().exp2();
    let mut scaling = FrozenScaling::new(area, friction, &diagonal, &closing);
    // Forces of the size of the load: without a gap there are no distances to go by.
    let size = c * norm(&primal.load);
    if size > 0.0 {
        scaling.unit = size.log2().round().exp2();
    }
    let mut contact = CscMatrix::empty(primal.dofs.n_free);
    let mut distance = Vec::with_capacity(scaling.scale.len());
    for (pane, area) in area.iter().enumerate() {
        for (k, j) in components(layout, pane).into_iter().enumerate() {
            let factor = scaling.scale[3 * pane + k] / area;
            let (rows, values) = system.coupling.transposed.column(j);
            contact.indices.extend(rows);
            contact.data.extend(values.iter().map(|b| -c * factor * b));
            contact.indptr.push(contact.indices.len());
            contact.cols += 1;
            distance.push(-factor * closing[j] / scaling.unit);
        }
    }
    let mut matrix = (*primal.stiffness).clone();
    matrix.data.iter_mut().for_each(|entry| *entry *= c * c);
    FrozenGlobal {
        matrix,
        contact,
        load: primal.load.iter().map(|l| c * l / scaling.unit).collect(),
        distance,
        displacement_scale: c,
        scaling,
    }
}

impl FrozenGlobal {
    /// v of a displacement in m over the free degrees of freedom.
    #[must_use]
    pub fn displacement(&self, displacement: &[f64]) -> Vec<f64> {
        let scale = self.displacement_scale * self.scaling.unit;
        displacement.iter().map(|u| u / scale).collect()
    }

    /// u' = Hᵀv + w.
    #[must_use]
    pub fn velocity(&self, v: &[f64]) -> Vec<f64> {
        let mut velocity = vec![0.0; self.distance.len()];
        self.contact.mul_transposed(v, &mut velocity);
        for (u, w) in velocity.iter_mut().zip(&self.distance) {
            *u += w;
        }
        velocity
    }
}

/// Most outer steps, and most products with W altogether.
const MOST_STEPS: usize = 1000;
const MOST_APPLICATIONS: usize = 400_000;

/// Loosest and tightest tolerance of an inner problem, relative to ‖h‖, and its share of the last error.
const LOOSEST: f64 = 1e-2;
const TIGHTEST: f64 = 1e-14;
const SHARE: f64 = 0.1;

/// Outer steps in which the error must halve.
const PATIENCE: usize = 100;

/// Minimises ½ λᵀSλ − λᵀh over λ_N ≥ 0 and ‖λ_T‖ ≤ g with GPCG for the slip bounds g = λ_N of the last minimiser, again and again
/// (HKL Algorithm 4.1 at constant F). Each of these problems is convex, so a singular W needs nothing else; whether their sequence
/// converges depends on μ.
pub(super) fn solve(scaled: &Scaled<'_>, tolerance: f64) -> Candidate {
    let size = norm(&scaled.rhs);
    if size == 0.0 {
        return Candidate::zero(scaled);
    }
    let mut operator = SparseOperator {
        scaled,
        applications: 0,
    };
    let projections = AtomicUsize::new(0);
    let steplength = projected_gradient_steplength(&mut operator);
    let mut multiplier = vec![0.0; scaled.rhs.len()];
    let mut best = (f64::INFINITY, multiplier.clone());
    let mut errors: Vec<f64> = Vec::new();
    let mut inner_tolerance = LOOSEST;
    let mut outer_steps = 0;
    while outer_steps < MOST_STEPS {
        let left = MOST_APPLICATIONS.saturating_sub(operator.applications());
        if left == 0 {
            break;
        }
        let (normal, _) = scaled.layout.split(&multiplier);
        let bounds = normal.iter().take(scaled.layout.n_pairs());
        let set = FeasibleSet::new(
            scaled.layout.n_panes(),
            bounds.map(|g| [*g; 2]).collect(),
            &projections,
        );
        let mut next = multiplier.clone();
        set.project(&mut next);
        let gpcg = Gpcg {
            steplength,
            max_applications: left,
        };
        // The rounding n ε (‖S‖ ‖λ‖ + ‖h‖) of r = S λ − h with ‖S‖ < 2/ᾱ.
        let rounding =
            scaled.rhs.len() as f64 * f64::EPSILON * (2.0 / steplength * norm(&next) + size);
        gpcg.minimise(
            &mut operator,
            &set,
            &mut next,
            rounding.max(inner_tolerance * size),
        );
        let change = relative_change(&next, &multiplier);
        multiplier = next;
        outer_steps += 1;
        let error = scaled.worst_error(&multiplier);
        if error < best.0 {
            best = (error, multiplier.clone());
        }
        if error <= tolerance || !error.is_finite() {
            break;
        }
        errors.push(best.0);
        let stalled = errors.len() > PATIENCE
            && errors[errors.len() - 1] > 0.5 * errors[errors.len() - 1 - PATIENCE];
        if stalled || (change == 0.0 && inner_tolerance * size <= rounding) {
            break;
        }
        let wanted = SHARE * error.min(change.max(SHARE * error));
        inner_tolerance = wanted.clamp(TIGHTEST, inner_tolerance);
    }
    Candidate {
        multiplier: best.1,
        newton_steps: 0,
        outer_steps,
        applications: operator.applications(),
    }
}
