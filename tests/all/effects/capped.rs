//! Coulomb friction capped at a pressure, ‖F⁻¹σ_t‖ ≤ min(−σ_ν, p_cap), and the laws it becomes.

use contact3d::{
    dual::ExplicitDual,
    post::Zone,
    scene::{DualOperatorKind, InnerSolver, Method, PrecisionControl, Scene, SceneFile},
    solver::{SolvedBy, Status},
};

use super::{
    scenes::{CONTACT, RAMPS, distance, in_contact, steel},
    support::{Case, pipelines},
};

/// As for the other limits: residuals below 1e-12 ‖λ‖, conditioning of some tens.
const SAME: f64 = 1e-10;

/// A cap within the pressures of the usual loads, 0 to 5.2e7 Pa.
const CAP: f64 = 1e7;

/// A block that its own weight presses on the whole face, with 2.8e7 to 3.1e7 Pa, and pushes aside.
const PRESSED: &str = "
title = 'pressed block'
body.brick = { size = [3.0, 1.0, 1.0], cells = [12, 4, 4] }
clamp = [{ face = 'z_max' }]
material.isotropic = { young_modulus = 21.19e10, poisson_ratio = 0.277 }
body_force.value = [6e6, 1e6, -6e7]
contact.face = 'z_min'
";

/// The ramps of the published law, capped.
fn capped_ramps(cap: f64) -> String {
    format!("{RAMPS}\npressure_cap = {cap:e}\n")
}

/// A scene with other settings of the solver.
fn solved(text: &str, method: Method, inner: InnerSolver, operator: DualOperatorKind) -> Case {
    let mut scene = Scene::parse("test", text).unwrap();
    scene.solve.method = method;
    scene.solve.inner = inner;
    scene.solve.precision = PrecisionControl::Fixed;
    scene.solve.epsilon = Some(1e-12);
    scene.assemble.dual_operator = operator;
    Case::new(scene)
}

/// Every method, each with the error that it may leave.
fn all_methods(text: &str) -> [(Case, f64); 4] {
    use DualOperatorKind::{Explicit, Implicit};
    [
        (Method::Newton, InnerSolver::Newton, Explicit, SAME),
        (Method::FixedPoint, InnerSolver::Newton, Explicit, SAME),
        (Method::FixedPoint, InnerSolver::Gpcg, Explicit, 1e-8),
        (Method::Auto, InnerSolver::Gpcg, Implicit, 1e-8),
    ]
    .map(|(method, inner, operator, same)| (solved(text, method, inner, operator), same))
}

fn pressures(case: &Case) -> Vec<f64> {
    let panes = case.report().panes;
    panes.iter().map(|pane| -pane.normal_stress).collect()
}

/// A cap that no iterate reaches is not seen by any number; one above the pressures of the solution, which
/// iterates may pass, changes it by rounding.
#[test]
fn a_cap_above_all_pressures_is_none() {
    let uncapped = steel(&[CONTACT, RAMPS]);
    let unseen = steel(&[CONTACT, &capped_ramps(1e300)]);
    assert_eq!(unseen.solution.multiplier, uncapped.solution.multiplier);
    assert_eq!(unseen.solution.displacement, uncapped.solution.displacement);
    assert_eq!(unseen.report().panes, uncapped.report().panes);
    let largest = pressures(&uncapped).into_iter().fold(0.0, f64::max);
    let above = steel(&[CONTACT, &capped_ramps(1.01 * largest)]);
    let difference = distance(&above.solution.multiplier, &uncapped.solution.multiplier);
    // Converged to 1e-12 in a norm over both parts of the multipliers.
    assert!(difference < 1e-12, "{difference:e}");
}

