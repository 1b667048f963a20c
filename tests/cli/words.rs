//! Messages speak the language of scenes, and what they advise helps.

use crate::program::{Program, pipeline};

/// What the program says about Table 1's scene with a change, and its exit code.
fn said(program: &Program, scene: &str, change: &str) -> (Option<i32>, String) {
    let scene = pipeline(scene);
    let scene = scene.to_str().unwrap();
    let mut command = program.command(&["mesh", scene, "run.h5", "--set", change]);
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    // Long messages are folded behind a bar.
    let words: Vec<&str> = text.split_whitespace().filter(|w| *w != "│").collect();
    (output.status.code(), words.join(" "))
}

fn refusal(program: &Program, scene: &str, change: &str) -> String {
    let (code, text) = said(program, scene, change);
    assert_eq!(code, Some(2), "{change}: {text}");
    for rust in [
        "Constant(",
        "Varying(",
        "Some(",
        "Box([",
        "Ramp",
        "Formula",
        "f64",
        "usize",
        "variant",
        "NaN",
        "struct",
        "field `",
        "wanted",
        "untagged",
        "u64",
    ] {
        assert!(!text.contains(rust), "{change}: {rust}: {text}");
    }
    text
}

#[test]
fn values_are_shown_as_scenes_write_them() {
    let program = Program::new();
    for (change, fragment) in [
        ("contact.gap=nan", "found nan"),
        ("contact.gap=-1", "found -1.0"),
        (
            "traction.0.value=[1, inf, \"x\"]",
            "found [1.0, inf, \"x\"]",
        ),
        ("contact.axis_1=[0,0,0]", "found [0.0, 0.0, 0.0]"),
        (
            "contact.axis_1=[0,0,1]",
            "found (0.0, 0.0, 1.0) at x, y, z = 0.0, 0.0, 0.0, where the normal is (0.0, 0.0, -1.0)",
        ),
        (
            "contact.axis_1=[\"x\",0,\"1/x\"]",
            "found (0.0, 0.0, inf) at x, y, z = 0.0, 0.0, 0.0",
        ),
        (
            "contact.angle=\"1/x\"",
            "found inf at x, y, z = 0.0, 0.0, 0.0",
        ),
        (
            "contact.gap=\"x - 1\"",
            "found -1.0 at x, y, z = 0.0, 0.0, 0.0",
        ),
        (
            "friction.slip_bound=1e6",
            "found { ramp = { initial = 0.3, residual = 0.2, onset = ",
        ),
        ("clamp.0.components=[]", "found []"),
        ("solve.epsilon=1e300", "found 1e300"),
        (
            "solve.epsilon=\"a\"",
            "expected a number, found string \"a\"",
        ),
        ("traction.0.value=[1,2]", "expected 3 values, found 2"),
        (
            "material.isotropic=3",
            "expected a table, found integer `3`",
        ),
        (
            "clamp.0.components=[\"w\"]",
            "unknown word `w`, expected one of `x`, `y`, `z`",
        ),
        (
            "region=[{part={box=[[5,0,0],[6,1,1]]},material={isotropic={young_modulus=1.0,poisson_ratio=0.3}}}]",
            "found { box = [[5.0, 0.0, 0.0], [6.0, 1.0, 1.0]] }",
        ),
        (
            "clamp.0={box=[[5,0,0],[6,1,1]]}",
            "found [[5.0, 0.0, 0.0], [6.0, 1.0, 1.0]]",
        ),
        (
            "traction.0.value=[0,0,\"1/(x-x)\"]",
            "found inf at x, y, z = ",
        ),
        (
            "traction.0.value=[0,0,\"1/(x-x)\"]",
            "sqrt(max(FORMULA, 0))",
        ),
        (
            "body.brick=[[3,1,1],[12,4,4]]",
            "body.brick: expected a table, found a list",
        ),
        ("contact=[[\"z_min\"]]", "expected a table, found a list"),
        ("assemble=[]", "assemble: expected a table, found a list"),
        (
            "traction.0.value=[1,2,3,4]",
            "traction.0.value: expected 3 values, found 4",
        ),
        (
            "body.brick.cells=[12,4,-4]",
            "expected a whole number from 0 on, found integer `-4`",
        ),
        (
            "solve.max_outer_steps=-1",
            "expected a whole number from 0 on, found integer `-1`",
        ),
        (
            "solve.method=3",
            "solve.method: expected a word, found integer `3`",
        ),
        (
            "contact=3",
            "contact: expected a table, or several tables [[contact]], found integer `3`",
        ),
        (
            "solve.method={newton=1, auto=2}",
            "write method = \"auto\"; `contact3d-pipe help scene`",
        ),
        (
            "step=[{value={\"traction.0\"=true}}]",
            "expected a number, or an expression in x, y, z as a string, or a list of 3 values, found boolean `true`",
        ),
        (
            "step=[{value={\"traction.0\"=[1,2]}}]",
            "expected 3 values, found 2",
        ),
        (
            "friction.coefficient_2={constant=1e-320}",
            "friction.coefficient_2.constant: expected a finite positive number, 1e-100 at least, found 1e-320",
        ),
        (
            "friction.coefficient_2={expression=\"1e-320 + 0*s1\"}",
            "1e-100 at least, on the whole contact face, found 1e-320",
        ),
        (
            "contact.friction.coefficient.constant=0.3",
            "friction: expected a contact face that it can be the law of, found none, for each has contact.friction in its place",
        ),
    ] {
        let text = refusal(&program, "newton.toml", change);
        assert!(text.contains(fragment), "{change}: {text}");
    }
    assert!(!program.path("run.h5").exists());
}

