//! The adjoint of a solution: what a small force anywhere makes of a functional Q(u, λ).
//!
//! At a solution the contact conditions are smooth but for kinks, so that Q follows the loads by δQ = zᵀδl. With R(x; h, u_t) = 0 for
//! the natural map R of the unknowns x (λ, and the rigid motions of a body that floats), h = B A⁻¹ l and u_t = C A⁻¹ l,
//!
//!   R'ᵀy = Q_λ − B A⁻¹Q_u,  ζ = (∂R/∂h)ᵀy,  τ = (∂R/∂u_t)ᵀy,  z = A⁻¹(Q_u − Bᵀζ − Cᵀτ):
//!
//! one solve with the transposed matrix of Newton's method and one with the factor of A. On panes that stick or are pressed ζ is the
//! adjoint's multiplier, and z moves the face as Q_λ says.

use super::{
    ContactBody, ContactState, Ellipse, NaturalMap, Solution,
    conditions::{Bound, Evaluation},
};
use crate::{
    dual::{Assembly, ContactSystem, DualSystem, LocalStiffness},
    linalg::{DenseLu, add_scaled},
};

/// A pane is at a kink where its trial stress is this near to another zone, beside the largest pressure or its ellipse.
const KINK: f64 = 1e-6;

/// What solves leave of an adjoint: no digit of an estimated error depends on it.
const LEFT: f64 = 1e-6;

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
}

/// The adjoints of some functionals at one solution.
#[derive(Debug, Clone, Default)]
pub(crate) struct Adjoints {
    /// In the order of the functionals.
    pub(crate) of: Vec<Adjoint>,
    /// Panes at a kink, where the adjoint is that of one side of it.
    pub(crate) kinks: usize,
}

impl Adjoints {
    /// Solves for the adjoints of functionals; `None` where S is not dense or the matrix of Newton's method is singular.
    pub(crate) fn new(
        system: &DualSystem,
        face: Option<&ContactState<'_>>,
        solution: &Solution,
        functionals: &[LinearFunctional],
    ) -> Option<Self> {
        let assembly = &system.assembly;
        let (Some(face), Some(dual)) = (face, &system.contact) else {
            let forces: Vec<Vec<f64>> = functionals
                .iter()
                .map(|it| it.by_displacement.clone())
                .collect();
            let alone = |displacement| Adjoint {
                displacement,
                ..Adjoint::default()
            };
            let of = assembly.solve_several(&forces, LEFT).into_iter().map(alone);
            let of = of.collect();
            return Some(Self { of, kinks: 0 });
        };
        let balanced = dual.balanced(assembly, face.surface, face.interface);
        let dual = balanced.as_ref().unwrap_or(dual);
        let explicit = dual.explicit()?;
        let laws = face.laws();
        let set = laws.feasible_set(solution.coulomb.as_ref());
        let bound = Bound::of(&laws, &set);
        let known = &solution.local_stiffness;
        let stiffness = if known.len() == explicit.dimension() {
            known.clone()
        } else {
            LocalStiffness::new(explicit).stiffness
        };
        let map = NaturalMap::with_steplengths(explicit, bound, stiffness);
        let at = evaluated(&map, dual, (assembly, face), solution);
        let (coupled, factor) = {
            let (coupled, matrix) = map.coupled_derivative(&at);
            let factor = DenseLu::new(&matrix, coupled.len())?;
            (coupled, factor)
        };
        let linearised = Linearised {
            factor,
            map: &map,
            at: &at,
            coupled,
            dual,
            body: ContactBody {
                assembly,
                face: *face,
            },
        };
        Some(Self {
            of: linearised.adjoints(functionals),
            kinks: at.kinks(),
        })
    }
}

