//! The contact problem of a solution with its friction frozen, in the order and units in which other programs take it.

use contact3d::{
    AssembledProblem,
    contact::{Interface, MultiplierLayout},
    dual::{ContactSystem, ExplicitDual, OperatorForm, pane_stiffness},
    linalg::{CscMatrix, norm, power_of_two_near_largest},
    mesh::ContactSurface,
};

use super::fclib::FclibSolution;

/// Components of r and u at a contact: N, T1, T2.
pub(super) const SPACE_DIMENSION: usize = 3;

/// A problem with Coulomb's law between r and u, components N, T1, T2 contact after contact.
pub(super) struct FrozenProblem {
    /// What ties u to r.
    pub(super) equations: Equations,
    /// Coefficients of friction and what leads back to stresses.
    pub(super) scaling: FrozenScaling,
}

/// The linear equations of a problem with n contacts.
pub(super) enum Equations {
    /// u = W r + q: W = D a⁻¹ S a⁻¹ D, `[3 n, 3 n]`, and q = −D a⁻¹ h / t, `[3 n]`.
    Local { w: CscMatrix, q: Vec<f64> },
    /// M v = H r + f and u = Hᵀ v + w for m free degrees of freedom, displacements being c t v.
    Global {
        /// M = c² A, `[m, m]`.
        m: CscMatrix,
        /// H = −c Bᵀ a⁻¹ D, `[m, 3 n]`.
        h: CscMatrix,
        /// f = c l / t, `[m]`.
        f: Vec<f64>,
        /// w = D (∫gap − B u_c) / (a t) with the displacement u_c of clamps, `[3 n]`.
        w: Vec<f64>,
        /// c, a power of two, in (m/N)^(1/2).
        displacement_scale: f64,
    },
}

/// The scales that make r and u numbers of order one.
///
/// At each pane of area a, with the coefficients F₁, F₂ that act on it at the solution, aλ in N is t D r, and Sλ/a − h/a in m is
/// t D⁻¹ u: D = s diag(1, F₁, F₂) and μ = 1 where the coefficients differ, D = s and μ = F where both are the same on all panes, and
/// one power of two s for each contact. Coulomb's law with the ellipse F₁, F₂ for stresses and slips is that with the circle μ for
/// (r, u), exactly: ‖F⁻¹r_T‖ ≤ r_N, and r_T runs along −F² u_T where it slides.
pub(super) struct FrozenScaling {
    /// μ, `[n]`; 0 on panes without friction.
    pub(super) mu: Vec<f64>,
    /// The diagonal of D, `[3 n]`, in (m/N)^(-1/2).
    pub(super) scale: Vec<f64>,
    /// t, a power of two, in (N m)^(1/2).
    pub(super) unit: f64,
    /// a in m², `[n]`.
    pub(super) area: Vec<f64>,
}

impl FrozenProblem {
    /// The local problem of a dense S, for (F₁, F₂) on each pane, `None` without friction.
    pub(super) fn local(
        problem: &AssembledProblem,
        surface: &ContactSurface,
        interface: &Interface,
        friction: &[Option<[f64; 2]>],
    ) -> Self {
        let dual = &everywhere(problem, surface, interface);
        let area = &surface.pane_area;
        let n = dual.dimension();
        let diagonal: Vec<f64> = (0..n).map(|j| dual.diagonal(j)).collect();
        let scaling = FrozenScaling::new(area, friction, &diagonal, &dual.rhs);
        let order: Vec<usize> = (0..area.len())
            .flat_map(|pane| components(dual.layout, pane))
            .collect();
        let factor = |k: usize| scaling.scale[k] / area[k / SPACE_DIMENSION];
        let mut data = Vec::with_capacity(n * n);
        for (k, &j) in order.iter().enumerate() {
            let column = dual.column(j);
            let entries = order.iter().enumerate();
            // One product on either side of the diagonal, so that W is as symmetric as S.
            data.extend(entries.map(|(l, &i)| factor(k.min(l)) * (column[i] * factor(k.max(l)))));
        }
        let w = CscMatrix {
            rows: n,
            cols: n,
            indptr: (0..=n).map(|j| j * n).collect(),
            indices: (0..n).flat_map(|_| 0..n).collect(),
            data,
        };
        let offsets = order.iter().enumerate();
        let q = offsets.map(|(k, &j)| -factor(k) * dual.rhs[j] / scaling.unit);
        Self {
            equations: Equations::Local { w, q: q.collect() },
            scaling,
        }
    }

