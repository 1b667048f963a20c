//! Rigid tools against closed forms, and the same problem said in other ways.

use contact3d::{
    Problem,
    history::StepRecord,
    post::{ContactReport, ToolState},
    scene::{
        Body, Clamp, Component, Contact, Force, Friction, HalfSpace, Material, Obstacle, Scene,
        Sphere, Step, Tool, ToolMotion,
    },
    solver::{Solution, Status},
};

use ToolMotion::{TurnX, TurnY, X, Y, Z};

fn block() -> Scene {
    Scene::new(Body::brick([1.0; 3], [6; 3]), Material::isotropic(1e5, 0.3))
}

/// A ball above the middle of the top.
fn ball() -> Obstacle {
    Obstacle::Sphere(Sphere {
        centre: [0.5, 0.5, 3.0],
        radius: 2.0,
        side: contact3d::scene::Side::Outside,
    })
}

fn tool(free: &[ToolMotion]) -> Tool {
    Tool {
        name: Some("tool".into()),
        free: free.to_vec(),
        ..Tool::default()
    }
}

fn moved(displacement: [f64; 3], turn: [f64; 3]) -> Tool {
    Tool {
        displacement: displacement.map(Into::into),
        turn: turn.map(Into::into),
        ..tool(&[])
    }
}

fn loaded(free: &[ToolMotion], force: [f64; 3], moment: [f64; 3]) -> Tool {
    Tool {
        force: force.map(Into::into),
        moment: moment.map(Into::into),
        ..tool(free)
    }
}

fn against(obstacle: Option<Obstacle>) -> Contact {
    Contact {
        obstacle,
        ..Contact::on("z_max").of_tool("tool")
    }
}

fn run(scene: Scene) -> (Solution, ContactReport) {
    let problem = Problem::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let problem = problem.assemble().unwrap_or_else(|error| panic!("{error}"));
    let settings = problem.scene().solve.clone();
    problem
        .solve_and_report(&settings)
        .expect("settings of a scene")
}

fn solved(scene: Scene) -> (Solution, ContactReport) {
    let (solution, report) = run(scene);
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    // A solve to 1e-12 of sums over some hundred panes.
    assert!(
        report.certificate.worst() < 1e-8,
        "{:?}",
        report.certificate
    );
    (solution, report)
}

/// The largest difference over the largest value.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let size = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let differences = &mut found.iter().zip(expected).map(|(a, b)| a - b);
    size(differences) / size(&mut expected.iter().copied())
}

/// Pressing the ball into the block is pressing the block into the ball.
#[test]
fn a_tool_that_moves_is_a_clamp_that_moves_the_other_way() {
    let shift = [0.005, 0.0, -0.02];
    let rough = || block().with_friction(Friction::coulomb(0.3));
    let by_tool = rough()
        .with_clamp(Clamp::face("z_min"))
        .with_contact(against(Some(ball())))
        .with_tool(moved(shift, [0.0; 3]));
    let mut resting = against(Some(ball()));
    resting.tool = None;
    let by_clamp = rough()
        .with_clamp(Clamp {
            value: shift.map(|u| (-u).into()),
            ..Clamp::face("z_min")
        })
        .with_contact(resting);
    let (by_tool, report) = solved(by_tool);
    let (by_clamp, _) = solved(by_clamp);
    // Conditioning of S times rounding.
    assert!(apart(&by_tool.multiplier, &by_clamp.multiplier) < 1e-11);
    // The force that moves it there moves it there.
    let [along, _, down] = report.tools[0].force;
    let force = [along, 0.0, down];
    let by_force = rough()
        .with_clamp(Clamp::face("z_min"))
        .with_contact(against(Some(ball())))
        .with_tool(loaded(&[X, Z], force, [0.0; 3]));
    let (by_force, report) = solved(by_force);
    assert!(apart(&by_force.multiplier, &by_tool.multiplier) < 1e-9);
    assert!(apart(&report.tools[0].displacement, &shift) < 1e-9);
}

