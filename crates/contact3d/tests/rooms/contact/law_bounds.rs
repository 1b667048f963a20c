//! Bounds of laws against closed forms.

use contact3d::{
    Problem, ProblemError,
    contact::{FaceLaw, LawBounds},
    scene::{
        Body, Clamp, Coefficient, Contact, Formula, Friction, FrictionLaw, Grid, Material, Ramp,
        Scene, Table,
    },
};
use proptest::prelude::*;

fn formula(text: &str) -> Coefficient {
    Coefficient::Expression(Formula::parse(text).unwrap())
}

fn pair(first: Coefficient, second: Coefficient) -> FrictionLaw {
    FrictionLaw::Orthotropic(Box::new([first, second]))
}

/// A law on 33 × 33 nodes of (0, 1)².
fn on_square(law: FrictionLaw) -> FaceLaw {
    let at = |k: usize| [(k % 33) as f64 / 32.0, (k / 33) as f64 / 32.0, 0.0];
    FaceLaw::new("friction", law, (0..33 * 33).map(at).collect())
}

/// Closed forms evaluated in another order: a few roundings.
fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 8.0 * f64::EPSILON * expected.abs()
}

/// Estimates: golden sections leave 1e-9 of an interval, squared at extremes where F is smooth.
fn close(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-12 * expected.abs()
}

fn ramp(initial: f64, residual: f64, onset: f64, rate: f64) -> Coefficient {
    Coefficient::Ramp(Ramp {
        initial,
        residual,
        onset,
        rate,
    })
}

#[test]
fn the_published_law() {
    let law = on_square(pair(
        ramp(0.3, 0.2, 1e-5, 3000.0),
        ramp(0.3, 0.2, 1e-5, 1000.0),
    ));
    let bounds = LawBounds::new(&law, 3.0);
    assert_eq!([bounds.smallest.value, bounds.largest.value], [0.2, 0.3]);
    assert_eq!(bounds.lipschitz.value, 3000.0);
    assert_eq!(bounds.lipschitz.coefficient, 0);
    assert_eq!(bounds.lipschitz.slip, [1e-5, 0.0]);
    assert!(near(bounds.anisotropy.value, 1.5));
    assert!(!bounds.estimated && bounds.largest.position.is_none());
}

#[test]
fn constants_have_no_slope() {
    let law = on_square(pair(
        Coefficient::Constant(0.25),
        Coefficient::Constant(1.0),
    ));
    let bounds = LawBounds::new(&law, 3.0);
    assert_eq!([bounds.smallest.value, bounds.largest.value], [0.25, 1.0]);
    assert_eq!(
        [bounds.smallest.coefficient, bounds.largest.coefficient],
        [0, 1]
    );
    assert_eq!(
        [bounds.lipschitz.value, bounds.anisotropy.value],
        [0.0, 4.0]
    );
    assert_eq!(bounds.anisotropy.coefficient, 1);
}

#[test]
fn slips_beyond_the_body_do_not_count() {
    let law = on_square(FrictionLaw::Isotropic(ramp(0.5, 0.25, 1.0, 0.125)));
    let bounds = LawBounds::new(&law, 2.0);
    assert_eq!(bounds.smallest.value, 0.375);
    assert_eq!(bounds.smallest.slip, [2.0, 0.0]);
    assert_eq!(
        [bounds.lipschitz.value, bounds.anisotropy.value],
        [0.125, 1.0]
    );
}

#[test]
fn a_table_is_as_steep_as_its_steepest_piece() {
    let law = on_square(FrictionLaw::Isotropic(Coefficient::Table(Table {
        slip: vec![0.0, 0.5, 1.0, 2.0],
        value: vec![1.0, 0.25, 0.5, 2.0],
    })));
    let bounds = LawBounds::new(&law, 3.0);
    assert_eq!(
        [bounds.smallest.value, bounds.smallest.slip[0]],
        [0.25, 0.5]
    );
    assert_eq!([bounds.largest.value, bounds.largest.slip[0]], [2.0, 2.0]);
    assert_eq!(
        [bounds.lipschitz.value, bounds.lipschitz.slip[0]],
        [1.5, 0.0]
    );
}

