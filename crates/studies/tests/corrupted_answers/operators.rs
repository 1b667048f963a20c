//! Answers to a problem that is wrong by a known amount: another S, another h, another friction.

use std::sync::Arc;

use contact3d::{
    dual::ExplicitDual,
    post::Zone,
    scene::{InnerSolver, Method, PrecisionControl, Scene, SolveSettings},
    solver::{Solution, Status},
};
use studies::stability::VerdictLevel;

use crate::case::{Case, distance};

/// What is wrong with one row of S, or with one entry of h.
const WRONG: f64 = 1e-7;

/// How S or h is corrupted, at the pane that bears most.
#[derive(Debug, Clone, Copy)]
enum Wrong {
    Entry,
    Row,
    Rhs,
}

impl Wrong {
    const ALL: [Self; 3] = [Self::Entry, Self::Row, Self::Rhs];

    /// Corrupts the dual problem; returns by how much r = S λ − h of that pane is wrong at the
    /// solution, in m³.
    fn apply(self, case: &mut Case) -> f64 {
        let pane = case.most_pressed();
        let multiplier = case.solution.multiplier.clone();
        let contact = case.problem.system.contact.as_mut();
        let contact = contact.expect("a contact face");
        let dual = contact.explicit_mut().expect("S is dense");
        let n = dual.dimension();
        let mut s = dual.operator.as_slice().to_vec();
        let before = row(dual, pane, &multiplier);
        match self {
            Self::Entry => s[pane * n + pane] *= 1.0 + WRONG,
            Self::Row => {
                for j in 0..n {
                    s[pane * n + j] *= 1.0 + WRONG;
                    s[j * n + pane] = s[pane * n + j];
                }
            }
            Self::Rhs => dual.rhs[pane] *= 1.0 + WRONG,
        }
        dual.operator = Arc::new(s);
        row(dual, pane, &multiplier) - before
    }
}

/// The component of S λ − h that belongs to a pane, in m³.
fn row(dual: &ExplicitDual, pane: usize, multiplier: &[f64]) -> f64 {
    let column = dual.column(pane).iter().zip(multiplier);
    column.map(|(s, l)| s * l).sum::<f64>() - dual.rhs[pane]
}

/// Algorithm 4.1 to 1e-10, far below what is wrong.
fn successive_approximations() -> SolveSettings {
    SolveSettings {
        method: Method::FixedPoint,
        inner: InnerSolver::Gpcg,
        precision: PrecisionControl::Fixed,
        epsilon: Some(1e-10),
        ..SolveSettings::default()
    }
}

fn solve(case: &Case, settings: &SolveSettings) -> Solution {
    case.problem.solve(settings).expect("S is dense")
}

/// A method that believes S and h is wrong by as much as they are, says so, and is rejected: where
/// S' λ' = h', the true residual of the pane is what S' and h' are off, and the certificate shows
/// it as a stress, times ρ.
#[test]
fn an_answer_to_a_wrong_dual_problem_is_rejected() {
    for name in ["hkl2011_table1.toml", "tresca.toml", "frictionless.toml"] {
        let case = Case::named(name);
        let clean = solve(&case, &successive_approximations());
        assert_eq!(clean.status, Status::Converged, "{name}");
        // A few times ε: the change of the last step, not the error.
        assert!(case.figure(&clean) < 1e-8, "{name}");
        assert!(distance(&clean.multiplier, &case.solution.multiplier) < 1e-8);
        for wrong in Wrong::ALL {
            let mut case = Case::named(name);
            let pane = case.most_pressed();
            let residual = wrong.apply(&mut case).abs();
            let stress = residual * case.solution.trace.local_stiffness[pane];
            let expected = 0.9 * stress / case.pressure();
            // ρ_i S_ii ≥ 1, so that a wrong diagonal alone shows in full.
            assert!(expected >= 0.8 * WRONG, "{name}, {wrong:?}: {expected:e}");
            let answer = solve(&case, &successive_approximations());
            let figure = case.figure(&answer);
            assert!(
                figure >= expected,
                "{name}, {wrong:?}: {figure:e} < {expected:e}"
            );
            assert_eq!(case.verdict_of_certificate(figure), VerdictLevel::Fail);
            assert_eq!(answer.status, Status::ReducedAccuracy, "{name}, {wrong:?}");
            // The error it reports, in another norm, is the distance to the true answer.
            let off = distance(&answer.multiplier, &case.solution.multiplier);
            let ratio = answer.accuracy / off;
            assert!((0.1..10.0).contains(&ratio), "{name}, {wrong:?}: {ratio}");
        }
    }
}

