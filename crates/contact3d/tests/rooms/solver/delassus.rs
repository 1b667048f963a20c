//! Closed forms, problems whose forces are not unique, and problems that both solvers must solve alike.

use nalgebra::{DMatrix, DVector};

use contact3d::{
    linalg::CscMatrix,
    solver::{
        DelassusError, DelassusMethod, DelassusProblem, DelassusSettings, DelassusSolution,
        DelassusStatus, Obstruction, solve_delassus,
    },
};

fn sparse(matrix: &DMatrix<f64>) -> CscMatrix {
    let mut sparse = CscMatrix::empty(matrix.nrows());
    for column in matrix.column_iter() {
        let entries = column
            .iter()
            .enumerate()
            .filter(|(_, value)| **value != 0.0);
        for (row, value) in entries {
            sparse.indices.push(row);
            sparse.data.push(*value);
        }
        sparse.indptr.push(sparse.indices.len());
        sparse.cols += 1;
    }
    sparse
}

fn problem(matrix: &DMatrix<f64>, offset: &[f64], mu: &[f64]) -> DelassusProblem {
    DelassusProblem::new(sparse(matrix), offset.to_vec(), mu.to_vec()).expect("a problem")
}

/// The methods that solve small problems by themselves.
const EXACT: [DelassusMethod; 3] = [
    DelassusMethod::Newton,
    DelassusMethod::Gpcg,
    DelassusMethod::Nsgs,
];

fn solved(problem: &DelassusProblem, method: DelassusMethod) -> DelassusSolution {
    let settings = DelassusSettings {
        method,
        ..DelassusSettings::default()
    };
    let solution = solve_delassus(problem, &settings);
    assert_eq!(
        solution.status,
        DelassusStatus::Converged,
        "{method:?}: {solution:?}"
    );
    assert!(solution.error <= 1e-10 && solution.scaled_error <= 1e-10);
    solution
}

/// W = diag(2, 4, 4): open for q_N ≥ 0, else r_N = −q_N/2, stick while ‖q_T‖/4 ≤ μ r_N.
#[test]
fn one_contact_in_closed_form() {
    let w = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 4.0, 4.0]));
    let cases = [
        ([1.0, 5.0, 5.0], [0.0, 0.0, 0.0]),
        ([-2.0, 0.8, 0.6], [1.0, -0.2, -0.15]),
        ([-2.0, 30.0, 40.0], [1.0, -0.5 * 0.6, -0.5 * 0.8]),
    ];
    for method in EXACT {
        for (q, r) in cases {
            let solution = solved(&problem(&w, &q, &[0.5]), method);
            for (found, expected) in solution.force.iter().zip(r) {
                // The tolerance of the solve times ‖u‖ = 50.
                assert!(
                    (found - expected).abs() <= 5e-9,
                    "{method:?} {q:?}: {:?}",
                    solution.force
                );
            }
        }
    }
}

#[test]
fn without_friction_there_are_no_tangential_forces() {
    let w = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0]);
    let solution = solved(
        &problem(&w, &[-1.0, 3.0, 1.0], &[0.0]),
        DelassusMethod::Auto,
    );
    assert_eq!(solution.force, [0.5, 0.0, 0.0]);
    assert_eq!(solution.velocity, [0.0, 3.5, 1.0]);
}

#[test]
fn nothing_pushes_and_nothing_is_there() {
    let w = DMatrix::identity(3, 3);
    assert_eq!(
        solved(&problem(&w, &[0.0; 3], &[0.5]), DelassusMethod::Auto).force,
        [0.0; 3]
    );
    let none = problem(&DMatrix::zeros(0, 0), &[], &[]);
    assert!(solved(&none, DelassusMethod::Auto).force.is_empty());
}

/// A point of a body: its number, and the point from the centre.
type At = (usize, [f64; 3]);