/// Where every pane is pressed harder than the cap, the bound is given: Tresca's law.
#[test]
fn a_cap_below_all_pressures_is_a_given_slip_bound() {
    let coefficients = "coefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n";
    let cap = 2.2e7;
    let tresca = format!("{PRESSED}\n[friction]\nslip_bound = {cap:e}\n{coefficients}");
    let tresca = Case::of(&tresca);
    assert_eq!(tresca.solution.trace.solved_by, SolvedBy::Minimisation);
    assert_eq!(tresca.solution.status, Status::Converged);
    assert!(pressures(&tresca).iter().all(|p| *p > cap));
    let report = tresca.report();
    assert!(report.count(Zone::Stick) > 0 && report.count(Zone::Slip) > 0);
    let capped = format!("{PRESSED}\n[friction]\npressure_cap = {cap:e}\n{coefficients}");
    for (capped, same) in all_methods(&capped) {
        assert!(capped.solution.status.is_solved());
        let difference = distance(&capped.solution.multiplier, &tresca.solution.multiplier);
        assert!(difference < same, "{difference:e}");
        let zones = |case: &Case| -> Vec<Zone> {
            let panes = case.report().panes;
            panes.iter().map(|pane| pane.zone).collect()
        };
        assert_eq!(zones(&capped), zones(&tresca));
    }
    // Without the cap the answer is another one.
    let uncapped = format!("{PRESSED}\n[friction]\n{coefficients}");
    let uncapped = Case::of(&uncapped);
    assert!(distance(&uncapped.solution.multiplier, &tresca.solution.multiplier) > 1e-3);
}

/// Between the limits all methods agree, slipping panes carry F times the smaller of pressure and
/// cap, and the certificate holds.
#[test]
fn all_methods_find_panes_that_slip_below_and_at_the_cap() {
    use super::scenes::{BODY, LOAD, STEEL};
    let text = [BODY, STEEL, LOAD, CONTACT, &capped_ramps(CAP)].concat();
    let reference = Case::of(&text);
    assert_eq!(reference.solution.status, Status::Converged);
    let report = reference.report();
    let slipping = report.panes.iter().filter(|pane| pane.zone == Zone::Slip);
    let (mut below, mut at) = (0, 0);
    for pane in slipping {
        let pressure = -pane.normal_stress;
        let stress = pane.friction.unwrap().coulomb.unwrap().scaled_stress;
        let bound = pressure.min(CAP);
        // Newton's method leaves 1e-12 of the largest stress, some 4e7 Pa.
        assert!((stress - bound).abs() < 1e-9 * CAP, "{stress} of {bound}");
        if pressure > CAP { at += 1 } else { below += 1 }
    }
    assert!(
        below > 0 && at > 0,
        "{below} panes below the cap, {at} at it"
    );
    assert!(report.certificate.worst() < 1e-12);
    for (case, same) in all_methods(&text) {
        assert!(case.solution.status.is_solved());
        let difference = distance(&case.solution.multiplier, &reference.solution.multiplier);
        assert!(difference < same, "{difference:e}");
    }
}

/// KPRGP too, at the accuracy of the paper: it ends by its own rule.
#[test]
fn the_papers_inner_solver_knows_the_cap() {
    use super::scenes::{BODY, LOAD, STEEL};
    let text = [BODY, STEEL, LOAD, CONTACT, &capped_ramps(CAP)].concat();
    let mut scene = Scene::parse("test", &text).unwrap();
    scene.solve.method = Method::FixedPoint;
    scene.solve.inner = InnerSolver::Kprgp;
    scene.solve.epsilon = Some(1e-4);
    let case = Case::new(scene);
    assert!(case.solution.status.is_solved());
    let reference = Case::of(&text);
    let difference = distance(&case.solution.multiplier, &reference.solution.multiplier);
    // The published rule leaves the multipliers 0.2 to 1.3 per cent off.
    assert!(difference < 0.02, "{difference:e}");
}

/// A certificate by the uncapped law would accept an answer that ignores the cap; this one does not.
#[test]
fn the_certificate_rejects_the_answer_of_the_uncapped_law() {
    let uncapped = steel(&[CONTACT, RAMPS]);
    let capped = steel(&[CONTACT, &capped_ramps(CAP)]);
    let report = capped.problem.report(&uncapped.solution).unwrap();
    assert!(report.certificate.friction_bound.unwrap() > 0.1);
    assert!(report.certificate.fixed_point.unwrap() > 0.01);
}

