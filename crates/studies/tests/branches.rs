//! Paths of solutions against closed forms: one contact node in all its states, under a constant coefficient and under one that
//! falls with the slip, and two nodes with all their states enumerated, along whole paths.

use std::path::{Path as FilePath, PathBuf};

use contact3d::{
    dual::ExplicitDual,
    linalg::norm,
    scene::{Coefficient, Formula, Ramp, Scene, SceneFile},
    solver::Linearisation,
};
use nalgebra::{DMatrix, DVector};
use studies::branches::{
    Branches, Family, ParameterRange, Path, PathEnd, PathPoint, PointKind, Switch,
};

fn folder() -> PathBuf {
    FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard")
}

fn scene(name: &str) -> Scene {
    let file = SceneFile::read(&folder().join(name)).expect("a scene of the hard cases");
    file.scene
}

/// Paths over a change of a scene, and what they are of.
struct Followed {
    branches: Branches,
    /// S and h at the start of the range.
    dual: ExplicitDual,
}

fn follow(
    scene: &Scene,
    [from, to]: [f64; 2],
    all: bool,
    set: impl Fn(&mut Scene, f64),
) -> Followed {
    let at = |value: f64| {
        let mut changed = scene.clone();
        set(&mut changed, value);
        Ok(changed)
    };
    let range = ParameterRange {
        key: "parameter".into(),
        from,
        to,
    };
    let folder = folder();
    let family = Family::new(range, &at, &folder).expect("a family");
    let branches = Branches::follow(&family, all, &mut |_, _| {}).expect("paths");
    let contact = family.base.system.contact.as_ref().expect("contact");
    Followed {
        branches,
        dual: contact.explicit().expect("a dense operator").clone(),
    }
}

fn set_friction(scene: &mut Scene, value: f64) {
    scene.friction.as_mut().expect("friction").coefficient = Some(Coefficient::Constant(value));
}

fn points(branches: &Branches) -> impl Iterator<Item = &PathPoint> {
    branches.paths.iter().flat_map(|path| &path.points)
}

/// How often the paths pass a value of the parameter; folds and kinks are points, so they are monotone between points.
fn crossings(branches: &Branches, parameter: f64) -> usize {
    let crosses = |path: &Path| {
        let pairs = path.points.windows(2);
        pairs
            .filter(|p| (p[0].parameter < parameter) != (p[1].parameter < parameter))
            .count()
    };
    branches.paths.iter().map(crosses).sum()
}

/// Along a path det R' changes its sign exactly where the parameter turns, and every point is certified.
fn require_consistent(branches: &Branches) {
    for point in points(branches) {
        // The solvers stop at n ε times the mobility of panes; these problems have a handful of unknowns.
        assert!(point.residual < 1e-11, "{point:?}");
    }
    for path in &branches.paths {
        assert!(matches!(path.end, PathEnd::Range | PathEnd::KnownPoint));
        let mut sense = 0.0;
        for pair in path.points.windows(2) {
            if pair[0].kind == PointKind::BranchPoint {
                sense = 0.0;
            }
            let now =
                (pair[1].parameter - pair[0].parameter).signum() * f64::from(pair[1].determinant);
            if pair[1].kind != PointKind::Fold && pair[1].parameter != pair[0].parameter {
                assert!(sense == 0.0 || sense == now, "{pair:?}");
                sense = now;
            }
        }
    }
}

/// S, h of one node that is neither coupled to t₂ nor loaded along it.
fn planar(dual: &ExplicitDual) -> ([[f64; 2]; 2], [f64; 2]) {
    let s = |i: usize, j: usize| dual.column(j)[i];
    // Coupling to the second direction is rounding of its own compliance.
    assert!(
        s(0, 2).abs() + s(1, 2).abs() < 1e-14 * s(2, 2)
            && dual.rhs[2].abs() < 1e-14 * norm(&dual.rhs)
    );
    (
        [[s(0, 0), s(0, 1)], [s(1, 0), s(1, 1)]],
        [dual.rhs[0], dual.rhs[1]],
    )
}