/// Unit cubes of mass 1 that would move with a velocity, and touch at points: the body above and its point from its centre, and those of
/// the body below, `None` for the ground. W = HᵀM⁻¹H.
fn problem_of_bodies(
    n_bodies: usize,
    contacts: &[(usize, [f64; 3], Option<At>)],
    velocity: [f64; 3],
    mu: f64,
) -> DelassusProblem {
    let mut h = DMatrix::<f64>::zeros(6 * n_bodies, 3 * contacts.len());
    for (c, &(upper, arm, lower)) in contacts.iter().enumerate() {
        let below = lower.map(|(body, arm)| (body, arm, -1.0));
        for (body, [x, y, z], sign) in below.into_iter().chain([(upper, arm, 1.0)]) {
            // Velocities of the point along N = z, T1 = x, T2 = y for the twist (v, ω).
            let rows = [
                [0.0, 0.0, 1.0, y, -x, 0.0],
                [1.0, 0.0, 0.0, 0.0, z, -y],
                [0.0, 1.0, 0.0, -z, 0.0, x],
            ];
            for (k, row) in rows.iter().enumerate() {
                for (twist, value) in row.iter().enumerate() {
                    h[(6 * body + twist, 3 * c + k)] += sign * value;
                }
            }
        }
    }
    let of_all = |of_one: [f64; 6]| DVector::from_vec(of_one.repeat(n_bodies));
    let inverse = DMatrix::from_diagonal(&of_all([1.0, 1.0, 1.0, 6.0, 6.0, 6.0]));
    let [vx, vy, vz] = velocity;
    let free = of_all([vx, vy, vz, 0.0, 0.0, 0.0]);
    let w = h.transpose() * inverse * &h;
    let w = (&w + w.transpose()) * 0.5;
    let q = h.transpose() * free;
    problem(&w, q.as_slice(), &vec![mu; contacts.len()])
}

/// A unit cube of mass 1 that rests on n × n points: six degrees of freedom, W of rank six.
fn resting_cube(side: usize, push: f64, mu: f64) -> DelassusProblem {
    let at = |i: usize| i as f64 / (side - 1) as f64 - 0.5;
    let points = (0..side * side).map(|k| (0, [at(k % side), at(k / side), -0.5], None));
    problem_of_bodies(1, &points.collect::<Vec<_>>(), [push, 0.0, -1.0], mu)
}

/// Cubes on each other, each on four points, and the lowest on the ground: forces that move two cubes only.
fn tower(n: usize) -> DelassusProblem {
    let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]];
    let contacts = (0..n).flat_map(|k| {
        let below = k.checked_sub(1);
        corners.map(|[x, y]| (k, [x, y, -0.5], below.map(|below| (below, [x, y, 0.5]))))
    });
    problem_of_bodies(n, &contacts.collect::<Vec<_>>(), [0.05, 0.0, -1.0], 0.5)
}

/// Forces are not unique, but their resultant is: weight 1, and friction that holds the push or slides at μ.
#[test]
fn a_singular_matrix_leaves_the_resultant_alone() {
    for method in EXACT {
        for (push, mu, friction) in [(0.2, 0.5, -0.2), (0.8, 0.5, -0.5)] {
            let cube = resting_cube(4, push, mu);
            let solution = solved(&cube, method);
            let total = |k: usize| -> f64 { solution.force.iter().skip(k).step_by(3).sum() };
            let expected = [1.0, friction, 0.0];
            for k in 0..3 {
                // Sixteen forces, each as accurate as the tolerance of the solve times ‖u‖ ≤ 6 over the least eigenvalue, about 1.
                assert!(
                    (total(k) - expected[k]).abs() <= 1e-8,
                    "{method:?}: {} for {:?}",
                    total(k),
                    expected
                );
            }
        }
    }
}

/// W = Gᵀ G + I for entries of a linear congruential generator: unique for small μ, so all solvers find the same forces.
#[test]
fn all_solvers_find_the_same_forces_in_any_units() {
    let mut state = 7_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let n = 12;
    let g = DMatrix::from_fn(3 * n, 3 * n, |_, _| 0.1 * next());
    let w = g.transpose() * &g + DMatrix::identity(3 * n, 3 * n);
    let q: Vec<f64> = (0..3 * n).map(|_| next()).collect();
    let mu: Vec<f64> = (0..n)
        .map(|c| {
            if c % 4 == 3 {
                0.0
            } else {
                0.1 + 0.05 * c as f64
            }
        })
        .collect();
    let given = problem(&w, &q, &mu);
    let newton = solved(&given, DelassusMethod::Newton).force;
    let largest = newton.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    let others = [DelassusMethod::Gpcg, DelassusMethod::Nsgs];
    let others = others.map(|method| solved(&given, method).force).concat();
    for (a, b) in newton.iter().cycle().zip(&others) {
        // Twice the tolerance of a solve over the least eigenvalue 1 of W, times ‖u‖ < 6 r_max.
        assert!((a - b).abs() <= 2e-9 * largest, "{a} {b}");
    }
    // In units in which velocities are 1e-6 and forces 1e6 times as large, with W at 1e-12.
    let small: Vec<f64> = q.iter().map(|q| q * 1e-6).collect();
    let other = solved(&problem(&(w * 1e-12), &small, &mu), DelassusMethod::Auto).force;
    for (a, b) in newton.iter().zip(&other) {
        assert!((1e6 * a - b).abs() <= 1e-8 * 1e6 * largest, "{a} {b}");
    }
}

