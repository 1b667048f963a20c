//! What rounding of a long way, which weak springs let the body go, makes of an answer.
//!
//! Gaps and slips are differences of places: after a way of length U they are known to U ε/2, whatever is solved for them. A pane that is
//! pressed or sticks takes that as ρ |Rⁱ| U ε/2, an open one not at all, one that slides as the turn of its slip.

use super::{
    judge::{ABOUT, NO_DIGIT},
    polish::COARSEST,
};
use crate::{
    dual::Balance,
    linalg::norm,
    solver::{
        Solution, Status,
        conditions::{Bound, Conditions},
        problem::DiscreteProblem,
    },
};

impl DiscreteProblem<'_> {
    /// The error that U ε/2 makes of λ, relative as that of the answer; 0 where no weak springs hold the body.
    pub(in crate::solver) fn rounding_of_way(&self, solution: &Solution) -> f64 {
        let Some(balance) = self.dual.balance.as_ref().filter(|it| it.is_resisted()) else {
            return 0.0;
        };
        if !solution.status.is_solved() {
            return 0.0;
        }
        let unknowns = self.unknowns(solution);
        let exact = self.body.exact(self.dual, &unknowns, None, f64::EPSILON);
        let (multiplier, motion) = self.dual.parts(&unknowns);
        let set;
        let bound = match self.laws.coulomb() {
            Some(law) => Bound::Coulomb(self.laws, law),
            None => {
                set = self.laws.feasible_set(None);
                Bound::Frozen(&set)
            }
        };
        let layout = self.dual.layout();
        let mut steplengths = solution.local_stiffness.clone();
        steplengths.extend(balance.steplengths());
        let conditions = Conditions::new(bound, layout, steplengths);
        let mut gradient: Vec<f64> = exact.closing.iter().map(|c| -c).collect();
        gradient.extend(balance.excess(multiplier, motion));
        let slip = self.body.tangential(&exact.moved.displacement);
        let here = conditions.evaluate(&unknowns, &gradient, &slip);
        let FaceTravel {
            along_normals,
            whole,
        } = self.way(balance, motion);
        let stress = |j: usize, way: f64| {
            let volume = self.laws.area[layout.pane_of(j)] * 0.5 * f64::EPSILON * way;
            solution.local_stiffness[j] * volume
        };
        let mut change = vec![0.0; layout.n_multipliers()];
        for (pane, at) in here.panes.iter().enumerate() {
            if at.pressed {
                let normal = layout.normal(pane);
                change[normal] = stress(normal, along_normals);
            }
            let Some(pair) = layout.tangential(pane) else {
                continue;
            };
            let by_point = at.ellipse.projection_derivative(at.trial).by_point;
            for (row, &j) in by_point.iter().zip(&pair) {
                let terms = row.iter().zip(&pair);
                change[j] = terms.map(|(by, &k)| (by * stress(k, whole)).abs()).sum();
            }
        }
        self.sizes(multiplier, &here).relative(self.laws, &change)
    }

    fn way(&self, balance: &Balance, motion: &[f64]) -> FaceTravel {
        let motion = balance.whole_way(motion);
        let primal = &self.body.assembly.primal;
        let mut rigid = vec![0.0; primal.load.len()];
        balance.coupling.add_rigid(&motion, &mut rigid);
        let nodes = self.body.face.surface.nodes.iter();
        let ways = nodes.map(|&node| norm(&primal.dofs.change_at_node(node, &rigid)));
        let area = &self.laws.area;
        let raised = balance
            .coupling
            .integrals_of(&motion, self.dual.layout().n_multipliers());
        let raised = raised
            .iter()
            .zip(area)
            .map(|(volume, area)| volume.abs() / area);
        FaceTravel {
            along_normals: raised.fold(0.0, f64::max),
            whole: ways.fold(0.0, f64::max),
        }
    }
}

/// How far weak springs let the contact face go, in m. Motions along a flat face leave it by nothing, so that they take no digit of a gap.
struct FaceTravel {
    /// The largest mean displacement of a pane along its normal.
    along_normals: f64,
    /// The largest displacement of a node.
    whole: f64,
}

/// An answer that is no better than rounding of the way allows.
pub(in crate::solver) fn limited_by(way: f64, epsilon: f64, solution: Solution) -> Solution {
    if !solution.status.is_solved() || way <= solution.accuracy.max(ABOUT * epsilon) {
        return solution;
    }
    Solution {
        status: match way {
            _ if way > NO_DIGIT => Status::Inaccurate,
            _ if way > COARSEST => Status::Stopped,
            _ => Status::RoundingLimit,
        },
        accuracy: way.min(1.0),
        ..solution
    }
}
