//! Laws of friction whose slip bound follows the pressure, one for each contact face, and their coefficients at
//! nodes and panes.

use std::{
    ops::Range,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicUsize, Ordering},
    },
};

use crate::{
    linalg::CscMatrix,
    scene::{Coefficient, FrictionLaw, SlipBound, is_coefficient},
};

/// Coulomb's law with F(x, |u_t1|, |u_t2|) at the contact nodes: a law for each face with friction, in the order of their
/// nodes and panes. Beside it other faces may have given slip bounds.
///
/// A clone counts its evaluations anew.
#[derive(Debug)]
pub struct CoulombLaw {
    faces: Vec<FaceLaw>,
    /// The coefficients at the contact nodes of laws that do not follow the slip.
    unchanging: OnceLock<Vec<[f64; 2]>>,
    /// Evaluations at nodes, counted on any thread.
    evaluations: AtomicUsize,
    /// Lengths of the path slid before, which coefficients follow beside the slip, `[n_contact_nodes]`, in m;
    /// `None` where there is none or they do not.
    pub(super) path: Option<Arc<Vec<[f64; 3]>>>,
}

/// The law of one face.
#[derive(Debug, Clone)]
pub struct FaceLaw {
    /// Its key in the scene.
    pub(super) key: String,
    /// The law as a function of place and slip; its evaluations are not counted.
    pub law: FrictionLaw,
    /// Contact nodes, `[n_contact_nodes]` of the face, in m.
    pub positions: Vec<[f64; 3]>,
    /// The first of them among all contact nodes.
    first_node: usize,
    /// The panes of the face.
    pub(crate) panes: Range<usize>,
    /// The slip bound g as a function of the pressure.
    pub(super) bound: SlipBound,
    /// Means of its place-dependent stress in Pa over the panes of the face; empty where it has none.
    pub(super) of_panes: Vec<f64>,
}

impl Clone for CoulombLaw {
    fn clone(&self) -> Self {
        Self {
            path: self.path.clone(),
            ..Self::new(self.faces.clone())
        }
    }
}

impl FaceLaw {
    /// A law with the slip bound λ_ν at contact nodes in m, under its key in the scene; the first face, without panes.
    #[must_use]
    pub fn new(key: impl Into<String>, law: FrictionLaw, positions: Vec<[f64; 3]>) -> Self {
        Self {
            key: key.into(),
            law,
            positions,
            first_node: 0,
            panes: 0..0,
            bound: SlipBound::Pressure,
            of_panes: Vec::new(),
        }
    }

    /// The same on given panes, its nodes beginning with `first_node`.
    pub(crate) fn placed(self, first_node: usize, panes: Range<usize>) -> Self {
        Self {
            first_node,
            panes,
            ..self
        }
    }

    /// The semi-axes g F₁, g F₂ in Pa on the panes of a face with given slip bounds, whose coefficients are constant; none
    /// for other laws.
    pub(super) fn given_semi_axes(&self) -> impl Iterator<Item = [f64; 2]> {
        let coefficients = self.law.evaluate([0.0; 3], [0.0; 3], [0.0; 2]);
        self.of_panes
            .iter()
            .map(move |g| coefficients.map(|f| f * g))
    }

    /// F of an isotropic law, or F₁ and F₂.
    #[must_use]
    pub fn coefficients(&self) -> &[Coefficient] {
        self.law.coefficients()
    }

    /// The contact nodes of the face among all of them.
    pub(crate) fn nodes(&self) -> Range<usize> {
        self.first_node..self.first_node + self.positions.len()
    }
}

impl CoulombLaw {
    /// The laws of faces whose nodes and panes follow each other.
    #[must_use]
    pub fn new(faces: Vec<FaceLaw>) -> Self {
        Self {
            faces,
            unchanging: OnceLock::new(),
            evaluations: AtomicUsize::new(0),
            path: None,
        }
    }

    /// The laws of the faces.
    #[must_use]
    pub fn faces(&self) -> &[FaceLaw] {
        &self.faces
    }

    /// The law of the only face with friction; of the first where there are several.
    #[must_use]
    pub fn only(&self) -> &FaceLaw {
        &self.faces[0]
    }

