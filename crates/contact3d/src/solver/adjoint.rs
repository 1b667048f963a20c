//! The adjoint of a solution: what a small force anywhere makes of a functional Q(u, λ).
//!
//! At a solution the contact conditions are smooth but for kinks, so that Q follows the loads by δQ = zᵀδl. With R(x; h, u_t) = 0 for
//! the natural map R of the unknowns x (λ, and the rigid motions of a body that floats), h = B A⁻¹ l and u_t = C A⁻¹ l,
//!
//!   R'ᵀy = Q_λ − B A⁻¹Q_u,  ζ = (∂R/∂h)ᵀy,  τ = (∂R/∂u_t)ᵀy,  z = A⁻¹(Q_u − Bᵀζ − Cᵀτ):
//!
//! one solve with the transposed matrix of Newton's method and one with the factor of A. Where S is implicit GMRES multiplies with
//! R'ᵀy = y + ζ/ρ − B A⁻¹(Bᵀζ + Cᵀτ). On panes that stick or are pressed ζ is the
//! adjoint's multiplier, and z moves the face as Q_λ says.
//!
//! Where contact springs σ gave the solution, with the unknown μ = λ + σ r and A_σ = A + BᵀσB, the same holds with A_σ for A and
//! Q_u + Bᵀσ Q_λ for Q_u, since δλ = δμ + σ B δu; then A z = Q_u − Bᵀζ' − Cᵀτ for the multiplier ζ' = ζ + σ (B z − Q_λ).

use super::{
    ContactBody, ContactProblem, NaturalMap, Solution, StartStrategy,
    conditions::{Bound, Conditions, Evaluation},
    tolerances::{GMRES_MAX_APPLICATIONS, GMRES_TOLERANCE},
    two_levels::{PaneLevels, TwoLevels},
};
use crate::{
    contact::Ellipse,
    dual::{Assembly, LocalStiffness},
    linalg::{DenseLu, add_scaled, difference, gmres_several},
};

/// A pane is at a kink where its trial stress is this near to another zone, relative to the largest pressure or to its ellipse: where λ
/// and loads are known to six digits, they do not tell its zone.
const NON_SMOOTH_DISTANCE: f64 = 1e-6;

/// What solves leave of an adjoint: estimates weigh residuals by it, which are orthogonal to what is left.
const ADJOINT_TOLERANCE: f64 = 1e-3;

/// The derivative of a functional by the displacement and by the multipliers.
#[derive(Debug, Clone, Default)]
pub(crate) struct LinearFunctional {
    /// Q_u over the free degrees of freedom, `[n_free]`.
    pub(crate) by_displacement: Vec<f64>,
    /// Q_λ, `[n_multipliers]`.
    pub(crate) by_multiplier: Vec<f64>,
}

/// The adjoint of one functional.
#[derive(Debug, Clone, Default)]
pub(crate) struct Adjoint {
    /// z over the free degrees of freedom, `[n_free]`, in units of Q for a newton.
    pub(crate) displacement: Vec<f64>,
    /// ζ, `[n_multipliers]`; empty without contact.
    pub(crate) multiplier: Vec<f64>,
    /// τ at the contact nodes, `[n_contact_nodes]`; empty where friction follows no slip.
    pub(crate) slip_force: Vec<[f64; 2]>,
    /// Panes at a kink, where the adjoint is that of one side of it.
    pub(crate) kinks: usize,
}

impl Adjoint {
    /// Solves for the adjoints of functionals at one solution, with A alone where there is no contact problem; `None` where the matrix of Newton's
    /// method is singular, and for a body that floats on an implicit S.
    pub(crate) fn of(
        assembly: &Assembly,
        problem: Option<&ContactProblem<'_>>,
        solution: &Solution,
        functionals: &[LinearFunctional],
    ) -> Option<Vec<Self>> {
        let Some(problem) = problem else {
            let forces = functionals.iter().map(|it| it.by_displacement.clone());
            let response = assembly.solve_several(forces.collect(), ADJOINT_TOLERANCE);
            let alone = |displacement| Adjoint {
                displacement,
                ..Adjoint::default()
            };
            return Some(response.into_iter().map(alone).collect());
        };
        if solution.trace.strategy != Some(StartStrategy::ContactSprings) {
            return Self::of_contact(problem, solution, functionals);
        }
        let face = problem.body.face;
        let system = problem
            .system
            .with_contact_springs((face.surface, face.interface))?;
        let augmented = ContactProblem::new(&system, face)?;
        let springs = augmented.dual.explicit()?.contact_springs.clone()?;
        let coupling = &augmented.dual.coupling;
        let with_springs = |it: &LinearFunctional| {
            let stresses = it.by_multiplier.iter().zip(&*springs);
            let stresses: Vec<f64> = stresses.map(|(q, spring)| q * spring).collect();
            let mut it = it.clone();
            add_scaled(
                &mut it.by_displacement,
                1.0,
                &coupling.nodal_forces(&stresses),
            );
            it
        };
        let all: Vec<LinearFunctional> = functionals.iter().map(with_springs).collect();
        let mut adjoints = Self::of_contact(&augmented, solution, &all)?;
        for (adjoint, functional) in adjoints.iter_mut().zip(functionals) {
            let moved = coupling.integrate(&adjoint.displacement);
            let apart = difference(&moved, &functional.by_multiplier);
            let parts = adjoint.multiplier.iter_mut().zip(apart).zip(&*springs);
            parts.for_each(|((zeta, apart), spring)| *zeta += spring * apart);
        }
        Some(adjoints)
    }

