//! What is still open in a search for paths.

use serde::{Deserialize, Serialize};

use super::{
    kink::Ray,
    path::{FIRST_STEP, RETURNED},
    record::{FrontRecord, PathOrigin},
};
use crate::linalg::{difference, norm};

/// Half paths that are still to be followed, and branch points that are known.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Open {
    pub(super) rays: Vec<FrontRecord>,
    pub(super) branch_points: Vec<Vec<f64>>,
}

impl Open {
    pub(super) fn keep(&mut self, rays: &[Ray]) {
        let origin = PathOrigin::BranchPoint;
        let records = rays.iter().map(|ray| ray.record(origin, FIRST_STEP));
        self.rays.extend(records);
    }

    pub(super) fn knows(&self, point: &[f64]) -> bool {
        let near = |known: &Vec<f64>| norm(&difference(known, point)) < RETURNED;
        self.branch_points.iter().any(near)
    }
}
