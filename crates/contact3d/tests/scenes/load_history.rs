//! Load histories: one node against its closed-form path, one step against the static answer, all methods
//! against each other.

use contact3d::{
    AssembledProblem, InMemory, Problem, SolvedProblem,
    history::StepRecord,
    scene::{Method, Scene, SolveSettings, Step},
    solver::Start,
};

/// The corner (1, 0, 0) of a cube of edge 1 is free and belongs to one tetrahedron; its shear modulus, and the force of
/// the weight on it.
const SHEAR: f64 = 6.0;
const PRESS: f64 = 2.0;

/// A cube whose nodes are held but for one. With C₁₂ = −C₄₄ the three displacements of that node do not couple, and its
/// stiffness is V |∇φ|² (C₁₁ + 2 C₄₄)/3 = C₄₄ for C₁₁ = 4 C₄₄ and the corner tetrahedron, V = 1/6, ∇φ = (1, −1, −1).
/// The weight presses it down by p V/4, a traction q on x_max drives it by q/6: one of two triangles has it, and a third
/// of that.
fn one_node(friction: &str, steps: &str) -> Scene {
    let (c, g) = (4.0 * SHEAR, SHEAR);
    let (weight, push) = (24.0 * PRESS, 6.0);
    let text = format!(
        "title = 'one node'
         body.brick = {{ size = [1.0, 1.0, 1.0], cells = [1, 1, 1] }}
         material.voigt.stiffness = [
           [{c}, -{g}, -{g}, 0.0, 0.0, 0.0], [-{g}, {c}, -{g}, 0.0, 0.0, 0.0], [-{g}, -{g}, {c}, 0.0, 0.0, 0.0],
           [0.0, 0.0, 0.0, {g}, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, {g}, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, {g}]]
         clamp = [
           {{ box = [[0.0, 0.0, 0.0], [0.0, 1.0, 1.0]] }},
           {{ box = [[0.0, 1.0, 0.0], [1.0, 1.0, 1.0]] }},
           {{ box = [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0]] }}]
         contact = {{ face = 'z_min', multipliers = 'nodal' }}
         body_force.value = [0.0, 0.0, -{weight}]
         traction = [{{ name = 'push', face = 'x_max', value = [{push}, 0.0, 0.0] }}]
         {friction}
         {steps}"
    );
    Scene::parse("one node", &text).unwrap_or_else(|error| panic!("{error:?}"))
}

fn assembled(scene: Scene) -> AssembledProblem {
    let problem = Problem::new(scene).expect("a brick");
    problem.assemble().expect("a discrete problem")
}

fn solved(scene: Scene) -> SolvedProblem {
    let settings = scene.solve.clone();
    let history = assembled(scene).solve_history(&settings);
    history.expect("a history")
}

/// u_x of the free node.
fn displacement(record: &StepRecord) -> f64 {
    record.displacement[1][0]
}

/// Weight first, then the push up to 1.5 times the friction, back to −1.5 times, and up again.
const LOOP: &str = "
    [[step]]
    factor = { push = 0.0 }
    [[step]]
    factor = { push = 1.5 }
    increments = 6
    [[step]]
    factor = { push = -1.5 }
    increments = 6
    [[step]]
    factor = { push = 1.5 }
    increments = 6";

/// The pushes of [`LOOP`] in N: the traction's force on the node is 1.
fn pushes() -> Vec<f64> {
    let mut pushes = vec![0.0];
    for (from, to) in [(0.0, 1.5), (1.5, -1.5), (-1.5, 1.5)] {
        pushes.extend((1..=6).map(|j| from + (to - from) * f64::from(j) / 6.0));
    }
    pushes
}

/// Equilibrium k u + λ = f with |λ| ≤ F P, in backward differences: the node sticks at its place while it can, and slides
/// to where friction holds it otherwise, f − k u = ± P F(s) with s linear in the slip, F = f₀ − c s.
fn closed_form(f0: f64, c: f64, slip: impl Fn(f64, f64, f64) -> (f64, f64)) -> Vec<[f64; 3]> {
    let (mut u, mut path) = (0.0, 0.0);
    let mut found = Vec::new();
    for force in pushes() {
        // s = a + b |Δu| for the slip that the law follows.
        let trial = force - SHEAR * u;
        let direction = f64::signum(trial);
        let (a, b) = slip(u, path, direction);
        let increment = |[a, b]: [f64; 2]| {
            let excess = trial.abs() - PRESS * (f0 - c * a);
            excess.max(0.0) / (SHEAR - PRESS * c * b)
        };
        // A slip that falls on the way to zero grows again beyond it.
        let increment = match increment([a, b]) {
            inwards if b < 0.0 && inwards > a => increment([-a, 1.0]),
            increment => increment,
        };
        u += direction * increment;
        path += increment;
        let stress = force - SHEAR * u;
        found.push([u, stress, stress * direction * increment]);
    }
    found
}

