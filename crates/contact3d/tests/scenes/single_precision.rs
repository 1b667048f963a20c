//! A factor in single precision gives the answers of one in double precision, or says that it cannot.

use std::{path::Path, sync::Arc};

use contact3d::{
    Problem, ProblemError,
    linalg::Precision,
    scene::{
        Body, Clamp, Coefficient, Contact, DualOperatorKind, FactorPrecision, Friction,
        InnerSolver, Material, Method, Scene, SolveSettings, Traction,
    },
    solver::{Solution, Status},
};

/// The published scene with 3 n × n × n cells.
fn published(n: usize) -> Scene {
    let falling = |rate| Coefficient::ramp(0.3, 0.2, 1e-5, rate);
    pulled(n).with_friction(Friction::orthotropic(falling(3000.0), falling(1000.0)))
}

/// The same without friction.
fn pulled(n: usize) -> Scene {
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [3 * n, n, n]),
        Material::isotropic(21.19e10, 0.277),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
    .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
    .with_contact(Contact::on("z_min"))
}

fn solved(mut scene: Scene, factor: FactorPrecision) -> Result<Solution, ProblemError> {
    scene.assemble.factor = factor;
    let settings = scene.solve.clone();
    let assembled = Problem::new(scene)?.assemble()?;
    let expected = match factor {
        FactorPrecision::Single => Precision::Single,
        FactorPrecision::Double | FactorPrecision::Auto => Precision::Double,
    };
    assert_eq!(assembled.system.assembly.factor.precision(), expected);
    assembled.solve(&settings)
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    norm(&mut x.iter().zip(y).map(|(x, y)| x - y)) / norm(&mut y.iter().copied())
}

/// Solves a scene with both factors: same status, multipliers and displacements within `tolerance`.
fn compare(scene: &Scene, tolerance: f64) {
    let double = solved(scene.clone(), FactorPrecision::Double).expect("double");
    let single = solved(scene.clone(), FactorPrecision::Single).expect("single");
    assert_eq!(single.status, double.status);
    for (name, single, double) in [
        ("multipliers", &single.multiplier, &double.multiplier),
        ("displacements", &single.displacement, &double.displacement),
    ] {
        let error = distance(single, double);
        assert!(error <= tolerance, "{name} differ by {error:e}");
    }
}

/// Both answers are solved to ε = 1e-12.
const SOLVED: f64 = 1e-11;

#[test]
fn newtons_method_finds_the_same_answers() {
    compare(&published(6), SOLVED);
    compare(&pulled(4), SOLVED);
    let constant = Friction::orthotropic(Coefficient::Constant(0.3), Coefficient::Constant(0.1));
    compare(&pulled(4).with_friction(constant), SOLVED);
}

#[test]
fn a_body_without_contact_is_solved_to_rounding() {
    let mut scene = pulled(4);
    scene.contacts.clear();
    let double = solved(scene.clone(), FactorPrecision::Double).expect("double");
    let single = solved(scene, FactorPrecision::Single).expect("single");
    // Both are refined with residuals in twice the working precision.
    assert!(distance(&single.displacement, &double.displacement) < 1e-14);
}

#[test]
fn successive_approximations_find_the_same_answers_with_either_operator() {
    for operator in [DualOperatorKind::Explicit, DualOperatorKind::Implicit] {
        let mut scene = published(4);
        scene.assemble.dual_operator = operator;
        scene.solve = SolveSettings {
            method: Method::FixedPoint,
            inner: InnerSolver::Gpcg,
            epsilon: Some(1e-9),
            ..SolveSettings::default()
        };
        // Both are within about ε of the solution, whose contraction per step is a third.
        compare(&scene, 1e-8);
    }
}

#[test]
fn what_single_precision_cannot_factorise_is_refused_or_left_to_double() {
    let mut scene = published(4);
    scene.material = Some(Material::isotropic(21.19e10, 0.499_999_9));
    let refused = solved(scene.clone(), FactorPrecision::Single);
    assert!(refused.is_err(), "a factor of a nearly incompressible body");
    let answer = solved(scene, FactorPrecision::Double).expect("double");
    assert!(answer.status.is_solved());
}

/// Whether the contractions measured on a scene are those of a good preconditioner.
fn served(mut scene: Scene, folder: &Path) -> Option<bool> {
    scene.assemble.factor = FactorPrecision::Single;
    scene.assemble.dual_operator = DualOperatorKind::Explicit;
    let problem = Problem::in_folder(scene, folder).expect("a problem");
    let assembled = problem.assemble().ok()?;
    Some(assembled.system.is_well_preconditioned())
}

