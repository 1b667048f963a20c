//! A problem with the forms of its contact face, and all that is measured on its mesh.

use std::{path::Path, sync::Arc};

use faer::Mat;

use super::{
    FrictionFunctional, InfSup, LevelWork, Observed, ScaledPoint, Thresholds,
    bound::{DisplacementNorm, FaceConstants, NormConstants},
    contraction::LocalContraction,
    dense::{DenseFactor, diagonal, inverse, largest_ratio},
    face::{FaceForms, FaceGram, PaneIntegrals, TriangulatedFace, factorised, product, sum},
    interpolation::{Interpolation, lagrange_on_absolute, on_finer_functions},
    quartic::{diameter, largest_over_fourth},
    scaled::ScaledLaws,
    trace::{TraceConstants, first_sobolev_gram},
};
use crate::shared::{dual_of, refuse_floating};
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    contact::{ContactFrame, CoulombLaw, Interface, LawBounds, SlipOperator},
    dual::{DualSystem, ExplicitDual, LocalStiffness},
    linalg::{CholeskyFactor, CscMatrix, Factor, FactorStructure, Work, Workspace, dot},
    mesh::{ContactSurface, Mesh},
    scene::{DualOperatorKind, FactorPrecision, InvalidValue, Scene, SolveSettings},
    solver::{ContactState, Linearisation, PaneLaws, Status},
};

/// Parts in which the sides of contact triangles are cut to measure interpolation.
const FINER: [usize; 3] = [2, 4, 8];

/// The theory on one mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TheoryLevel {
    /// Smallest number of cells along an edge; 0 for a mesh file.
    pub n_div: usize,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Panes m, or nodes that carry multipliers.
    pub n_panes: usize,
    /// How the solve ended.
    pub status: Status,
    /// Constants of the contact face.
    pub face: FaceConstants,
    /// Constants in each norm of displacements.
    pub norms: Vec<NormConstants>,
    /// Stability of several spaces of multipliers.
    pub inf_sup: Vec<InfSup>,
    /// Ψ′ at the solution; `None` where there is none, or it is singular.
    pub local: Option<LocalContraction>,
    /// Sign of det R′ at the solution.
    pub determinant: i8,
    /// What Ψ does.
    pub observed: Observed,
    /// The friction functional of the program beside HKL's; `None` for nodal multipliers, or without a solution.
    pub functional: Option<FrictionFunctional>,
    /// Solutions for scaled laws.
    pub scaled: Vec<ScaledPoint>,
    /// Where the scaled law reaches its limits.
    pub thresholds: Thresholds,
}

impl TheoryProblem {
    pub(super) fn measure(
        &self,
        n_div: usize,
        work: &mut LevelWork<'_, '_>,
    ) -> Result<TheoryLevel, ProblemError> {
        let face = self.face_constants();
        let law = LawBounds::new(self.law().only(), self.assembled.mesh().extent());
        let norms = [0, 1].map(|k| self.norm_constants(k, &face, &law));
        let sharp = norms[1].bound.sharp.recip();
        work.figure(&format!(
            "uniqueness is proven for the law scaled by less than {sharp:.2e}"
        ));
        // To rounding, whatever the scene's own settings are: Ψ is differentiated and disturbed at the solution.
        let solution = self.assembled.solve(&SolveSettings::default())?;
        let contact = self.contact();
        let solved = solution.status.is_solved();
        let local = self
            .contraction(contact.interface, &solution, true)
            .filter(|_| solved);
        let scan = ScaledLaws::scan(self, work)?;
        let bounds = norms.each_ref().map(|n| n.bound);
        let thresholds = Thresholds {
            paper: bounds.map(|q| q.paper.recip()),
            weighted: bounds.map(|q| q.weighted.recip()),
            sharp: bounds.map(|q| q.sharp.recip()),
            norm: [
                scan.first(|p| p.norm[0] >= 1.0)?,
                scan.first(|p| p.norm[1] >= 1.0)?,
            ],
            spectral_radius: scan.first(|p| p.spectral_radius >= 1.0)?,
            singular: scan.first(|p| p.determinant <= 0)?,
        };
        Ok(TheoryLevel {
            n_div,
            n_free: self.assembled.n_free(),
            n_panes: self.rows.len(),
            status: solution.status,
            face,
            observed: self.observe(&norms, local.as_ref(), &solution.multiplier),
            norms: norms.to_vec(),
            inf_sup: Vec::new(),
            functional: self.functional(&solution).filter(|_| solved),
            determinant: self.determinant(contact.interface, &solution.multiplier),
            local,
            scaled: scan.points,
            thresholds,
        })
    }

