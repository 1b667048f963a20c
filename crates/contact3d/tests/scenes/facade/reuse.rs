//! Other loads and laws on one factor.

use contact3d::{
    ProblemError,
    scene::{Clamp, Coefficient, Friction, Quantity, SolveSettings},
    solver::Start,
};

use super::{assembled, block, solved};

fn ramp() -> Coefficient {
    Coefficient::ramp(0.3, 0.2, 1e-5, 3000.0)
}

#[test]
fn a_changed_problem_has_the_bits_of_its_own_assembly() {
    let base = assembled(block(Friction::coulomb(ramp())));
    type Change = fn(&mut contact3d::scene::Scene);
    let changes: [Change; 5] = [
        |scene| scene.pressures[0].value = 1e7.into(),
        |scene| {
            scene.body_force = Some(contact3d::scene::BodyForce {
                value: [0.0, 0.0, -1e6].map(Into::into),
            })
        },
        |scene| scene.contacts[0].gap = Quantity::formula("1e-6*x").expect("a formula"),
        |scene| scene.friction = Some(Friction::orthotropic(0.3, 0.2)),
        |scene| scene.friction = Some(Friction::tresca(2e6)),
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let shared = base.with_changes(change).expect("the same operator");
        let own = assembled(shared.scene().clone());
        let [shared_answer, own_answer] = [&shared, &own].map(solved);
        assert_eq!(
            shared_answer.multiplier, own_answer.multiplier,
            "change {number}"
        );
        assert_eq!(
            shared_answer.displacement, own_answer.displacement,
            "change {number}"
        );
        let [first, second] = [(&shared, &shared_answer), (&own, &own_answer)]
            .map(|(problem, answer)| problem.report(answer).expect("finite loads"));
        assert_eq!(first.panes, second.panes, "change {number}");
    }
}

#[test]
fn what_needs_its_own_assembly_is_refused_by_its_key() {
    let base = assembled(block(Friction::coulomb(0.3)));
    let refused = |change: &dyn Fn(&mut contact3d::scene::Scene)| match base.with_changes(change) {
        Err(ProblemError::OtherOperator { key }) => key,
        Err(ProblemError::Invalid(invalid)) => invalid.key,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("another operator was not noticed"),
    };
    assert_eq!(
        refused(&|scene| scene
            .clamps
            .push(Clamp::face("x_max").along(&[contact3d::scene::Component::Y]))),
        "clamp"
    );
    assert_eq!(
        refused(&|scene| scene.material = Some(contact3d::scene::Material::isotropic(1e11, 0.3))),
        "material"
    );
    assert_eq!(
        refused(
            &|scene| scene.bodies = vec![contact3d::scene::Body::brick([3.0, 1.0, 1.0], [6, 2, 2])]
        ),
        "body"
    );
    assert_eq!(
        refused(&|scene| scene.contacts[0].angle = Some(10.0.into())),
        "contact"
    );
    assert_eq!(refused(&|scene| scene.friction = None), "friction");
    // The dense operator was formed without the compliance that such a law asks for.
    assert_eq!(
        refused(&|scene| scene.friction = Some(Friction::coulomb(ramp()))),
        "friction"
    );
    assert_eq!(
        refused(&|scene| scene.pressures[0].value = f64::NAN.into()),
        "pressure.0.value"
    );
}

#[test]
fn solves_of_one_assembly_count_apart() {
    let problem = assembled(block(Friction::coulomb(ramp())));
    let [first, second] = [(); 2].map(|()| solved(&problem));
    assert!(first.trace.law_evaluations > 0);
    assert_eq!(
        (first.trace.law_evaluations, first.trace.applications),
        (second.trace.law_evaluations, second.trace.applications)
    );
    let start = Start {
        multiplier: Some(&first.multiplier),
        checkpoint: None,
    };
    let settings = SolveSettings::default();
    let warm = problem.solve_from(&settings, start, &mut |_| {});
    let warm = warm.expect("S is dense");
    assert!(warm.trace.newton.len() < first.trace.newton.len());
    let mut steps = 0;
    let cold = problem.solve_from(&settings, Start::default(), &mut |_| steps += 1);
    assert_eq!(cold.expect("S is dense").multiplier, first.multiplier);
    // The last steps measure the error and are not seen.
    assert!(0 < steps && steps <= first.trace.newton.len());
}