proptest! {
    /// No sample of a grid law inside its cells exceeds the bounds, and the best of the corners,
    /// approached from inside every cell, attains them.
    #[test]
    fn grids_are_bounded_by_their_corners(
        values in proptest::collection::vec(0.1..1.0_f64, 24),
        samples in proptest::collection::vec((0.0..4.0_f64, 0.0..5.0_f64), 200),
    ) {
        let rows = |values: &[f64]| values.chunks(3).map(<[f64]>::to_vec).collect::<Vec<_>>();
        let grid = |slip_1: &[f64], slip_2: &[f64], values: &[f64]| Coefficient::Grid(Grid {
            slip_1: slip_1.to_vec(),
            slip_2: slip_2.to_vec(),
            value: rows(values),
        });
        let law = on_square(pair(
            grid(&[0.0, 1.0, 1.5, 3.0], &[0.0, 0.5, 4.0], &values[..12]),
            grid(&[0.0, 0.7, 1.2, 2.0], &[0.0, 1.0, 2.0], &values[12..]),
        ));
        let bounds = LawBounds::new(&law, 10.0);
        let mut corners = [[0.0, 1.0, 1.5, 3.0, 0.7, 1.2, 2.0], [0.0, 0.5, 4.0, 1.0, 2.0, 2.0, 2.0]];
        corners.iter_mut().for_each(|c| c.sort_by(f64::total_cmp));
        let mut points = samples;
        for s1 in corners[0] {
            for s2 in corners[1] {
                let inside = [-1e-9, 0.0, 1e-9];
                points.extend(inside.iter().flat_map(|d| inside.map(|e| ((s1 + d).max(0.0), (s2 + e).max(0.0)))));
            }
        }
        let mut steepest = 0.0_f64;
        let mut ratio = 1.0_f64;
        for (s1, s2) in points {
            let [first, second] = law.law.evaluate([0.0; 3], [0.0; 3], [s1, s2]);
            prop_assert!(first.min(second) >= bounds.smallest.value - 1e-15);
            prop_assert!(first.max(second) <= bounds.largest.value + 1e-15);
            ratio = ratio.max(first / second).max(second / first);
            for [a, b] in law.law.derivative([0.0; 3], [0.0; 3], [s1, s2]) {
                steepest = steepest.max(a.hypot(b));
            }
        }
        // Corners are approached to 1e-9, where F and its slopes (below 10) change by 1e-8.
        prop_assert!((steepest - bounds.lipschitz.value).abs() < 1e-6);
        prop_assert!((ratio - bounds.anisotropy.value).abs() < 1e-6);
    }
}

#[test]
fn an_expression_with_a_peak_inside_the_range() {
    // F = 0.2 + (s/c) exp(-s/c): the peak 0.2 + 1/e at s = c, the steepest slope 1/c at 0.
    let law = on_square(pair(
        formula("0.2 + (s1/3e-4)*exp(-s1/3e-4)"),
        Coefficient::Constant(0.2),
    ));
    let bounds = LawBounds::new(&law, 3.0);
    let peak = 0.2 + (-1.0_f64).exp();
    assert!(close(bounds.largest.value, peak));
    // A maximum is flat: its place is known to the root of the rounding of F.
    assert!((bounds.largest.slip[0] / 3e-4 - 1.0).abs() < 1e-6);
    assert!(near(bounds.lipschitz.value, 1.0 / 3e-4));
    assert!(close(bounds.anisotropy.value, peak / 0.2));
    assert!(bounds.estimated);
}

#[test]
fn an_expression_of_both_slips() {
    // A bump of height 0.5 at (2e-3, 5e-2), with widths as large as its distances.
    let law = on_square(pair(
        formula("0.3 + 0.5*exp(0 - ((s1-2e-3)/2e-3)^2 - ((s2-5e-2)/5e-2)^2)"),
        Coefficient::Constant(0.4),
    ));
    let bounds = LawBounds::new(&law, 1.0);
    assert!(close(bounds.largest.value, 0.8));
    assert!((bounds.largest.slip[0] / 2e-3 - 1.0).abs() < 1e-6);
    assert!((bounds.largest.slip[1] / 5e-2 - 1.0).abs() < 1e-6);
    assert!(close(bounds.anisotropy.value, 2.0));
}

#[test]
fn an_expression_of_place_and_slip() {
    // Largest at the node (1, 0.5), smallest far away at large slip.
    let law = on_square(FrictionLaw::Isotropic(formula(
        "0.5 + 0.25*x - (y-0.5)^2 + 0.1*exp(-s/1e-4)",
    )));
    let bounds = LawBounds::new(&law, 1.0);
    assert!(near(bounds.largest.value, 0.85));
    assert_eq!(bounds.largest.position, Some([1.0, 0.5, 0.0]));
    assert!(near(bounds.smallest.value, 0.25));
    assert!(near(bounds.lipschitz.value, 1000.0));
}

