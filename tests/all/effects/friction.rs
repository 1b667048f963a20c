//! Laws of friction that coincide in a limit.

use contact3d::{
    contact::{Interface, InterfaceFriction},
    solver::{ContactProblem, ContactSide, SolvedBy, Start, Status},
};

use super::{
    scenes::{CONTACT, RAMPS, distance, in_contact, steel},
    support::Case,
};

/// Both answers have residuals below 1e-12 ‖λ‖; the conditioning of the problem is some tens.
const SAME: f64 = 1e-10;

fn constant() -> Case {
    in_contact("", "coefficient.constant = 0.3")
}

fn assert_same(found: &Case, expected: &Case) {
    assert_eq!(found.solution.status, Status::Converged);
    let difference = distance(&found.solution.multiplier, &expected.solution.multiplier);
    assert!(difference < SAME, "multipliers {difference:e}");
    let [found, expected] = [found, expected].map(|case| case.displacement().concat());
    let difference = distance(&found, &expected);
    assert!(difference < SAME, "displacement {difference:e}");
}

#[test]
fn equal_coefficients_are_isotropic() {
    let pair = in_contact(
        "",
        "coefficient_1.constant = 0.3\ncoefficient_2.constant = 0.3",
    );
    assert_same(&pair, &constant());
}

/// Laws whose values do not change are recognised and cost what a constant costs.
#[test]
fn flat_ramps_and_tables_are_constants_to_the_last_bit() {
    let constant = constant();
    for law in [
        "coefficient.ramp = { initial = 0.3, residual = 0.3, onset = 1e-5, rate = 1e3 }",
        "coefficient.table = { slip = [0.0, 1e-5, 1.0], value = [0.3, 0.3, 0.3] }",
    ] {
        let flat = in_contact("", law);
        assert_eq!(
            flat.solution.multiplier, constant.solution.multiplier,
            "{law}"
        );
        assert!(flat.solution.friction.unwrap().slip.is_none(), "{law}");
    }
}

/// The same through the code for laws that follow the slip.
#[test]
fn laws_that_follow_the_slip_by_nothing_are_constants() {
    let constant = constant();
    for law in [
        "coefficient.expression = '0.3 + 0*s'",
        "coefficient_1.expression = '0.3 + 0*s2'\ncoefficient_2.constant = 0.3",
        // F moves by 1e-15, a rounding.
        "coefficient.table = { slip = [0.0, 1e-3], value = [0.3, 0.300000000000001] }",
    ] {
        let flat = in_contact("", law);
        let friction = flat.solution.friction.as_ref().unwrap();
        assert!(friction.slip.is_some(), "{law}");
        assert_same(&flat, &constant);
    }
}

#[test]
fn a_ramp_is_its_table_and_its_grid() {
    let ramps = steel(&[CONTACT, RAMPS]);
    // 1e-5 + 0.1/3000 and 1e-5 + 0.1/1000.
    let tables = in_contact(
        "",
        "coefficient_1.table = { slip = [0.0, 1e-5, 4.333333333333333e-5], value = [0.3, 0.3, 0.2] }
         coefficient_2.table = { slip = [0.0, 1e-5, 1.1e-4], value = [0.3, 0.3, 0.2] }",
    );
    assert_same(&tables, &ramps);
    let grids = in_contact(
        "",
        "coefficient_1.grid = { slip_1 = [0.0, 1e-5, 4.333333333333333e-5], slip_2 = [0.0], value = [[0.3], [0.3], [0.2]] }
         coefficient_2.grid = { slip_1 = [0.0], slip_2 = [0.0, 1e-5, 1.1e-4], value = [[0.3, 0.3, 0.2]] }",
    );
    assert_same(&grids, &ramps);
}

/// A solution with Coulomb friction is one with Tresca friction at its own slip bound.
#[test]
fn tresca_at_the_converged_bound_is_coulomb() {
    let coulomb = steel(&[CONTACT, RAMPS]);
    let state = &coulomb.solution.friction.as_ref().unwrap().coulomb;
    let scene = in_contact("", "slip_bound = 1.0").scene().clone();
    let interface = Interface::new(&scene, coulomb.mesh()).unwrap();
    let mut interface = interface.unwrap();
    interface.friction = InterfaceFriction::Tresca(state.semi_axes());
    let contact = ContactSide {
        surface: coulomb.mesh().contact.as_ref().unwrap(),
        interface: &interface,
    };
    let settings = &coulomb.scene().solve;
    let tresca = ContactProblem::new(&coulomb.system, contact).unwrap();
    let tresca = tresca
        .solve(settings, Start::default(), &mut |_| {})
        .unwrap();
    assert_eq!(tresca.trace.solved_by, SolvedBy::Minimisation);
    let difference = distance(&tresca.multiplier, &coulomb.solution.multiplier);
    assert!(difference < SAME, "{difference:e}");
}

#[test]
fn vanishing_friction_is_frictionless() {
    let none = steel(&[CONTACT]);
    let tiny = in_contact("", "coefficient.constant = 1e-9");
    let m = none.solution.multiplier.len();
    // The answer depends on F at a rate near 1, so F = 1e-9 moves it by some 1e-9.
    let difference = distance(&tiny.solution.multiplier[..m], &none.solution.multiplier);
    assert!(difference < 1e-8, "{difference:e}");
    let displacement = [&tiny, &none].map(|case| case.displacement().concat());
    assert!(distance(&displacement[0], &displacement[1]) < 1e-8);
    // A slip bound of zero leaves nothing at all.
    let zero = in_contact("", "slip_bound = 0.0");
    let normal = distance(&zero.solution.multiplier[..m], &none.solution.multiplier);
    assert!(normal < SAME, "{normal:e}");
    assert!(zero.solution.multiplier[m..].iter().all(|t| *t == 0.0));
}

