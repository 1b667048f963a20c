//! Model features side by side: histories, bodies that float, several faces, obstacles, springs, moved clamps. Whatever a scene
//! puts together, the answer satisfies its conditions, forces and moments sum to zero, and all methods find the same one.

use contact3d::{Problem, solver::Status};

use super::pieces::*;

#[test]
fn histories_of_bodies_that_float() {
    check_all("path length", |space| {
        let law = format!("{ORTHOTROPIC}\nfollows = 'path-length'");
        let block = Pieces::new(&[WEIGHT, PUSHED]);
        block.floor(space, "", &law).steps(&TO_AND_FRO)
    });
    let step_slip = format!("{RAMP}\nfollows = 'step-slip'");
    let block = Pieces::new(&[WEIGHT, PUSHED]).floor("panes", HOLLOW, &step_slip);
    check("hollow", &block.steps(&TO_AND_FRO), "P1");
    let block = Pieces::new(&[WEIGHT, MOVED_ALONG]).floor("nodal", "", RAMP);
    check("moved along", &block.steps(&MOVED_AND_BACK), "P1");
}

#[test]
fn histories_of_faces_obstacles_and_springs() {
    let gap = "factor.push = 1.0\nvalue = { 'contact.1.gap' = 2e-7 }\nincrements = 2";
    let steps = ["factor.push = 0.0", gap, "factor.push = -0.5"];
    check_all("faces", |space| {
        let block = Pieces::new(&[PRESSED, PULLED, HELD]);
        block
            .faces(space, "x_min", ["", ""], [CONSTANT, RAMP])
            .steps(&steps)
    });
    let smooth =
        Pieces::new(&[PRESSED, PULLED, HELD]).faces("panes", "x_min", ["", ""], ["", RAMP]);
    check("smooth floor", &smooth.steps(&steps), "P1");
    let bore = Pieces::new(&[PRESSED, MOVED]).floor("panes", BORE, RAMP);
    check("bore", &bore.steps(&MOVED_AND_BACK), "P1");
    let springs = Pieces::new(&[PRESSED, PUSHED, SPRINGS]).floor("nodal", "", ORTHOTROPIC);
    check("springs", &springs.steps(&TO_AND_FRO), "P1");
}

#[test]
fn bodies_that_float_between_faces_and_obstacles() {
    check_all("corner", |space| {
        Pieces::new(&[WEIGHT, PUSHED]).faces(space, "x_min", ["", ""], [ORTHOTROPIC, RAMP])
    });
    for (name, more, laws) in [
        ("given", ["", ""], [TRESCA, CONSTANT]),
        ("both given", ["", ""], [TRESCA, "slip_bound = 1e6"]),
        ("smooth wall", ["", ""], [CONSTANT, ""]),
        ("hollow", [HOLLOW, HOLLOW_WALL], [CONSTANT, RAMP]),
    ] {
        let block = Pieces::new(&[WEIGHT, PUSHED]);
        check(name, &block.faces("panes", "x_min", more, laws), "P1");
    }
    for (name, obstacle) in [("hollow", HOLLOW), ("bore", BORE)] {
        let block = Pieces::new(&[WEIGHT, PUSHED]).floor("nodal", obstacle, RAMP);
        check(name, &block, "P1");
    }
    let moved = Pieces::new(&[WEIGHT, MOVED_ALONG, PUSHED_ASIDE]);
    let moved = moved.faces("nodal", "y_min", ["", ""], [CONSTANT, RAMP]);
    check("moved along in a corner", &moved, "P1");
    let spring = "[[spring]]\nface = 'y_max'\nnormal = 2e11";
    let block = Pieces::new(&[WEIGHT, PUSHED, spring]).floor("panes", "", RAMP);
    check("spring", &block, "P1");
}