#[test]
fn a_factor_that_serves_badly_is_seen() {
    let nowhere = Path::new("");
    assert_eq!(served(published(4), nowhere), Some(true));
    let mut slender = published(2);
    slender.bodies = vec![Body::brick([100.0, 1.0, 1.0], [200, 2, 2])];
    assert_ne!(served(slender, nowhere), Some(true));
    // The factor of another matrix, whose diagonal is half as large again in every second row.
    let mut scene = published(4);
    scene.assemble.factor = FactorPrecision::Single;
    let assembled = Problem::new(scene)
        .expect("a problem")
        .assemble()
        .expect("a factor");
    let mut system = assembled.system.clone();
    assert!(system.is_well_preconditioned());
    let stiffness = Arc::make_mut(&mut system.assembly.primal.stiffness);
    for j in (0..stiffness.cols).step_by(2) {
        let column = stiffness.indptr[j]..stiffness.indptr[j + 1];
        let diagonal = column.into_iter().find(|&k| stiffness.indices[k] == j);
        stiffness.data[diagonal.expect("a diagonal")] *= 1.5;
    }
    assert!(!system.is_well_preconditioned());
}

/// A slice of a nearly incompressible block in plane strain, its outer faces held, pressed on a roller.
fn slice(poisson: f64) -> Scene {
    let text = format!(
        "title = 'slice'\n[body]\nelement = 'P2'\n[body.brick]\nsize = [2.0, 0.05, 1.0]\ncells = [40, 1, 20]\n\
         [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = {poisson:?}\n\
         [[clamp]]\nface = 'y_min'\ncomponents = ['y']\n[[clamp]]\nface = 'y_max'\ncomponents = ['y']\n\
         [[clamp]]\nface = 'x_min'\ncomponents = ['x', 'z']\nvalue = [0.0, 0.0, -1e-4]\n[[clamp]]\nface = 'x_max'\ncomponents = ['x', 'z']\nvalue = [0.0, 0.0, -1e-4]\n\
         [[clamp]]\nface = 'z_max'\ncomponents = ['x', 'z']\nvalue = [0.0, 0.0, -1e-4]\n\
         [contact]\nface = 'z_min'\nmultipliers = 'nodal'\n\
         obstacle.cylinder = {{ point = [1.0, 0.0, -100.0], direction = [0.0, 1.0, 0.0], radius = 100.0 }}\n\
         [friction]\ncoefficient.constant = 0.5\n"
    );
    Scene::parse("slice", &text).expect("a scene")
}

/// S̃ is right to some percent for the slice, too, but in a motion that all nodes take part in, and one of them feels a
/// multiple of its own stress.
#[test]
fn errors_that_panes_feel_are_seen() {
    let nowhere = Path::new("");
    assert_eq!(served(slice(0.3), nowhere), Some(true));
    assert_eq!(served(slice(0.49999), nowhere), Some(false));
}

/// On `soft_block.toml` S without the correction of the motion as a whole is 16 % off.
#[test]
fn a_body_on_soft_springs_keeps_its_answer() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/hard"));
    let text = std::fs::read_to_string(folder.join("soft_block.toml")).expect("a scene");
    let scene = Scene::parse("soft_block.toml", &text).expect("a scene");
    let answer = |factor| {
        let mut scene = scene.clone();
        scene.assemble.factor = factor;
        let settings = scene.solve.clone();
        let problem = Problem::in_folder(scene, folder).expect("a problem");
        problem
            .assemble()
            .expect("a factor")
            .solve(&settings)
            .expect("solved")
    };
    let (single, double) = (
        answer(FactorPrecision::Single),
        answer(FactorPrecision::Double),
    );
    let error = distance(&single.multiplier, &double.multiplier);
    // Both say how far they are from the solution.
    assert!(
        single.status.is_solved() && error <= 10.0 * (single.accuracy + double.accuracy).max(1e-12),
        "{error:e}"
    );
}

/// A column far longer than its foot, of one pane: the foot hardly moves beside the body, so its displacement is wanted to
/// more digits than the next round of corrections would need.
#[test]
fn a_foot_that_hardly_moves_is_solved_to_rounding() {
    let mut scene = Scene::new(
        Body::brick([0.775, 0.503, 19.7], [2, 2, 28]),
        Material::isotropic(1.18e10, 0.359),
    )
    .with_clamp(Clamp::face("z_max"))
    .with_body_force([-95.12, 614.2, -36450.0])
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::orthotropic(0.457, 0.183));
    scene.assemble.dual_operator = DualOperatorKind::Explicit;
    let answer = |factor| solved(scene.clone(), factor).expect("an answer");
    let (single, double) = (
        answer(FactorPrecision::Single),
        answer(FactorPrecision::Double),
    );
    assert_eq!(single.status, Status::Converged);
    // Both are accurate to 1e-12 or better.
    assert!(distance(&single.multiplier, &double.multiplier) < 1e-11);
}