/// The residuals vanish at solutions only; without forces the largest is what is left of u_N.
#[test]
fn the_error_sees_what_is_wrong() {
    let w = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 4.0, 4.0]));
    let given = problem(&w, &[-2.0, 0.8, 0.6], &[0.5]);
    assert!(given.error(&[1.0, -0.2, -0.15]) < 1e-15);
    let size = (4.0_f64 + 0.64 + 0.36).sqrt();
    // Without forces −û = (2 − 0.5, −0.8, −0.6), whose projection on the cone has the normal part (1.5 + 0.5) / 1.25 and the norm 1.6 √1.25,
    // less than the penetration u_N = −2.
    let expected = 2.0 / size;
    assert!(1.6 * 1.25_f64.sqrt() < 2.0);
    assert!((given.error(&[0.0; 3]) - expected).abs() < 1e-15);
    assert!(given.error(&[1.0, 0.2, 0.15]) > 0.1);
    assert!(given.error(&[-1.0, 0.0, 0.0]) > 0.1);
}

/// Where W = 0 and bodies would have to be pushed apart no forces do; large ones make the residual small relative to them.
#[test]
fn what_has_no_solution_does_not_converge() {
    let mut w = DMatrix::zeros(6, 6);
    w[(0, 0)] = 1.0;
    let given = problem(&w, &[-2.0, 0.8, 0.6, -2.0, 30.0, 40.0], &[0.5; 2]);
    for method in [
        DelassusMethod::Auto,
        DelassusMethod::Newton,
        DelassusMethod::Gpcg,
        DelassusMethod::Nsgs,
    ] {
        let settings = DelassusSettings {
            method,
            ..DelassusSettings::default()
        };
        let solution = solve_delassus(&given, &settings);
        assert_ne!(
            solution.status,
            DelassusStatus::Converged,
            "{method:?}: {solution:?}"
        );
    }
    let mut large = vec![0.0; 6];
    large[3] = 1e12;
    assert!(given.error(&large) < 1e-10 && given.error_by_offset(&large) > 0.01);
}

/// Two points of a body between walls that close by 0.5 each: their velocities along N add up to −1, whatever the forces.
fn squeezed(mu: f64) -> DelassusProblem {
    let h = DMatrix::from_row_slice(1, 6, &[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]);
    let slides = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, 1.0, 2.0, 0.0, 1.0, 1.0]));
    let q = [-0.5, 0.2, -0.1, -0.5, 0.2, 0.1];
    problem(&(h.transpose() * h + slides), &q, &[mu; 2])
}

#[test]
fn a_direction_proves_that_there_is_no_solution() {
    for mu in [0.0, 0.7] {
        let given = squeezed(mu);
        // Forces that swallow velocities: r − P(r − û) is rounded to 0, the penetration of 0.5 is there all the same.
        let jammed = [3e30, 0.0, 0.0, 3e30, 0.0, 0.0];
        assert!(given.error_by_offset(&jammed) > 0.5);
        let solution = solve_delassus(&given, &DelassusSettings::default());
        assert_eq!(solution.status, DelassusStatus::NoSolution, "{solution:?}");
        let proof = solution.separation.expect("a proof");
        assert_eq!(proof.obstruction, Obstruction::Penetration);
        let expected = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        for (found, expected) in proof.direction.iter().zip(expected) {
            // The kernel of W to some units of rounding.
            assert!((found - expected).abs() < 1e-14, "{:?}", proof.direction);
        }
    }
}

