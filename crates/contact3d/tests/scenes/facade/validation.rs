//! A scene built in Rust is refused by the keys of scene files.

use contact3d::{
    Problem, ProblemError,
    scene::{
        Body, Clamp, Coefficient, Contact, Friction, Material, Pressure, Quantity, Scene,
        SolveSettings, Table,
    },
};

use super::{assembled, block};

fn refused(scene: Scene) -> String {
    match Problem::new(scene) {
        Err(ProblemError::Invalid(invalid)) => invalid.key,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("an impossible scene"),
    }
}

#[test]
fn values_that_no_problem_has_are_refused_by_their_keys() {
    let base = || block(Friction::coulomb(0.3));
    let with = |friction| refused(block(friction));
    let mut soft = base();
    soft.material = Some(Material::isotropic(2.1e11, 0.5));
    assert_eq!(refused(soft), "material.isotropic.poisson_ratio");
    let body = || Body::brick([1.0; 3], [2; 3]);
    let bare = Scene::new(body(), Material::isotropic(2.1e11, 0.3));
    assert_eq!(refused(bare.clone()), "clamp");
    let loose = bare.with_clamp(Clamp::face("x_min"));
    assert_eq!(
        refused(loose.clone().with_friction(Friction::coulomb(0.3))),
        "friction"
    );
    assert_eq!(
        refused(loose.clone().with_contact(Contact::on("bottom"))),
        "contact.face"
    );
    assert_eq!(
        refused(loose.with_pressure(Pressure::on("x_min", 1.0))),
        "pressure.0.face"
    );
    assert_eq!(
        with(Friction::coulomb(-0.3)),
        "friction.coefficient.constant"
    );
    let table = Table {
        slip: vec![0.0, 1.0],
        value: vec![0.3, 0.0],
    };
    assert_eq!(
        with(Friction::orthotropic(0.3, Coefficient::Table(table))),
        "friction.coefficient_2.table.value"
    );
    assert_eq!(with(Friction::tresca(-1.0)), "friction.slip_bound");
    let unknown = Coefficient::formula("0.3 + decay*s").expect("a formula with a parameter");
    assert_eq!(
        with(Friction::coulomb(unknown.clone())),
        "friction.coefficient.expression"
    );
    let mut known = block(Friction::coulomb(unknown));
    known.parameters.insert("decay".to_owned(), 1e3);
    assert!(Problem::new(known).is_ok());
}

#[test]
fn formulas_are_checked_where_they_act() {
    let formula = |text| Quantity::formula(text).expect("a formula");
    let mut lifted = block(Friction::coulomb(0.3));
    lifted.contacts[0].gap = formula("-x");
    assert_eq!(refused(lifted), "contact.gap");
    let mut undefined = block(Friction::coulomb(0.3));
    undefined.pressures[0].value = formula("sqrt(x - 1)");
    let error = Problem::new(undefined)
        .expect("loads are integrated later")
        .assemble();
    let error = error.expect_err("a load that is not a number").to_string();
    assert!(error.starts_with("pressure.0.value: expected"), "{error}");
}

#[test]
fn settings_are_checked() {
    let problem = assembled(block(Friction::coulomb(0.3)));
    let settings = SolveSettings {
        epsilon: Some(2.0),
        ..SolveSettings::default()
    };
    let error = problem.solve(&settings).expect_err("an accuracy above one");
    assert!(
        error
            .to_string()
            .starts_with("solve.epsilon: expected a number with 0 < epsilon < 1"),
        "{error}"
    );
}

#[test]
fn a_scene_built_in_rust_has_a_text() {
    let scene = block(Friction::orthotropic(
        0.3,
        Coefficient::ramp(0.3, 0.2, 0.0, 1e3),
    ));
    let text = scene.to_toml().expect("numbers only");
    assert_eq!(Scene::parse("again", &text).expect("a scene"), scene);
}