/// A plate that is bonded to a face moves as nodes that are held do, and the forces that it then has move it there.
#[test]
fn a_bonded_tool_is_a_clamp_that_moves() {
    let held = || block().with_clamp(Clamp::face("z_min"));
    let bonded = |tool: Tool| {
        held().with_tool(Tool {
            face: Some("z_max".into()),
            ..tool
        })
    };
    let (given, report) = solved(bonded(moved([1e-3, 0.0, -0.01], [0.0, 0.002, 0.0])));
    let text = ["1e-3 + 0.002*(z-1)", "0", "-0.01 - 0.002*(x-0.5)"];
    let mut clamp = Clamp::face("z_max");
    clamp.value = text.map(|text| contact3d::scene::Quantity::formula(text).expect("a formula"));
    let (by_clamp, _) = solved(held().with_clamp(clamp));
    assert!(apart(&given.displacement, &by_clamp.displacement) < 1e-11);
    let ToolState { force, moment, .. } = report.tools[0];
    let free = ToolMotion::ALL;
    let (_, again) = solved(bonded(loaded(&free, force, moment)));
    assert!(apart(&again.tools[0].displacement, &report.tools[0].displacement) < 1e-9);
    assert!((again.tools[0].turn[1] - 0.002).abs() < 1e-9 * 0.002);
}

/// Two columns under one platen: forces are those of their stiffnesses.
#[test]
fn a_guided_platen_presses_columns_by_their_stiffness() {
    let text = include_str!("../../../../pipelines/platen.toml");
    let (_, report) = solved(Scene::parse("platen.toml", text).expect("a pipeline"));
    let platen = report.tools[0];
    // Rounding of a uniform strain.
    assert!((platen.displacement[2] + 1e-4).abs() < 1e-13, "{platen:?}");
    assert!((platen.force[2] + 2e3).abs() < 1e-7, "{platen:?}");
    // 1500 N at 0.05 m and 500 N at 0.15 m, about 0.1 m.
    assert!((platen.moment[1].abs() - 50.0).abs() < 1e-7, "{platen:?}");
}

/// A platen that presses a block to a rough floor: both float, and forces and moments of both balance.
#[test]
fn a_platen_holds_a_block_that_nothing_else_holds() {
    let scene = block()
        .with_contact(Contact::on("z_min"))
        .with_friction(Friction::coulomb(0.3))
        .with_tool(Tool {
            face: Some("z_max".into()),
            ..loaded(&ToolMotion::ALL, [100.0, 0.0, -1000.0], [0.0, 50.0, 0.0])
        });
    let (_, report) = solved(scene);
    let contact = report.resultants.contact.expect("contact");
    // Sums over nodes, to the accuracy of the solve.
    assert!(apart(&contact.contact_force, &[-100.0, 0.0, 1000.0]) < 1e-9);
    assert!(apart(&report.tools[0].force, &[100.0, 0.0, -1000.0]) < 1e-9);
    assert!(report.resultants.force_imbalance < 1e-9);
    assert!(report.resultants.moment_imbalance < 1e-9);
}

/// A flat tool on part of the top, of width one in a block of four.
fn punch(tool: Tool, friction: f64) -> Scene {
    let scene = Scene::new(
        Body::brick([4.0, 4.0, 2.0], [16, 16, 4]),
        Material::isotropic(1e5, 0.3),
    );
    let part = [[1.5, 1.5, 2.0], [2.5, 2.5, 2.0]];
    let scene = scene
        .with_clamp(Clamp::face("z_min"))
        .with_contact(against(None).inside(part))
        .with_tool(tool);
    match friction {
        0.0 => scene,
        friction => scene.with_friction(Friction::coulomb(friction)),
    }
}

/// A force beyond the edge of the panes, or a push beyond friction, has no equilibrium; within both there is one.
#[test]
fn a_punch_stands_only_where_contact_can_hold_it() {
    let free = [X, Y, Z, TurnX, TurnY, ToolMotion::TurnZ];
    let status = |force: [f64; 3], offset: f64| {
        // The moment of a force that acts beside the middle.
        let moment = [0.0, -force[2] * offset, 0.0];
        run(punch(loaded(&free, force, moment), 0.3)).0.status
    };
    for (push, offset, stands) in [
        (0.29, 0.0, true),
        (0.31, 0.0, false),
        // Panes end at 0.5, their centres lie at 0.25.
        (0.0, 0.2, true),
        (0.0, 0.6, false),
    ] {
        let found = status([push * 100.0, 0.0, -100.0], offset);
        match stands {
            true => assert!(found.is_solved(), "{push} {offset}: {found:?}"),
            false => assert_eq!(found, Status::NoEquilibrium, "{push} {offset}"),
        }
    }
}