/// Open, sticking and sliding solutions of one node for every F: all three beyond F = |λ_t|/λ_ν of the sticking one, where it and the
/// sliding one are born at a kink.
#[test]
fn one_node_has_its_three_states_along_the_path() {
    let Followed { branches, dual } =
        follow(&scene("one_node.toml"), [0.5, 4.0], true, set_friction);
    let (s, h) = planar(&dual);
    require_consistent(&branches);
    let determinant = s[0][0] * s[1][1] - s[0][1] * s[1][0];
    let stick = [
        (s[1][1] * h[0] - s[0][1] * h[1]) / determinant,
        (s[0][0] * h[1] - s[1][0] * h[0]) / determinant,
    ];
    let born = stick[1].abs() / stick[0];
    let sign = stick[1].signum();
    for point in points(&branches) {
        let friction = point.parameter;
        let slip = h[0] / (s[0][0] + sign * friction * s[0][1]);
        let expected = match point.zones {
            [1, 0, 0] => [0.0, 0.0],
            [0, 1, 0] => stick,
            _ => [slip, sign * friction * slip],
        };
        let off = (point.multiplier[0] - expected[0]).hypot(point.multiplier[1] - expected[1]);
        // Rounding of a 3 × 3 system of condition 10.
        assert!(
            off <= 1e-13 * stick[0].hypot(stick[1]),
            "{point:?} {expected:?}"
        );
        // Ψ maps g to (h_ν − S_νt F g sign)/S_νν where the node slides, and is constant elsewhere.
        let radius = if point.zones == [0, 0, 1] {
            friction * s[0][1].abs() / s[0][0]
        } else {
            0.0
        };
        // 2^22 squarings of a 2 × 2 matrix.
        assert!(
            (point.spectral_radius - radius).abs() < 1e-5,
            "{point:?} {radius}"
        );
    }
    let fold = points(&branches)
        .find(|point| point.kind == PointKind::KinkFold)
        .expect("a fold");
    // Located to 1e-13 of the range of 3.5.
    assert!(
        (fold.parameter - born).abs() < 1e-12,
        "{} {born}",
        fold.parameter
    );
    for (friction, count) in [(0.7, 1), (born - 1e-6, 1), (born + 1e-6, 3), (3.3, 3)] {
        assert_eq!(crossings(&branches, friction), count, "F = {friction}");
    }
    assert_eq!(branches.end_solutions(4.0).len(), 3);
    assert_eq!((branches.degree(0.5), branches.degree(4.0)), (1, 1));
    assert!(branches.is_followed() && !branches.is_incomplete());
}

/// The sign of det R' that paths carry is that of the program's own linearisation.
#[test]
fn determinants_are_those_of_newtons_matrix() {
    let base = scene("one_node.toml");
    let Followed { branches, .. } = follow(&base, [0.5, 4.0], true, set_friction);
    let end = branches.end_solutions(4.0);
    let mut changed = base;
    set_friction(&mut changed, 4.0);
    let problem = contact3d::Problem::in_folder(changed, &folder()).expect("a problem");
    let problem = problem.assemble().expect("a factor");
    let dual = problem
        .system
        .contact
        .as_ref()
        .and_then(|contact| contact.explicit())
        .expect("dense");
    let contact = problem.contact_side().expect("contact");
    let mut signs = Vec::new();
    for (_, point) in end {
        let linearised = Linearisation::new(dual, &contact.laws(), &point.multiplier);
        assert_eq!(point.determinant, linearised.determinant_sign);
        signs.push(point.determinant);
    }
    signs.sort_unstable();
    assert_eq!(signs, [-1, 1, 1]);
}

/// For h_ν = 0 all of the segment from 0 to S⁻¹h solves at F* = S_νν/|S_νt|: the path stands upright there.
#[test]
fn one_node_has_a_ray_of_solutions_at_the_critical_friction() {
    let base = scene("one_node.toml");
    let along = |value: f64| {
        let mut changed = base.clone();
        changed.tractions[0].value[2] = value.into();
        changed
    };
    let normal = |value: f64| {
        follow(&along(value), [0.1, 0.2], false, set_friction)
            .dual
            .rhs[0]
    };
    let (at_zero, at_one) = (normal(0.0), normal(1e-3));
    let touching = along(-1e-3 * at_zero / (at_one - at_zero));
    let Followed { branches, dual } = follow(&touching, [2.5, 1.0], true, set_friction);
    let (s, h) = planar(&dual);
    let critical = s[0][0] / s[0][1].abs();
    let mut shares = Vec::new();
    for point in points(&branches) {
        // h_ν is zero to rounding of the load, 1e-16 of h_t, and F − F* is what multiplies it near the ray.
        assert!(point.residual < 1e-11);
        if point.zones == [0, 0, 1]
            && point.largest_pressure > 0.0
            && (point.parameter - critical).abs() < 1e-9
        {
            shares.push(point.multiplier[0]);
        }
    }
    let stick = h[1] * s[0][1] / (s[0][1] * s[0][1] - s[0][0] * s[1][1]);
    let most = shares.iter().copied().fold(0.0, f64::max);
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    // Steps along the ray are a tenth of its length at most.
    assert!(
        most > 0.8 * stick && least < 0.2 * stick && shares.len() > 5,
        "{shares:?} {stick}"
    );
    assert!(points(&branches).any(|point| point.parameter == 1.0 && point.largest_pressure == 0.0));
}

