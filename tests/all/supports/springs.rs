//! Faces on springs.

use contact3d::{
    Problem,
    scene::{Clamp, Component, DualOperatorKind, Method, Scene, Spring},
    solver::Status,
};

use super::{close, support::Case};

const YOUNG: f64 = 2e11;
const SIZE: [f64; 3] = [1.0, 0.8, 1.5];

/// A block with whatever holds and loads it.
fn block(element: &str, poisson: f64, tables: &str) -> String {
    format!(
        "title = 'on springs'
        [body]
        element = '{element}'
        [body.brick]
        size = {SIZE:?}
        cells = [4, 4, 3]
        [material.isotropic]
        young_modulus = {YOUNG:?}
        poisson_ratio = {poisson}
        {tables}"
    )
}

/// Backsolves with condition numbers near 1e4.
const ROUNDING: f64 = 1e-10;

const SIDES: &str = "[[clamp]]\nface = 'x_min'\ncomponents = ['x']\n[[clamp]]\nface = 'y_min'\ncomponents = ['y']\n";

/// u_z = −p/k − p z/E under a pressure p on a bed of springs k.
#[test]
fn a_block_on_a_bed_of_springs_sinks_by_the_pressure_over_the_stiffness() {
    let (p, k) = (3e7, 5e11);
    for element in ["P1", "P2"] {
        let bed = format!(
            "[[spring]]\nface = 'z_min'\nnormal = {k:?}\n[[pressure]]\nface = 'z_max'\nvalue = {p:?}\n"
        );
        let case = Case::of(&block(element, 0.3, &format!("{SIDES}{bed}")));
        let strain = p / YOUNG;
        for (u, [x, y, z]) in case.displacement().iter().zip(&case.mesh().coordinates) {
            close(
                u,
                &[0.3 * strain * x, 0.3 * strain * y, -p / k - strain * z],
                ROUNDING,
            );
        }
        let report = case.report();
        let r = report.resultants;
        let area = SIZE[0] * SIZE[1];
        close(&r.spring_force.unwrap(), &[0.0, 0.0, p * area], ROUNDING);
        close(
            &[r.spring_energy.unwrap()],
            &[0.5 * p * p / k * area],
            ROUNDING,
        );
        close(&[2.0 * r.strain_energy], &[r.load_work], ROUNDING);
        let row = report
            .forces
            .iter()
            .find(|row| row.source == "spring.0")
            .unwrap();
        close(&row.force, &[0.0, 0.0, p * area], ROUNDING);
        let moment = [p * area * SIZE[1] / 2.0, -p * area * SIZE[0] / 2.0, 0.0];
        close(&row.moment, &moment, ROUNDING);
        assert!(r.force_imbalance < 1e-12 && r.moment_imbalance < 1e-12);
        // A state that the elements hold has no error to find.
        assert!(report.discretisation_error.relative() < 1e-9);
    }
}

/// Springs K under tractions K c move the whole body by c without strain, whatever the axes of K and however it varies;
/// nothing else holds the body.
#[test]
fn tensors_in_rotated_axes_push_back_as_they_should() {
    // R diag(9, 4, 1) Rᵀ for the rotation with the columns (2, 1, 2)/3, (−2, 2, 1)/3, (−1, −2, 2)/3, times 9.
    let tensor = [[53.0, 4.0, 26.0], [4.0, 29.0, 22.0], [26.0, 22.0, 44.0]];
    let c = [1e-5, -2e-5, 3e-5];
    for factor in ["1e9", "1e9*(1 + 0.5*x*y)"] {
        let row = |i: usize, by: &str| {
            tensor[i]
                .map(|k: f64| format!("'{k:?}*{factor}{by}'"))
                .join(", ")
        };
        let rows = [0, 1, 2].map(|i| format!("[{}]", row(i, ""))).join(", ");
        let traction = [0, 1, 2].map(|i| {
            let k_c: f64 = (0..3).map(|j| tensor[i][j] * c[j]).sum();
            format!("'{k_c:e}*{factor}'")
        });
        let traction = traction.join(", ");
        for (element, clamp) in [
            ("P1", String::new()),
            ("P2", String::new()),
            // A held component of the same face couples to the free ones through the springs.
            (
                "P2",
                format!(
                    "[[clamp]]\nface = 'z_min'\ncomponents = ['z']\nvalue = [0.0, 0.0, {:?}]\n",
                    c[2]
                ),
            ),
        ] {
            let case = Case::of(&block(
                element,
                0.3,
                &format!(
                    "{clamp}[[spring]]\nface = 'z_min'\ntensor = [{rows}]\n[[traction]]\nface = 'z_min'\nvalue = [{traction}]\n"
                ),
            ));
            for u in case.displacement() {
                // Softer than the body by some orders of magnitude, which the backsolves feel.
                close(&u, &c, 1e-8);
            }
            let r = case.report().resultants;
            let forces = [r.applied_force, r.spring_force.unwrap(), r.clamp_force];
            let sum: Vec<f64> = (0..3).map(|k| forces.iter().map(|f| f[k]).sum()).collect();
            let size = r
                .applied_force
                .iter()
                .fold(0.0_f64, |most, f| most.max(f.abs()));
            assert!(sum.iter().all(|s| s.abs() < 1e-8 * size), "{sum:?}");
        }
    }
}