fn compare(scene: Scene, expected: &[[f64; 3]]) -> SolvedProblem {
    let history = solved(scene);
    assert_eq!(history.records.len(), expected.len());
    for (record, [u, force, dissipated]) in history.records.iter().zip(expected) {
        assert!(record.status.is_solved(), "{:?}", record.status);
        // Some ten roundings of numbers near 1.
        let close = |found: f64, expected: f64| (found - expected).abs() < 1e-13;
        assert!(
            close(displacement(record), *u),
            "{} {u}",
            displacement(record)
        );
        assert!(close(record.multiplier_force[1], *force));
        assert!(close(record.energies.dissipation, *dissipated));
        assert!(close(record.multiplier_force[0], PRESS));
    }
    history
}

const CONSTANT: &str = "friction.coefficient.constant = 0.3";

#[test]
fn one_node_loads_unloads_and_reloads_as_by_hand() {
    let expected = closed_form(0.3, 0.0, |_, _, _| (0.0, 0.0));
    // It slides in both directions, and sticks between.
    let slides = expected.windows(2).filter(|pair| pair[0][0] != pair[1][0]);
    assert!((6..16).contains(&slides.count()));
    let history = compare(one_node(CONSTANT, LOOP), &expected);
    // The last two pushes differ by a whole loop: its area is what friction took, 4 F P (u_max − F P/k … ) by hand.
    let whole: f64 = history.records[7..]
        .iter()
        .map(|r| r.energies.dissipation)
        .sum();
    let half_way = (1.5 - 2.0 * 0.6 + 1.5) / SHEAR;
    assert!((whole - 2.0 * 0.6 * half_way).abs() < 1e-13, "{whole}");
}

/// The coefficient falls along the whole path, with |u|, or with the slip of each increment.
#[test]
fn coefficients_follow_the_slip_that_the_scene_says() {
    let law = |follows: &str| {
        format!(
            "friction = {{ coefficient = {{ expression = '0.3 - 0.2*s' }}, follows = '{follows}' }}"
        )
    };
    let path = closed_form(0.3, 0.2, |_, path, _| (path, 1.0));
    compare(one_node(&law("path-length"), LOOP), &path);
    let step = closed_form(0.3, 0.2, |_, _, _| (0.0, 1.0));
    compare(one_node(&law("step-slip"), LOOP), &step);
    let total = closed_form(0.3, 0.2, |u, _, direction| {
        let outwards = u * direction >= 0.0;
        (u.abs(), if outwards { 1.0 } else { -1.0 })
    });
    compare(one_node(&law("total-slip"), LOOP), &total);
    assert!(total.windows(2).any(|pair| pair[0][0] * pair[1][0] < 0.0));
    assert!(path.last() != step.last() && path.last() != total.last());
}

/// Under a load that only grows, one step does what many do.
#[test]
fn halving_the_steps_of_a_growing_load_changes_nothing_for_one_node() {
    let ends: Vec<f64> = [1, 2, 4, 8, 16]
        .map(|increments| {
            let steps =
                format!("step = [{{ factor = {{ push = 1.5 }}, increments = {increments} }}]");
            // The weight grows with the push, so the node slides all along or never.
            displacement(
                solved(one_node(CONSTANT, &steps))
                    .records
                    .last()
                    .expect("steps"),
            )
        })
        .to_vec();
    for end in &ends {
        assert!((end - (1.5 - 0.6) / SHEAR).abs() < 1e-14, "{ends:?}");
    }
}

