//! Methods that stop by their own rule: Algorithm 4.1 and single minimisations by KPRGP or GPCG.
//!
//! Their rule measures a gradient; the error of λ is measured afterwards. While it is larger than promised, the method goes on from
//! where it stopped, with a smaller ε, or where S has single precision with the h that refined residuals correct.

use super::{
    Inner, MethodResult, NeedsExplicit, Progress, Solution, Start, Status, assessment::Assessment,
    conditions::Bound, newton::NewtonDriver, problem::ContactSolve,
};
use crate::{
    dual::{
        ContactSystem, ExplicitDual, LocalStiffness, OperatorForm, SMALL_MEMORY,
        friction_stiffness, pane_stiffness,
    },
    linalg::{FEW_ROUNDINGS, Precision, Work},
    scene::SolveSettings,
};

/// Most repetitions of a method whose error is larger than promised: each asks for a digit more, or corrects what single precision left.
const MAX_REPETITIONS: usize = 4;

/// Applications of S by products for each multiplier after which S is formed: forming takes no more than one each, and reads the factor
/// once for a block of columns, not for each.
const APPLICATIONS_BEFORE_DENSE: usize = 50;

/// Matrices of the size of S that Newton's and the interior point method hold at a time.
const DENSE_MATRICES: usize = 4;

impl ContactSolve<'_> {
    /// By the method and the inner solver that the settings name.
    pub(super) fn by_given_method(
        &self,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        let local = self.dual.explicit().map(LocalStiffness::new);
        let driver = self.dual.explicit().zip(local.as_ref());
        let driver = driver.map(|(dual, local)| NewtonDriver::new(dual, local, bound, None));
        let stiffness = match &local {
            Some(local) => local.stiffness.clone(),
            None => self.pane_stiffness(),
        };
        let once = |solve: &ContactSolve<'_>, observe: &mut dyn FnMut(Progress<'_>)| {
            let explicit = solve.dual.explicit().zip(local.as_ref());
            let inner = Inner::chosen(self.settings.inner, explicit, &stiffness)?;
            let found = solve.by_inner(inner, observe);
            Ok(self.measured(driver.as_ref(), bound, &stiffness, found))
        };
        let mut solution = once(self, observe)?;
        let is_single = self.body.precision() == Precision::Single;
        let Some(driver) = driver.as_ref().filter(|_| is_single) else {
            return Ok(solution);
        };
        for _ in 0..MAX_REPETITIONS {
            // With S in single precision a method can reach what rounding in double makes of S λ.
            let is_accurate = match solution.status {
                Status::ReducedAccuracy | Status::Inaccurate => false,
                Status::MachinePrecision => {
                    solution.accuracy <= FEW_ROUNDINGS * driver.dual.rounding()
                }
                _ => true,
            };
            if is_accurate {
                break;
            }
            let unknowns = self.unknowns(&solution);
            let here = self.about(driver, &unknowns, None, f64::EPSILON);
            let corrected = ContactSystem {
                coupling: self.dual.coupling.clone(),
                unconstrained: Vec::new(),
                form: OperatorForm::Explicit(here.dual.absolute()),
            };
            let again = ContactSolve {
                dual: &corrected,
                start: Start::at(&solution.multiplier),
                ..*self
            };
            let next = once(&again, observe)?;
            let falls = next.accuracy <= 0.5 * solution.accuracy;
            solution = next.or_nearer(solution);
            if !falls {
                break;
            }
        }
        Ok(solution)
    }

    /// By products of S, Coulomb's law by Algorithm 4.1 with GPCG inside, convex problems by GPCG alone: each run with no more than so many,
    /// repeated with a smaller ε while its error is larger than asked.
    pub(super) fn by_gradients(
        &self,
        bound: Bound<'_>,
        most_products: usize,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let stiffness = self.pane_stiffness();
        let mut once = |settings: &SolveSettings, start: Start<'_>| {
            let solve = ContactSolve {
                settings,
                start,
                ..*self
            };
            let found = solve.by_inner(Inner::Gpcg(&stiffness), observe);
            self.measured(None, bound, &stiffness, found)
        };
        let mut settings = self.settings.clone();
        settings.max_operator_applications = settings.max_operator_applications.min(most_products);
        let mut solution = once(&settings, self.start);
        for _ in 0..MAX_REPETITIONS {
            if !matches!(
                solution.status,
                Status::ReducedAccuracy | Status::Inaccurate
            ) {
                break;
            }
            let too_large = solution.accuracy / self.settings.epsilon();
            settings.epsilon = Some(settings.epsilon() / too_large.max(10.0));
            let next = once(&settings, Start::at(&solution.multiplier));
            solution = next.or_nearer(solution);
        }
        solution
    }

    /// Products with S that forming it is worth, if dense matrices fit beside the factor.
    pub(super) fn products_before_dense(&self) -> Option<usize> {
        let n = self.dual.layout().n_multipliers();
        let in_factor = self.body.assembly.factor.structure().value_count();
        let bytes = |numbers: usize| (numbers * size_of::<f64>()) as f64;
        let fits = bytes(DENSE_MATRICES * n * n) <= bytes(in_factor).max(SMALL_MEMORY);
        fits.then_some(APPLICATIONS_BEFORE_DENSE * n)
    }

    /// S of a convex problem, formed where the assembly has none.
    pub(super) fn dense(&self) -> ExplicitDual {
        let (coupling, rhs) = (&self.dual.coupling, self.dual.dual_rhs().to_vec());
        let (assembly, face) = (self.body.assembly, self.body.face);
        let face = (face.surface, face.interface);
        // No law of a convex problem follows the slip, so nothing asks for that of A⁻¹l.
        let mut dual = ExplicitDual::new(assembly, coupling, rhs, &[], face, &Work::default());
        dual.rigid = self.dual.rigid().cloned();
        dual
    }

    /// Local stiffness where S is not dense.
    pub(super) fn pane_stiffness(&self) -> Vec<f64> {
        let mut stiffness = pane_stiffness(&self.body.assembly.primal, &self.dual.coupling);
        friction_stiffness(&mut stiffness, self.dual.layout(), self.dual.dual_rhs());
        stiffness
    }

    /// What a method found by its own rule, with its measured error and the status that follows.
    fn measured(
        &self,
        driver: Option<&NewtonDriver<'_>>,
        bound: Bound<'_>,
        local_stiffness: &[f64],
        found: MethodResult,
    ) -> Solution {
        let unknowns = self.unknowns(&found.solution);
        let error = match driver {
            _ if !found.stop.is_solution() => f64::NAN,
            Some(driver) => self.error_of(driver, &unknowns),
            None => self.error_by_products(bound, &unknowns, local_stiffness),
        };
        let assessment = Assessment::of_method(&found, error, self.settings.epsilon());
        let mut solution = found.solution;
        solution.trace.local_stiffness = local_stiffness.to_vec();
        solution.assess(assessment);
        solution
    }
}
