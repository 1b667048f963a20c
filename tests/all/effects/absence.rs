//! What a scene lacks has no unknowns and is never evaluated.

use contact3d::solver::SolvedBy;

use super::{
    scenes::{CONTACT, RAMPS, in_contact, steel},
    support::Case,
};

/// (primal unknowns, multipliers, evaluations of the law).
fn counts(case: &Case) -> (usize, usize, usize) {
    // With the published stopping rule the accuracy is reported instead.
    assert!(case.solution.status.is_solved());
    (
        case.solution.displacement.len(),
        case.solution.multiplier.len(),
        case.solution.trace.law_evaluations,
    )
}

/// 13 × 5 × 5 nodes, those at x = 0 held.
const N_FREE: usize = 12 * 5 * 5 * 3;

#[test]
fn without_contact_there_is_one_solve() {
    let case = steel(&[]);
    assert_eq!(counts(&case), (N_FREE, 0, 0));
    assert_eq!(case.solution.trace.solved_by, SolvedBy::Direct);
    assert_eq!(case.solution.trace.applications, 1);
    assert!(case.system.contact.is_none() && case.contact_side().is_none());
    assert!(case.mesh().contact.is_none());
}

#[test]
fn frictionless_contact_has_normal_multipliers_only() {
    let case = steel(&[CONTACT]);
    let (m, _) = case.sizes();
    assert_eq!((m, counts(&case)), (12, (N_FREE, m, 0)));
    assert_eq!(case.solution.trace.solved_by, SolvedBy::Minimisation);
    assert_eq!(case.solution.trace.history.len(), 1);
    let system = case.system.contact.as_ref().unwrap();
    assert_eq!(system.coupling.n_multipliers(), m);
    assert_eq!(system.explicit().unwrap().operator.as_slice().len(), m * m);
}

#[test]
fn a_given_slip_bound_needs_one_minimisation_and_no_law() {
    let case = in_contact("", "slip_bound = 1e6");
    let (m, _) = case.sizes();
    let (_, multipliers, evaluations) = counts(&case);
    assert_eq!((multipliers, evaluations), (3 * m, 0));
    assert_eq!(case.solution.trace.solved_by, SolvedBy::Minimisation);
    assert_eq!(case.solution.trace.history.len(), 1);
    assert!(case.solution.friction.is_none());
}

#[test]
fn a_law_without_slip_is_evaluated_once_at_each_contact_node() {
    for law in [
        "coefficient.constant = 0.3",
        "coefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2",
        "coefficient.expression = '0.2 + 0.1*x'",
        "coefficient.table = { slip = [0.0, 1.0], value = [0.3, 0.3] }",
    ] {
        for settings in ["", "[solve]\nmethod = 'fixed-point'\nepsilon = 1e-6"] {
            let case = in_contact("", &format!("{law}\n{settings}"));
            let (m, nodes) = case.sizes();
            let (_, multipliers, evaluations) = counts(&case);
            assert_eq!(
                (multipliers, evaluations),
                (3 * m, nodes),
                "{law} {settings}"
            );
            assert!(case.solution.friction.as_ref().unwrap().slip.is_none());
            let explicit = case.system.contact.as_ref().unwrap().explicit();
            assert!(explicit.unwrap().compliance.is_none());
            // Post-processing asks for the same coefficients, however often.
            case.report();
            case.report();
            assert_eq!(case.interface().coulomb().unwrap().evaluations(), nodes);
        }
    }
}

#[test]
fn a_law_of_the_slip_adds_the_slips_of_the_contact_nodes() {
    let case = steel(&[CONTACT, RAMPS]);
    let (m, nodes) = case.sizes();
    let (_, multipliers, evaluations) = counts(&case);
    assert_eq!(multipliers, 3 * m);
    assert!(evaluations > nodes && evaluations.is_multiple_of(nodes));
    let friction = case.solution.friction.as_ref().unwrap();
    assert_eq!(friction.slip.as_ref().map(Vec::len), Some(nodes));
    let explicit = case.system.contact.as_ref().unwrap().explicit();
    let compliance = explicit.unwrap().compliance.as_ref().unwrap();
    assert_eq!(compliance.matrix.len(), 3 * m * 2 * nodes);
}

#[test]
fn clamps_at_zero_prescribe_nothing() {
    let moved = "[[clamp]]\nface = 'x_max'\ncomponents = ['y']\nvalue = [0.0, 1e-6, 0.0]\n";
    for (value, is_there) in [("1e-6", true), ("0.0", false)] {
        let case = steel(&[&moved.replace("1e-6", value), CONTACT]);
        let primal = &case.system.assembly.primal;
        assert_eq!(primal.dofs.prescribed.is_some(), is_there);
        assert_eq!(case.report().resultants.clamp_work.is_some(), is_there);
    }
}

#[test]
fn without_springs_there_is_no_part_of_theirs() {
    let spring = "[[spring]]\nface = 'x_max'\nnormal = 1e9\n";
    let [with, without] = [&[spring, CONTACT][..], &[CONTACT]].map(|tables| {
        let case = steel(tables);
        let entries = case.system.assembly.primal.stiffness.data.len();
        (entries, case.report().resultants)
    });
    // Nodes of a triangle share a tetrahedron already.
    assert_eq!(with.0, without.0);
    assert!(with.1.spring_energy.is_some() && with.1.spring_force.is_some());
    assert!(without.1.spring_energy.is_none() && without.1.spring_force.is_none());
}

#[test]
fn frame_and_gap_are_as_small_as_they_can_be() {
    let plain = in_contact("", "coefficient.constant = 0.3");
    let plain = plain.interface();
    assert_eq!((plain.frame.axes.len(), &plain.gap), (1, &None));
    assert_eq!(plain.frame.normals.len(), 1);
    let wide = in_contact(
        "angle = '10*x'\ngap = '1e-6*x'",
        "coefficient.constant = 0.3",
    );
    let (_, nodes) = wide.sizes();
    let interface = wide.interface();
    assert_eq!(interface.frame.axes.len(), nodes);
    assert_eq!(interface.gap.as_ref().map(Vec::len), Some(nodes));
    assert_eq!(interface.frame.normals.len(), 1);
    let plane = "obstacle.half_space = { point = [0.0, 0.0, -1e-5], normal = [1e-3, 0.0, 1.0] }";
    let round = "obstacle.sphere = { centre = [1.5, 0.5, -9.0], radius = 9.0 }";
    for (obstacle, normals) in [(plane, 1), (round, nodes)] {
        let case = in_contact(obstacle, "coefficient.constant = 0.3");
        let interface = case.interface();
        assert_eq!(interface.frame.normals.len(), normals);
        assert_eq!(interface.frame.axes.len(), normals);
        assert_eq!(interface.gap.as_ref().map(Vec::len), Some(nodes));
    }
}
