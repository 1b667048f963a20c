//! What a solution means: contact zones, stresses, resultants, and a certificate.

mod areas;
mod certificate;
mod checks;
mod concentration;
mod estimate;
mod functional;
mod patch;
mod peak;
mod recovery;
mod resultants;
mod rounding;
mod stress;
mod tools;
mod zones;

pub use crate::solver::Zone;
pub use certificate::Certificate;
pub use checks::CheckFailure;
pub use concentration::StressConcentration;
pub use estimate::{ContactError, ErrorEstimate, LoadedBoundary, MAX_RELIABLE_ESTIMATE};
pub use functional::FunctionalEstimate;
pub(crate) use recovery::StressRecovery;
pub use resultants::{ContactResultants, FaceResultants, Resultants, SourceForce, von_mises};
pub use rounding::Rounding;
pub use stress::LargestStress;
pub use tools::ToolState;
pub use zones::{PaneCoulomb, PaneFriction, PaneState};

use concentration::Concentrations;
use nalgebra::{Matrix3, Vector3};
use resultants::NodalForces;

use crate::{
    contact::{CoulombLaw, Coupling, FrictionField},
    dual::{PrimalSystem, pane_stiffness},
    elasticity::{InternalForces, MaterialField},
    linalg::FEW_ROUNDINGS,
    mesh::{GEOMETRY_TOLERANCE, Mesh},
    scene::{Functional, InvalidValue, Scene},
    solver::{Adjoint, ContactSide, CoulombState, FrictionState, LinearFunctional, Solution},
};

/// A solved problem, as post-processing needs it: no factor, no dual operator.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// A and l.
    pub system: &'a PrimalSystem,
    /// B and the laws of the contact face; `None` without contact.
    pub contact: Option<SolvedContact<'a>>,
    /// λ, u and the friction they were found with.
    pub solution: &'a Solution,
}

impl Solved<'_> {
    /// Depth in m to which a face may lie in its obstacle by the digits of a mesh file, or by what distances before an increment leave of
    /// those after it; by rounding of places for bricks.
    fn touching_depth(&self) -> f64 {
        let share = match self.scene.as_brick() {
            Some(_) if !self.scene.follows_tools() => FEW_ROUNDINGS * f64::EPSILON,
            _ => GEOMETRY_TOLERANCE,
        };
        share * self.mesh.extent()
    }

    /// The friction that a solution itself makes; `None` without Coulomb's law.
    pub(crate) fn friction(&self) -> Option<FrictionState> {
        let contact = self.contact?;
        let (law, friction) = contact.friction(self)?;
        let normal = &self.solution.multiplier[..contact.coupling.layout.n_panes()];
        let slip_bound = law.slip_bounds(normal);
        Some(FrictionState {
            coulomb: CoulombState {
                slip_bound,
                friction,
            },
            ..FrictionState::default()
        })
    }
}

/// The contact part of a solved problem.
#[derive(Debug, Clone, Copy)]
pub struct SolvedContact<'a> {
    /// B.
    pub coupling: &'a Coupling,
    /// Γ_c and its laws.
    pub state: ContactSide<'a>,
}

impl SolvedContact<'_> {
    /// The contact nodes of a contact triangle: its corners, then those between them.
    #[must_use]
    pub fn nodes_of(&self, mesh: &Mesh, place: usize) -> Vec<usize> {
        let surface = self.state.surface;
        let nodes = mesh.facet_nodes(surface.facets[place]);
        nodes
            .map(|node| surface.contact_nodes(place, [node])[0])
            .collect()
    }

    /// The stiffness that residuals are measured by; that of single nodes where the solve kept none.
    fn local_stiffness(&self, solved: &Solved<'_>) -> Vec<f64> {
        let known = &solved.solution.trace.local_stiffness;
        if known.len() == solved.solution.multiplier.len() {
            known.clone()
        } else {
            pane_stiffness(solved.system, self.coupling)
        }
    }

    /// The law and F at the slip of a solution; `None` without Coulomb's law.
    fn friction(&self, solved: &Solved<'_>) -> Option<(&CoulombLaw, FrictionField)> {
        let law = self.state.interface.coulomb()?;
        let slip = if law.depends_on_slip() {
            let interface = self.state.interface;
            interface.slip_of_displacement(
                self.state.surface,
                &solved.system.dofs,
                &solved.solution.displacement,
            )
        } else {
            Vec::new()
        };
        Some((
            law,
            FrictionField::new(law, &self.state.surface.pane_average, &slip),
        ))
    }
}