/// A ramp written as a formula in three ways has the path of the ramp: the same folds and kinks at the same loads.
#[test]
fn kinks_inside_formulas_are_located_like_those_of_a_ramp() {
    let ramp = Ramp {
        initial: 1.4,
        residual: 0.2,
        onset: 1e-4,
        rate: 1000.0,
    };
    let formula = |text: &str| Coefficient::Expression(Formula::parse(text).expect("a formula"));
    let laws = [
        Coefficient::Ramp(ramp),
        formula("max(0.2, min(1.4, 1.4 - 1000*(s - 1e-4)))"),
        formula("if(s < 1e-4, 1.4, if(s > 1.3e-3, 0.2, 1.4 - 1000*(s - 1e-4)))"),
        formula("0.8 + 500*(abs(s - 1.3e-3) - abs(s - 1e-4))"),
    ];
    let specials = laws.map(|law| {
        let mut base = scene("one_node.toml");
        base.friction.as_mut().expect("friction").coefficient = Some(law);
        let push = |scene: &mut Scene, value: f64| {
            scene.tractions[0].value = [value.into(), 0.0.into(), (-4e-3).into()];
        };
        let Followed { branches, .. } = follow(&base, [-2e-3, 8e-3], true, push);
        require_consistent(&branches);
        let special = points(&branches).filter(|point| point.kind != PointKind::Regular);
        special
            .map(|point| (point.kind, point.parameter, point.switches.clone()))
            .collect::<Vec<_>>()
    });
    let knots = |switch: &Switch| matches!(switch, Switch::Knot(..));
    let with_knots = specials[0].iter().filter(|(.., s)| s.iter().any(knots));
    assert!(with_knots.count() >= 2, "no knot is met");
    for other in &specials[1..] {
        assert_eq!(other.len(), specials[0].len());
        for (one, two) in specials[0].iter().zip(other) {
            assert_eq!((one.0, &one.2), (two.0, &two.2));
            // Places are located to 1e-12 of the range; coefficients of both kinds of law differ by rounding, times 1/F' of
            // 1e3 per unit of slip.
            assert!((one.1 - two.1).abs() < 1e-12, "{one:?} {two:?}");
        }
    }
}

/// All slips of one node under a ramp by scanning its scalar equation, against the number of solutions on the paths.
#[test]
fn one_node_under_a_falling_coefficient_has_the_solutions_of_its_scalar_equation() {
    require_solutions_of_the_scalar_equation(Ramp {
        initial: 1.4,
        residual: 0.2,
        onset: 1e-4,
        rate: 1000.0,
    });
}

/// At its end this ramp doubles 1/F within 1e-7 m, a hundredth of the slip that loads move over the difference by which they are
/// differentiated: R itself must not be differenced there.
#[test]
fn one_node_under_a_coefficient_that_all_but_vanishes_has_the_solutions_of_its_scalar_equation() {
    require_solutions_of_the_scalar_equation(Ramp {
        initial: 1.4,
        residual: 0.01,
        onset: 0.0,
        rate: 1e5,
    });
}

