//! The hard cases hold at a coarse size, and problems whose solutions are known in closed form.

use std::sync::LazyLock;

use crate::support::pipelines;
use contact3d::{
    dual::{DualSystem, ExplicitDual},
    linalg::Precision,
    scene::{DualOperatorKind, FactorPrecision, InnerSolver, Method, Scene, SceneFile},
    solver::{ContactProblem, ContactSide, Linearisation, Solution, Start, Status},
};
use contact3d_pipe::{StabilityRow, SuiteCase, read_suite};
use studies::stability::VerdictLevel;

/// λ, μ of the one- and two-node bodies, in Pa.
const LAME: [f64; 2] = [1.5, 1.0];

fn hard_cases() -> Vec<SuiteCase> {
    let cases = read_suite(&pipelines().join("hard/suite.toml"), true);
    cases.unwrap_or_else(|error| panic!("{error}"))
}

/// The hard cases, checked once for the tests that read what came of them.
static CHECKED: LazyLock<Vec<StabilityRow>> = LazyLock::new(|| {
    hard_cases()
        .iter()
        .map(|case| case.check(&mut |_| {}))
        .collect()
});

#[test]
fn hard_cases_hold_but_for_those_known_to_be_open() {
    assert!(CHECKED.len() >= 45);
    for row in CHECKED.iter() {
        let check = row.outcome.as_ref();
        let check = check.unwrap_or_else(|reason| panic!("{}: {reason}", row.name));
        let verdict = check.verdict();
        let fails = verdict.level == VerdictLevel::Fail;
        assert_eq!(fails, !row.open.is_empty(), "{}: {verdict}", row.name);
        // Of an open case, too, whatever its conditioning.
        for result in check.invariances.iter().filter(|r| r.invariance.is_exact()) {
            let (name, change) = (&row.name, result.invariance);
            assert!(
                result.difference == 0.0,
                "{name}, {change:?}: {:e}",
                result.difference
            );
        }
        // (3.1) of HKL.
        assert!(check.conditioning.dual.smallest > 0.0, "{}", row.name);
    }
}

/// Too ill-conditioned for 24 bits: thin, slender or stretched bodies, and soft springs. `auto` takes double precision there.
const MOST_REFUSED: usize = 7;

#[test]
fn a_factor_in_single_precision_gives_the_answers_of_double_or_none() {
    let mut refused = 0;
    for mut case in hard_cases() {
        case.scene.scene.assemble.factor = FactorPrecision::Single;
        let row = case.check(&mut |_| {});
        let Ok(check) = row.outcome else {
            refused += 1;
            continue;
        };
        assert_eq!(check.precision, Precision::Single);
        // It holds the answer against those of other algorithms with a factor in double precision.
        let verdict = check.verdict();
        assert!(
            verdict.level != VerdictLevel::Fail,
            "{}: {verdict}",
            row.name
        );
    }
    assert!(refused <= MOST_REFUSED, "{refused} cases have no factor");
}

/// What the zones of a load case must be: open, sticking, slipping.
#[test]
fn zones_of_the_pure_loads_are_pure() {
    let zones = |name: &str| {
        let row = CHECKED.iter().find(|row| row.name == name);
        let outcome = &row.expect("a case of the suite").outcome;
        outcome.as_ref().expect("a discrete problem").zones
    };
    assert_eq!(zones("no load")[2], 0);
    assert_eq!(zones("pure lift-off")[1..], [0, 0]);
    assert_eq!(zones("pure pressing")[2], 0);
    assert!(zones("pure pressing")[1] > 0);
    assert_eq!(zones("pure shear")[1], 0);
    assert!(zones("pure shear")[2] > 0);
}

/// A problem of `pipelines/hard` with its dense operator.
struct Small {
    scene: Scene,
    mesh: contact3d::mesh::Mesh,
    system: DualSystem,
    interface: contact3d::contact::Interface,
}

impl Small {
    fn new(name: &str, friction: f64, traction: [f64; 3]) -> Self {
        let file = SceneFile::read(&pipelines().join("hard").join(name)).unwrap();
        let text = file.scene.to_toml().unwrap();
        let mut table: toml::Table = text.parse().unwrap();
        table["friction"]["coefficient"]["constant"] = friction.into();
        table["traction"][0]["value"] = traction.to_vec().into();
        let mut scene = file.changed("a load", &table.to_string()).unwrap().scene;
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        let mesh = contact3d::mesh::Mesh::of_scene(&scene, &file.folder).unwrap();
        let interface = contact3d::contact::Interface::new(&scene, &mesh);
        Self {
            system: DualSystem::new(&scene, &mesh).unwrap(),
            interface: interface.unwrap().unwrap(),
            mesh,
            scene,
        }
    }