/// The natural map at a solution, with the exact gradient of its displacement.
fn evaluated(
    map: &NaturalMap<'_>,
    dual: &ContactSystem,
    (assembly, face): (&Assembly, &ContactState<'_>),
    solution: &Solution,
) -> Evaluation {
    let dofs = &assembly.primal.dofs;
    let displacement = &solution.displacement;
    let closing = if solution.closing.is_empty() {
        dual.closing(displacement, dofs, face.surface, face.interface)
    } else {
        solution.closing.clone()
    };
    let mut gradient: Vec<f64> = closing.iter().map(|c| -c).collect();
    let mut unknowns = solution.multiplier.clone();
    gradient.resize(dual.n_unknowns(), 0.0);
    unknowns.resize(dual.n_unknowns(), 0.0);
    let body = ContactBody {
        assembly,
        face: *face,
    };
    let slip = body.tangential(displacement);
    map.conditions.evaluate(&unknowns, &gradient, &slip)
}

impl Evaluation {
    /// Panes whose zone a small change would turn.
    fn kinks(&self) -> usize {
        let near = |level: f64| (level - 1.0).abs() <= KINK;
        let largest = self.panes.iter().map(|pane| pane.pressure.abs());
        let small = KINK * largest.fold(0.0, f64::max);
        let turns = self.panes.iter().filter(|pane| {
            let has_ellipse = pane.ellipse.semi_axes != Ellipse::POINT.semi_axes;
            pane.pressure.abs() <= small
                || pane.pressed && has_ellipse && near(pane.ellipse.level(pane.trial))
        });
        turns.count()
    }
}

/// The contact conditions about a solution.
struct Linearised<'a> {
    map: &'a NaturalMap<'a>,
    at: &'a Evaluation,
    /// The unknowns that are coupled, and R' of them; the others do not move.
    coupled: Vec<usize>,
    factor: DenseLu,
    dual: &'a ContactSystem,
    body: ContactBody<'a>,
}

/// An adjoint before it has moved the body.
struct AdjointLoad {
    /// y, `[n_unknowns]`.
    weights: Vec<f64>,
    /// Q_u − Bᵀζ − Cᵀτ.
    force: Vec<f64>,
    multiplier: Vec<f64>,
    slip_force: Vec<[f64; 2]>,
}

impl Linearised<'_> {
    /// The adjoints of all functionals, side by side: the factor is read once for all of them.
    fn adjoints(&self, functionals: &[LinearFunctional]) -> Vec<Adjoint> {
        let assembly = self.body.assembly;
        let is_loaded = |it: &&LinearFunctional| it.by_displacement.iter().any(|f| *f != 0.0);
        let loaded = functionals.iter().filter(is_loaded);
        let loaded: Vec<Vec<f64>> = loaded.map(|it| it.by_displacement.clone()).collect();
        let mut moved = assembly.solve_several(&loaded, LEFT).into_iter();
        let loads: Vec<AdjointLoad> = functionals
            .iter()
            .map(|it| {
                let moved = is_loaded(&it).then(|| moved.next()).flatten();
                self.load(it, moved.as_deref())
            })
            .collect();
        let forces: Vec<Vec<f64>> = loads.iter().map(|load| load.force.clone()).collect();
        let moved = assembly.solve_several(&forces, LEFT);
        let both = loads.into_iter().zip(moved);
        both.map(|(load, displacement)| self.adjoint(load, displacement))
            .collect()
    }

    /// What loads an adjoint; `moved` is A⁻¹Q_u.
    fn load(&self, functional: &LinearFunctional, moved: Option<&[f64]>) -> AdjointLoad {
        let dual = self.dual;
        let mut force = functional.by_displacement.clone();
        let mut rhs = functional.by_multiplier.clone();
        if let Some(moved) = moved {
            add_scaled(&mut rhs, -1.0, &dual.coupling.integrate(moved));
        }
        if let Some(balance) = &dual.balance {
            rhs.extend(balance.coupling.work_of(&force));
        }
        let mut coupled: Vec<f64> = self.coupled.iter().map(|&j| rhs[j]).collect();
        self.factor.solve_transposed(&mut coupled);
        let mut weights = vec![0.0; rhs.len()];
        for (&j, y) in self.coupled.iter().zip(coupled) {
            weights[j] = y;
        }
        let (multiplier, slip_force) = self.map.conditions.transposed(self.at, &weights);
        add_scaled(&mut force, -1.0, &dual.coupling.nodal_forces(&multiplier));
        if !slip_force.is_empty() {
            let ContactBody { assembly, face } = &self.body;
            let dofs = &assembly.primal.dofs;
            for (local, (&node, along)) in face.surface.nodes.iter().zip(&slip_force).enumerate() {
                let vector = face.interface.frame.vector(local, 0.0, *along);
                for (dof, part) in dofs.dof[node].iter().zip(vector) {
                    if let Some(dof) = *dof {
                        force[dof] -= part;
                    }
                }
            }
        }
        AdjointLoad {
            weights,
            force,
            multiplier,
            slip_force,
        }
    }

    fn adjoint(&self, load: AdjointLoad, mut displacement: Vec<f64>) -> Adjoint {
        if let Some(balance) = &self.dual.balance {
            let rows = load.weights.iter().zip(&self.map.conditions.steplengths);
            let motion: Vec<f64> = rows
                .skip(load.multiplier.len())
                .map(|(y, rho)| -y * rho)
                .collect();
            balance.coupling.add_motion(&motion, &mut displacement);
        }
        Adjoint {
            displacement,
            multiplier: load.multiplier,
            slip_force: load.slip_force,
        }
    }
}