fn block(steps: &str, settings: &str) -> Scene {
    let text = format!(
        "title = 'block'
         body.brick = {{ size = [3.0, 1.0, 1.0], cells = [6, 2, 2] }}
         material.isotropic = {{ young_modulus = 2.1e11, poisson_ratio = 0.3 }}
         clamp = [{{ face = 'x_min' }}]
         contact = {{ face = 'z_min', gap = '1e-7*x' }}
         pressure = [{{ name = 'press', face = 'z_max', value = 2e7 }}]
         traction = [{{ name = 'pull', face = 'x_max', value = [1e7, '2e6*y', 0.0] }}]
         friction.coefficient_1.expression = '0.3*(0.7 + 0.3*exp(-s1/1e-5))'
         friction.coefficient_2.expression = '0.2*(0.7 + 0.3*exp(-s2/1e-5))'
         {settings}
         {steps}"
    );
    Scene::parse("block", &text).unwrap_or_else(|error| panic!("{error:?}"))
}

#[test]
fn a_history_of_one_step_is_the_static_answer_to_the_bit() {
    let fixed_point = "solve = { method = 'fixed-point', epsilon = 1e-8 }";
    let implicit = "assemble.dual_operator = 'implicit'";
    for settings in ["", fixed_point, implicit] {
        let problem = assembled(block("", settings));
        let settings_of = problem.scene().solve.clone();
        let expected = problem.solve(&settings_of).expect("a solution");
        let report = problem.report(&expected).expect("a report");
        let found = solved(block("[[step]]\ntitle = 'the only one'", settings));
        assert_eq!(found.solution.multiplier, expected.multiplier);
        assert_eq!(found.solution.displacement, expected.displacement);
        assert_eq!(found.solution.status, expected.status);
        assert_eq!(found.report.panes, report.panes);
        assert_eq!(found.report.resultants, report.resultants);
        assert_eq!(found.report.certificate, report.certificate);
    }
}

const CYCLE: &str = "
    [[step]]
    title = 'press'
    factor = { pull = 0.0 }
    [[step]]
    title = 'pull'
    factor = { pull = 1.0 }
    increments = 2
    [[step]]
    title = 'push'
    factor = { pull = -0.5, 'contact.gap' = 0.5 }
    [[step]]
    title = 'let go'
    value = { pull = [0.0, 3e6, 0.0], press = '1e7*(1 + x/3)' }
    increments = 2";

/// Newton's method, successive approximations and the implicit operator take the same path, and every answer satisfies the
/// conditions of its own step.
#[test]
fn all_methods_take_the_same_path() {
    let reference = solved(block(CYCLE, ""));
    assert_eq!(reference.records.len(), 6);
    for follows in ["total-slip", "step-slip", "path-length"] {
        let law = format!("friction.follows = '{follows}'");
        let reference = solved(block(CYCLE, &law));
        for record in &reference.records {
            // Newton's answers are exact to rounding.
            assert!(record.certificate < 1e-10, "{}", record.certificate);
            // Where the whole face sticks it vanishes to rounding.
            let energies = &record.energies;
            assert!(energies.dissipation >= -1e-14 * energies.strain);
        }
        for settings in [
            "solve = { method = 'fixed-point', epsilon = 1e-9 }",
            "assemble.dual_operator = 'implicit'\nsolve.epsilon = 1e-9",
            "assemble.factor = 'single'",
        ] {
            let other = solved(block(CYCLE, &format!("{law}\n{settings}")));
            for (a, b) in reference.records.iter().zip(&other.records) {
                let largest = a.multiplier.iter().fold(0.0_f64, |m, l| m.max(l.abs()));
                for (x, y) in a.multiplier.iter().zip(&b.multiplier) {
                    // epsilon, times what the path before adds to it.
                    assert!((x - y).abs() < 1e-6 * largest, "{settings}: {x} {y}");
                }
            }
        }
    }
}