    fn contact(&self) -> ContactSide<'_> {
        ContactSide {
            surface: self.mesh.contact.as_ref().unwrap(),
            interface: &self.interface,
        }
    }

    fn dual(&self) -> &ExplicitDual {
        let contact = self.system.contact.as_ref().unwrap();
        contact.explicit().unwrap()
    }

    fn solve(&self, method: Method, inner: InnerSolver) -> Solution {
        let mut settings = self.scene.solve.clone();
        (settings.method, settings.inner, settings.epsilon) = (method, inner, Some(1e-12));
        let contact = ContactProblem::new(&self.system, self.contact()).unwrap();
        contact
            .solve(&settings, Start::default(), &mut |_| {})
            .unwrap()
    }

    fn linearise(&self, multiplier: &[f64]) -> Linearisation {
        Linearisation::new(self.dual(), &self.contact().laws(), multiplier)
    }
}

/// One node under the force (l_t, l_ν), with the stiffness of its plane and the area of its pane.
struct OneNode {
    tt: f64,
    tn: f64,
    area: f64,
    load: [f64; 2],
}

/// The tetrahedron (0,0,0), (1,−1,0), (1,1,0), (3,0,1): the hat function of its free corner has the
/// gradient (−1, 0, 2), so A = V (μ |g|² I + (λ + μ) g gᵀ) with V = 1/3; along t₁ = x and
/// ν = −z, g = (−1, −2). The loaded faces are (0,0,0), (3,0,1) and either of the others.
impl OneNode {
    fn new(traction: [f64; 3]) -> Self {
        let [lambda, mu] = LAME;
        let volume = 1.0 / 3.0;
        // |(3,0,1) × (1,∓1,0)| / 2 = √(1 + 1 + 9) / 2 each, a third of which comes to the node.
        let share = 2.0 * 11.0_f64.sqrt() / 2.0 / 3.0;
        Self {
            tt: volume * (5.0 * mu + (lambda + mu)),
            tn: volume * 2.0 * (lambda + mu),
            area: 1.0 / 3.0,
            load: [share * traction[0], -share * traction[2]],
        }
    }

    /// λ = (λ_ν, λ_t1, λ_t2) in Pa from contact forces in N.
    fn multiplier(&self, normal: f64, tangential: f64) -> Vec<f64> {
        vec![normal / self.area, tangential / self.area, 0.0]
    }

    fn sticking(&self) -> Vec<f64> {
        self.multiplier(self.load[1], self.load[0])
    }

    /// Sliding along ±t₁ under λ_t = ±F λ_ν and u_ν = 0.
    fn sliding(&self, friction: f64, sign: f64) -> (f64, Vec<f64>) {
        let [along, across] = self.load;
        let slip = (along - sign * friction * across) / (self.tt - sign * friction * self.tn);
        let normal = across - self.tn * slip;
        (slip, self.multiplier(normal, sign * friction * normal))
    }
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>().sqrt();
    norm(&mut x.iter().zip(y).map(|(x, y)| x - y)) / norm(&mut y.iter().copied()).max(1e-300)
}

/// Sticking, sliding and open solutions for F between 1.5 and 3 times the load's inclination: each
/// is one to the program too, with the sign of det R' that a_tt − F a_tν gives, and one is found.
#[test]
fn one_node_with_three_solutions() {
    let traction = [2e-3, 0.0, -1e-3];
    let small = Small::new("one_node.toml", 3.0, traction);
    let node = OneNode::new(traction);
    // Two roundings.
    assert!((node.tt / node.tn - 1.5).abs() < 1e-15);
    let (slip, sliding) = node.sliding(3.0, 1.0);
    assert!(slip > 0.0 && sliding[0] > 0.0);
    let solutions = [(node.sticking(), 1), (sliding, -1), (vec![0.0; 3], 1)];
    for (multiplier, sign) in &solutions {
        let linearisation = small.linearise(multiplier);
        // A dozen roundings of numbers of the size of the multipliers.
        assert!(linearisation.residual < 1e-14, "{linearisation:?}");
        assert_eq!(linearisation.determinant_sign, *sign);
    }
    let indices: i8 = solutions.iter().map(|(_, sign)| sign).sum();
    assert_eq!(indices, 1);
    for inner in [InnerSolver::Newton, InnerSolver::Gpcg, InnerSolver::Kprgp] {
        for method in [Method::Newton, Method::FixedPoint] {
            let found = small.solve(method, inner);
            assert_eq!(found.status, Status::Converged);
            let nearest = solutions
                .iter()
                .map(|(known, _)| distance(&found.multiplier, known));
            // ε = 1e-12 times ‖R'⁻¹‖, below 10.
            assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-11);
        }
    }
}