    /// The same with the unknowns of the body; S is not formed, and its diagonal estimated by that of single nodes.
    pub(super) fn global(
        problem: &AssembledProblem,
        surface: &ContactSurface,
        interface: &Interface,
        friction: &[Option<[f64; 2]>],
    ) -> Self {
        let primal = &problem.system.assembly.primal;
        let coupling = interface.coupling_everywhere(surface, &primal.dofs);
        let layout = coupling.layout;
        let diagonal: Vec<f64> = pane_stiffness(primal, &coupling)
            .iter()
            .map(|rho| if *rho > 0.0 { rho.recip() } else { 0.0 })
            .collect();
        let system = ContactSystem {
            coupling,
            unconstrained: Vec::new(),
            form: OperatorForm::implicit(Vec::new()),
        };
        let nothing = vec![0.0; primal.dofs.n_free];
        let closing = system.gap_residual(&nothing, &primal.dofs, surface, interface);
        let mean = primal.stiffness.mean_diagonal();
        let c = (-0.5 * mean.log2()).round().exp2();
        let mut scaling = FrozenScaling::new(&surface.pane_area, friction, &diagonal, &closing);
        // Forces of the size of the load: without a gap there are no distances to go by.
        let size = c * norm(&primal.load);
        if size > 0.0 {
            scaling.unit = size.log2().round().exp2();
        }
        let mut h = CscMatrix::empty(primal.dofs.n_free);
        let mut w = Vec::with_capacity(scaling.scale.len());
        for (pane, area) in surface.pane_area.iter().enumerate() {
            for (k, j) in components(layout, pane).into_iter().enumerate() {
                let factor = scaling.scale[SPACE_DIMENSION * pane + k] / area;
                let entries = system.coupling.transposed.entries(j);
                h.push_column(entries.map(|(row, b)| (row, -c * factor * b)));
                w.push(-factor * closing[j] / scaling.unit);
            }
        }
        let mut m = (*primal.stiffness).clone();
        m.data.iter_mut().for_each(|entry| *entry *= c * c);
        let equations = Equations::Global {
            m,
            h,
            f: primal.load.iter().map(|l| c * l / scaling.unit).collect(),
            w,
            displacement_scale: c,
        };
        Self { equations, scaling }
    }

    /// Forces r with the displacement in m over the free degrees of freedom that belongs to them, and what u they lead to.
    pub(super) fn solution(&self, r: Vec<f64>, displacement: &[f64]) -> FclibSolution {
        let mut u = vec![0.0; r.len()];
        let (offset, v) = match &self.equations {
            Equations::Local { w, q } => {
                w.mul(&r, &mut u);
                (q, None)
            }
            Equations::Global {
                h,
                w,
                displacement_scale,
                ..
            } => {
                let scale = displacement_scale * self.scaling.unit;
                let v: Vec<f64> = displacement.iter().map(|u| u / scale).collect();
                h.mul_transposed(&v, &mut u);
                (w, Some(v))
            }
        };
        for (u, offset) in u.iter_mut().zip(offset) {
            *u += offset;
        }
        FclibSolution { v, u, r }
    }