    fn face_constants(&self) -> FaceConstants {
        let size = self.face.size();
        let whole = sum(&self.forms.mass, &self.forms.stiffness);
        let finer = |kind| {
            FINER.map(|parts| on_finer_functions(&self.face, parts, kind).unwrap_or(f64::NAN))
        };
        FaceConstants {
            triangle_size: size,
            pane_size: pane_size(self.assembled.mesh(), self.surface()).unwrap_or(size),
            inverse_first: size * ratio(&whole, &self.forms.mass),
            inverse_fourth: size.sqrt() * largest_over_fourth(&self.face),
            axes: axes_constant(&self.face, &whole, &self.contact().interface.frame),
            lagrange: lagrange_on_absolute(&self.face),
            lagrange_finer: finer(Interpolation::Lagrange),
            clement_finer: finer(Interpolation::Clement),
        }
    }

    fn norm_constants(&self, k: usize, face: &FaceConstants, law: &LawBounds) -> NormConstants {
        let assembly = &self.system().assembly;
        let (stiffness, load) = (&*assembly.primal.stiffness, &assembly.primal.load);
        let mut work = Workspace::default();
        let norm = DisplacementNorm::ALL[k];
        let (ellipticity, continuity, load) = match norm {
            DisplacementNorm::Energy => {
                (1.0, 1.0, dot(load, &assembly.solve(load, &mut work)).sqrt())
            }
            DisplacementNorm::FirstSobolev => {
                let (gram, factor) = &self.sobolev;
                let n = load.len();
                let mut by_gram = inverse(factor);
                let dual = dot(load, &by_gram(load.clone())).sqrt();
                let largest = largest_ratio(n, |v| product(stiffness, v), by_gram);
                let by_stiffness = |f: Vec<f64>| assembly.solve(&f, &mut work);
                let softest = largest_ratio(n, |v| product(gram, v), by_stiffness);
                (softest.recip(), largest, dual)
            }
        };
        let areas = diagonal(&self.rows.areas());
        let over = self.pressure[k].1.largest_of(&areas);
        let trace = TraceConstants::new(&self.grams[k], &self.face, &self.forms);
        // c_r of the scene's r_h, and the bound of the norm of r_h|v_t| by ‖v‖ that does without it.
        let (interpolation, interpolated) = match self.contact().interface.slip.operator {
            SlipOperator::Lagrange => (face.lagrange, trace.interpolated),
            // Larger on finer functions, among them |φ| of φ ∈ Y^h, until it settles.
            SlipOperator::Clement(_) => (face.clement_finer[2], trace.tangential),
        };
        let constants = NormConstants {
            norm,
            ellipticity,
            continuity,
            load,
            inverse_half: (face.pane_size * over).sqrt(),
            trace,
            ..NormConstants::default()
        };
        let nodal = self.surface().is_nodal();
        constants.bounded(face, law, [interpolation, interpolated], nodal)
    }
}

/// √ of the largest eigenvalue of X v = θ Y v.
fn ratio(form: &CscMatrix, norm: &CscMatrix) -> f64 {
    let Some(factor) = factorised(norm) else {
        return f64::NAN;
    };
    largest_ratio(form.cols, |v| product(form, v), inverse(&factor)).sqrt()
}