    /// Number of contact nodes on faces with friction.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        let last = self.faces.last();
        last.map_or(0, |face| face.first_node + face.positions.len())
    }

    /// Number of panes with friction.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.faces.last().map_or(0, |face| face.panes.end)
    }

    /// (F₁, F₂) at all contact nodes with friction for their slips in m, `[n_friction_nodes]`; no slips mean zero.
    /// Laws that do not follow the slip are evaluated only once.
    #[must_use]
    pub fn at_nodes(&self, slip: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let everywhere = |slip: &[[f64; 2]]| {
            let slip_of = |node: usize| slip.get(node).copied().unwrap_or([0.0; 2]);
            let nodes = 0..self.n_nodes();
            nodes
                .map(|node| self.evaluate(node, slip_of(node)))
                .collect()
        };
        if self.depends_on_slip() {
            return everywhere(slip);
        }
        self.unchanging.get_or_init(|| everywhere(&[])).clone()
    }

    /// (F₁, F₂) at a contact node for the slips (|u_t1|, |u_t2|) in m.
    #[must_use]
    pub fn evaluate(&self, contact_node: usize, slip: [f64; 2]) -> [f64; 2] {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let (law, path, position) = self.law_at(contact_node);
        law.evaluate(path, position, slip)
    }

    /// ∂F_i/∂|u_tk| in 1/m at a contact node.
    #[must_use]
    pub fn derivative(&self, contact_node: usize, slip: [f64; 2]) -> [[f64; 2]; 2] {
        let (law, path, position) = self.law_at(contact_node);
        law.derivative(path, position, slip)
    }

    /// The law at a contact node, the path slid there before, and its place.
    fn law_at(&self, contact_node: usize) -> (&FrictionLaw, [f64; 3], [f64; 3]) {
        let is_before = |face: &FaceLaw| face.first_node <= contact_node;
        let face = &self.faces[self.faces.partition_point(is_before) - 1];
        let path = self.path.as_ref();
        let path = path.map_or([0.0; 3], |path| path[contact_node]);
        (
            &face.law,
            path,
            face.positions[contact_node - face.first_node],
        )
    }

    fn face_of(&self, pane: usize) -> &FaceLaw {
        &self.faces[self.faces.partition_point(|face| face.panes.end <= pane)]
    }

    /// The slip bound g in Pa of a pane under a pressure λ_ν in Pa; NaN for NaN where it follows the pressure.
    #[must_use]
    pub fn slip_bound(&self, pane: usize, pressure: f64) -> f64 {
        let face = self.face_of(pane);
        let of_pane = || face.of_panes[pane - face.panes.start];
        face.bound.at(pressure, of_pane)
    }

    /// dg/dλ_ν; at a cap that of larger pressures, an element of the generalised derivative.
    #[must_use]
    pub fn slip_bound_slope(&self, pane: usize, pressure: f64) -> f64 {
        self.face_of(pane).bound.slope(pressure)
    }

    /// The slip bounds g in Pa of all panes with friction under the normal stresses λ_ν in Pa of all panes, no pressure where they pull,
    /// `[n_friction_panes]`.
    #[must_use]
    pub fn slip_bounds(&self, normal: &[f64]) -> Vec<f64> {
        let panes = normal.iter().take(self.n_panes()).enumerate();
        let bounds = panes.map(|(pane, value)| self.slip_bound(pane, value.max(0.0)));
        bounds.collect()
    }

    /// Whether any coefficient depends on the solution.
    #[must_use]
    pub fn depends_on_slip(&self) -> bool {
        self.faces.iter().any(|face| face.law.depends_on_slip())
    }

    /// Evaluations at nodes so far.
    #[must_use]
    pub fn evaluations(&self) -> usize {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Sets the number of evaluations.
    pub(crate) fn set_evaluations(&self, evaluations: usize) {
        self.evaluations.store(evaluations, Ordering::Relaxed);
    }
}

/// Friction coefficients on the contact face at one state of slip.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrictionField {
    /// (F₁, F₂) at the contact nodes of the faces with friction, `[n_friction_nodes]`.
    pub nodal: Vec<[f64; 2]>,
    /// Diagonal of 𝓕_i⁻¹ = (1/|Rⁱ|) ∫_{Rⁱ} r_h F⁻¹ on each pane with friction (HKL (4.2)), `[n_friction_panes]`.
    pub pane_inverse: Vec<[f64; 2]>,
}

impl FrictionField {
    /// Evaluates the law at nodal slips and averages F⁻¹, Lagrange-interpolated, over the panes by
    /// [`pane_average`](crate::mesh::ContactSurface::pane_average).
    #[must_use]
    pub fn new(law: &CoulombLaw, average: &CscMatrix, slip: &[[f64; 2]]) -> Self {
        let nodal = law.at_nodes(slip);
        let pane_inverse = (0..law.n_panes())
            .map(|pane| {
                average.entries(pane).fold([0.0; 2], |sum, (node, weight)| {
                    std::array::from_fn(|i| sum[i] + weight / nodal[node][i])
                })
            })
            .collect();
        Self {
            nodal,
            pane_inverse,
        }
    }

    /// Whether all coefficients that act on some panes are positive and finite, which no theory
    /// does without; formulas may fail at slips that only a solution shows.
    #[must_use]
    pub fn is_admissible(&self, average: &CscMatrix, acts: impl Fn(usize) -> bool) -> bool {
        let panes = (0..self.pane_inverse.len()).filter(|pane| acts(*pane));
        let nodes = panes.flat_map(|pane| average.entries(pane).map(|(node, _)| node));
        let mut coefficients = nodes.flat_map(|node| self.nodal[node]);
        coefficients.all(is_coefficient)
    }

    /// The coefficients (F₁, F₂) that act on a pane: the reciprocals of 𝓕_i⁻¹.
    #[must_use]
    pub fn pane(&self, pane: usize) -> [f64; 2] {
        self.pane_inverse[pane].map(f64::recip)
    }
}