    /// ‖r − P(r − û)‖ / max(‖q‖, ‖r‖, ‖u‖), 0 for 0/0, with û = u + (μ‖u_T‖, 0, 0) and the projection P on the cones ‖x_T‖ ≤ μ x_N:
    /// the error by which `fc3d_compute_error` of Siconos 4.4 measures forces where its argument `norm` is ‖q‖. r solves the problem
    /// where it vanishes (G. De Saxcé, Z.-Q. Feng, *Math. Comput. Model.* 28 (1998) 225). `None` for a global problem.
    pub(super) fn error(&self, solution: &FclibSolution) -> Option<f64> {
        let Equations::Local { q, .. } = &self.equations else {
            return None;
        };
        let FclibSolution { r, u, .. } = solution;
        let contacts = r.as_chunks().0.iter().zip(u.as_chunks().0);
        let residuals = contacts
            .zip(&self.scaling.mu)
            .flat_map(|((r, u), mu)| residual(*r, *u, *mu));
        let residual = norm(&residuals.collect::<Vec<f64>>());
        let size = [q, r, u].map(|x| norm(x)).into_iter().fold(0.0, f64::max);
        Some(if residual == 0.0 {
            0.0
        } else {
            residual / size
        })
    }
}

impl FrozenScaling {
    /// For panes of some areas with (F₁, F₂) where S has a diagonal and h some size; both follow the layout with tangential pairs on
    /// all panes.
    fn new(area: &[f64], friction: &[Option<[f64; 2]>], diagonal: &[f64], h: &[f64]) -> Self {
        let layout = MultiplierLayout::new(area.len(), area.len());
        let mut pairs = friction.iter().flatten();
        let is_isotropic = pairs.all(|[first, second]| first == second);
        let mut scale = Vec::with_capacity(SPACE_DIMENSION * area.len());
        let mut offset: Vec<f64> = Vec::with_capacity(scale.len());
        for (pane, area) in area.iter().enumerate() {
            let ellipse = match friction[pane] {
                Some([first, second]) if !is_isotropic => [1.0, first, second],
                Some(_) | None => [1.0; SPACE_DIMENSION],
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
        let mu = friction.iter().map(|friction| match friction {
            None => 0.0,
            Some([only, _]) if is_isotropic => *only,
            Some(_) => 1.0,
        });
        Self {
            mu: mu.collect(),
            scale,
            unit: power_of_two_near_largest(&offset).unwrap_or(1.0),
            area: area.to_vec(),
        }
    }

    /// r of multipliers with pairs on the first panes, in Pa.
    pub(super) fn forces(&self, layout: MultiplierLayout, multiplier: &[f64]) -> Vec<f64> {
        let mut forces = Vec::with_capacity(self.scale.len());
        for (pane, area) in self.area.iter().enumerate() {
            let [first, second] = layout.pair(multiplier, pane);
            let stresses = [multiplier[layout.normal(pane)], first, second];
            let own = &self.scale[SPACE_DIMENSION * pane..];
            forces.extend((0..SPACE_DIMENSION).map(|k| area * stresses[k] / (self.unit * own[k])));
        }
        forces
    }
}

/// S with tangential pairs on all panes: that of the file where it has them.
fn everywhere(
    problem: &AssembledProblem,
    surface: &ContactSurface,
    interface: &Interface,
) -> ExplicitDual {
    let system = &problem.system;
    let contact = system.contact.as_ref();
    match contact.and_then(ContactSystem::explicit) {
        Some(dual) if dual.layout.n_pairs() == dual.n_panes() => dual.clone(),
        _ => ExplicitDual::everywhere(&system.assembly, surface, interface),
    }
}

/// The places of N, T1 and T2 of a pane in a layout with pairs on all panes.
fn components(layout: MultiplierLayout, pane: usize) -> [usize; SPACE_DIMENSION] {
    let [first, second] = layout.tangential(pane).expect("a pair on every pane");
    [layout.normal(pane), first, second]
}

/// r − P(r − û) at one contact.
fn residual(r: [f64; 3], u: [f64; 3], mu: f64) -> [f64; 3] {
    let x = [
        r[0] - (u[0] + mu * u[1].hypot(u[2])),
        r[1] - u[1],
        r[2] - u[2],
    ];
    let tangential = x[1].hypot(x[2]);
    let projected = if mu * tangential <= -x[0] {
        [0.0; 3]
    } else if tangential <= mu * x[0] {
        x
    } else {
        let normal = (x[0] + mu * tangential) / (1.0 + mu * mu);
        let share = mu * normal / tangential;
        [normal, share * x[1], share * x[2]]
    };
    [0, 1, 2].map(|k| r[k] - projected[k])
}