fn require_solutions_of_the_scalar_equation(ramp: Ramp) {
    let mut base = scene("one_node.toml");
    base.friction.as_mut().expect("friction").coefficient = Some(Coefficient::Ramp(ramp));
    let push = |scene: &mut Scene, value: f64| {
        scene.tractions[0].value = [value.into(), 0.0.into(), (-4e-3).into()];
    };
    let range = [-2e-3, 8e-3];
    let Followed { branches, .. } = follow(&base, range, true, push);
    require_consistent(&branches);
    let ends = range.map(|value| follow(&base, [value, value + 1e-9], false, push).dual);
    let (s, _) = planar(&ends[0]);
    let h_at = |value: f64| {
        let share = (value - range[0]) / (range[1] - range[0]);
        [0, 1].map(|k| ends[0].rhs[k] + share * (ends[1].rhs[k] - ends[0].rhs[k]))
    };
    let friction =
        |slip: f64| (ramp.initial - ramp.rate * (slip - ramp.onset).max(0.0)).max(ramp.residual);
    // The integral of u_t over the node's patch, over its area, is the slip.
    let pressed = points(&branches).find(|point| point.largest_pressure > 0.0);
    let area = pressed.map_or(f64::NAN, |point| point.normal_force / point.multiplier[0]);
    // The slip that the stresses of a slip leave, less that slip; the direction has a sign.
    let excess = |h: [f64; 2], sign: f64, slip: f64| {
        let bound = sign * friction(slip);
        let normal = h[0] / (s[0][0] + bound * s[0][1]);
        (
            normal,
            sign * (h[1] - s[1][0] * normal - s[1][1] * bound * normal) / area - slip,
        )
    };
    let count = |value: f64| {
        let h = h_at(value);
        let mut solutions = usize::from(h[0] < 0.0);
        let determinant = s[0][0] * s[1][1] - s[0][1] * s[1][0];
        let stick = [
            (s[1][1] * h[0] - s[0][1] * h[1]) / determinant,
            (s[0][0] * h[1] - s[1][0] * h[0]) / determinant,
        ];
        solutions += usize::from(stick[0] > 0.0 && stick[1].abs() < ramp.initial * stick[0]);
        for sign in [1.0, -1.0] {
            let steps = 200_000;
            let widest = 4e-2;
            let mut last = excess(h, sign, 0.0);
            for k in 1..=steps {
                let next = excess(h, sign, widest * f64::from(k) / f64::from(steps));
                if last.0 > 0.0 && next.0 > 0.0 && (last.1 > 0.0) != (next.1 > 0.0) {
                    solutions += 1;
                }
                last = next;
            }
        }
        solutions
    };
    let folds = points(&branches)
        .filter(|point| matches!(point.kind, PointKind::Fold | PointKind::KinkFold));
    assert!(folds.count() >= 2, "the ramp is too flat to show anything");
    let mut seen = std::collections::BTreeSet::new();
    for k in 1..40 {
        let value = range[0] + (range[1] - range[0]) * f64::from(k) / 40.3;
        let expected = count(value);
        assert_eq!(crossings(&branches, value), expected, "at {value}");
        seen.insert(expected);
    }
    assert!(
        seen.len() > 1,
        "one number of solutions everywhere: {seen:?}"
    );
}

/// All 16 states of two nodes that move in a plane.
fn enumerated(dual: &ExplicitDual, friction: f64) -> Vec<Vec<f64>> {
    let unknowns: Vec<usize> = (0..dual.dimension())
        .filter(|&j| dual.column(j)[j] > 0.0)
        .collect();
    assert_eq!(unknowns.len(), 4, "two nodes in a plane");
    let s = DMatrix::from_fn(4, 4, |i, j| dual.column(unknowns[j])[unknowns[i]]);
    let h = DVector::from_fn(4, |i, _| dual.rhs[unknowns[i]]);
    let mut found = Vec::new();
    for code in 0..16 {
        let states = [code % 4, code / 4];
        let (mut matrix, mut rhs) = (s.clone(), h.clone());
        for (node, state) in states.into_iter().enumerate() {
            let mut row = |i: usize, entries: &[(usize, f64)]| {
                matrix.row_mut(i).fill(0.0);
                entries
                    .iter()
                    .for_each(|(j, value)| matrix[(i, *j)] = *value);
                rhs[i] = 0.0;
            };
            match state {
                0 => {
                    row(node, &[(node, 1.0)]);
                    row(2 + node, &[(2 + node, 1.0)]);
                }
                1 => {}
                state => {
                    let sign = if state == 2 { 1.0 } else { -1.0 };
                    row(2 + node, &[(2 + node, 1.0), (node, -sign * friction)]);
                }
            }
        }
        let Some(l) = matrix.lu().solve(&rhs) else {
            continue;
        };
        let r = &s * &l - &h;
        let holds = |(node, state): (usize, usize)| match state {
            0 => r[node] >= 0.0,
            1 => l[node] >= 0.0 && l[2 + node].abs() <= friction * l[node],
            2 => l[node] >= 0.0 && r[2 + node] <= 0.0,
            _ => l[node] >= 0.0 && r[2 + node] >= 0.0,
        };
        if states.into_iter().enumerate().all(holds) {
            let mut multiplier = vec![0.0; dual.dimension()];
            let pairs = unknowns.iter().zip(l.iter());
            pairs.for_each(|(j, l)| multiplier[*j] = *l);
            found.push(multiplier);
        }
    }
    found
}