/// Stiffer and stiffer springs tend to the clamp with order 1/k, with contact and friction, too.
#[test]
fn stiff_springs_tend_to_the_clamp() {
    for (element, contact) in [
        ("P1", "multipliers = 'panes'"),
        ("P2", "multipliers = 'nodal'"),
    ] {
        let text = block(
            element,
            0.3,
            &format!(
                "[[clamp]]\nface = 'x_min'\n[[traction]]\nface = 'x_max'\nvalue = [1e7, 4e6, 1e6]
                [[pressure]]\nface = 'z_max'\nvalue = 3e7\n[contact]\nface = 'z_min'\n{contact}
                [friction]\ncoefficient.constant = 0.3"
            ),
        );
        let scene = Scene::parse("held", &text).unwrap();
        let held = Case::new(scene.clone());
        let sprung = |k: f64| {
            let mut scene = scene.clone();
            scene.clamps.clear();
            scene.springs = vec![Spring {
                face: "x_min".to_owned(),
                normal: Some(k.into()),
                tangential: Some(k.into()),
                ..Spring::default()
            }];
            let case = Case::new(scene);
            assert_eq!(case.solution.status, Status::Converged);
            assert!(case.report().certificate.worst() < 1e-10);
            case
        };
        let differences: Vec<f64> = [1e15, 1e16, 1e17]
            .map(|k| {
                let case = sprung(k);
                let (here, there) = (case.displacement(), held.displacement());
                let pairs = here.as_flattened().iter().zip(there.as_flattened());
                let square: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
                let size: f64 = there.as_flattened().iter().map(|u| u * u).sum();
                (square / size).sqrt()
            })
            .to_vec();
        assert!(differences[0] < 1e-2, "{differences:?}");
        for pair in differences.windows(2) {
            // 1/k up to its square, which is below a per cent of it here.
            assert!(
                (pair[0] / pair[1] / 10.0 - 1.0).abs() < 0.05,
                "{differences:?}"
            );
        }
    }
}

/// Springs, prescribed displacements and friction together, by Newton's method and by successive approximations with the implicit
/// operator.
#[test]
fn methods_agree_on_springs() {
    let scene = |element: &str| {
        let text = block(
            element,
            0.3,
            "[[clamp]]\nface = 'z_max'\nvalue = [2e-6, 1e-6, -1e-5]
            [[spring]]\nface = 'x_min'\nnormal = '1e12*(1 + y)'\ntangential = 3e11
            [contact]\nface = 'z_min'\ngap = '1e-6*x'
            [friction]\ncoefficient.ramp = { initial = 0.3, residual = 0.2, onset = 1e-7, rate = 3e4 }",
        );
        Scene::parse("springs", &text).unwrap()
    };
    for element in ["P1", "P2"] {
        let newton = Case::new(scene(element));
        assert_eq!(newton.solution.status, Status::Converged);
        assert!(newton.report().certificate.worst() < 1e-10);
        let mut other = scene(element);
        other.assemble.dual_operator = DualOperatorKind::Implicit;
        other.solve.method = Method::FixedPoint;
        other.solve.epsilon = Some(1e-10);
        let other = Case::new(other);
        // ε = 1e-10 of the changes, which contract by a tenth or so.
        close(
            &other.solution.multiplier,
            &newton.solution.multiplier,
            1e-8,
        );
        // The energy balance: a(u, u) = work of the clamp − Σ |R| λ·u.
        let report = newton.report();
        let r = &report.resultants;
        let against: f64 = report
            .panes
            .iter()
            .zip(&newton.mesh().contact.as_ref().unwrap().pane_area)
            .enumerate()
            .map(|(i, (pane, area))| {
                let state = newton.contact_side().unwrap();
                let gap = state.interface.gap.as_ref().unwrap();
                let weights = state.surface.pane_weights(i);
                let mean: f64 = weights.map(|(node, weight)| weight * gap[node]).sum();
                let friction = pane.friction.unwrap();
                let along: f64 = (0..2).map(|k| friction.stress[k] * friction.slip[k]).sum();
                area * (-pane.normal_stress * (mean - pane.gap) - along)
            })
            .sum();
        let balance = r.clamp_work.unwrap() + r.load_work - against;
        close(&[2.0 * r.strain_energy], &[balance], 1e-9);
    }
}