/// c_t: sup of ‖φ_t‖_1 / ‖φ‖_1 over nodal fields, φ_t interpolated; 1 where the axes do not turn.
fn axes_constant(face: &TriangulatedFace, whole: &CscMatrix, frame: &ContactFrame) -> f64 {
    if frame.axes.len() == 1 {
        return 1.0;
    }
    let Some(factor) = factorised(whole) else {
        return f64::NAN;
    };
    let free = face.free_nodes();
    let n = free.len();
    let mut work = Workspace::default();
    let form = |field: &[f64]| {
        let mut image = vec![0.0; 3 * n];
        for axis in 0..2 {
            let direction = |i: usize| frame.axes_at(free[i])[axis];
            let along: Vec<f64> = (0..n)
                .map(|i| (0..3).map(|c| direction(i)[c] * field[c * n + i]).sum())
                .collect();
            for (i, value) in product(whole, &along).into_iter().enumerate() {
                (0..3).for_each(|c| image[c * n + i] += direction(i)[c] * value);
            }
        }
        image
    };
    let solve = |mut forces: Vec<f64>| {
        for part in forces.chunks_exact_mut(n.max(1)) {
            factor.solve_in_place(part, &mut work);
        }
        forces
    };
    largest_ratio(3 * n, form, solve).sqrt()
}

/// The largest diameter of a pane; `None` for nodal multipliers.
fn pane_size(mesh: &Mesh, surface: &ContactSurface) -> Option<f64> {
    if surface.is_nodal() {
        return None;
    }
    let mut corners = vec![Vec::new(); surface.n_panes()];
    for (&facet, &pane) in surface.facets.iter().zip(&surface.facet_pane) {
        corners[pane].extend(mesh.corners(&mesh.facets[facet]));
    }
    let sizes = corners.iter().map(|points| diameter(points));
    Some(sizes.fold(0.0, f64::max))
}

/// A problem with Coulomb friction on linear tetrahedra, with the forms of its contact face.
pub(super) struct TheoryProblem {
    pub(super) assembled: AssembledProblem,
    pub(super) local: LocalStiffness,
    pub(super) face: TriangulatedFace,
    pub(super) forms: FaceForms,
    pub(super) rows: PaneIntegrals,
    /// In H¹(Ω)³ and in the energy norm.
    pub(super) grams: [FaceGram; 2],
    pub(super) sobolev: (CscMatrix, CholeskyFactor),
    /// Of the mass of Y^h.
    pub(super) mass_factor: CholeskyFactor,
    /// ‖·‖²_{*,h} over V₀^h in both norms of displacements, `[m, m]`, and its factor.
    pub(super) pressure: [(Mat<f64>, DenseFactor); 2],
    /// The compliance u_t = … − G λ of the contact nodes, `[2 n_contact_nodes, 3 m]`.
    pub(super) compliance: Mat<f64>,
}

