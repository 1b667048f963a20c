//! What friction can bear at most where supports and load settle the pressure.
//!
//! Where no motion that is left to friction moves the face along its normal, λ_ν = T(h_ν − S_νt λ_t) for the solution T of frictionless
//! contact, and T does not expand: ‖T(a) − T(b)‖_S ≤ ‖a − b‖_S⁻¹ for S = S_νν, since λ_ν is the projection of S⁻¹a on a convex cone. With
//! |λ_t| ≤ F λ_ν on every pane ‖S_νt λ_t‖²_S⁻¹ ≤ λ_ν·N λ_ν for the norms N_ij of the blocks F_i (S_tν S⁻¹S_νt)_ij F_j, so ‖λ_ν − T(h_ν)‖_S ≤
//! κ ‖λ_ν‖_S for the largest eigenvalue κ² of S⁻¹N. Where κ < 1 friction does no more work than c·T(h_ν) + ‖c‖_S⁻¹ κ / (1 − κ) ‖T(h_ν)‖_S in
//! a motion, for the work c_i that a unit of pressure on pane i allows. A load that works more in it has no equilibrium.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2};

use super::contact_cone::{ContactCone, FrictionResistance, PROOF_MARGIN};
use crate::{
    dual::{ExplicitDual, RigidEquilibrium},
    linalg::{dot, largest_eigenvalue, norm},
    solver::{
        FeasibleSet,
        convex::{ConvexProgram, InteriorPoint, Motions},
    },
};

/// S + G D⁻¹Gᵀ of a face and its weak supports.
struct PressedFace {
    normal: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    /// S_νt.
    mixed: DMatrix<f64>,
    /// h_ν.
    rhs: DVector<f64>,
}

/// A rigid motion, in terms of active modes, in which the load works more than friction can that is at most F₁, F₂ times the pressure of a pane.
pub(super) fn beyond_friction(
    dual: &ExplicitDual,
    equilibrium: &RigidEquilibrium,
    areas: &[f64],
    coefficients: &[[f64; 2]],
) -> Option<Vec<f64>> {
    let layout = dual.layout;
    let free = &equilibrium.coupling.integrals[equilibrium.coupling.n_supported()..];
    // Coordinates of a mesh have rounding errors, as proofs have.
    let is_along = |g: &Vec<f64>| norm(&g[layout.normals()]) <= PROOF_MARGIN * norm(g);
    if free.is_empty() || !free.iter().all(is_along) {
        return None;
    }
    let face = PressedFace::new(dual, equilibrium)?;
    let sensitivity = face.sensitivity(coefficients);
    let (pressure, error) = face.frictionless_pressure();
    let bounds = (0..layout.n_panes()).map(|i| match coefficients.get(i) {
        Some(f) => FrictionResistance::Tresca(f.map(|f| f * pressure[i])),
        None => FrictionResistance::None,
    });
    let bounds: Vec<FrictionResistance> = bounds.collect();
    let motion = ContactCone::new(equilibrium, areas, layout, &bounds)?.mechanism()?;
    let integrals = equilibrium
        .coupling
        .integrals_of(&motion, layout.n_multipliers());
    let by_pressure = DVector::from_fn(layout.n_panes(), |i, _| {
        match (coefficients.get(i), layout.tangential(i)) {
            (Some([a, b]), Some([j, k])) => (a * integrals[j]).hypot(b * integrals[k]),
            _ => 0.0,
        }
    });
    let size = pressure.dot(&(&face.normal * &pressure)).sqrt() + error;
    let reach = sensitivity / (1.0 - sensitivity) * size + error;
    let friction = by_pressure.dot(&pressure) + face.dual_norm(&by_pressure) * reach;
    let is_proven = sensitivity < 1.0 && dot(&equilibrium.resultant, &motion) > friction;
    is_proven.then_some(motion)
}