#[test]
fn kinds_are_named_those_found_and_those_there_are() {
    let program = Program::new();
    let all = "expected exactly one of constant, ramp, table, grid, expression; found";
    for (change, fragment, advice) in [
        ("friction.coefficient_1={}", format!("friction.coefficient_1: {all} none"), "such as friction.coefficient.constant = 0.3"),
        ("friction.coefficient_1.constant=0.3", format!("friction.coefficient_1: {all} constant and ramp"), "--set 'friction.coefficient_1={ ... }'"),
        ("friction.coefficient_1=0.3", format!("friction.coefficient_1: {all} number `0.3`"), "name the kind"),
        ("friction.coefficient_1=\"ramp\"", format!("friction.coefficient_1: {all} string \"ramp\""), "name the kind"),
        ("material={}", "material: expected exactly one of isotropic, orthotropic, voigt; found none".into(), "such as material.isotropic"),
        ("material.voigt={}", "material: expected exactly one of isotropic, orthotropic, voigt; found isotropic and voigt".into(), "leave one of them"),
        ("body.gmsh={file=\"a.msh\"}", "body: expected exactly one of brick, gmsh; found brick and gmsh".into(), "leave one of them"),
        ("region=[{part={},material={}}]", "region.0.part: expected exactly one of group, box; found none".into(), "part.box"),
    ] {
        let text = refusal(&program, "newton.toml", change);
        assert!(text.contains(&fragment), "{change}: {text}");
        assert!(text.contains(advice), "{change}: {text}");
    }
    // The advice, followed.
    for change in [
        "friction.coefficient_1={ constant = 0.3 }",
        "material={ isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 } }",
        "region=[{ part = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]] }, material = { isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 } } }]",
    ] {
        let (code, text) = said(&program, "newton.toml", change);
        assert_eq!(code, Some(0), "{change}: {text}");
    }
}

#[test]
fn a_word_needs_no_quotes_and_other_text_is_explained() {
    let program = Program::new();
    let text = refusal(&program, "newton.toml", "contact.gap=1e-6*x");
    let (_, advised) = text.split_once("--set '").expect(&text);
    let (advised, _) = advised.split_once('\'').expect(&text);
    assert_eq!(advised, "contact.gap=\"1e-6*x\"");
    let (code, text) = said(&program, "newton.toml", "contact.multipliers=nodal");
    assert_eq!(code, Some(0), "{text}");
    let status = program.command(&["status", "run.h5"]).output().unwrap();
    assert!(status.status.success());
    // A value that would bring other keys with it is none.
    refusal(
        &program,
        "newton.toml",
        "solve.epsilon=1e-4\nmethod = \"newton\"",
    );
}

#[test]
fn names_in_formulas_are_explained() {
    let program = Program::new();
    let unknown = refusal(&program, "newton.toml", "contact.gap=\"top*x\"");
    for fragment in [
        "contact.gap: expected the variables x, y, z, names of the table [parameters], which is empty, the functions sqrt",
        "found the unknown name top in \"top*x\"",
        "top = 1.0, with the value you mean, below a line [parameters]",
    ] {
        assert!(unknown.contains(fragment), "{fragment}: {unknown}");
    }
    for (change, fragment) in [
        (
            "contact.gap=\"foo(x)\"",
            "\"foo\" is no function; expected one of sqrt, exp",
        ),
        (
            "contact.gap=\"abs x\"",
            "put the argument of a function in parentheses",
        ),
        (
            "contact.gap=\"max(x)\"",
            "two arguments or more, such as max(x, 0)",
        ),
        (
            "contact.gap=\"if(x, 1, 2)\"",
            "expected an operator or one of < <= > >= (if takes a condition and two values), found `,`",
        ),
        ("contact.gap=\"x < 1\"", "such as if(x < 1, 0.3, 0.2)"),
        ("contact.gap=\"s1\"", "found the unknown name s1"),
        (
            "parameters.s1=1",
            "parameters.s1: expected a name that means nothing else in formulas, found s1, a variable",
        ),
        ("parameters.max=1", "found max, a function"),
        ("parameters.PI=1", "found PI, a constant"),
        (
            "parameters={\"a-b\"=1}",
            "parameters.a-b: expected a name of letters",
        ),
        (
            "parameters.mu=inf",
            "parameters.mu: expected a finite number",
        ),
        (
            "parameters.mu=\"x\"",
            "parameters.mu: expected a number, found string \"x\"",
        ),
    ] {
        let text = refusal(&program, "newton.toml", change);
        assert!(text.contains(fragment), "{change}: {text}");
    }
    let text = refusal(&program, "parameters.toml", "contact.gap=\"crawn*x\"");
    assert!(
        text.contains("the parameters mu, loss, onset, width, pull, crown,")
            || text.contains("the parameters crown, loss, mu, onset, pull, width,"),
        "{text}"
    );
}

#[test]
fn the_hard_cases_are_part_of_the_program() {
    let program = Program::new();
    let mut command = program.command(&["stability", "--coarse", "--only", "one node"]);
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(text.lines().count() > 1, "{text}");
    let left = std::fs::read_dir(program.path(".")).unwrap().count();
    assert_eq!(left, 0, "nothing is left in the folder");
}
