//! Scenes that put model features together, and what each of their answers must show.

use contact3d::scene::{DualOperatorKind, InnerSolver, Method, Scene};

use super::support::Case;

pub(super) const WEIGHT: &str = "[body_force]\nvalue = [0.0, 0.0, -8e6]";
pub(super) const PRESSED: &str = "[[pressure]]\nface = 'z_max'\nvalue = 1e7";
pub(super) const PUSHED: &str =
    "[[traction]]\nname = 'push'\nface = 'x_max'\nvalue = [-1.5e6, 3e5, 0.0]";
pub(super) const PULLED: &str =
    "[[traction]]\nname = 'push'\nface = 'y_max'\nvalue = [-1.5e6, 3e5, 0.0]";
pub(super) const PUSHED_ASIDE: &str =
    "[[traction]]\nname = 'push'\nface = 'y_max'\nvalue = [-5e5, -1.5e6, 0.0]";
pub(super) const HELD: &str = "[[clamp]]\nname = 'hold'\nface = 'x_max'";
pub(super) const MOVED: &str =
    "[[clamp]]\nname = 'hold'\nface = 'x_max'\nvalue = [-2e-6, 1e-6, 0.0]";
/// One component, so that contact holds the rest.
pub(super) const MOVED_ALONG: &str = "[[clamp]]\nname = 'hold'\nface = 'x_max'\ncomponents = ['x']\nvalue = ['1e-6 + 1e-6*y', 0.0, 0.0]";
pub(super) const SPRINGS: &str =
    "[[spring]]\nface = 'y_max'\nnormal = 2e11\ntangential = '1e11*(1 + x)'";

pub(super) const CONSTANT: &str = "coefficient.constant = 0.4";
/// Weakens over more than the slips of these scenes: steeper ramps have several solutions.
pub(super) const RAMP: &str =
    "coefficient.ramp = { initial = 0.5, residual = 0.3, onset = 1e-7, rate = 3e4 }";
pub(super) const TRESCA: &str = "slip_bound = 2e6";
pub(super) const ORTHOTROPIC: &str = "coefficient_2.ramp = { initial = 0.5, residual = 0.35, onset = 1e-7, rate = 3e4 }\ncoefficient_1.constant = 0.4";

/// Obstacles beneath the lower face: hollow, a ball, the bore of a cylinder.
pub(super) const HOLLOW: &str = "obstacle.height.value = '-2e-7*(1 - (2*x - 1)^2)'";
pub(super) const BALL: &str = "obstacle.sphere = { centre = [0.4, 0.5, -50.0], radius = 50.0 }";
pub(super) const BORE: &str = "gap = 5e-7\nobstacle.cylinder = { point = [0.5, 0.0, 3e5], direction = [0.0, 1.0, 0.0], radius = 3e5, side = 'inside' }";
/// A hollow wall behind x_min.
pub(super) const HOLLOW_WALL: &str =
    "obstacle.height = { value = '-2e-7*(1 - (2*y - 1)^2)', direction = 'x' }";

pub(super) const TO_AND_FRO: [&str; 3] = [
    "factor.push = 0.0",
    "factor.push = 1.0\nincrements = 2",
    "factor.push = -1.0\nincrements = 2",
];

pub(super) const MOVED_AND_BACK: [&str; 3] = [
    "factor.hold = 0.5",
    "factor.hold = 1.0\nincrements = 2",
    "factor.hold = -0.5\nincrements = 2",
];

/// A scene piece by piece.
#[derive(Clone, Default)]
pub(super) struct Pieces(String);

impl Pieces {
    pub(super) fn new(parts: &[&str]) -> Self {
        Self(parts.join("\n"))
    }

    /// Contact of z_min alone.
    pub(super) fn floor(self, multipliers: &str, more: &str, law: &str) -> Self {
        let contact = format!("[contact]\nface = 'z_min'\nmultipliers = '{multipliers}'\n{more}");
        Self([&self.0, &contact, "[friction]", law].join("\n"))
    }

    /// Contact of z_min and of another face, each with its obstacle or gap and its law; an empty one is none.
    pub(super) fn faces(
        self,
        multipliers: &str,
        wall: &str,
        more: [&str; 2],
        laws: [&str; 2],
    ) -> Self {
        let spaces = [multipliers, "panes"];
        let mut text = self.0;
        for (i, (face, name)) in [("z_min", "floor"), (wall, "wall")].into_iter().enumerate() {
            text += &format!(
                "\n[[contact]]\nface = '{face}'\nname = '{name}'\nmultipliers = '{}'\n{}\n",
                spaces[i], more[i]
            );
            let lines = laws[i].lines().map(|line| format!("friction.{line}\n"));
            text.extend(lines);
        }
        Self(text)
    }

