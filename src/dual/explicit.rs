use super::{
    Assembly, DualOperator,
    dense::{subtract_product, symmetric_product},
};
use crate::{
    elasticity::DofMap,
    linalg::{CscMatrix, Workspace},
    mesh::ContactSurface,
    scene::Frame,
};

/// The dual problem as dense arrays: S, h and the compliance of the contact nodes.
///
/// With the free displacement A⁻¹l at λ = 0, the tangential displacement of the contact nodes is
/// affine in λ: u_t = `slip_free` − G λ.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplicitDual {
    /// S = B A⁻¹ Bᵀ, column-major, exactly symmetric, `[3 n_panes, 3 n_panes]`, in m³/Pa.
    pub operator: Vec<f64>,
    /// h = B A⁻¹ l with the gap's integral subtracted, `[3 n_panes]`, in m³.
    pub rhs: Vec<f64>,
    /// G = C A⁻¹ Bᵀ with the rows u_t1, u_t2 of contact node after contact node, column-major,
    /// `[2 n_contact_nodes, 3 n_panes]`, in m/Pa.
    pub compliance: Vec<f64>,
    /// (u_t1, u_t2) of A⁻¹l at the contact nodes, signed, `[n_contact_nodes]`, in m.
    pub slip_free: Vec<[f64; 2]>,
}

impl ExplicitDual {
    /// Forms S and G by forward solves W = L⁻¹PBᵀ on the supernodes B reaches, S = WᵀW.
    #[must_use]
    pub fn new(assembly: &Assembly, surface: &ContactSurface, frame: &Frame) -> Self {
        let selection = tangential_selection(surface, frame, &assembly.primal.dofs);
        let coupling = assembly.primal.coupling.transposed.transpose();
        let half_solved = assembly.factor.forward_rows(&coupling);
        let operator = half_solved.gram();
        let compliance = half_solved.compliance(&selection.transpose());
        let mut unconstrained = assembly.primal.load.clone();
        assembly
            .factor
            .solve_in_place(&mut unconstrained, &mut Workspace::default());
        let mut slip_free = vec![0.0; selection.cols];
        selection.mul_transposed(&unconstrained, &mut slip_free);
        Self {
            operator,
            rhs: assembly.dual_rhs.clone(),
            compliance,
            slip_free: pairs(&slip_free),
        }
    }

    /// Number of multipliers 3m.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.rhs.len()
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.dimension() / 3
    }

    /// The relative rounding error 3m ε of S λ, below which no residual is worth reducing.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.dimension() as f64 * f64::EPSILON
    }

    /// One column (or row) of S.
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        &self.operator[j * self.dimension()..(j + 1) * self.dimension()]
    }

    /// One column of G, `[2 n_contact_nodes]`.
    #[must_use]
    pub fn compliance_column(&self, j: usize) -> &[f64] {
        let rows = 2 * self.slip_free.len();
        &self.compliance[j * rows..(j + 1) * rows]
    }

    /// S λ in m³.
    #[must_use]
    pub fn apply(&self, multiplier: &[f64]) -> Vec<f64> {
        symmetric_product(&self.operator, multiplier)
    }

    /// Signed (u_t1, u_t2) = slip_free − G λ at the contact nodes, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn tangential_displacement(&self, multiplier: &[f64]) -> Vec<[f64; 2]> {
        let mut slip = self.slip_free.concat();
        subtract_product(&self.compliance, multiplier, &mut slip);
        pairs(&slip)
    }
}

/// Cᵀ of C u = (u_t1, u_t2) node by node; columns of held degrees of freedom are empty.
fn tangential_selection(surface: &ContactSurface, frame: &Frame, dofs: &DofMap) -> CscMatrix {
    let mut transposed = CscMatrix {
        rows: dofs.n_free,
        cols: 2 * surface.nodes.len(),
        indptr: vec![0],
        indices: Vec::new(),
        data: Vec::new(),
    };
    for &node in &surface.nodes {
        for axis in [frame.axis_1, frame.axis_2] {
            for (dof, direction) in dofs.dof[node].iter().zip(axis) {
                if let (Some(dof), true) = (*dof, direction != 0.0) {
                    transposed.indices.push(dof);
                    transposed.data.push(direction);
                }
            }
            transposed.indptr.push(transposed.indices.len());
        }
    }
    transposed
}

fn pairs(flat: &[f64]) -> Vec<[f64; 2]> {
    flat.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

/// S applied as a dense symmetric matrix; the factor of A is used only for the displacement.
pub struct ExplicitOperator<'a> {
    dual: &'a ExplicitDual,
    assembly: &'a Assembly,
    work: Workspace,
    actions: usize,
}

impl<'a> ExplicitOperator<'a> {
    /// Joins the dense dual problem and the factor it came from.
    #[must_use]
    pub fn new(dual: &'a ExplicitDual, assembly: &'a Assembly) -> Self {
        Self {
            dual,
            assembly,
            work: Workspace::default(),
            actions: 0,
        }
    }
}

impl DualOperator for ExplicitOperator<'_> {
    fn dimension(&self) -> usize {
        self.dual.dimension()
    }

    fn rhs(&self) -> &[f64] {
        &self.dual.rhs
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.actions += 1;
        self.dual.apply(multiplier)
    }

    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.actions += 1;
        self.assembly.displacement(multiplier, &mut self.work)
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(self.dual.tangential_displacement(multiplier))
    }

    fn actions(&self) -> usize {
        self.actions
    }
}