/// Work of the tool, strain energy and friction add up; pressing and lifting without friction gains nothing.
#[test]
fn energies_of_a_tool_add_up() {
    let scene = |friction: f64, free: bool| {
        let tool = match free {
            true => loaded(&[Z], [0.0, 0.0, -300.0], [0.0; 3]),
            false => moved([0.0, 0.0, -0.02], [0.0; 3]),
        };
        let scene = block()
            .with_clamp(Clamp::face("z_min"))
            .with_contact(against(Some(ball())))
            .with_tool(tool)
            .with_step(Step::new("press").with_factor("tool", 1.0).in_increments(4))
            .with_step(Step::new("lift").with_factor("tool", 0.0).in_increments(4));
        match friction {
            0.0 => scene,
            friction => scene.with_friction(Friction::coulomb(friction)),
        }
    };
    for (friction, free) in [(0.0, true), (0.0, false), (0.3, false)] {
        let problem = Problem::new(scene(friction, free)).expect("a scene");
        let problem = problem.assemble().expect("a discrete problem");
        let history = problem
            .solve_history(&Default::default())
            .expect("a history");
        let records: &[StepRecord] = &history.records;
        assert_eq!(records.len(), 8);
        let sum = |of: fn(&StepRecord) -> f64| records.iter().map(of).sum::<f64>();
        let most = records
            .iter()
            .map(|it| it.energies.strain)
            .fold(0.0, f64::max);
        let work = sum(|it| it.energies.load_work);
        let taken =
            sum(|it| it.energies.dissipation + it.energies.normal_work + it.energies.imbalance);
        assert!((work - taken).abs() < 1e-9 * most, "{work} {taken}");
        // Works along chords of a force that grows with the contact: eight increments leave a percent or two.
        assert!(work > -0.02 * most, "{work} of {most}");
        assert!(records[7].tools[0].force[2].abs() < 1e-6);
    }
}

/// A step that drives the tool to a place.
fn step(name: &str, to: [f64; 3]) -> Step {
    let mut step = Step::new(name);
    step.value.insert(
        "tool.displacement".into(),
        contact3d::scene::StepValue::Vector(to.map(Into::into)),
    );
    step
}

fn followed(ball: Sphere) -> Scene {
    let mut contact = against(Some(Obstacle::Sphere(ball)));
    contact.follow = Some(contact3d::scene::Follow::Increment);
    block()
        .with_clamp(Clamp::face("z_min"))
        .with_contact(contact)
        .with_tool(tool(&[]))
}

fn records(scene: Scene) -> Vec<StepRecord> {
    let problem = Problem::new(scene).expect("a scene");
    let problem = problem.assemble().expect("a discrete problem");
    let history = problem.solve_history(&Default::default());
    history.expect("a history").records
}

/// A tool that has moved with `follow` has the normals of the place that an increment drives it to, be it the first: against a static problem
/// that begins there.
#[test]
fn a_tool_that_is_followed_has_the_normals_of_its_place() {
    let Obstacle::Sphere(mut above) = ball() else {
        unreachable!("it is one")
    };
    above.centre[2] += 0.2;
    let place = [0.3, 0.0, -0.22];
    // Moments are about the point where the increment drives it.
    let about = |point: [f64; 3]| Tool {
        point: Some(point),
        ..tool(&[])
    };
    let mut above_pivot = followed(above);
    above_pivot.tools = vec![about([1.0, 2.0, 3.0])];
    let at_once = above_pivot.clone().with_step(step("press", place));
    let aside_then_down = above_pivot
        .with_step(step("aside", [0.3, 0.0, 0.0]))
        .with_step(step("press", place));
    let mut beside = above;
    beside.centre[0] += 0.3;
    beside.centre[2] -= 0.22;
    let mut contact = against(Some(Obstacle::Sphere(beside)));
    contact.follow = Some(contact3d::scene::Follow::Start);
    // The ball begins 0.02 inside the body.
    contact.interference = true;
    let direct = block()
        .with_clamp(Clamp::face("z_min"))
        .with_contact(contact)
        .with_tool(about([1.3, 2.0, 2.78]));
    let (direct, report) = solved(direct);
    for scene in [aside_then_down, at_once] {
        let records = records(scene);
        let last = records.last().expect("an increment");
        assert!(apart(&last.multiplier, &direct.multiplier) < 1e-9);
        assert!(apart(&last.tools[0].moment, &report.tools[0].moment) < 1e-9);
    }
}

