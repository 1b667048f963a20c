//! What the steps of a load history before this one left on the contact face.

use std::{borrow::Cow, sync::Arc};

use super::{Interface, InterfaceFriction, SlipOperator, SlipOperatorDerivative};
use crate::{elasticity::DofMap, mesh::ContactSurface, scene::SlipMeasure};

/// Where the contact nodes are when a step begins, and how far they have slid.
#[derive(Debug, Clone, PartialEq)]
pub struct Past {
    /// (u_t1, u_t2) that the slip of the step is counted from, `[n_contact_nodes]`, in m.
    pub tangential: Vec<[f64; 2]>,
    /// Lengths of the path of sliding: Σ r_h|Δu_t1|, Σ r_h|Δu_t2| and the sum of the roots of their squares,
    /// `[n_contact_nodes]`, in m.
    pub path: Vec<[f64; 3]>,
    /// The slip that coefficients of friction follow.
    pub follows: SlipMeasure,
}

/// How slips φ are made of the signed (u_t1, u_t2) at the contact nodes.
#[derive(Debug, Clone)]
pub struct SlipMap {
    /// r_h.
    pub operator: SlipOperator,
    /// What former steps of a load history left; `None` in the first, and without a history.
    pub past: Option<Past>,
}

impl SlipMap {
    /// r_h of the slips that coefficients follow at the contact nodes, for the signed (u_t1, u_t2) there, in m. A path of
    /// sliding from former steps is added by the law.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.operator.slip(&self.counted(tangential))
    }

    /// The derivative of [`Self::slip`] by (u_t1, u_t2).
    #[must_use]
    pub fn derivative(&self, tangential: &[[f64; 2]]) -> SlipOperatorDerivative {
        self.operator.derivative(&self.counted(tangential))
    }

    /// u_t less where the slip is counted from, where the law counts from there.
    fn counted<'u>(&self, tangential: &'u [[f64; 2]]) -> Cow<'u, [[f64; 2]]> {
        match &self.past {
            Some(past) if past.follows != SlipMeasure::TotalSlip => past.slip(tangential).into(),
            _ => tangential.into(),
        }
    }
}

impl Interface {
    /// The face in a later step: slip is counted from where the step begins.
    #[must_use]
    pub fn after(mut self, past: Past) -> Self {
        if past.follows == SlipMeasure::PathLength
            && let InterfaceFriction::Coulomb(law) = &mut self.friction
        {
            law.path = Some(Arc::new(past.path.clone()));
        }
        self.slip.past = Some(past);
        self
    }

    /// [`SlipMap::slip`] of a displacement over the free degrees of freedom in m.
    #[must_use]
    pub fn slip_of_displacement(
        &self,
        surface: &ContactSurface,
        dofs: &DofMap,
        displacement: &[f64],
    ) -> Vec<[f64; 2]> {
        let at_node = |node| dofs.at_node(node, displacement);
        self.slip
            .slip(&self.frame.nodal_tangential(surface, at_node))
    }

    /// The lengths of the path of sliding at the end of a step, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn path_after(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let SlipMap { operator, past } = &self.slip;
        let moved = match past {
            None => operator.slip(tangential),
            Some(past) => operator.slip(&past.slip(tangential)),
        };
        let before = |node: usize| past.as_ref().map_or([0.0; 3], |past| past.path[node]);
        let nodes = moved.iter().enumerate();
        nodes
            .map(|(node, &[first, second])| {
                let before = before(node);
                [
                    before[0] + first,
                    before[1] + second,
                    before[2] + first.hypot(second),
                ]
            })
            .collect()
    }

    /// Where the slip of the step is counted from at a contact node, (u_t1, u_t2) in m.
    #[must_use]
    pub fn slip_origin(&self, node: usize) -> [f64; 2] {
        self.slip
            .past
            .as_ref()
            .map_or([0.0; 2], |past| past.tangential[node])
    }

    /// What the integrals of (u_ν, u_t1, u_t2) over the panes are counted from: those of the gap, and of where the
    /// step begins, in m³; `[n_multipliers]`, or shorter by what is zero.
    pub(crate) fn offsets(&self, surface: &ContactSurface) -> Vec<f64> {
        let n_panes = surface.n_panes();
        let over =
            |pane: usize, values: &[f64]| surface.pane_area[pane] * surface.pane_mean(pane, values);
        let mut offsets = match &self.gap {
            Some(gap) => (0..n_panes).map(|pane| over(pane, gap)).collect(),
            None => Vec::new(),
        };
        let past = self.slip.past.as_ref().filter(|_| self.has_friction());
        let Some(past) = past else {
            return offsets;
        };
        offsets.resize(n_panes, 0.0);
        let components = [0, 1].map(|k| past.component(k));
        for pane in 0..self.n_friction_panes() {
            offsets.extend(components.iter().map(|values| over(pane, values)));
        }
        offsets
    }
}

impl Past {
    /// u_t − u_tⁿ⁻¹ at the contact nodes in m.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let pairs = tangential.iter().zip(&self.tangential);
        pairs
            .map(|(u, from)| [u[0] - from[0], u[1] - from[1]])
            .collect()
    }

    /// u_t1 or u_t2 where the step begins, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn component(&self, k: usize) -> Vec<f64> {
        self.tangential.iter().map(|u| u[k]).collect()
    }
}