#[test]
fn a_gap_of_zero_is_no_gap() {
    let law = "coefficient.constant = 0.3";
    let zero = in_contact("gap = '0*x'", law);
    assert!(zero.interface().gap.is_some());
    assert_eq!(zero.solution.multiplier, constant().solution.multiplier);
    let constant_gap = in_contact("gap = 1e-5", law);
    let formula = in_contact("gap = '1e-5 + 0*x'", law);
    assert_eq!(
        formula.solution.multiplier,
        constant_gap.solution.multiplier
    );
    assert!(distance(&constant_gap.solution.multiplier, &zero.solution.multiplier) > 1e-3);
}

#[test]
fn a_frame_that_turns_by_nothing_is_constant() {
    let law = "coefficient_1.constant = 0.3\ncoefficient_2.constant = 0.1";
    let fixed = in_contact("axis_1 = [1.0, 2.0, 0.0]", law);
    let turning = in_contact("axis_1 = ['1 + 0*x', 2.0, 0.0]", law);
    assert!(turning.interface().frame.axes.len() > 1);
    assert_same(&turning, &fixed);
    // On z_min the default t₁ is x and t₂ is y.
    let degrees = f64::atan2(2.0, 1.0).to_degrees();
    assert_same(&in_contact(&format!("angle = {degrees:?}"), law), &fixed);
    assert_same(
        &in_contact(&format!("angle = '0*y + ({degrees:?})'"), law),
        &fixed,
    );
}

#[test]
fn a_quarter_turn_exchanges_the_coefficients() {
    let [plain, turned] =
        [("", [0.3, 0.1]), ("angle = 90", [0.1, 0.3])].map(|(angle, [f1, f2])| {
            let law = format!("coefficient_1.constant = {f1}\ncoefficient_2.constant = {f2}");
            in_contact(angle, &law)
        });
    let displacement = [&turned, &plain].map(|case| case.displacement().concat());
    let difference = distance(&displacement[0], &displacement[1]);
    assert!(difference < SAME, "{difference:e}");
    let unturned = in_contact(
        "",
        "coefficient_1.constant = 0.1\ncoefficient_2.constant = 0.3",
    );
    let displacement = [&unturned, &plain].map(|case| case.displacement().concat());
    assert!(distance(&displacement[0], &displacement[1]) > 1e-3);
}

/// Formulas with kinks are the ramps that they write out, for Newton's method as well.
#[test]
fn ramps_written_with_max_or_if_are_ramps() {
    let ramp = in_contact(
        "",
        "coefficient.ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 3000.0 }",
    );
    for formula in [
        "max(0.3 - 3000*max(s - 1e-5, 0), 0.2)",
        "min(0.3, max(0.3 - 3000*(s - 1e-5), 0.2))",
        "if(s < 1e-5, 0.3, if(s < 1e-5 + 0.1/3000, 0.3 - 3000*(s - 1e-5), 0.2))",
        "0.25 + 1500*(abs(s - 1e-5 - 0.1/3000) - abs(s - 1e-5))",
    ] {
        let found = in_contact("", &format!("coefficient.expression = '{formula}'"));
        assert_same(&found, &ramp);
        let steps = |case: &Case| case.solution.trace.newton.len();
        assert_eq!(steps(&found), steps(&ramp), "{formula}");
    }
}

#[test]
fn parameters_are_the_numbers_they_stand_for() {
    let law = "coefficient.expression = 'mu*(0.7 + rest*exp(-s/1e-5))'";
    let named_with = |mu: &str| {
        let parameters = format!("\n[parameters]\nmu = {mu}\nrest = 0.3\ntop = 1e-6\nturn = 30\n");
        steel(&[
            CONTACT,
            "gap = 'top*x'\nangle = 'turn + y'",
            "\n[friction]\n",
            law,
            &parameters,
        ])
    };
    let written = in_contact(
        "gap = '1e-6*x'\nangle = '30 + y'",
        "coefficient.expression = '0.4*(0.7 + 0.3*exp(-s/1e-5))'",
    );
    assert_eq!(
        named_with("0.4").solution.multiplier,
        written.solution.multiplier
    );
    assert_ne!(
        named_with("0.3").solution.multiplier,
        written.solution.multiplier
    );
}

/// A law that fails at large slips is a law where pressed panes do not slip so far, and a failed
/// solve where they do.
#[test]
fn a_law_may_fail_at_slips_that_do_not_occur() {
    let levelled = in_contact("", "coefficient.expression = 'max(0.3 - 400*s, 1e-3)'");
    let falling = in_contact("", "coefficient.expression = '0.3 - 400*s'");
    assert_same(&falling, &levelled);
    let warned = falling.interface().warnings(3.0, "m");
    assert_eq!(warned.len(), 1);
    let too_steep = in_contact("", "coefficient.expression = '0.3 - 3e4*s'");
    assert_eq!(too_steep.solution.status, Status::NumericalError);
}

/// A formula that levels off above zero is admissible at every slip; one that does not is refused
/// before anything is solved (`tests/cli/law.rs`).
#[test]
fn a_formula_that_levels_off_is_a_law() {
    let law = "coefficient.expression = '0.1 + 0.2*exp(-s/6e-5)'";
    for method in ["", "[solve]\nmethod = 'fixed-point'\nepsilon = 1e-4\n"] {
        let case = in_contact("", &format!("{law}\n{method}"));
        // With the published stopping rule the accuracy is reported instead.
        assert!(case.solution.status.is_solved(), "{method}");
        let friction = case.report().friction.unwrap();
        assert!(
            friction.is_admissible(&case.mesh().contact.as_ref().unwrap().pane_average, |_| {
                true
            })
        );
    }
}