#[test]
fn a_root_is_not_lipschitz() {
    let law = on_square(FrictionLaw::Isotropic(formula("0.2 + 0.1*sqrt(s)")));
    assert_eq!(LawBounds::new(&law, 1.0).lipschitz.value, f64::INFINITY);
}

#[test]
fn bounds_scale_with_the_unit_of_length() {
    let laws = ["0.2 + (s/3e-4)*exp(-s/3e-4)", "0.2 + (s/3e-1)*exp(-s/3e-1)"];
    let [metres, millimetres] = [(laws[0], 3.0), (laws[1], 3000.0)].map(|(text, extent)| {
        let law = on_square(FrictionLaw::Isotropic(formula(text)));
        LawBounds::new(&law, extent)
    });
    assert!(close(metres.largest.value, millimetres.largest.value));
    assert!(close(
        metres.lipschitz.value,
        1000.0 * millimetres.lipschitz.value
    ));
}

/// A law on a face from the origin to (1, 1, 0) of a body of 3 m.
fn on_body(friction: Friction) -> Result<Problem, ProblemError> {
    let body = Body::brick([1.0, 1.0, 3.0], [2, 2, 2]);
    let scene = Scene::new(body, Material::isotropic(1.0, 0.3))
        .with_clamp(Clamp::face("z_max"))
        .with_contact(Contact::on("z_min"))
        .with_friction(friction);
    Problem::new(scene)
}

fn words(friction: Friction) -> Vec<String> {
    let problem = on_body(friction).unwrap_or_else(|error| panic!("{error}"));
    problem.warnings().iter().map(ToString::to_string).collect()
}

#[test]
fn laws_that_fail_at_some_slip_are_warned_of_with_the_place() {
    let cases = [
        ("0.3 - 0.2*s1", "|u_t1| = 3.0000e0 m"),
        ("0.3 - 2e5*s2", "|u_t2| = 3.0000e0 m"),
        ("0.3 + exp(1e3*s2)", "at worst inf at |u_t2|"),
        ("sqrt(1 - s1)", "at worst nan at |u_t1|"),
        // Negative only around 1e-3, in a dip narrower than a decade.
        (
            "0.3 - 0.31*exp(0 - ((s2-1e-3)/1e-3)^2)",
            "|u_t2| = 1.0000e-3 m",
        ),
    ];
    for (text, place) in cases {
        let found = words(Friction::orthotropic(0.3, formula(text)));
        assert_eq!(found.len(), 1, "{found:?}");
        for fragment in ["friction.coefficient_2.expression: not 0 < F", place] {
            assert!(found[0].contains(fragment), "{text}: {}", found[0]);
        }
    }
    let found = words(Friction::coulomb(formula("0.3 - s")));
    assert!(
        found[0].starts_with("friction.coefficient.expression"),
        "{found:?}"
    );
    assert!(
        found[0].contains("at worst -2.7 at |u_t| = 3.0000e0 m;"),
        "{found:?}"
    );
    let good = Friction::orthotropic(formula("0.3 - 0.09*s1 + 1e-9*x"), formula("1e-30"));
    assert!(words(good).is_empty());
}

/// What a warning advises ends it.
#[test]
fn the_advice_about_a_law_helps() {
    for (text, advice, followed) in [
        (
            "0.3 - 1e3*s",
            "max(FORMULA, 0.05)",
            "max(0.3 - 1e3*s, 0.05)",
        ),
        (
            "0.3 + exp(1e3*s)",
            "min(FORMULA, 1)",
            "min(0.3 + exp(1e3*s), 1)",
        ),
        (
            "sqrt(1 - s)",
            "if(CONDITION, FORMULA, VALUE)",
            "if(s < 0.99, sqrt(1 - s), 0.1)",
        ),
    ] {
        let found = words(Friction::coulomb(formula(text)));
        assert!(found[0].contains(advice), "{}", found[0]);
        let found = words(Friction::coulomb(formula(followed)));
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn laws_that_fail_without_slip_are_refused_with_the_place() {
    for (text, fragment) in [
        ("0.3 + ln(s2)", "-inf at |u_t2| = 0.0000e0 m"),
        ("x - 0.5", "-0.5 at x, y, z = 0.0, 0.0, 0.0"),
        ("0 - 1", "-1.0 at every slip"),
        ("0", "0.0 at every slip"),
    ] {
        let law = Friction::orthotropic(0.3, formula(text));
        let Err(ProblemError::Invalid(refused)) = on_body(law) else {
            panic!("{text}: accepted");
        };
        assert_eq!(refused.key, "friction.coefficient_2.expression");
        assert!(
            refused.found.contains(fragment),
            "{text}: {}",
            refused.found
        );
    }
}