impl TheoryProblem {
    pub(super) fn new(mut scene: Scene, folder: &Path) -> Result<Self, ProblemError> {
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        scene.assemble.factor = FactorPrecision::Double;
        let mesh = Mesh::of_scene(&scene, folder)?;
        let assembled = Problem::of_checked(scene, Arc::new(mesh))?.assemble()?;
        refuse_floating(&assembled, "the constants of the theory")?;
        let contact = assembled
            .contact_state()
            .ok_or_else(|| singular("no contact"))?;
        let (surface, frame) = (contact.surface, &contact.interface.frame);
        let primal = &assembled.system().assembly.primal;
        let dofs = &primal.dofs;
        if surface.nodes.iter().any(|&n| dofs.held_at(n) != [0.0; 3]) {
            return Err(moved_face().into());
        }
        let gram = first_sobolev_gram(assembled.mesh(), dofs);
        // K has the pattern of A where materials couple all components, so the order of A's factor serves it.
        let assembly = &assembled.system().assembly;
        let order = assembly.factor.structure().permutation.clone();
        let structure = FactorStructure::analyse(&gram, order);
        let factor = structure
            .and_then(|structure| CholeskyFactor::of_structure(structure, &gram, &Work::default()));
        let factor = factor.map_err(|_| singular("H¹"))?;
        let Factor::Double(stiffness) = &*assembly.factor else {
            return Err(singular("single precision"));
        };
        let grams = [&factor, stiffness].map(|f| FaceGram::new(f, surface, frame, dofs));
        let face = TriangulatedFace::new(assembled.mesh(), surface, dofs);
        let forms = face.forms();
        let rows = PaneIntegrals::of_surface(surface);
        let pressure = |gram: &FaceGram| {
            let form = gram.normal_glued(&rows)?;
            let factor = DenseFactor::new(&form)?;
            Some((form, factor))
        };
        let [first, second] = grams.each_ref().map(pressure);
        let factors = factorised(&forms.mass).zip(first.zip(second));
        let (mass_factor, (first, second)) = factors.ok_or_else(|| singular("Q"))?;
        Ok(Self {
            local: LocalStiffness::new(dual_of(&assembled)),
            mass_factor,
            pressure: [first, second],
            compliance: grams[1].tangential_by_multipliers(&rows),
            face,
            forms,
            rows,
            grams,
            sobolev: (gram, factor),
            assembled,
        })
    }

    pub(super) fn system(&self) -> &DualSystem {
        self.assembled.system()
    }

    pub(super) fn contact(&self) -> ContactState<'_> {
        self.assembled
            .contact_state()
            .expect("checked when assembled")
    }

    pub(super) fn dual(&self) -> &ExplicitDual {
        dual_of(&self.assembled)
    }

    /// The sign of det R′ for the law of an interface.
    pub(super) fn determinant(&self, interface: &Interface, multiplier: &[f64]) -> i8 {
        Linearisation::new(self.dual(), &self.laws_of(interface), multiplier).determinant
    }

    /// The laws of the panes with another interface.
    pub(super) fn laws_of(&self, interface: &Interface) -> PaneLaws {
        let surface = self.surface();
        ContactState { surface, interface }.laws()
    }

    pub(super) fn into_sobolev_gram(self) -> (TriangulatedFace, FaceGram) {
        let [gram, _] = self.grams;
        (self.face, gram)
    }

    pub(super) fn law(&self) -> &CoulombLaw {
        self.contact()
            .interface
            .coulomb()
            .expect("checked before meshing")
    }

    pub(super) fn surface(&self) -> &ContactSurface {
        self.contact().surface
    }

    /// (u_t1, u_t2) at the contact nodes of a displacement of the free degrees of freedom.
    pub(super) fn tangential_of(&self, displacement: &[f64]) -> Vec<[f64; 2]> {
        let contact = self.contact();
        let dofs = &self.system().assembly.primal.dofs;
        let at_node = |node| dofs.at_node(node, displacement);
        let frame = &contact.interface.frame;
        frame.nodal_tangential(contact.surface, at_node)
    }

    /// The same of a multiplier.
    pub(super) fn tangential(&self, multiplier: &[f64]) -> Vec<[f64; 2]> {
        let system = self.system();
        let coupled = system.contact.as_ref().expect("checked when assembled");
        let mut work = Workspace::default();
        self.tangential_of(&coupled.displacement(&system.assembly, multiplier, &mut work))
    }
}

fn moved_face() -> InvalidValue {
    InvalidValue {
        key: "clamp".into(),
        expected: "contact nodes that are held at zero, or not at all".into(),
        found: "clamps with a value on contact nodes".into(),
        help: "traces that vanish where they are held are what HKL section 3 is about; hold other faces, or leave value out".into(),
    }
}

fn singular(form: &str) -> ProblemError {
    ProblemError::Invalid(InvalidValue {
        key: "contact".into(),
        expected: "forms of the contact face that have a factor, HKL (3.1)".into(),
        found: format!("a singular one ({form})"),
        help: "choose panes that are wider than the triangles, or nodal multipliers".into(),
    })
}
