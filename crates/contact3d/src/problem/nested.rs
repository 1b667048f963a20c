//! A start for Newton's method where S is implicit: the solution on a coarser mesh of the same brick, found from one that is coarser
//! still (nested iteration).
//!
//! Without a dense S no sweeps of relaxation settle the zones, and each step moves their borders by a few panes. The solution on half as many
//! cells along each edge knows them up to a pane.

use super::{AssembledProblem, Problem, RunStorage, storage::ReadOnly};
use crate::{
    contact::transferred_by_cells,
    post::EstimatedErrors,
    scene::{Brick, DualOperatorKind, ElementOrder, Method, SolveSettings},
    solver::Start,
};

/// Most multipliers of a coarser problem whose S is dense: Newton's method takes seconds on them.
const DENSE: usize = 1_500;

impl AssembledProblem {
    /// Multipliers in Pa to start from; `None` where S is dense or could be, without friction, where the method was given, the body is no
    /// brick, or the coarser problem has no solution.
    pub(super) fn nested_start(
        &self,
        settings: &SolveSettings,
        storage: &mut dyn RunStorage,
    ) -> Option<Vec<f64>> {
        let dual = self.system.contact.as_ref()?;
        let has_friction = self.problem.interface()?.has_friction();
        let needs_start = dual.explicit().is_none() && settings.method == Method::Auto;
        if !needs_start || !has_friction || dual.layout().n_multipliers() <= DENSE {
            return None;
        }
        let mut scene = self.scene().clone();
        let element = scene.element();
        let brick = scene.as_brick_mut()?;
        *brick = halved(brick, element)?;
        scene.adapt = None;
        let scene = scene.checked().ok()?;
        let mesh = self.mesh().of_other_cells(&scene).ok()?;
        let coarse = Problem::on_mesh(scene, mesh).ok()?;
        let n_panes = coarse.mesh().contact.as_ref()?.n_panes();
        let mut scene = coarse.scene().clone();
        scene.assemble.dual_operator = if 3 * n_panes <= DENSE {
            DualOperatorKind::Explicit
        } else {
            DualOperatorKind::Implicit
        };
        let coarse = Problem::of_checked(scene, coarse.mesh)
            .ok()?
            .assemble()
            .ok()?;
        let storage = &mut ReadOnly(storage);
        let errors = EstimatedErrors::Nothing;
        let found = coarse
            .run_evaluated(settings, Start::default(), Vec::new(), errors, storage)
            .ok()?;
        let is_solution = found.solution.status.is_success(settings);
        let brick = coarse.scene().as_brick()?;
        is_solution.then(|| {
            transferred_by_cells(
                (coarse.mesh(), brick),
                self.mesh(),
                &found.solution.multiplier,
            )
        })
    }
}

/// The brick with every other plane between its cells; `None` where there are too few.
fn halved(brick: &Brick, element: ElementOrder) -> Option<Brick> {
    // Panes of P1 are 2 × 2 cells.
    let unit = match element {
        ElementOrder::P1 => 2,
        ElementOrder::P2 => 1,
    };
    let counts = brick.cells.map(|n| n.div_ceil(2 * unit) * unit);
    if counts == brick.cells {
        return None;
    }
    let mut coarse = brick.clone();
    for (axis, n) in counts.into_iter().enumerate() {
        let planes = brick.planes(axis);
        let cells = planes.len() - 1;
        let kept = (0..=n).map(|k| planes[k * cells / n]).collect();
        coarse = coarse.with_planes(axis, kept);
    }
    coarse.grading = Default::default();
    Some(coarse)
}