/// Work of the loads, strain energy, work on the foundation and dissipation: without friction they balance to rounding, and
/// with it the difference falls with the increments.
#[test]
fn energies_balance() {
    let cycle = |n: usize, friction: &str| {
        let steps = format!(
            "step = [{{ factor = {{ pull = 0.0 }}, increments = {n} }},
                     {{ factor = {{ pull = 1.0 }}, increments = {n} }},
                     {{ factor = {{ pull = -1.0 }}, increments = {n} }}]"
        );
        let mut scene = block(&steps, "");
        if friction.is_empty() {
            scene.friction = None;
        } else {
            scene.friction = Some(contact3d::scene::Friction::coulomb(0.3));
        }
        let history = solved(scene);
        let sum = |of: &dyn Fn(&StepRecord) -> f64| history.records.iter().map(of).sum::<f64>();
        [
            sum(&|r| r.energies.load_work),
            sum(&|r| r.energies.dissipation),
            sum(&|r| r.energies.imbalance),
        ]
    };
    let [work, dissipation, imbalance] = cycle(2, "");
    assert_eq!(dissipation, 0.0);
    // Sums over some hundred nodes.
    assert!(imbalance.abs() < 1e-12 * work, "{imbalance} of {work}");
    let shares: Vec<f64> = [4, 8, 16]
        .map(|n| {
            let [_, dissipation, imbalance] = cycle(n, "Coulomb");
            imbalance.abs() / dissipation
        })
        .to_vec();
    // Of first order: each halving about halves it.
    assert!(shares[2] < 0.1 && shares[1] / shares[2] > 1.5, "{shares:?}");
}

/// A step that no method solves ends the history with its status.
#[test]
fn a_step_without_an_answer_ends_the_history() {
    let mut scene = block(CYCLE, "");
    scene.solve = SolveSettings {
        method: Method::FixedPoint,
        max_outer_steps: 3,
        ..SolveSettings::default()
    };
    let history = solved(scene);
    assert_eq!(history.records.len(), 1);
    assert!(!history.solution.status.is_solved());
}

/// A block on soft springs and a round foundation, loaded, unloaded and loaded again: without load it rests without any force, and what it
/// bears the second time is what it bore the first. Without steps and load it is left where it is.
#[test]
fn unloading_ends_no_history() {
    for held in [
        "",
        "spring = [{ face = 'z_max', normal = 1e3, tangential = 1e3 }]",
    ] {
        let text = |value: f64, steps: &str| {
            format!(
                "title = 'unloaded'
                 body.brick = {{ size = [0.2, 0.2, 0.1], cells = [4, 4, 2] }}
                 material.isotropic = {{ young_modulus = 1e8, poisson_ratio = 0.3 }}
                 pressure = [{{ name = 'press', face = 'z_max', value = {value:?} }}]
                 contact.face = 'z_min'
                 contact.obstacle.cylinder = {{ point = [0.1, 0.1, -5.0], direction = [1.0, 0.0, 0.0], radius = 5.0 }}
                 friction.coefficient.constant = 0.3
                 {held}
                 {steps}"
            )
        };
        let steps = "step = [{}, { factor.press = 0.0 }, { factor.press = 1.0 }]";
        let scene = Scene::parse("unloaded", &text(1e4, steps)).expect("a scene");
        let run = solved(scene);
        let forces: Vec<f64> = run.records.iter().map(|it| it.contact_force[2]).collect();
        assert!(forces.len() == 3 && forces[1] == 0.0, "{held} {forces:?}");
        let force = 1e4 * 0.04;
        // Springs take their share, at most of the order of their stiffness over that of the contact.
        assert!(
            (forces[0] - force).abs() < 0.01 * force,
            "{held} {forces:?}"
        );
        // Friction brings panes to rest at other slips, within its share of the force.
        assert!(
            (forces[2] - forces[0]).abs() < 1e-6 * force,
            "{held} {forces:?}"
        );
        assert!(
            run.records[1]
                .displacement
                .as_flattened()
                .iter()
                .all(|u| *u == 0.0)
        );

        let still = assembled(Scene::parse("unloaded", &text(0.0, "")).expect("a scene"));
        let solution = still.solve(&SolveSettings::default()).expect("S is dense");
        assert!(solution.status.is_solved() && solution.displacement.iter().all(|u| *u == 0.0));
    }
}