/// A ball that a tool turns by 1.5 rad about a pivot far off its centre, in steps that touch nothing before the last, against the ball that
/// begins there.
#[test]
fn a_tool_that_is_turned_far_is_where_it_was_turned_to() {
    let Obstacle::Sphere(mut ball) = ball() else {
        unreachable!("it is one")
    };
    ball.centre[2] -= 0.02;
    let (pivot, axis, angle) = ([0.4, 0.7, 4.5], [1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0], 1.5_f64);
    // Rodrigues' formula, backwards.
    let arm: [f64; 3] = std::array::from_fn(|k| ball.centre[k] - pivot[k]);
    let along: f64 = arm.iter().zip(axis).map(|(r, n)| r * n).sum();
    let across = [1, 2, 0].map(|k: usize| {
        let next = (k + 1) % 3;
        axis[k] * arm[next] - axis[next] * arm[k]
    });
    let (sin, cos) = (-angle).sin_cos();
    let mut begin = ball;
    begin.centre = std::array::from_fn(|k| {
        pivot[k] + cos * arm[k] + sin * across[k] + (1.0 - cos) * along * axis[k]
    });
    let at_pivot = || Tool {
        point: Some(pivot),
        ..tool(&[])
    };
    let mut scene = followed(begin);
    scene.tools = vec![at_pivot()];
    let mut turned = Step::new("turn").in_increments(3);
    let turn = axis.map(|n| (angle * n).into());
    let turn = contact3d::scene::StepValue::Vector(turn);
    turned.value.insert("tool.turn".into(), turn);
    let records = records(scene.with_step(turned));
    assert!(records[1].multiplier.iter().all(|stress| *stress == 0.0));
    let mut contact = against(Some(Obstacle::Sphere(ball)));
    contact.interference = true;
    let direct = block()
        .with_clamp(Clamp::face("z_min"))
        .with_contact(contact)
        .with_tool(at_pivot());
    let (direct, report) = solved(direct);
    assert!(apart(&records[2].multiplier, &direct.multiplier) < 1e-9);
    let [found, expected] = [&records[2].tools[0], &report.tools[0]];
    assert!(apart(&found.force, &expected.force) < 1e-9);
    assert!(apart(&found.moment, &expected.moment) < 1e-9);
}

/// What friction adds to the force of a ball that is dragged is μN; without friction nothing holds it over the middle of the block, and
/// towards its ends, which give way more, it is pushed on.
#[test]
fn a_tool_is_dragged_against_friction_alone() {
    let Obstacle::Sphere(ball) = ball() else {
        unreachable!("it is one")
    };
    let forces = |friction: Option<f64>| {
        let mut scene = followed(ball)
            .with_step(step("press", [-0.1, 0.0, -0.02]))
            .with_step(step("drag", [0.1, 0.0, -0.02]).in_increments(4));
        if let Some(friction) = friction {
            scene = scene.with_friction(Friction::coulomb(friction));
        }
        let records = records(scene);
        [2, 4].map(|k| records[k].tools[0].force)
    };
    let ([middle, smooth], [_, rough]) = (forces(None), forces(Some(0.3)));
    let (added, bound) = (rough[0] - smooth[0], -0.3 * rough[2]);
    // Normals lean by a tenth: the pressing force differs by that of their cosines.
    assert!((added / bound - 1.0).abs() < 0.01, "{added} of {bound}");
    assert!(middle[0].abs() < 0.005 * bound && smooth[0] < -0.1 * bound);
    // The drive's work becomes strain energy but for the work of pressures, which vanishes with the increments.
    let normal_work = |increments: usize| {
        let drag = step("drag", [0.1, 0.0, -0.02]).in_increments(increments);
        let scene = followed(ball).with_step(step("press", [-0.1, 0.0, -0.02]));
        let records = records(scene.with_step(drag));
        let sum = |of: fn(&StepRecord) -> f64| records[1..].iter().map(of).sum::<f64>();
        let work = sum(|it| it.energies.load_work);
        let normal = sum(|it| it.energies.normal_work);
        let after = records[increments].energies.strain;
        // Sums of products of hundreds of displacements and forces.
        assert!((work - (after - records[0].energies.strain) - normal).abs() < 1e-12 * after);
        normal.abs() / after
    };
    let [coarse, fine] = [4, 16].map(normal_work);
    assert!(fine < 0.005 && fine < coarse / 3.0, "{coarse:e}, {fine:e}");
}