/// Two nodes: every point of every path is one of the enumerated solutions, and none of them is missing.
#[test]
fn two_nodes_have_the_solutions_of_all_their_states_at_every_friction() {
    let Followed { branches, dual } =
        follow(&scene("two_nodes.toml"), [0.3, 3.0], true, set_friction);
    require_consistent(&branches);
    assert!(branches.is_followed() && !branches.is_incomplete());
    for point in points(&branches).filter(|point| point.kind == PointKind::Regular) {
        let near = enumerated(&dual, point.parameter).into_iter().map(|known| {
            norm(&contact3d::linalg::difference(&known, &point.multiplier)) / norm(&known)
        });
        let nearest = near.fold(f64::INFINITY, f64::min);
        // Rounding of systems of condition 1e3.
        assert!(nearest < 1e-12, "{nearest} {point:?}");
    }
    let mut most = 0;
    for k in 1..200 {
        let friction = 0.3 + 2.7 * f64::from(k) / 200.37;
        let expected = enumerated(&dual, friction).len();
        assert_eq!(crossings(&branches, friction), expected, "F = {friction}");
        most = most.max(expected);
    }
    assert_eq!(most, 5);
    assert_eq!((branches.degree(0.3), branches.degree(3.0)), (1, 1));
    let branch_points: Vec<&PathPoint> = points(&branches)
        .filter(|point| point.kind == PointKind::BranchPoint)
        .collect();
    // Both nodes stick with |λ_t| = 2 λ_ν: four half paths meet at F = 2.
    assert!(!branch_points.is_empty());
    branch_points
        .iter()
        .for_each(|point| assert!((point.parameter - 2.0).abs() < 1e-12));
}

/// A coefficient that falls from 5 to 0.01 within 1e-5 m of slip bends paths within millionths of the range: as the load grows from
/// nothing, two panes of the symmetric body begin to slip at once, and the path goes back from there.
#[test]
fn a_path_passes_the_kinks_of_a_strongly_weakening_law() {
    let mut base = scene("brick.toml");
    if let Some(brick) = base.as_brick_mut() {
        brick.cells = [12, 4, 4];
    }
    let ramp = Ramp {
        initial: 5.0,
        residual: 0.01,
        onset: 0.0,
        rate: 4.99e5,
    };
    let friction = base.friction.as_mut().expect("friction");
    friction.coefficient_1 = Some(Coefficient::Ramp(ramp));
    friction.coefficient_2 = Some(Coefficient::Ramp(ramp));
    let Followed { branches, .. } = follow(&base, [0.02, 0.3], false, load_in_part);
    let first = &branches.paths[0];
    for path in &branches.paths {
        let (last, earlier) = path.points.split_last().expect("points");
        // What a certified point may have.
        assert!(earlier.iter().all(|point| point.residual <= 1e-8));
        assert!(last.residual <= 1e-8 || path.end == PathEnd::Uncertified);
    }
    let mut special = first.points.clone();
    special.retain(|point| point.kind != PointKind::Regular);
    assert_eq!(
        (special[1].kind, special[1].switches.len()),
        (PointKind::BranchPoint, 2)
    );
    assert!(special[2].zones == [2, 8, 2] && !special[2].is_attracting());
    let ends: Vec<PathEnd> = branches.paths.iter().map(|path| path.end).collect();
    assert!(branches.is_followed(), "{ends:?}");
}

/// A share of the published tractions.
fn load_in_part(scene: &mut Scene, share: f64) {
    scene.tractions[0].value = [(1e7 * share).into(), 0.0.into(), (2e7 * share).into()];
    scene.tractions[1].value = [0.0.into(), 0.0.into(), (-3e7 * share).into()];
}