/// Two blocks that stick without pressure, sheared and brought back: they return; those that slid are held back by the same friction.
#[test]
fn blocks_without_pressure_come_back() {
    // Free sides take a fifth or so of Gγ.
    let stuck = -0.8 * 1e9 / 2.62 * 1e-3;
    for (bound, force, near) in [
        (1e6, [stuck, 0.0], [0.1 * -stuck, 1e-6]),
        (1e5, [-1e5, 1e5], [1e2; 2]),
    ] {
        let text = format!(
            "title = 'sheared'
             body = [
                 {{ name = 'a', brick = {{ size = [1.0, 1.0, 0.5], cells = [4, 4, 2] }} }},
                 {{ name = 'b', origin = [0.0, 0.0, 0.5], brick = {{ size = [1.0, 1.0, 0.5], cells = [4, 4, 2] }} }},
             ]
             material.isotropic = {{ young_modulus = 1e9, poisson_ratio = 0.31 }}
             clamp = [{{ face = 'a.z_min' }}, {{ name = 'c', face = 'b.z_max', value = [1e-3, 0.0, 0.0] }}]
             contact = {{ between = ['b.z_min', 'a.z_max'], friction.slip_bound = {bound:?} }}
             step = [{{ factor.c = 1.0 }}, {{ factor.c = 0.0 }}]"
        );
        let run = solved(Scene::parse("sheared", &text).expect("a scene"));
        let found: Vec<f64> = run.records.iter().map(|it| it.contact_force[0]).collect();
        assert!(run.solution.status.is_solved() && found.len() == 2);
        // Panes that slide a little aside bear a thousandth less along x.
        let close = |k: usize| (found[k] - force[k]).abs() < near[k];
        assert!(close(0) && close(1), "{bound} {found:?}");
    }
}

#[test]
fn a_scene_with_steps_has_no_single_answer() {
    let problem = assembled(block(CYCLE, ""));
    let refused = problem.solve(&SolveSettings::default()).unwrap_err();
    assert!(refused.to_string().contains("history"), "{refused}");
}

#[test]
fn bad_histories_are_refused_with_the_key() {
    let refused = |steps: &str| {
        let text = block("", "").to_toml().expect("text") + steps;
        Scene::parse("bad", &text).expect_err(steps).to_string()
    };
    for (steps, key, found) in [
        (
            "[[step]]\nfactor = { shove = 1.0 }",
            "step.0.factor.shove",
            "\"press\"",
        ),
        (
            "[[step]]\nvalue = { press = [1.0, 2.0, 3.0] }",
            "step.0.value.press",
            "one number",
        ),
        (
            "[[step]]\nvalue = { pull = 1.0 }",
            "step.0.value.pull",
            "three numbers",
        ),
        ("[[step]]\ntime = 1.0\n[[step]]", "step.1.time", "none"),
        (
            "[[step]]\ntime = 1.0\n[[step]]\ntime = 1.0",
            "step.1.time",
            "after 1.0",
        ),
        ("[[step]]\ntime = 0.0", "step.0.time", "after 0"),
        (
            "[[step]]\nincrements = 0",
            "step.0.increments",
            "at least 1",
        ),
        (
            "[[step]]\nincrements = 1000000",
            "step.0.increments",
            "100000",
        ),
        (
            "[[step]]\nfactor = { press = nan }",
            "step.0.factor.press",
            "finite",
        ),
        (
            "[[step]]\nvalue = { 'contact.gap' = -1.0 }",
            "step.0",
            "gap",
        ),
    ] {
        let message = refused(steps);
        assert!(
            message.contains(key) && message.contains(found),
            "{steps}: {message}"
        );
    }
    let twice = Scene::parse(
        "bad",
        &block("", "")
            .to_toml()
            .expect("text")
            .replace("name = \"pull\"", "name = \"press\""),
    );
    assert!(twice.unwrap_err().to_string().contains("no other load"));
    let mut scene = block("", "");
    scene.friction.as_mut().expect("friction").follows = contact3d::scene::SlipMeasure::PathLength;
    assert!(scene.validate().unwrap_err().key == "friction.follows");
    scene.steps.push(Step::default());
    assert!(scene.validate().is_ok());
}

/// From the records of any number of increments the others follow with the same bits.
#[test]
fn going_on_gives_the_same_bits_after_every_increment() {
    for settings in [
        "friction.follows = 'path-length'",
        "solve = { method = 'fixed-point', epsilon = 1e-8 }",
        "assemble.dual_operator = 'implicit'",
    ] {
        let problem = assembled(block(CYCLE, settings));
        let from = |records: Vec<StepRecord>| {
            let settings = &problem.scene().solve;
            let start = Start::default();
            let solved = problem.run(settings, start, records, &mut InMemory);
            solved.expect("a history").records
        };
        let whole = from(Vec::new());
        for done in 1..=whole.len() {
            assert_eq!(from(whole[..done].to_vec()), whole, "{settings}, {done}");
        }
    }
}