/// What is given of a motion must be its place or its load, and names must be those of tools.
#[test]
fn contradictions_are_refused_with_their_key() {
    let scene = |tool: Tool| {
        block()
            .with_clamp(Clamp::face("z_min"))
            .with_contact(against(Some(ball())))
            .with_tool(tool)
    };
    let both = Tool {
        force: [0.0, 0.0, -1.0].map(Into::into),
        ..moved([0.0; 3], [0.0; 3])
    };
    let moved_while_free = Tool {
        turn: [0.0, 0.1, 0.0].map(Into::into),
        ..tool(&[TurnY])
    };
    let other_name = Tool {
        name: Some("toll".into()),
        ..tool(&[])
    };
    let unused = Tool {
        name: None,
        ..tool(&[])
    };
    let bonded_twice = Tool {
        face: Some("z_min".into()),
        ..tool(&[])
    };
    for (tool, key) in [
        (both, "tool.0.force"),
        (moved_while_free, "tool.0.turn"),
        (other_name, "contact.tool"),
        (bonded_twice, "tool.0.face"),
    ] {
        let error = scene(tool).validate().expect_err(key);
        assert_eq!(error.key, key, "{error:?}");
    }
    let error = scene(tool(&[])).with_tool(unused).validate();
    assert_eq!(error.expect_err("unused").key, "tool.1");
    let error = scene(tool(&[])).with_tool(tool(&[])).validate();
    assert!(error.is_err(), "two of one name");
    let step = Step::new("s").with_factor("drum", 1.0);
    let error = scene(tool(&[])).with_step(step).validate();
    assert_eq!(error.expect_err("unknown").key, "step.0.factor.drum");
    // A clamp that holds a node of the bonded face where the tool is free.
    let clamped = block()
        .with_clamp(Clamp::face("x_min").along(&[Component::X]))
        .with_clamp(Clamp::face("z_min"))
        .with_tool(Tool {
            face: Some("z_max".into()),
            ..tool(&[X])
        });
    let error = Problem::new(clamped).expect("a scene").assemble();
    assert!(
        error
            .expect_err("a contradiction")
            .to_string()
            .contains("clamp.0")
    );
}

/// A force on a face, the same on a tool that only touches it and slides freely, and the obstacle given as a half-space.
#[test]
fn a_flat_tool_without_friction_presses_as_its_force_does() {
    let plane = Obstacle::HalfSpace(HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    });
    let press = |obstacle| {
        let tool = loaded(&[Z], [0.0, 0.0, -300.0], [0.0; 3]);
        let scene = block().with_clamp(Clamp::face("z_min"));
        solved(scene.with_contact(against(obstacle)).with_tool(tool))
    };
    let (flat, report) = press(None);
    let (plane, _) = press(Some(plane));
    assert!(apart(&flat.multiplier, &plane.multiplier) < 1e-11);
    let force = Force::on("z_max", [0.0, 0.0, -300.0]);
    let (_, by_force) = solved(block().with_clamp(Clamp::face("z_min")).with_force(force));
    let applied = by_force.resultants.applied_force;
    let contact = report.resultants.contact.expect("contact").contact_force;
    assert!(apart(&contact, &applied) < 1e-9);

    // On a smooth floor nothing else holds the block, which yields by F h / (E A).
    let tool = loaded(&[Z], [0.0, 0.0, -300.0], [0.0; 3]);
    let floor = block().with_contact(Contact::on("z_min"));
    let (_, report) = solved(floor.with_contact(against(None)).with_tool(tool));
    assert!(apart(&report.tools[0].displacement, &[0.0, 0.0, -3e-3]) < 1e-9);
}