/// Everything the post stage reports.
#[derive(Debug, Clone)]
pub struct ContactReport {
    /// State of each pane, `[n_panes]`; empty without contact.
    pub panes: Vec<PaneState>,
    /// (F₁, F₂) at the contact nodes of faces with friction for the slip of the solution; `None` without Coulomb's law.
    pub friction: Option<FrictionField>,
    /// Nodal displacement, `[n_nodes]`, in m.
    pub displacement: Vec<[f64; 3]>,
    /// Forces of the clamps on the nodes, `[n_nodes]`, in N.
    pub reaction: Vec<[f64; 3]>,
    /// Voigt stress (xx, yy, zz, yz, xz, xy) at the centroid of each tetrahedron in Pa.
    pub stress: Vec<[f64; 6]>,
    /// Voigt stress at the nodes of each material in Pa, `[n_material_nodes]` in the order of [`MaterialNodes`](crate::mesh::MaterialNodes).
    pub nodal_stress: Vec<[f64; 6]>,
    /// Von Mises stress of these in Pa, `[n_material_nodes]`.
    pub von_mises: Vec<f64>,
    /// The largest von Mises stress; zero where no errors are estimated.
    pub largest_von_mises: LargestStress,
    /// Forces on the body, one row for each clamp, spring, load and contact face.
    pub forces: Vec<SourceForce>,
    /// Forces, moments and energies of the whole body.
    pub resultants: Resultants,
    /// The rigid tools, `[n_tools]`.
    pub tools: Vec<ToolState>,
    /// What happens on each of several contact faces, in the order of their multipliers; empty for one.
    pub faces: Vec<FaceResultants>,
    /// How well the discrete problem is satisfied.
    pub certificate: Certificate,
    /// The estimated distance of the discrete solution from the body it models.
    pub discretisation_error: ErrorEstimate,
    /// Quantities of the answer with their errors; empty where no dense dual problem was at hand, in a load history, where nothing
    /// is deformed, and where the estimated error is more than half of the answer.
    pub functionals: Vec<FunctionalEstimate>,
    /// The first check that fails, which takes back the claim of the solve; [`Self::classify`] acts on it.
    pub failed_check: Option<CheckFailure>,
}

/// Which errors are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EstimatedErrors {
    /// None.
    Nothing,
    /// That of the displacement in the energy norm.
    Energy,
    /// That and those of quantities.
    Quantities,
}