/// One node that sticks, slips below the cap, and slips at it.
#[test]
fn one_node_has_its_closed_form() {
    let file = SceneFile::read(&pipelines().join("hard/one_node.toml")).unwrap();
    let friction = 0.3;
    let solve = |traction: [f64; 3], cap: Option<f64>| -> Case {
        let mut table: toml::Table = file.scene.to_toml().unwrap().parse().unwrap();
        table["friction"]["coefficient"]["constant"] = friction.into();
        if let Some(cap) = cap {
            let law = table["friction"].as_table_mut().unwrap();
            law.insert("pressure_cap".to_owned(), cap.into());
        }
        table["traction"][0]["value"] = traction.to_vec().into();
        let mut scene = file.changed("a load", &table.to_string()).unwrap().scene;
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        Case::try_new(scene, &file.folder).unwrap()
    };
    let agree = |case: &Case, expected: [f64; 2], zone: Zone| {
        assert_eq!(case.solution.status, Status::Converged);
        assert_eq!(case.report().panes[0].zone, zone);
        let found = &case.solution.multiplier;
        for (found, expected) in found.iter().zip(expected) {
            // S and h are rounded, while the answer's displacement is solved to twice the precision: by its own
            // measure the two are 3.3e-13 apart.
            assert!(
                (found - expected).abs() < 1e-12 * expected.abs(),
                "{found} {expected}"
            );
        }
        assert!(found[2].abs() < 1e-12 * expected[0]);
    };
    let entries = |dual: &ExplicitDual| {
        let column = |j: usize| dual.column(j).to_vec();
        let (normal, tangential) = (column(0), column(1));
        (
            [normal[0], normal[1], tangential[1]],
            [dual.rhs[0], dual.rhs[1]],
        )
    };
    // Pushed down and aside: the free node would stick with |λ_t| = λ_ν/3 > F λ_ν, so it slips.
    let pushed = [1e-3, 0.0, -3e-3];
    let uncapped = solve(pushed, None);
    let contact = uncapped.system.contact.as_ref().unwrap();
    let ([nn, nt, _], [h, _]) = entries(contact.explicit().unwrap());
    let pressure = h / (nn + friction * nt);
    agree(&uncapped, [pressure, friction * pressure], Zone::Slip);
    // A cap above the pressure changes nothing.
    let above = solve(pushed, Some(1.01 * pressure));
    agree(&above, [pressure, friction * pressure], Zone::Slip);
    // One below it: λ_t = F p_cap, and the normal row gives the pressure.
    let cap = 0.4 * pressure;
    let stress = friction * cap;
    let below = solve(pushed, Some(cap));
    agree(&below, [(h - nt * stress) / nn, stress], Zone::Slip);
    // Pushed aside by half of that it sticks, S λ = h, until the cap is below |λ_t| / F.
    let down = [5e-4, 0.0, -3e-3];
    let sticking = solve(down, None);
    let contact = sticking.system.contact.as_ref().unwrap();
    let ([nn, nt, tt], [h_n, h_t]) = entries(contact.explicit().unwrap());
    let determinant = nn * tt - nt * nt;
    let glued = [
        (tt * h_n - nt * h_t) / determinant,
        (nn * h_t - nt * h_n) / determinant,
    ];
    assert!(glued[1].abs() < friction * glued[0], "{glued:?}");
    agree(&sticking, glued, Zone::Stick);
    let least = glued[1].abs() / friction;
    agree(&solve(down, Some(1.01 * least)), glued, Zone::Stick);
    let stress = friction * 0.5 * least * glued[1].signum();
    let slipping = [(h_n - nt * stress) / nn, stress];
    agree(&solve(down, Some(0.5 * least)), slipping, Zone::Slip);
}

/// Constant coefficients go through the code for laws that do not follow the slip.
#[test]
fn a_constant_law_is_capped_too() {
    let law = "coefficient.constant = 0.3\n";
    let uncapped = in_contact("", law);
    let high = in_contact("", &format!("{law}pressure_cap = 1e12"));
    assert_eq!(high.solution.multiplier, uncapped.solution.multiplier);
    let low = in_contact("", &format!("{law}pressure_cap = {CAP:e}"));
    let shear = low.report().panes.into_iter().map(|pane| {
        let [t1, t2] = pane.friction.unwrap().stress;
        t1.hypot(t2)
    });
    let shear = shear.fold(0.0, f64::max);
    // 0.3 × 1e7 Pa, to rounding.
    assert!((shear / (0.3 * CAP) - 1.0).abs() < 1e-12, "{shear}");
}
