//! Newton's method by products with an implicit S gives the answers of the one on a dense S.

use contact3d::{
    Problem,
    scene::{
        Body, Clamp, Coefficient, Contact, DualOperatorKind, ElementOrder, Friction, Material,
        Scene, Traction,
    },
    solver::{Solution, SolvedBy},
};

fn solved(friction: &Friction, kind: DualOperatorKind) -> Solution {
    solved_on(Body::brick([3.0, 1.0, 1.0], [24, 8, 8]), friction, kind)
}

fn solved_on(body: Body, friction: &Friction, kind: DualOperatorKind) -> Solution {
    let mut scene = Scene::new(body, Material::isotropic(21.19e10, 0.277))
        .with_clamp(Clamp::face("x_min"))
        .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
        .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
        .with_contact(Contact::on("z_min"))
        .with_friction(friction.clone());
    scene.assemble.dual_operator = kind;
    let settings = scene.solve.clone();
    let assembled = Problem::new(scene).unwrap().assemble().unwrap();
    assembled.solve(&settings).unwrap()
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let difference = square(&mut x.iter().zip(y).map(|(x, y)| x - y));
    (difference / square(&mut y.iter().copied())).sqrt()
}

#[test]
fn it_agrees_with_the_dense_operator_whether_or_not_friction_follows_the_slip() {
    let falling = |rate| Coefficient::ramp(0.3, 0.2, 1e-5, rate);
    let constant = Coefficient::Constant;
    for friction in [
        Friction::orthotropic(falling(3000.0), falling(1000.0)),
        Friction::orthotropic(constant(0.3), constant(0.1)),
    ] {
        let dense = solved(&friction, DualOperatorKind::Explicit);
        let products = solved(&friction, DualOperatorKind::Implicit);
        assert_eq!(products.trace.solved_by, SolvedBy::Newton);
        assert!(products.status.is_solved() && products.trace.history.is_empty());
        // Both are solved to ε = 1e-12; one digit is left for the norms in which errors are measured.
        assert!(distance(&products.multiplier, &dense.multiplier) < 1e-11);
        assert!(distance(&products.displacement, &dense.displacement) < 1e-11);
    }
}

/// With more than 1,500 multipliers, so that it starts from a coarser mesh: a block, and a plate that bends far more than its panes
/// yield.
#[test]
fn it_agrees_with_the_dense_operator_from_the_answer_on_a_coarser_mesh() {
    for height in [1.0, 0.2] {
        let mut body = Body::brick([3.0, 1.0, height], [39, 13, 2]);
        body.element = ElementOrder::P2;
        let friction = Friction::coulomb(0.3);
        let dense = solved_on(body.clone(), &friction, DualOperatorKind::Explicit);
        let products = solved_on(body, &friction, DualOperatorKind::Implicit);
        assert_eq!(products.trace.solved_by, SolvedBy::Newton);
        assert!(products.status.is_solved() && products.trace.history.is_empty());
        // The plate's S has 100 times the condition of the block's, and errors are measured by local stiffness.
        let apart = distance(&products.multiplier, &dense.multiplier);
        assert!(apart < 1e-9, "{height} m: {apart:e}");
    }
}