impl ContactReport {
    /// Evaluates a solved problem, with the error of its displacement in the energy norm and the quantities that are stored of it.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn new(solved: &Solved<'_>, stored: Vec<FunctionalEstimate>) -> Result<Self, InvalidValue> {
        let recovery = StressRecovery::new(solved.mesh);
        Self::with(
            solved,
            &recovery,
            EstimatedErrors::Energy,
            &|_| None,
            stored,
        )
    }

    /// As [`Self::new`], with the errors of quantities of the solution by their `adjoints`, or without the cost of any estimate.
    ///
    /// # Errors
    /// A load that is not finite.
    pub(crate) fn with(
        solved: &Solved<'_>,
        recovery: &StressRecovery,
        errors: EstimatedErrors,
        adjoints: &dyn Fn(&[LinearFunctional]) -> Option<Vec<Adjoint>>,
        stored: Vec<FunctionalEstimate>,
    ) -> Result<Self, InvalidValue> {
        let friction = solved.contact.as_ref();
        let friction = friction.and_then(|contact| contact.friction(solved));
        let stiffness = solved
            .contact
            .map_or_else(Vec::new, |contact| contact.local_stiffness(solved));
        let panes = solved.contact.map_or_else(Vec::new, |contact| {
            let friction = friction.as_ref().map(|(law, field)| (*law, field));
            zones::pane_states(solved, &contact, friction, &stiffness)
        });
        let displacement = solved.system.dofs.to_nodes(&solved.solution.displacement);
        let material = MaterialField::new(solved.scene, solved.mesh);
        let internal = InternalForces::of(solved.mesh, &material, &displacement);
        let nodal_stress = recovery.nodal_stress(solved.mesh, &internal);
        let forces = NodalForces::new(solved, &displacement, &internal.forces)?;
        let terms = rounding::terms(solved);
        let resultants = Resultants::new(solved, &terms, &displacement, &forces, &internal.forces);
        let rounding_energy = rounding::of_energy(solved, &terms, &displacement, &forces);
        let von_mises: Vec<f64> = nodal_stress.iter().map(von_mises).collect();
        let highest = von_mises.iter().copied().fold(0.0, f64::max);
        let motion = (&displacement[..], &forces.clamp[..]);
        let concentrations = (errors != EstimatedErrors::Nothing)
            .then(|| Concentrations::new(solved, &recovery.nodes, &panes, motion, highest));
        let tools = solved.system.dofs.tool_rows(&solved.solution.displacement);
        let known = concentrations
            .as_ref()
            .map(|concentrations| estimate::SolutionData {
                displacement: &displacement,
                concentrations,
                tools: &tools,
                internal: &internal,
                nodal_stress: &nodal_stress,
                recovery,
                panes: &panes,
                stiffness: &stiffness,
                strain_energy: resultants.strain_energy,
                rounding: rounding_energy,
            });
        let (discretisation_error, mut functionals) = match &known {
            None => Default::default(),
            Some(known) if errors == EstimatedErrors::Energy => {
                (ErrorEstimate::new(solved, known), stored)
            }
            Some(known) => functional::estimates(adjoints, solved, known, &resultants),
        };
        let mut report = Self {
            largest_von_mises: match &known {
                None => LargestStress::default(),
                Some(known) => {
                    let mut found = functionals.iter().cloned();
                    let peak = found.find(|it| it.functional == Functional::LargestPressure);
                    let peak = peak.or_else(|| {
                        let stiffness = areas::half_space_stiffness(solved);
                        peak::largest_pressure(solved, known, &stiffness, 0.0)
                    });
                    let mut largest = LargestStress::new(solved, known, &von_mises, peak.as_ref());
                    // Contact may be elsewhere.
                    let is_guess = discretisation_error.is_unreliable() && solved.contact.is_some();
                    // By symmetry neighbours may be wrong together; stresses on the whole are off by this share.
                    let of_body = discretisation_error.relative() * largest.value;
                    largest.error = match is_guess {
                        true => f64::INFINITY,
                        false => largest.error.max(of_body),
                    };
                    let wanted = solved.scene.adapt.and_then(|adapt| adapt.of);
                    let is_known = |it: &FunctionalEstimate| Some(it.functional) == wanted;
                    if wanted == Some(Functional::LargestVonMises)
                        && !functionals.iter().any(is_known)
                    {
                        functionals.push(largest.quantity(solved.mesh, &discretisation_error));
                    }
                    largest
                }
            },
            discretisation_error,
            functionals,
            forces: resultants::by_source(solved, &displacement, &forces)?,
            resultants,
            tools: ToolState::of(solved, &forces),
            faces: FaceResultants::of_faces(solved, &panes, &forces),
            certificate: Certificate::new(solved, &terms, &panes, &stiffness),
            von_mises,
            nodal_stress,
            stress: internal.stress,
            panes,
            friction: friction.map(|(_, field)| field),
            displacement,
            reaction: forces.clamp,
            failed_check: None,
        };
        if report.discretisation_error.is_unreliable() {
            report.functionals.clear();
        }
        let rounding = Rounding::new(solved, &terms, &report.panes, &stiffness, &[]);
        report.failed_check = report.first_failed_check(solved, &rounding, rounding_energy);
        Ok(report)
    }

    /// The estimated relative error of a quantity of the answer, of the displacement in the energy norm where none is named; `None` of
    /// a quantity that the answer does not have. An answer with an error of half of itself has no quantities yet: that error is theirs.
    #[must_use]
    pub fn relative_error(&self, of: Option<Functional>) -> Option<f64> {
        let error = &self.discretisation_error;
        match of.filter(|_| !error.is_unreliable()) {
            None => Some(error.relative()),
            Some(of) => self.functional(of).map(|it| self.relative_error_of(it)),
        }
    }

    /// The error bar of a quantity over its value; not below one for an area on so few panes that it is not told.
    pub(crate) fn relative_error_of(&self, quantity: &FunctionalEstimate) -> f64 {
        if quantity.functional.is_area() && self.has_few_panes() {
            quantity.relative().max(1.0)
        } else {
            quantity.relative()
        }
    }

    /// Whether the contact face has too few panes to tell an area of contact or stick: with 8, ranges missed the truth.
    #[must_use]
    pub fn has_few_panes(&self) -> bool {
        self.panes.len() < areas::FEWEST_PANES
    }

    /// The value of a quantity; `None` where the answer does not have it, and of means and areas without their error.
    #[must_use]
    pub fn value(&self, of: Functional) -> Option<f64> {
        let contact = self.resultants.contact.as_ref();
        match of {
            Functional::NormalForce => Some(contact?.normal_force),
            Functional::TangentialForce => contact?.tangential_force.map(|[a, b]| a.hypot(b)),
            Functional::LargestPressure => Some(contact?.largest_pressure),
            Functional::LargestVonMises => Some(self.largest_von_mises.value),
            Functional::StrainEnergy => Some(self.resultants.strain_energy),
            _ => {
                let mut all = self.functionals.iter();
                all.find(|it| it.functional == of).map(|it| it.value)
            }
        }
    }

    /// A quantity of the answer with its error; `None` where it is absent or zero.
    #[must_use]
    pub fn functional(&self, functional: Functional) -> Option<&FunctionalEstimate> {
        let mut all = self.functionals.iter();
        all.find(|it| it.functional == functional && it.value != 0.0)
    }

    /// Where the largest pressure or stress grows with every finer mesh; `None` where nothing tells so, and of other quantities.
    #[must_use]
    pub fn concentration(&self, of: Functional) -> Option<StressConcentration> {
        match of {
            Functional::LargestVonMises => self.largest_von_mises.concentration,
            Functional::LargestPressure => {
                let grows = self.functional(of)?.error_bar().is_infinite();
                grows.then_some(StressConcentration::Contact)
            }
            _ => None,
        }
    }

    /// The largest principal strain of a tetrahedron, by its corners.
    #[must_use]
    pub fn largest_strain(&self, mesh: &Mesh) -> f64 {
        let of_tetrahedron = |corners: &[usize; 4]| {
            let edges = |field: &[[f64; 3]]| {
                let at = |k: usize| Vector3::from(field[corners[k]]);
                Matrix3::from_columns(&[at(1) - at(0), at(2) - at(0), at(3) - at(0)])
            };
            let inverse = edges(&mesh.coordinates).try_inverse()?;
            let gradient = edges(&self.displacement) * inverse;
            Some(gradient.symmetric_part().symmetric_eigenvalues().amax())
        };
        largest(mesh.tetrahedra.iter().filter_map(of_tetrahedron))
    }

    /// Number of panes in a zone.
    #[must_use]
    pub fn count(&self, zone: Zone) -> usize {
        self.panes.iter().filter(|pane| pane.zone == zone).count()
    }
}

/// max |v|; NaN if any is.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, v| {
        let v = v.abs();
        if v > most || v.is_nan() { v } else { most }
    })
}