/// Walls that stand at 45° to each other jam where μ > 1, but a wedge that moves out of their corner by itself needs no force.
#[test]
fn friction_that_could_jam_proves_nothing() {
    // Velocities of the wedge (x, y) along N and T1 of walls with normals (±1, 1)/√2, and T2 out of the plane.
    let root = 0.5_f64.sqrt();
    let h = DMatrix::from_row_slice(
        2,
        6,
        &[
            root, -root, 0.0, -root, root, 0.0, //
            root, root, 0.0, root, root, 0.0,
        ],
    );
    let w = h.transpose() * &h;
    // Into both walls, against the friction that would have to hold it: −û lies in K.
    let inward = h.transpose() * DVector::from_vec(vec![0.0, -1.0]);
    let close = [-0.5, 0.0, 0.0, -0.5, 0.0, 0.0];
    let q: Vec<f64> = inward.iter().zip(close).map(|(a, b)| a + b).collect();
    let pressed = solve_delassus(&problem(&w, &q, &[2.0; 2]), &DelassusSettings::default());
    assert_ne!(pressed.status, DelassusStatus::NoSolution, "{pressed:?}");
    let outward: Vec<f64> = inward.iter().zip(close).map(|(a, b)| b - a).collect();
    let free = solved(&problem(&w, &outward, &[2.0; 2]), DelassusMethod::Auto);
    assert_eq!(free.force, [0.0; 6]);
}

/// Coefficients of friction up to 9 on a W of rank 8 for 30 forces: proximal steps of a small share find nothing.
#[test]
fn large_friction_on_a_singular_matrix_is_solved_from_easier_problems() {
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    for _ in 0..12 {
        let n = 10;
        let h = DMatrix::from_fn(8, 3 * n, |_, _| next());
        let mu: Vec<f64> = (0..n).map(|_| 0.2 + 4.0 * (1.0 + next())).collect();
        let (mut r, mut u) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
        for c in 0..n {
            let along = [next(), next()];
            let length = along[0].hypot(along[1]);
            match c % 3 {
                0 => u[3 * c..3 * c + 3].copy_from_slice(&[1.0 + next(), along[0], along[1]]),
                1 => r[3 * c] = 1.0 + next(),
                _ => {
                    r[3 * c] = 1.0 + next();
                    for k in 0..2 {
                        u[3 * c + 1 + k] = along[k];
                        r[3 * c + 1 + k] = -mu[c] * r[3 * c] * along[k] / length;
                    }
                }
            }
        }
        let w = h.transpose() * &h;
        let w = (&w + w.transpose()) * 0.5;
        let q = DVector::from_vec(u) - &w * DVector::from_vec(r);
        solved(&problem(&w, q.as_slice(), &mu), DelassusMethod::Newton);
    }
}

#[test]
fn what_is_no_problem_is_refused() {
    let identity = || sparse(&DMatrix::identity(3, 3));
    let refused = |matrix, q: &[f64], mu: &[f64]| {
        DelassusProblem::new(matrix, q.to_vec(), mu.to_vec()).expect_err("refused")
    };
    assert!(matches!(
        refused(identity(), &[0.0; 3], &[-0.1]),
        DelassusError::NegativeFriction { contact: 0, .. }
    ));
    assert!(matches!(
        refused(identity(), &[0.0; 2], &[0.1]),
        DelassusError::Sizes { offset: 2, .. }
    ));
    assert!(matches!(
        refused(identity(), &[0.0, f64::NAN, 0.0], &[0.1]),
        DelassusError::NotFinite {
            array: "q",
            at: 1,
            ..
        }
    ));
    let mut skew = DMatrix::identity(3, 3);
    skew[(0, 2)] = 0.5;
    assert!(matches!(
        refused(sparse(&skew), &[0.0; 3], &[0.1]),
        DelassusError::NotSymmetric { .. }
    ));
    let negative = sparse(&(-DMatrix::<f64>::identity(3, 3)));
    assert!(matches!(
        refused(negative, &[0.0; 3], &[0.1]),
        DelassusError::NegativeDiagonal { row: 0, .. }
    ));
}

#[test]
fn a_tower_is_sparse_and_one_cube_is_not() {
    assert!(tower(30).is_sparse());
    assert!(!resting_cube(8, 0.2, 0.5).is_sparse());
}

/// More contacts than `auto` would take dense matrices for.
#[test]
fn large_towers_are_left_to_newtons_method() {
    let solution = solve_delassus(
        &tower(60),
        &DelassusSettings {
            method: DelassusMethod::Auto,
            tolerance: 1e-8,
        },
    );
    assert_eq!(solution.status, DelassusStatus::Converged);
}
