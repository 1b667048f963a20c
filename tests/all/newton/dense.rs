//! A problem with its dense dual operator, and the friction laws to try.

use contact3d::{
    contact::{CoulombLaw, Interface},
    dual::{BodyOperator, ContactOperator, ExplicitDual, LocalStiffness},
    linalg::Work,
    scene::{Coefficient, Friction, Ramp, Scene},
    solver::{
        ContactSide, Inner, MethodResult, NewtonSettings, NewtonSolution, PaneLaws, Start,
        SuccessiveApproximations, evaluate_mapping, newton,
    },
};

use super::support::Implicit;

pub(crate) struct Dense {
    pub(crate) scene: Scene,
    pub(crate) problem: Implicit,
    pub(crate) dual: ExplicitDual,
    pub(crate) local: LocalStiffness,
}

impl Dense {
    pub(crate) fn new(scene: Scene) -> Self {
        let problem = Implicit::new(&scene);
        let (assembly, contact) = (problem.assembly(), problem.contact());
        let unconstrained = assembly.unconstrained();
        let ContactSide { surface, interface } = problem.state();
        let (coupling, rhs) = (&contact.coupling, contact.dual_rhs().to_vec());
        let dual = ExplicitDual::new(
            assembly,
            coupling,
            rhs,
            &unconstrained,
            (surface, interface),
            &Work::default(),
        );
        Self {
            scene,
            problem,
            local: LocalStiffness::new(&dual),
            dual,
        }
    }

    pub(crate) fn with_contact<T>(
        &self,
        law: &Friction,
        run: impl FnOnce(&PaneLaws, &CoulombLaw) -> T,
    ) -> T {
        let mut scene = self.scene.clone();
        scene.friction = Some(law.clone());
        let interface = Interface::new(&scene, self.problem.mesh());
        let interface = interface.expect("finite formulas").expect("contact");
        let surface = self.problem.surface();
        let interface = &interface;
        let laws = ContactSide { surface, interface }.laws();
        run(&laws, laws.coulomb().expect("Coulomb friction"))
    }

    /// The law of the scene.
    pub(crate) fn law(&self) -> Friction {
        self.scene.friction.clone().expect("friction")
    }

    pub(crate) fn solve(&self, law: &Friction) -> NewtonSolution {
        self.with_contact(law, |laws, law| {
            newton(
                &self.dual,
                laws,
                law,
                None,
                &NewtonSettings::default(),
                |_, _| {},
            )
        })
    }

    /// Algorithm 4.1 on the explicit operator with the settings of the scene.
    pub(crate) fn approximate(&self, inner: Inner<'_>) -> MethodResult {
        let (assembly, system) = (self.problem.assembly(), self.problem.contact());
        self.with_contact(&self.law(), |laws, law| {
            let mut operator = ContactOperator::explicit(&self.dual, assembly, system);
            let method = SuccessiveApproximations {
                inner,
                body: &self.problem.body(),
                laws,
                law,
                settings: &self.scene.solve,
            };
            let mut held = BodyOperator::Constrained(&mut operator);
            method.solve(&mut held, Start::default(), &mut |_| {})
        })
    }

    /// ‖Ψ(λ) − λ‖ / ‖λ‖.
    pub(crate) fn distance_to_image(&self, law: &Friction, multiplier: &[f64]) -> f64 {
        self.with_contact(law, |laws, law| {
            evaluate_mapping(&self.dual, &self.local, laws, law, multiplier).relative_change
        })
    }
}

pub(crate) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

pub(crate) fn distance(x: &[f64], y: &[f64]) -> f64 {
    let difference: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(y)
}

/// The same coefficient along both axes, each with its own slip.
pub(crate) fn isotropic(coefficient: Coefficient) -> Friction {
    orthotropic(coefficient.clone(), coefficient)
}

pub(crate) fn orthotropic(first: Coefficient, second: Coefficient) -> Friction {
    Friction {
        coefficient_1: Some(first),
        coefficient_2: Some(second),
        ..Friction::default()
    }
}

/// From `initial` to `residual` over `width` metres from `onset`.
pub(crate) fn ramp(initial: f64, residual: f64, onset: f64, width: f64) -> Coefficient {
    Coefficient::Ramp(Ramp {
        initial,
        residual,
        onset,
        rate: (initial - residual).abs() / width,
    })
}

pub(crate) fn hard_laws() -> Vec<(&'static str, Friction)> {
    use Coefficient::Constant;
    let mut laws: Vec<_> = [
        ("F = 1", Constant(1.0)),
        ("F = 3", Constant(3.0)),
        ("F = 10", Constant(10.0)),
        ("F = 1e6", Constant(1e6)),
        ("a fall within 1e-9 m", ramp(0.3, 0.2, 1e-5, 1e-9)),
        ("weakening 2 to 0.1", ramp(2.0, 0.1, 0.0, 1e-4)),
        ("weakening 5 to 0.01", ramp(5.0, 0.01, 0.0, 1e-5)),
        ("hardening 0.1 to 2", ramp(0.1, 2.0, 0.0, 1e-4)),
    ]
    .map(|(name, coefficient)| (name, isotropic(coefficient)))
    .into();
    laws.push((
        "F1 / F2 = 1e6",
        orthotropic(Constant(0.3), Constant(0.3e-6)),
    ));
    laws
}