    pub(super) fn steps(self, steps: &[&str]) -> Self {
        let steps = steps.iter().map(|step| format!("\n[[step]]\n{step}"));
        Self(steps.fold(self.0, |text, step| text + &step))
    }

    pub(super) fn scene(&self, element: &str) -> Scene {
        let cells = match element {
            "P1" => "[4, 4, 4]",
            _ => "[2, 2, 2]",
        };
        let text = format!(
            "title = 'combined'
            [body]
            element = '{element}'
            [body.brick]
            size = [1.0, 1.0, 0.5]
            cells = {cells}
            [material.isotropic]
            young_modulus = 2e11
            poisson_ratio = 0.3
            {}",
            self.0
        );
        Scene::parse("combined", &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}

/// Methods and forms of S that must agree.
pub(super) const METHODS: [(DualOperatorKind, Method, InnerSolver); 3] = [
    (
        DualOperatorKind::Explicit,
        Method::Newton,
        InnerSolver::Kprgp,
    ),
    (
        DualOperatorKind::Explicit,
        Method::FixedPoint,
        InnerSolver::Kprgp,
    ),
    (DualOperatorKind::Implicit, Method::Auto, InnerSolver::Gpcg),
];

/// Solves a scene by all methods and checks each answer by itself and against Newton's.
pub(super) fn check(name: &str, pieces: &Pieces, element: &str) -> Case {
    let mut newton: Option<Case> = None;
    for (operator, method, inner) in METHODS {
        let mut scene = pieces.scene(element);
        scene.assemble.dual_operator = operator;
        scene.solve.method = method;
        scene.solve.inner = inner;
        if method != Method::Newton {
            scene.solve.epsilon = Some(1e-10);
        }
        let name = format!("{name} {element} {operator:?} {method:?}");
        let case = Case::new(scene);
        assert!(
            case.solution.status.is_solved(),
            "{name}: {:?}",
            case.solution.status
        );
        assert_consistent(&name, &case, method);
        match &newton {
            None => newton = Some(case),
            Some(newton) => {
                let found = distance(&case.solution.multiplier, &newton.solution.multiplier);
                // Successive approximations stop at changes of 1e-10 and contract by a half or better; an increment of a history
                // adds the error of the one before.
                assert!(found < 1e-7, "{name}: {found:e}");
            }
        }
    }
    newton.expect("the first method is Newton's")
}

/// Certificate, forces and moments of one answer.
fn assert_consistent(name: &str, case: &Case, method: Method) {
    let report = case.report();
    let worst = report.certificate.worst();
    // Newton's method goes to rounding; the others to 1e-10 of the multipliers, of which slips that are small beside the
    // compliance of a pane are a larger share.
    let allowed = if method == Method::Newton { 1e-8 } else { 1e-6 };
    assert!(worst < allowed, "{name}: {:?}", report.certificate);
    for (what, vectors) in [
        (
            "forces",
            report.forces.iter().map(|f| f.force).collect::<Vec<_>>(),
        ),
        ("moments", report.forces.iter().map(|f| f.moment).collect()),
    ] {
        let largest = vectors
            .iter()
            .flatten()
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        for c in 0..3 {
            let sum: f64 = vectors.iter().map(|v| v[c]).sum();
            // Sums of some hundred forces; first-order methods balance a body that floats as accurately as they minimise.
            let allowed = if method == Method::Newton {
                1e-10
            } else {
                1e-8
            };
            assert!(
                sum.abs() < allowed * largest,
                "{name}: {what} {sum:e} of {largest:e}"
            );
        }
    }
}

/// ‖a − b‖ / ‖b‖.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let size: f64 = b.iter().map(|b| b * b).sum();
    (difference / size).sqrt()
}

/// In both spaces of multipliers and both elements.
pub(super) fn check_all(name: &str, pieces: impl Fn(&str) -> Pieces) {
    for (multipliers, element) in [
        ("panes", "P1"),
        ("nodal", "P1"),
        ("panes", "P2"),
        ("nodal", "P2"),
    ] {
        let name = format!("{name} {multipliers}");
        check(&name, &pieces(multipliers), element);
    }
}