#[test]
fn springs_that_hold_too_little_or_push_are_refused() {
    let refused = |tables: &str| match Scene::parse("refused", &block("P1", 0.3, tables)) {
        Err(error) => error.to_string(),
        Ok(scene) => {
            let problem = Problem::new(scene).and_then(Problem::assemble);
            problem.expect_err("unusable springs").to_string()
        }
    };
    let found = refused("[[spring]]\nface = 'z_min'\nnormal = 1e10\n");
    for motion in [
        "translation along x",
        "translation along y",
        "rotation about z",
    ] {
        assert!(found.contains(motion), "{found}");
    }
    assert!(
        !found.contains("along z") && !found.contains("about x"),
        "{found}"
    );
    for (spring, words) in [
        ("normal = -1.0", ">= 0"),
        ("normal = 'x - 0.5'", "not negative"),
        (
            "normal = 1.0\ntensor = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
            "both",
        ),
        ("", "neither"),
        ("tensor = [[1, 0, 0], [0, 1, 0.1], [0, 0, 1]]", "symmetric"),
        ("tensor = [[1, 2, 0], [2, 1, 0], [0, 0, 1]]", "semidefinite"),
        ("tangential = 'ln(x - 2)'", "finite"),
    ] {
        let found = refused(&format!(
            "[[clamp]]\nface = 'x_min'\n[[spring]]\nface = 'z_min'\n{spring}\n"
        ));
        assert!(
            found.contains("spring.0") && found.contains(words),
            "{spring}: {found}"
        );
    }
    let found = refused(
        "[[clamp]]\nface = 'x_min'\n[[spring]]\nface = 'z_min'\nnormal = 1.0\n[contact]\nface = 'z_min'\n",
    );
    assert!(found.contains("spring.0.face"), "{found}");
}

/// In a slide along x, where nothing else is held, springs of stiffness k A have k A r²/(c V) of the body's own stiffness: refused below
/// 1e-9, an unknown motion above.
#[test]
fn springs_hold_a_body_in_contact_by_a_billionth_of_its_stiffness_or_are_refused() {
    // n cells of a side L have their nodes at a mean square of L² (n + 2) / 12 n from the middle; V / A is 1, and c is 2 G.
    let squares = SIZE.iter().zip([4.0, 4.0, 3.0]);
    let radius: f64 = squares.map(|(l, n)| l * l * (n + 2.0) / (12.0 * n)).sum();
    let assembled = |share: f64| {
        let k = share * YOUNG / 1.3 / radius;
        let tables = format!(
            "[[clamp]]\nface = 'y_min'\ncomponents = ['y']\n[[clamp]]\nface = 'z_max'\ncomponents = ['z']\n\
             [[spring]]\nface = 'x_max'\ntensor = [[{k:?}, 0, 0], [0, 0, 0], [0, 0, 0]]\n[contact]\nface = 'z_min'\n"
        );
        let scene = Scene::parse("soft", &block("P1", 0.3, &tables)).unwrap();
        Problem::new(scene).unwrap().assemble()
    };
    let found = assembled(0.99e-9).expect_err("too soft").to_string();
    for words in ["spring", "9.9e-10 of it in a translation along x", "remove"] {
        assert!(found.contains(words), "{found}");
    }
    assert!(assembled(1.01e-9).is_ok());
}

/// A spring under a part of a face's components that are held, and none under the others, is no contradiction.
#[test]
fn springs_beside_clamps_share_a_face() {
    let text = block(
        "P1",
        0.0,
        "[[pressure]]\nface = 'z_max'\nvalue = 1e7\n[[spring]]\nface = 'z_min'\nnormal = 1e12\n",
    );
    let scene = Scene::parse("shared", &text).unwrap();
    let rollers = Clamp::face("z_min").along(&[Component::X, Component::Y]);
    let case = Case::new(scene.with_clamp(rollers));
    for (u, [_, _, z]) in case.displacement().iter().zip(&case.mesh().coordinates) {
        close(u, &[0.0, 0.0, -1e7 / 1e12 - 1e7 / YOUNG * z], ROUNDING);
    }
}

/// A block on the floor, pushed with 5e4 N/m³ and held along that direction by given slip bounds alone, which could hold 7e4: Newton's
/// steps along it are long while all panes slip, and none of them may pass for rounding. Friction carries the whole push.
#[test]
fn friction_holds_what_a_weak_spring_does_not() {
    let (push, bound) = (5e4, 3.5e4);
    for normal in [1e4, 1e8] {
        let case = Case::of(&format!(
            "title = 'pushed'
            [body.brick]
            size = [0.8, 2.8, 0.5]
            cells = [2, 6, 1]
            [material.isotropic]
            young_modulus = 3e11
            poisson_ratio = 0.3
            [body_force]
            value = [0.0, {push}, 0.0]
            [[spring]]
            face = 'x_max'
            normal = {normal}
            [[pressure]]
            face = 'z_max'
            value = 4e5
            [contact]
            face = 'z_min'
            [friction]
            slip_bound = {bound}"
        ));
        assert!(
            case.solution.status.is_solved(),
            "{normal}: {:?}",
            case.solution.status
        );
        let panes = case.report().panes;
        let stresses = panes.iter().map(|pane| pane.friction.unwrap().stress);
        let (mut carried, mut most) = (0.0, 0.0_f64);
        for [across, along] in stresses {
            carried += along * 0.8 * 2.8 / panes.len() as f64;
            most = most.max(across.hypot(along));
        }
        close(&[carried], &[-push * 0.8 * 2.8 * 0.5], ROUNDING);
        assert!(most <= bound * (1.0 + ROUNDING), "{most}");
    }
}