/// A block whose upper face is moved to and fro: its reactions are the loads that would do the same, and their work balances.
#[test]
fn clamps_move_in_steps_and_their_work_counts() {
    let scene = |friction: &str, n: usize| {
        let text = format!(
            "title = 'sheared'
             body.brick = {{ size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }}
             material.isotropic = {{ young_modulus = 2e5, poisson_ratio = 0.3 }}
             clamp = [{{ name = 'top', face = 'z_max', value = [0.002, 0.0, -0.001] }}]
             contact.face = 'z_min'
             {friction}
             step = [{{ value = {{ top = [0.0, 0.0, -0.001] }}, increments = {n} }},
                     {{ value = {{ top = [0.002, 0.0, -0.001] }}, increments = {n} }},
                     {{ value = {{ top = [-0.002, 0.0, -0.001] }}, increments = {n} }},
                     {{ factor = {{ top = 0.0 }}, increments = {n} }}]"
        );
        Scene::parse("sheared", &text).unwrap_or_else(|error| panic!("{error:?}"))
    };
    let sums = |records: &[StepRecord]| {
        let energies = records.iter().map(|record| record.energies);
        energies.fold([0.0; 3], |[work, dissipated, missing], e| {
            [
                work + e.load_work,
                dissipated + e.dissipation,
                missing + e.imbalance,
            ]
        })
    };
    let smooth = solved(scene("", 2)).records;
    let [_, _, missing] = sums(&smooth);
    let largest = smooth.iter().map(|r| r.energies.strain).fold(0.0, f64::max);
    // Sums over some hundred nodes.
    assert!(missing.abs() < 1e-12 * largest, "{missing} of {largest}");
    let rough = solved(scene("friction.coefficient.constant = 0.2", 8)).records;
    for record in &rough {
        assert!(record.status.is_solved() && record.certificate < 1e-10);
        // The holder and the foundation balance each other.
        for c in 0..3 {
            let sum = record.loaded_force[c] + record.contact_force[c];
            assert!(
                sum.abs() < 1e-10 * record.multiplier_force[0].max(1.0),
                "{sum}"
            );
        }
    }
    let [work, dissipated, missing] = sums(&rough);
    // All that was put in is dissipated: the body is unloaded in the end but for what friction holds.
    assert!(dissipated > 0.5 * work && missing.abs() < 0.1 * dissipated);
    // The mean displacement of the top is what the steps say.
    let tops: Vec<f64> = rough.iter().map(|r| r.loaded_displacement[0]).collect();
    assert!(
        (tops[15] - 0.002).abs() < 1e-15 && (tops[11] - 0.001).abs() < 1e-15,
        "{tops:?}"
    );
}

/// Two faces with laws of their own: what each takes adds up, and the greased one takes less.
#[test]
fn every_face_has_its_share_of_the_dissipation() {
    let text = "title = 'two plates'
         body.brick = { size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }
         material.isotropic = { young_modulus = 2e5, poisson_ratio = 0.3 }
         clamp = [{ face = 'x_min', components = ['y'] }, { name = 'pull', face = 'x_max' }]
         pressure = [{ face = 'y_min', value = 1.0 }]
         body_force.value = [0.0, 0.0, -400.0]
         contact = [
           { face = 'z_min', friction = { coefficient = { constant = 0.3 }, follows = 'path-length' } },
           { face = 'y_max', gap = 1e-5, friction = { coefficient = { constant = 0.05 }, follows = 'path-length' } }]
         step = [{}, { value = { pull = [0.01, 0.0, 0.0] }, increments = 3 },
                 { value = { 'contact.1.gap' = 0.0 } }, { value = { pull = [-0.01, 0.0, 0.0] }, increments = 3 }]";
    let scene = Scene::parse("two plates", text).unwrap_or_else(|error| panic!("{error:?}"));
    let history = solved(scene);
    assert_eq!(history.records.len(), 8);
    let mut sums = [0.0; 2];
    for record in &history.records {
        assert!(record.status.is_solved() && record.certificate < 1e-9);
        let [dry, greased] = record.face_dissipation[..] else {
            panic!("two faces")
        };
        // The same numbers, added in another order.
        let whole = record.energies.dissipation;
        assert!((dry + greased - whole).abs() <= 1e-15 * whole.abs());
        sums = [sums[0] + dry, sums[1] + greased];
    }
    assert!(sums[0] > sums[1] && sums[1] >= 0.0, "{sums:?}");
}