#[test]
fn faces_obstacles_springs_and_moved_clamps() {
    let both = |block: Pieces, more, laws| block.faces("panes", "x_min", more, laws);
    for (name, block) in [
        (
            "obstacles",
            both(
                Pieces::new(&[PRESSED, PULLED, HELD]),
                [HOLLOW, HOLLOW_WALL],
                [CONSTANT, RAMP],
            ),
        ),
        (
            "ball and wall",
            both(
                Pieces::new(&[PRESSED, PULLED, HELD]),
                [BALL, HOLLOW_WALL],
                ["", ORTHOTROPIC],
            ),
        ),
        (
            "moved in a corner",
            both(
                Pieces::new(&[PRESSED, MOVED]),
                ["", ""],
                [ORTHOTROPIC, RAMP],
            ),
        ),
        (
            "springs in a corner",
            both(
                Pieces::new(&[PRESSED, PUSHED, SPRINGS]),
                ["", ""],
                [CONSTANT, RAMP],
            ),
        ),
        (
            "springs and a hollow",
            Pieces::new(&[PRESSED, PUSHED, SPRINGS]).floor("nodal", HOLLOW, RAMP),
        ),
        (
            "moved on springs",
            Pieces::new(&[PRESSED, MOVED, SPRINGS]).floor("panes", "", ORTHOTROPIC),
        ),
    ] {
        check(name, &block, "P1");
    }
}

/// All of them at once.
#[test]
fn a_history_with_everything() {
    let spring = "[[spring]]\nface = 'z_max'\nnormal = 1e10";
    let wall = "obstacle.height = { value = '-1e-7*(1 - (2*x - 1)^2)', direction = 'y' }";
    let steps = [
        "factor.hold = 0.0",
        "factor.hold = 1.0\nincrements = 2",
        "factor = { hold = -1.0, push = 0.5 }\nincrements = 2",
    ];
    for element in ["P1", "P2"] {
        let block = Pieces::new(&[WEIGHT, MOVED_ALONG, spring, PUSHED_ASIDE]);
        let block = block.faces("panes", "y_min", [HOLLOW, wall], [CONSTANT, RAMP]);
        check("everything", &block.steps(&steps), element);
    }
}

/// A body pushed step by step until nothing holds it: the history ends there, and no row of it has a huge displacement.
#[test]
fn a_history_ends_where_the_body_slides_off() {
    let steps = ["factor.push = 0.0", "factor.push = 2.0\nincrements = 4"];
    for multipliers in ["panes", "nodal"] {
        let scene = Pieces::new(&[WEIGHT, PUSHED]).floor(multipliers, "", CONSTANT);
        let scene = scene.steps(&steps).scene("P1");
        let problem = Problem::new(scene).and_then(|problem| problem.assemble());
        let problem = problem.unwrap_or_else(|error| panic!("{error}"));
        let history = problem
            .solve_history(&problem.scene().solve)
            .expect("a history");
        let (last, before) = history.records.split_last().expect("increments");
        assert!(before.iter().all(|record| record.status.is_solved()));
        // In the balance of forces 1.53 MN of 1.6 MN hold, but the push turns the block, too, and nodes reach further than panes:
        // panes are proved not to hold it; what nodes could do, the face that slides does not.
        let expected = match multipliers {
            "panes" => Status::NoEquilibrium,
            _ => Status::MaxNewtonSteps,
        };
        assert_eq!(last.status, expected, "{multipliers}");
        let moved = last
            .displacement
            .iter()
            .flatten()
            .fold(0.0_f64, |m, u| m.max(u.abs()));
        assert_eq!(moved, 0.0);
        // Every row has the coefficients of friction, so they make one array.
        let panes = history.records.iter().flat_map(|record| &record.panes);
        assert!(panes.map(|pane| pane.coefficients).all(|f| f == [0.4; 2]));
    }
}

/// A clamp along x leaves a node of the lower face two displacements. Where the axes of friction are those of the clamp it carries two
/// conditions; turned axes and normals with a part along x would make them three.
#[test]
fn half_held_nodes_carry_as_many_conditions_as_they_have_displacements() {
    let along = "[[clamp]]\nface = 'x_max'\ncomponents = ['x']";
    let block = |more: &str| Pieces::new(&[PRESSED, PULLED, along]).floor("nodal", more, CONSTANT);
    check("axes of the clamp", &block(""), "P1");
    // The cosine of 90° is 6e-17.
    check("exchanged axes", &block("angle = 90.0"), "P1");
    for more in ["angle = 30.0", HOLLOW] {
        let refused = Problem::new(block(more).scene("P1"));
        let message = refused
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default();
        assert!(message.contains("contact.multipliers"), "{more}: {message}");
    }
    let panes = Pieces::new(&[PRESSED, PULLED, along]).floor("panes", HOLLOW, CONSTANT);
    check("panes", &panes, "P1");
}
