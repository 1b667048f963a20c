//! Homogeneous deformations, which all elements represent exactly.

use contact3d::solver::Status;

use super::{close, support::Case};

const YOUNG: f64 = 2e11;
const SIZE: [f64; 3] = [1.0, 0.8, 1.5];
const PRESSED: f64 = 1e-5;

/// A block between planes of symmetry, pressed down by 1e-5 m.
fn pressed(element: &str, poisson: f64, below: &str) -> Case {
    Case::of(&format!(
        "title = 'pressed'
        body = {{ element = '{element}', brick = {{ size = {SIZE:?}, cells = [4, 4, 3] }} }}
        material.isotropic = {{ young_modulus = {YOUNG:?}, poisson_ratio = {poisson} }}
        [[clamp]]
        face = 'x_min'
        components = ['x']
        [[clamp]]
        face = 'y_min'
        components = ['y']
        [[clamp]]
        face = 'z_max'
        components = ['z']
        value = [0.0, 0.0, {:?}]
        {below}",
        -PRESSED
    ))
}

/// Backsolves with condition numbers near 1e4, and ε of the solve, 1e-12.
const ROUNDING: f64 = 1e-10;

#[test]
fn a_block_pressed_between_rollers_has_the_stress_of_hookes_law() {
    let rollers = "[[clamp]]\nface = 'z_min'\ncomponents = ['z']";
    for element in ["P1", "P2"] {
        let case = pressed(element, 0.3, rollers);
        let report = case.report();
        let stress = -YOUNG * PRESSED / SIZE[2];
        for found in &report.stress {
            close(found, &[0.0, 0.0, stress, 0.0, 0.0, 0.0], ROUNDING);
        }
        let area = SIZE[0] * SIZE[1];
        let force = stress * area;
        let rows: Vec<_> = report.forces.iter().collect();
        assert_eq!(rows.len(), 4);
        assert_eq!(
            (rows[2].source.as_str(), rows[2].face.as_str()),
            ("clamp.2", "z_max")
        );
        close(&rows[2].force, &[0.0, 0.0, force], ROUNDING);
        close(&rows[3].force, &[0.0, 0.0, -force], ROUNDING);
        // The centre of the face times the force.
        let moment = [SIZE[1] / 2.0 * force, -SIZE[0] / 2.0 * force, 0.0];
        close(&rows[2].moment, &moment, ROUNDING);
        let r = report.resultants;
        let work = -force * PRESSED;
        close(&[r.clamp_work.unwrap()], &[work], ROUNDING);
        close(&[r.strain_energy], &[work / 2.0], ROUNDING);
        assert_eq!(r.load_work, 0.0);
        close(
            &r.largest_displacement_along,
            &{
                let side = 0.3 * PRESSED / SIZE[2];
                [side * SIZE[0], side * SIZE[1], PRESSED]
            },
            ROUNDING,
        );
    }
}

#[test]
fn a_block_pressed_on_a_foundation_with_a_gap() {
    let gap = 0.25 * PRESSED;
    for (element, poisson, multipliers, friction, solve) in [
        ("P1", 0.3, "panes", "", ""),
        ("P2", 0.3, "panes", "", ""),
        (
            "P1",
            0.3,
            "nodal",
            "",
            "[assemble]\ndual_operator = 'implicit'",
        ),
        ("P2", 0.3, "nodal", "", ""),
        // Without lateral strain nothing slides, and friction changes nothing.
        (
            "P1",
            0.0,
            "panes",
            "[friction]\ncoefficient.constant = 0.3",
            "",
        ),
        (
            "P2",
            0.0,
            "nodal",
            "[friction]\ncoefficient.constant = 0.3",
            "",
        ),
        (
            "P1",
            0.0,
            "panes",
            "[friction]\ncoefficient.constant = 0.3",
            "[assemble]\nfactor = 'single'",
        ),
    ] {
        let below = format!(
            "[contact]\nface = 'z_min'\ngap = {gap:?}\nmultipliers = '{multipliers}'\n{friction}\n{solve}"
        );
        let case = pressed(element, poisson, &below);
        assert_eq!(case.solution.status, Status::Converged, "{element} {below}");
        let (m, _) = case.sizes();
        let pressure = YOUNG * (PRESSED - gap) / SIZE[2];
        let expected = vec![pressure; m];
        close(&case.solution.multiplier[..m], &expected, ROUNDING);
        let report = case.report();
        let area = SIZE[0] * SIZE[1];
        let contact = report.forces.last().unwrap();
        assert_eq!(
            (contact.source.as_str(), contact.face.as_str()),
            ("contact", "z_min")
        );
        close(&contact.force, &[0.0, 0.0, pressure * area], ROUNDING);
        close(
            &report.forces[2].force,
            &[0.0, 0.0, -pressure * area],
            ROUNDING,
        );
        // 2 J = work of the clamp − work against the contact stresses on the gap.
        let r = report.resultants;
        let energy = 0.5 * pressure * area * (PRESSED - gap);
        close(&[r.strain_energy], &[energy], ROUNDING);
        close(
            &[r.clamp_work.unwrap()],
            &[pressure * area * PRESSED],
            ROUNDING,
        );
    }
}

/// u = G x at all faces is u = G x inside, with constant stress, for any material.
#[test]
fn affine_values_on_all_faces_deform_the_body_affinely() {
    let faces = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];
    let clamps: String = faces
        .map(|face| {
            format!(
                "[[clamp]]\nface = '{face}'\nvalue = ['a*(2*x - y)', 'a*(x + 3*z)', 'a*(z - 4*x)']\n"
            )
        })
        .concat();
    for element in ["P1", "P2"] {
        let case = Case::of(&format!(
            "title = 'affine'
            parameters.a = 1e-5
            [body]
            element = '{element}'
            [body.brick]
            size = {SIZE:?}
            cells = [3, 2, 3]
            [material.isotropic]
            young_modulus = {YOUNG:?}
            poisson_ratio = 0.25
            {clamps}"
        ));
        // ν = 1/4: λ = μ = E/2.5; ε = 1e-5 (2, 0, 1; γ = 3, −4, 0), tr ε = 3e-5.
        let mu = YOUNG / 2.5 * 1e-5;
        let expected = [7.0, 3.0, 5.0, 3.0, -4.0, 0.0].map(|s| s * mu);
        for found in &case.report().stress {
            close(found, &expected, ROUNDING);
        }
        for (u, [x, y, z]) in case.displacement().iter().zip(&case.mesh().coordinates) {
            let exact = [2.0 * x - y, x + 3.0 * z, z - 4.0 * x].map(|v| 1e-5 * v);
            for (found, exact) in u.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-5 * ROUNDING, "{found} {exact}");
            }
        }
    }
}