    /// Those of a contact problem, by A and S as it has them.
    fn of_contact(
        problem: &ContactProblem<'_>,
        solution: &Solution,
        functionals: &[LinearFunctional],
    ) -> Option<Vec<Self>> {
        let assembly = problem.body.assembly;
        let ContactProblem { dual, laws, .. } = problem;
        let set = laws.feasible_set(solution.friction.as_ref().map(|it| &it.coulomb));
        let bound = Bound::of(laws, &set);
        let known = Some(&solution.trace.local_stiffness)
            .filter(|it| it.len() == dual.layout().n_multipliers());
        let adjoints = |conditions: &Conditions<'_>, at: &Evaluation, rows: Rows<'_>| {
            let linearised = Linearised {
                problem,
                conditions,
                at,
                rows,
            };
            linearised.adjoints(functionals)
        };
        let Some(explicit) = dual.explicit() else {
            if dual.rigid().is_some() {
                return None;
            }
            let levels = PaneLevels::new(assembly, &dual.coupling, known?);
            let conditions = Conditions::new(bound, dual.layout(), levels.steplengths.clone());
            let at = evaluated(&conditions, problem, solution);
            let levels = TwoLevels::at(&levels, &conditions, &at, laws.average.rows);
            return Some(adjoints(&conditions, &at, Rows::Products(levels)));
        };
        let stiffness = known.map_or_else(|| LocalStiffness::new(explicit).stiffness, Vec::clone);
        let map = NaturalMap::with_steplengths(explicit, bound, stiffness);
        let at = evaluated(&map.conditions, problem, solution);
        let (coupled, matrix) = map.coupled_derivative(&at);
        let factor = DenseLu::new(&matrix, coupled.len())?;
        drop(matrix);
        let rows = Rows::Dense { coupled, factor };
        Some(adjoints(&map.conditions, &at, rows))
    }
}

/// The natural map at a solution, with the gradient of its displacement.
fn evaluated(
    conditions: &Conditions<'_>,
    ContactProblem { dual, body, .. }: &ContactProblem<'_>,
    solution: &Solution,
) -> Evaluation {
    let ContactBody { assembly, face } = body;
    let dofs = &assembly.primal.dofs;
    let displacement = &solution.displacement;
    let residual = dual.gap_residual(displacement, dofs, face.surface, face.interface);
    let mut unknowns = solution.multiplier.clone();
    unknowns.resize(dual.n_unknowns(), 0.0);
    if let Some(springs) = &conditions.contact_springs {
        // μ = λ + σ r with r = gap − B u.
        let parts = unknowns.iter_mut().zip(springs.iter().zip(&residual));
        parts.for_each(|(mu, (spring, beyond))| *mu -= spring * beyond);
    }
    body.conditions_at(dual, conditions, &unknowns, displacement, &residual)
}

impl Evaluation {
    /// Panes whose zone a small change would turn.
    fn kinks(&self) -> usize {
        let near = |level: f64| (level - 1.0).abs() <= NON_SMOOTH_DISTANCE;
        let largest = self.panes.iter().map(|pane| pane.normal_trial.abs());
        let small = NON_SMOOTH_DISTANCE * largest.fold(0.0, f64::max);
        let turns = self.panes.iter().filter(|pane| {
            let has_ellipse = pane.ellipse.semi_axes != Ellipse::POINT.semi_axes;
            pane.normal_trial.abs() <= small
                || pane.pressed && has_ellipse && near(pane.ellipse.level(pane.trial))
        });
        turns.count()
    }
}