/// Newton's answer is polished with residuals of A and B, in which S counts only as a share of the
/// last step: wrong by 1e-7 it makes the last step wrong by 1e-7 of itself, and the answer stays
/// what it is.
#[test]
fn a_polished_answer_does_not_believe_a_wrong_dual_problem() {
    for name in ["hkl2011_table1.toml", "tresca.toml", "frictionless.toml"] {
        for wrong in Wrong::ALL {
            let mut case = Case::named(name);
            wrong.apply(&mut case);
            let answer = solve(&case, &SolveSettings::default());
            assert_eq!(answer.status, Status::Converged, "{name}, {wrong:?}");
            let off = distance(&answer.multiplier, &case.solution.multiplier);
            assert!(off < 1e-11, "{name}, {wrong:?}: {off:e}");
            let figure = case.figure(&answer);
            assert_ne!(case.verdict_of_certificate(figure), VerdictLevel::Fail);
        }
    }
}

/// The published law at 12 × 4 × 4 cells with other coefficients.
fn with_friction(coefficients: &str) -> Case {
    let text = include_str!("../../../../pipelines/hkl2011_table1.toml");
    let (body, rest) = text.split_once("# F1 falls").expect("the published scene");
    let (_, solve) = rest.split_once("[assemble]").expect("the published scene");
    let text =
        format!("{body}\n{coefficients}\n[assemble]{solve}").replace("48, 16, 16", "12, 4, 4");
    Case::of(Scene::parse("changed friction", &text).expect("a valid scene"))
}

/// F₁ of the published law, as a formula with a factor.
fn first(factor: &str) -> String {
    format!("max(0.2, 0.3 - 3000*max(s1 - 1e-5, 0))*{factor}")
}

/// The friction coefficient F₁ at one contact node 1e-4 too large: the answer to that law carries
/// too much tangential stress under this one. A pane sliding along t₁ bears λ_ν w 1e-4 more than it
/// may, for the weight w of the node in the mean of its pane.
#[test]
fn a_wrong_coefficient_at_one_node_is_rejected() {
    let true_law = Case::named("hkl2011_table1.toml");
    let pane = true_law.pane(Zone::Slip).expect("a slipping pane");
    let surface = true_law.surface();
    let (node, weight) = surface.pane_weights(pane).next().expect("a node");
    let [x, y, _] = true_law.problem.mesh().coordinates[surface.nodes[node]];
    let second =
        "coefficient_2.ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 1000.0 }";
    let law = |factor: &str| {
        let first = first(factor);
        with_friction(&format!(
            "[friction]\ncoefficient_1.expression = \"{first}\"\n{second}"
        ))
    };
    // The formula without the error is the published law.
    let same = law("1");
    let clean = true_law.figure(&same.solution);
    assert!(clean < 1e-11, "{clean:e}");
    // Nodes are 0.25 m apart: exp(−625) is nothing elsewhere.
    let wrong = law(&format!(
        "(1 + 1e-4*exp(-((x - {x})^2 + (y - {y})^2)/1e-4))"
    ));
    let friction = wrong.report.panes[pane].friction.expect("friction");
    let along = friction.stress[0].abs() / friction.stress[0].hypot(friction.stress[1]);
    assert!(along > 0.9, "the pane does not slide along t1: {along}");
    let expected = 0.5 * weight * 1e-4 * wrong.solution.multiplier[pane] / wrong.pressure();
    let report = true_law
        .problem
        .report(&wrong.solution)
        .expect("finite loads");
    let bound = report.certificate.friction_bound.expect("friction");
    assert!(bound >= expected, "{bound:e} < {expected:e}");
    assert_eq!(true_law.verdict_of_certificate(bound), VerdictLevel::Fail);
}

/// Friction that is not recomputed from the slip: the answer with F = F(0) = 0.3. A pane whose
/// nodes all slide further than 1e-5 + 0.1/3000 m along t₁ has F₁ = 0.2 and may carry two thirds of
/// what it does.
#[test]
fn friction_that_does_not_follow_the_slip_is_rejected() {
    let true_law = Case::named("hkl2011_table1.toml");
    let frozen = with_friction("[friction]\ncoefficient.constant = 0.3");
    let report = true_law
        .problem
        .report(&frozen.solution)
        .expect("finite loads");
    let dofs = &true_law.problem.system.assembly.primal.dofs;
    let displacement = dofs.to_nodes(&frozen.solution.displacement);
    let surface = true_law.surface();
    let slides = |pane: usize| {
        let mut nodes = surface.pane_weights(pane);
        // t₁ is the x axis.
        nodes.all(|(node, _)| displacement[surface.nodes[node]][0].abs() > 1e-5 + 0.1 / 3000.0)
    };
    let m = true_law.n_panes();
    let excess = (0..m).filter(|pane| slides(*pane)).map(|pane| {
        let along = frozen.solution.multiplier[m + 2 * pane].abs();
        along / 0.2 - frozen.solution.multiplier[pane]
    });
    let expected = 0.99 * excess.fold(0.0, f64::max) / frozen.pressure();
    assert!(expected > 0.1, "{expected}");
    let bound = report.certificate.friction_bound.expect("friction");
    assert!(bound >= expected);
    assert_eq!(true_law.verdict_of_certificate(bound), VerdictLevel::Fail);
}