impl PressedFace {
    /// `None` where S is not positive definite, as where clamps hold the face.
    fn new(dual: &ExplicitDual, equilibrium: &RigidEquilibrium) -> Option<Self> {
        let (m, n) = (dual.n_panes(), dual.dimension());
        let mut operator = DMatrix::from_fn(m, n, |i, j| dual.column(j)[i]);
        let mut rhs = DVector::from_row_slice(&dual.rhs[..m]);
        let coupling = &equilibrium.coupling;
        for p in 0..coupling.n_supported() {
            let (g, support) = (&coupling.integrals[p], coupling.support[p]);
            let (g, on_normal) = (DVector::from_row_slice(g), DVector::from_row_slice(&g[..m]));
            operator.ger(support.recip(), &on_normal, &g, 1.0);
            rhs.axpy(equilibrium.resultant[p] / support, &on_normal, 1.0);
        }
        let mixed = operator.columns(m, n - m).into_owned();
        let normal = operator.columns(0, m).into_owned();
        Some(Self {
            factor: normal.clone().cholesky()?,
            normal,
            mixed,
            rhs,
        })
    }

    /// κ, how far friction can change the pressure, as a share of it.
    fn sensitivity(&self, coefficients: &[[f64; 2]]) -> f64 {
        let m = self.normal.nrows();
        let triangle = self.factor.l();
        let mut half = self.mixed.clone();
        for (pane, f) in coefficients.iter().enumerate() {
            half.column_mut(2 * pane).scale_mut(f[0]);
            half.column_mut(2 * pane + 1).scale_mut(f[1]);
        }
        triangle.solve_lower_triangular_mut(&mut half);
        let product = half.transpose() * &half;
        let pairs = product.nrows() / 2;
        let mut norms = DMatrix::zeros(m, m);
        for i in 0..pairs {
            for j in 0..pairs {
                let block: Matrix2<f64> = product.fixed_view::<2, 2>(2 * i, 2 * j).into_owned();
                norms[(i, j)] = block.singular_values().max();
            }
        }
        triangle.solve_lower_triangular_mut(&mut norms);
        let mut norms = norms.transpose();
        triangle.solve_lower_triangular_mut(&mut norms);
        let square = largest_eigenvalue(m, |v| {
            let image = &norms * DVector::from_row_slice(v);
            image.iter().copied().collect()
        });
        square.sqrt()
    }

    /// An approximation p of T(h_ν), and a bound of its error in the norm of S. Of p = 0, exact where the face is lifted clear, and of the
    /// pressure that the interior point method finds, it is the one with the smaller bound.
    fn frictionless_pressure(&self) -> (DVector<f64>, f64) {
        let candidates = [DVector::zeros(self.rhs.len()), self.interior_pressure()];
        let measured = candidates.map(|pressure| (self.error_of(&pressure), pressure));
        let [open, pressed] = measured;
        let (error, pressure) = if open.0 <= pressed.0 { open } else { pressed };
        (pressure, error)
    }

    /// √(2 p·r₊) + ‖r₋‖_S⁻¹ for r = S p − h_ν, whose positive part is the gradient of a problem with the gap p·r₊ between it and its dual,
    /// and whose negative part is what that problem is off by.
    fn error_of(&self, pressure: &DVector<f64>) -> f64 {
        let gradient = &self.normal * pressure - &self.rhs;
        let gap = pressure.dot(&gradient.map(|r| r.max(0.0)));
        (2.0 * gap).sqrt() + self.dual_norm(&gradient.map(|r| r.min(0.0)))
    }

    /// The pressure at which the interior point method ends, converged or not; 0 where nothing presses.
    fn interior_pressure(&self) -> DVector<f64> {
        let m = self.rhs.len();
        let set = FeasibleSet::new(m, Vec::new());
        let diagonal = self.normal.diagonal();
        let stiffness: Vec<f64> = diagonal.iter().map(|s| s.recip()).collect();
        let entry = |i: usize, j: usize| self.normal[(i, j)];
        let bound = self.dual_norm(&self.rhs);
        let none = Motions::default();
        let rhs = self.rhs.as_slice();
        let program = ConvexProgram::new(entry, rhs, &set, &stiffness, bound, &none);
        let mut pressure = DVector::zeros(m);
        if let Some(mut inside) = InteriorPoint::new(&program) {
            // However far it comes: what the pressure is off by is bounded, and counts.
            inside.run(PROOF_MARGIN);
            pressure.copy_from_slice(&inside.unknowns(m));
        }
        pressure
    }

    /// √(c·S⁻¹c).
    fn dual_norm(&self, by_pressure: &DVector<f64>) -> f64 {
        let solved = self.factor.solve(by_pressure);
        by_pressure.dot(&solved).max(0.0).sqrt()
    }
}
