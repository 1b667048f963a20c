//! Clamps that no body can follow.

use contact3d::{Problem, scene::Scene};

const BODY: &str = "title = 'refused'
body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
";

/// The key and the words of the refusal.
fn refused(text: &str) -> String {
    let text = format!("{BODY}{text}");
    match Scene::parse("refused", &text) {
        Err(error) => error.to_string(),
        Ok(scene) => {
            let problem = Problem::new(scene).and_then(Problem::assemble);
            problem.expect_err("contradictory clamps").to_string()
        }
    }
}

#[test]
fn two_values_at_one_node_are_refused_with_its_place() {
    let fixed = "[[clamp]]\nface = 'x_min'\n";
    let found = refused(&format!(
        "{fixed}[[clamp]]\nface = 'z_max'\nvalue = [0.0, 0.0, -1e-5]\n"
    ));
    assert!(found.contains("clamp.1.value"), "{found}");
    assert!(found.contains("along z"), "{found}");
    assert!(
        found.contains("in clamp.0") && found.contains("1.0"),
        "{found}"
    );
    // Formulas that agree on the edge are no contradiction, rounding apart.
    let agree = format!(
        "{BODY}{fixed}[[clamp]]\nface = 'z_max'\nvalue = [0.0, 0.0, '-1e-5*sin(PI*(1 - x))']\n"
    );
    let scene = Scene::parse("agree", &agree).unwrap();
    Problem::new(scene).unwrap().assemble().unwrap();
    // Components that one of them leaves free are none, either.
    let rollers = "[[clamp]]\nface = 'x_min'\ncomponents = ['x', 'y']\n[[clamp]]\nface = 'z_max'\ncomponents = ['z']\nvalue = [0, 0, -1e-5]\n";
    let scene = Scene::parse("rollers", &format!("{BODY}{rollers}")).unwrap();
    Problem::new(scene).unwrap().assemble().unwrap();
}

#[test]
fn values_of_free_components_and_undefined_ones_are_refused() {
    let found =
        refused("[[clamp]]\nface = 'x_min'\ncomponents = ['x', 'y']\nvalue = [0.0, 0.0, -1e-5]\n");
    assert!(
        found.contains("clamp.0.value") && found.contains("along z"),
        "{found}"
    );
    let found = refused("[[clamp]]\nface = 'x_min'\nvalue = ['ln(y - 0.6)', 0.0, 0.0]\n");
    assert!(
        found.contains("clamp.0.value") && found.contains("finite"),
        "{found}"
    );
}

#[test]
fn held_contact_nodes_cannot_be_pushed_into_the_foundation() {
    let clamp = "[[clamp]]\nface = 'x_min'\nvalue = [0.0, 0.0, -1e-5]\n[contact]\nface = 'z_min'\n";
    let found = refused(clamp);
    assert!(
        found.contains("the gap") && found.contains("clamp"),
        "{found}"
    );
    let scene = Scene::parse("gap", &format!("{BODY}{clamp}gap = 1e-5\n")).unwrap();
    Problem::new(scene).unwrap().assemble().unwrap();
}