/// Pushed the other way the solution is one, but λ_ν ↦ λ_ν − (a_tν/a_tt) F g has a slope below −1.
#[test]
fn successive_approximations_that_cycle_are_recognised() {
    let traction = [-4e-3, 0.0, -1e-3];
    let small = Small::new("one_node.toml", 3.0, traction);
    let (slip, expected) = OneNode::new(traction).sliding(3.0, -1.0);
    assert!(slip < 0.0);
    let newton = small.solve(Method::Newton, InnerSolver::Newton);
    assert_eq!(newton.status, Status::Converged);
    // ε = 1e-12 times ‖R'⁻¹‖, below 10.
    assert!(distance(&newton.multiplier, &expected) < 1e-11);
    let linearisation = small.linearise(&expected);
    assert_eq!(linearisation.determinant_sign, 1);
    // λ_ν moves by F S_νt / S_νν for each unit of a frozen bound; rounding in systems of order three.
    let column = |j| small.dual().column(j);
    let closed = 3.0 * (column(1)[0] / column(0)[0]).abs();
    assert!((linearisation.contraction / closed - 1.0).abs() < 1e-12);
    assert!(closed > 1.0);
    for inner in [InnerSolver::Newton, InnerSolver::Gpcg, InnerSolver::Kprgp] {
        let found = small.solve(Method::FixedPoint, inner);
        assert_eq!(found.status, Status::Cycling);
        assert!(found.trace.history.len() < 40);
    }
}

/// What a node of the plane problem does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Open,
    Stick,
    Slide(f64),
}

/// All solutions of the problem of two nodes: for each of 16 pairs of states one linear system in
/// (λ_ν, λ_t1) of both, kept when it has the signs that the states ask for. Entries of S and h come
/// from the program; the conditions do not.
fn enumerate(dual: &ExplicitDual, friction: f64) -> Vec<Vec<f64>> {
    // λ_ν of both nodes, then pairs; λ_t2 is held.
    const UNKNOWNS: [usize; 4] = [0, 1, 2, 4];
    let states = [
        State::Open,
        State::Stick,
        State::Slide(1.0),
        State::Slide(-1.0),
    ];
    let pairs = states
        .iter()
        .flat_map(|a| states.iter().map(move |b| [*a, *b]));
    let solution = |states: [State; 2]| {
        let mut matrix = nalgebra::Matrix4::zeros();
        let mut rhs = nalgebra::Vector4::zeros();
        let s = |i: usize, j: usize| dual.column(UNKNOWNS[j])[UNKNOWNS[i]];
        for (node, state) in states.into_iter().enumerate() {
            let (normal, along) = (node, 2 + node);
            for (row, kinematic) in [
                (normal, state != State::Open),
                (along, state == State::Stick),
            ] {
                if kinematic {
                    (0..4).for_each(|j| matrix[(row, j)] = s(row, j));
                    rhs[row] = dual.rhs[UNKNOWNS[row]];
                } else {
                    matrix[(row, row)] = 1.0;
                }
            }
            if let State::Slide(sign) = state {
                matrix[(along, normal)] = -sign * friction;
            }
        }
        let x = matrix.lu().solve(&rhs)?;
        // −r = h − S λ: closing and slip.
        let moved =
            |row: usize| dual.rhs[UNKNOWNS[row]] - (0..4).map(|j| s(row, j) * x[j]).sum::<f64>();
        let allowed = states
            .into_iter()
            .enumerate()
            .all(|(node, state)| match state {
                State::Open => moved(node) <= 0.0,
                State::Stick => x[node] >= 0.0 && x[2 + node].abs() <= friction * x[node],
                State::Slide(sign) => x[node] >= 0.0 && sign * moved(2 + node) > 0.0,
            });
        allowed.then(|| vec![x[0], x[1], x[2], 0.0, x[3], 0.0])
    };
    pairs.filter_map(solution).collect()
}

#[test]
fn two_nodes_with_five_solutions() {
    let traction = [2e-3, 0.0, -1e-3];
    for (friction, count) in [(0.3, 1), (3.0, 5)] {
        let small = Small::new("two_nodes.toml", friction, traction);
        let solutions = enumerate(small.dual(), friction);
        assert_eq!(solutions.len(), count, "F = {friction}");
        let mut indices = 0;
        for multiplier in &solutions {
            let linearisation = small.linearise(multiplier);
            // Some dozen roundings, times the condition of S.
            assert!(linearisation.residual < 1e-13, "{linearisation:?}");
            indices += i32::from(linearisation.determinant_sign);
        }
        // The degree of R, which is the same for every F.
        assert_eq!(indices, 1);
        let found = small.solve(Method::Auto, InnerSolver::Newton);
        assert_eq!(found.status, Status::Converged);
        let distances = solutions.iter().map(|s| distance(&found.multiplier, s));
        // ε = 1e-12 times ‖R'⁻¹‖, below 100.
        assert!(distances.fold(f64::INFINITY, f64::min) < 1e-10);
    }
}