/// The contact conditions about a solution.
struct Linearised<'a> {
    problem: &'a ContactProblem<'a>,
    conditions: &'a Conditions<'a>,
    at: &'a Evaluation,
    rows: Rows<'a>,
}

/// How R' is known.
enum Rows<'a> {
    /// The unknowns that are coupled, and R' of them; the others do not move.
    Dense {
        coupled: Vec<usize>,
        factor: DenseLu,
    },
    /// By products, with its preconditioner.
    Products(TwoLevels<'a>),
}

impl Linearised<'_> {
    /// The adjoints of all functionals, side by side: the factor is read once for all of them.
    fn adjoints(&self, functionals: &[LinearFunctional]) -> Vec<Adjoint> {
        let assembly = self.problem.body.assembly;
        let is_loaded = |it: &&LinearFunctional| it.by_displacement.iter().any(|f| *f != 0.0);
        let loaded = functionals.iter().filter(is_loaded);
        let loaded = loaded.map(|it| it.by_displacement.clone());
        let mut response = assembly
            .solve_several(loaded.collect(), ADJOINT_TOLERANCE)
            .into_iter();
        let rows = functionals.iter().map(|it| {
            let response = is_loaded(&it).then(|| response.next()).flatten();
            self.rhs(it, response.as_deref())
        });
        let weights = self.weights(&rows.collect::<Vec<_>>());
        let forces_of = |y: &Vec<f64>| self.conditions.transposed(self.at, y);
        let forces: Vec<_> = weights.iter().map(forces_of).collect();
        let loads = functionals.iter().zip(&forces);
        let loads = loads.map(|(it, (multiplier, slip_force))| {
            let held = self.contact_force(multiplier, slip_force);
            difference(&it.by_displacement, &held)
        });
        let response = assembly.solve_several(loads.collect(), ADJOINT_TOLERANCE);
        let kinks = self.at.kinks();
        let parts = weights.iter().zip(forces).zip(response);
        let adjoint =
            |((y, (multiplier, slip_force)), mut displacement): ((&Vec<f64>, _), Vec<f64>)| {
                if let Some(equilibrium) = self.problem.dual.rigid() {
                    let rows = y.iter().zip(&self.conditions.steplengths);
                    let rows = rows.skip(self.problem.dual.layout().n_multipliers());
                    let motion: Vec<f64> = rows.map(|(y, rho)| -y * rho).collect();
                    equilibrium.coupling.add_motion(&motion, &mut displacement);
                }
                Adjoint {
                    displacement,
                    multiplier,
                    slip_force,
                    kinks,
                }
            };
        parts.map(adjoint).collect()
    }

    /// Q_λ − B A⁻¹Q_u; `response` is A⁻¹Q_u.
    fn rhs(&self, functional: &LinearFunctional, response: Option<&[f64]>) -> Vec<f64> {
        let dual = &self.problem.dual;
        let mut rhs = functional.by_multiplier.clone();
        if let Some(response) = response {
            add_scaled(&mut rhs, -1.0, &dual.coupling.integrate(response));
        }
        if let Some(equilibrium) = dual.rigid() {
            rhs.extend(equilibrium.coupling.work_of(&functional.by_displacement));
        }
        rhs
    }

    /// y of R'ᵀy = b for several b.
    fn weights(&self, rhs: &[Vec<f64>]) -> Vec<Vec<f64>> {
        match &self.rows {
            Rows::Dense { coupled, factor } => {
                let solved = |rhs: &Vec<f64>| {
                    let mut part: Vec<f64> = coupled.iter().map(|&j| rhs[j]).collect();
                    factor.solve_transposed(&mut part);
                    let mut weights = vec![0.0; rhs.len()];
                    coupled.iter().zip(part).for_each(|(&j, y)| weights[j] = y);
                    weights
                };
                rhs.iter().map(solved).collect()
            }
            Rows::Products(levels) => {
                let rhs: Vec<&[f64]> = rhs.iter().map(Vec::as_slice).collect();
                let solved = gmres_several(&rhs, GMRES_TOLERANCE, GMRES_MAX_APPLICATIONS, |v| {
                    let y: Vec<_> = v.iter().map(|v| levels.apply_transposed(v)).collect();
                    self.transposed_products(&y)
                });
                solved.iter().map(|v| levels.apply_transposed(v)).collect()
            }
        }
    }

    /// R'ᵀy = y + ζ/ρ − B A⁻¹(Bᵀζ + Cᵀτ) for several y, which share the reading of the factor.
    fn transposed_products(&self, several: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let transposed = several
            .iter()
            .map(|y| self.conditions.transposed(self.at, y));
        let transposed: Vec<_> = transposed.collect();
        let forces = transposed
            .iter()
            .map(|(by_rhs, by_slip)| self.contact_force(by_rhs, by_slip));
        let mut response: Vec<Vec<f64>> = forces.collect();
        let mut columns: Vec<&mut [f64]> = response.iter_mut().map(Vec::as_mut_slice).collect();
        self.problem
            .body
            .assembly
            .factor
            .solve_several(&mut columns);
        let all = several.iter().zip(&transposed).zip(&response);
        all.map(|((y, (by_rhs, _)), response)| {
            let mut product = self.problem.dual.coupling.integrate(response);
            let parts = y.iter().zip(by_rhs).zip(&self.conditions.steplengths);
            for (product, ((y, by), rho)) in product.iter_mut().zip(parts) {
                let own = if *rho > 0.0 { by / rho } else { 0.0 };
                *product = y + own - *product;
            }
            product
        })
        .collect()
    }

    /// Bᵀζ + Cᵀτ.
    fn contact_force(&self, multiplier: &[f64], slip_force: &[[f64; 2]]) -> Vec<f64> {
        let ContactProblem { dual, body, .. } = self.problem;
        let mut force = dual.coupling.nodal_forces(multiplier);
        let ContactBody { assembly, face } = body;
        let dofs = &assembly.primal.dofs;
        let frame = &face.interface.frame;
        for (local, along) in slip_force.iter().enumerate() {
            let vector = frame.vector(local, 0.0, *along);
            for (dof, part) in frame.terms(face.surface, dofs, local, vector) {
                force[dof] += part;
            }
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use super::{Adjoint, LinearFunctional};
    use crate::{
        AssembledProblem, Problem,
        linalg::norm,
        scene::{
            Body, Clamp, Coefficient, Contact, DualOperatorKind, ElementOrder, Friction, Material,
            Scene, Traction,
        },
    };

    fn assembled(kind: DualOperatorKind) -> AssembledProblem {
        let mut body = Body::brick([3.0, 1.0, 1.0], [12, 4, 2]);
        body.element = ElementOrder::P2;
        let falling = |rate| Coefficient::ramp(0.3, 0.2, 1e-5, rate);
        let mut scene = Scene::new(body, Material::isotropic(21.19e10, 0.277))
            .with_clamp(Clamp::face("x_min"))
            .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
            .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
            .with_contact(Contact::on("z_min"))
            .with_friction(Friction::orthotropic(falling(3000.0), falling(1000.0)));
        scene.assemble.dual_operator = kind;
        Problem::new(scene).unwrap().assemble().unwrap()
    }

    #[test]
    fn products_give_the_adjoints_of_the_dense_matrix() {
        let [dense, products] =
            [DualOperatorKind::Explicit, DualOperatorKind::Implicit].map(assembled);
        let solution = dense.solve(&dense.scene().solve).unwrap();
        let (m, n) = (dense.n_panes(), dense.n_free());
        let normal_force = LinearFunctional {
            by_displacement: vec![0.0; n],
            by_multiplier: (0..3 * m).map(|i| if i < m { 1.0 } else { 0.0 }).collect(),
        };
        let lifted = LinearFunctional {
            by_displacement: (0..n).map(|i| if i % 3 == 2 { 1.0 } else { 0.0 }).collect(),
            by_multiplier: vec![0.0; 3 * m],
        };
        let functionals = [normal_force, lifted];
        let of = |problem: &AssembledProblem| {
            let contact = problem.contact_problem();
            let assembly = &problem.system.assembly;
            Adjoint::of(assembly, contact.as_ref(), &solution, &functionals).unwrap()
        };
        for (by_products, by_matrix) in of(&products).iter().zip(&of(&dense)) {
            let far = |x: &[f64], y: &[f64]| {
                let apart: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
                norm(&apart) / norm(y)
            };
            // GMRES leaves 1e-4 of the residual, and S has a condition of some hundreds.
            assert!(far(&by_products.multiplier, &by_matrix.multiplier) < 0.05);
            assert!(far(&by_products.displacement, &by_matrix.displacement) < 5e-3);
            assert_eq!(by_products.slip_force.len(), by_matrix.slip_force.len());
        }
    }
}
