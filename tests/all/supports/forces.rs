//! Total forces and moments on faces, and loads and supports on parts of them.

use std::f64::consts::PI;

use contact3d::{
    elasticity::Loads,
    mesh::Mesh,
    scene::{Force, Pressure, Scene},
};

use super::{close, support::Case};

const YOUNG: f64 = 2e11;
const SIZE: [f64; 3] = [1.0, 0.8, 0.5];

/// Sums of nodal forces that partition unity.
const ROUNDING: f64 = 1e-13;

/// Backsolves with condition numbers near 1e4.
const SOLVED: f64 = 1e-10;

fn block(element: &str, cells: [usize; 3], tables: &str) -> String {
    format!(
        "title = 'pressed by a force'
        [body]
        element = '{element}'
        [body.brick]
        size = {SIZE:?}
        cells = {cells:?}
        [material.isotropic]
        young_modulus = {YOUNG:?}
        poisson_ratio = 0.3
        {tables}"
    )
}

const FOOT: &str = "[[clamp]]\nface = 'z_min'\n";

fn scene(text: &str) -> Scene {
    Scene::parse("test", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn on_mesh(scene: &Scene) -> (Mesh, Vec<[f64; 3]>) {
    let mesh = Mesh::of_scene(scene, "".as_ref()).unwrap_or_else(|error| panic!("{error}"));
    let forces = Loads::of(scene).nodal_forces(&mesh).expect("finite loads");
    (mesh, forces)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
}

/// Force, and moment about a point.
fn resultant(mesh: &Mesh, forces: &[[f64; 3]], about: [f64; 3]) -> [[f64; 3]; 2] {
    let mut sums = [[0.0; 3]; 2];
    for (at, force) in mesh.coordinates.iter().zip(forces) {
        let moment = cross([0, 1, 2].map(|c| at[c] - about[c]), *force);
        for c in 0..3 {
            sums[0][c] += force[c];
            sums[1][c] += moment[c];
        }
    }
    sums
}

/// Discs within cells, across them and over an edge, boxes that cut cells, all faces, linear and quadratic: the resultants are those of the
/// scene, and the clamp bears them.
#[test]
fn resultants_are_exact_on_any_mesh() {
    let (force, moment) = ([30.0, -20.0, -500.0], [7.0, -5.0, 3.0]);
    let point = [0.1, 0.2, 0.3];
    for (face, clamp, part, width) in [
        (
            "z_max",
            "z_min",
            "disc = { centre = [0.43, 0.37, 0.5], radius = 0.21 }",
            0.42,
        ),
        (
            "z_max",
            "z_min",
            "disc = { centre = [0.43, 0.37, 0.5], radius = 0.013 }",
            0.026,
        ),
        (
            "z_max",
            "z_min",
            "disc = { centre = [1.0, 0.8, 0.5], radius = 0.4 }",
            0.4,
        ),
        (
            "z_max",
            "z_min",
            "box = [[0.13, 0.31, 0.0], [0.77, 0.52, 1.0]]",
            0.21,
        ),
        (
            "y_min",
            "x_max",
            "disc = { centre = [0.3, 0.0, 0.2], radius = 0.15 }",
            0.3,
        ),
        (
            "x_min",
            "z_max",
            "box = [[0.0, 0.0, 0.11], [0.0, 0.7, 0.3]]",
            0.19,
        ),
        ("x_max", "x_min", "", 0.5),
    ] {
        for (element, cells) in [("P1", [2, 2, 2]), ("P1", [7, 5, 3]), ("P2", [4, 3, 2])] {
            let tables = format!(
                "[[clamp]]\nface = '{clamp}'\n[[force]]\nface = '{face}'\nvalue = {force:?}\nmoment = {moment:?}\npoint = {point:?}\n{part}\n"
            );
            let case = Case::of(&block(element, cells, &tables));
            let forces = Loads::of(case.problem.scene()).nodal_forces(case.mesh());
            let found = resultant(case.mesh(), &forces.expect("finite"), point);
            // A moment on a narrow part makes forces that are larger than the resultants by lengths over its width, at some 1000 points.
            let limit = 1e2 * ROUNDING * SIZE[0] / width;
            close(&found[0], &force, limit);
            close(&found[1], &moment, limit);
            let rows = case.report().forces;
            close(&rows[0].force, &force.map(|part| -part), SOLVED);
            close(&rows[0].moment, &rows[1].moment.map(|part| -part), SOLVED);
        }
    }
}

/// A round post of curved tetrahedra: on its side, on a disc of that, on part of its top.
#[test]
fn resultants_are_exact_on_curved_sides() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/contact3d/tests/meshes");
    let (force, moment, point) = ([3.0, -2.0, 5.0], [0.7, 0.5, -0.3], [1.0, 0.0, 0.25]);
    for part in [
        "face = 'side'",
        "face = 'side'\ndisc = { centre = [1.0, 0.0, 0.25], radius = 0.2 }",
        "face = 'top'\nbox = [[0.1, -0.4, 0.5], [0.6, 0.9, 0.5]]",
    ] {
        let post = scene(&format!(
            "title = 'post'
            body = {{ element = 'P2', gmsh = {{ file = 'post_order2_41.msh' }} }}
            material.isotropic = {{ young_modulus = {YOUNG:?}, poisson_ratio = 0.3 }}
            [[clamp]]
            face = 'foot'
            [[force]]
            value = {force:?}
            moment = {moment:?}
            point = {point:?}
            {part}"
        ));
        let mesh = Mesh::of_scene(&post, folder.as_ref()).unwrap_or_else(|e| panic!("{e}"));
        let forces = Loads::of(&post).nodal_forces(&mesh).expect("finite loads");
        let found = resultant(&mesh, &forces, point);
        close(&found[0], &force, 1e2 * ROUNDING);
        close(&found[1], &moment, 1e2 * ROUNDING);
    }
}

#[test]
fn a_force_on_a_face_is_a_traction_of_force_over_area() {
    let area = SIZE[0] * SIZE[1];
    for element in ["P1", "P2"] {
        let of = |tables: &str| {
            let text = block(element, [5, 4, 2], &format!("{FOOT}{tables}"));
            on_mesh(&scene(&text)).1
        };
        let force = of("[[force]]\nface = 'z_max'\nvalue = [3.0, -7.0, 11.0]\n");
        let traction = [3.0, -7.0, 11.0].map(|part| part / area);
        let traction = of(&format!(
            "[[traction]]\nface = 'z_max'\nvalue = {traction:?}\n"
        ));
        close(force.as_flattened(), traction.as_flattened(), ROUNDING);
    }
}

/// The pressure on a disc is that on its area: of a polygon with 256 sides and the same area, whose second moments are right to 1e-8. Where
/// cells are small beside the disc, nodal forces converge to those of a circle.
#[test]
fn discs_have_their_area_and_second_moments() {
    let (centre, radius, pressure) = ([0.41, 0.39, 0.5], 0.3, 2e6);
    for (element, cells) in [("P1", [3, 2, 1]), ("P1", [20, 16, 1]), ("P2", [6, 5, 1])] {
        let mut scene = scene(&block(element, cells, FOOT));
        let pressed = Pressure::on("z_max", pressure).within(centre, radius);
        scene = scene.with_pressure(pressed);
        let (mesh, forces) = on_mesh(&scene);
        let total = pressure * PI * radius.powi(2);
        let [force, moment] = resultant(&mesh, &forces, centre);
        close(&force, &[0.0, 0.0, -total], ROUNDING);
        assert!(moment[0].abs().max(moment[1].abs()) < 1e-12 * total);
        if element == "P2" {
            let squares = mesh.coordinates.iter().zip(&forces);
            // ∫ x² p of quadratic elements is exact.
            let second: f64 = squares
                .map(|(at, force)| -force[2] * (at[0] - centre[0]).powi(2))
                .sum();
            close(&[second], &[total * radius.powi(2) / 4.0], 1e-7);
        }
    }
}

/// A plate of n × n cells with a hole in the place of one of them, in Gmsh's format 2.2; its faces are `top` and `bottom`.
fn plate_with_hole(n: usize, hole: (usize, usize)) -> String {
    let m = n + 1;
    let node = |[i, j, k]: [usize; 3]| 1 + i + m * (j + m * k);
    let mut elements = Vec::new();
    for (i, j) in (0..n * n)
        .map(|cell| (cell % n, cell / n))
        .filter(|cell| *cell != hole)
    {
        for [a, b, c] in [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [1, 0, 2],
            [0, 2, 1],
            [2, 1, 0],
        ] {
            let mut path = vec![[i, j, 0]];
            for axis in [a, b, c] {
                let mut next = path[path.len() - 1];
                next[axis] += 1;
                path.push(next);
            }
            for (group, level) in [(1, 1), (3, 0)] {
                let at = path.iter().filter(|at| at[2] == level);
                if let [p, q, r] = at.map(|at| node(*at)).collect::<Vec<_>>()[..] {
                    elements.push(format!("2 2 {group} 1 {p} {q} {r}"));
                }
            }
            // Odd permutations turn the tetrahedron inside out.
            if (b + 3 - a) % 3 == 2 {
                path.swap(2, 3);
            }
            let [p, q, r, s] = [0, 1, 2, 3].map(|k| node(path[k]));
            elements.push(format!("4 2 2 1 {p} {q} {r} {s}"));
        }
    }
    let nodes = (0..2 * m * m).map(|n| format!("{} {} {} {}", n + 1, n % m, n / m % m, n / m / m));
    let elements = elements
        .iter()
        .enumerate()
        .map(|(k, element)| format!("{} {element}", k + 1));
    let list = |lines: Vec<String>| format!("{}\n{}", lines.len(), lines.join("\n"));
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"top\"\n2 3 \"bottom\"\n3 2 \"plate\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n$EndNodes\n$Elements\n{}\n$EndElements\n",
        list(nodes.collect()),
        list(elements.collect())
    )
}

/// A washer around a bolt hole: a disc whose centre is in the hole holds what lies around it, one beside the plate is refused.
#[test]
fn discs_may_lie_around_a_hole() {
    let folder = tempfile::tempdir().unwrap();
    let load_on = |plate: String, radius: f64, centre: [f64; 3]| {
        std::fs::write(folder.path().join("plate.msh"), plate).unwrap();
        let text = format!(
            "title = 'washer'
            body.gmsh.file = 'plate.msh'
            material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.3 }}
            clamp = [{{ face = 'bottom' }}]
            pressure = [{{ face = 'top', value = 1.0, disc = {{ centre = {centre:?}, radius = {radius} }} }}]"
        );
        let scene = scene(&text);
        let mesh = Mesh::of_scene(&scene, folder.path()).map_err(|error| error.to_string())?;
        let forces = Loads::of(&scene).nodal_forces(&mesh).expect("finite loads");
        Ok::<_, String>(resultant(&mesh, &forces, centre))
    };
    let load = |centre| load_on(plate_with_hole(3, (1, 1)), 1.2, centre);
    let [force, moment] = load([1.5, 1.5, 1.0]).unwrap();
    // The disc without the hole of 1 × 1.
    close(&force, &[0.0, 0.0, 1.0 - PI * 1.44], ROUNDING);
    assert!(moment.iter().all(|part| part.abs() < 1e-12), "{moment:?}");
    // A quarter of a plate with a hole of 2 × 2.
    let quarter = |centre| load_on(plate_with_hole(2, (0, 0)), 1.8, centre);
    let [force, _] = quarter([0.0, 0.0, 1.0]).unwrap();
    close(&force, &[0.0, 0.0, 1.0 - PI * 0.81], ROUNDING);
    for refused in [
        load([3.2, 1.5, 1.0]),
        load([1.5, 1.5, 1.3]),
        quarter([-0.1, 0.0, 1.0]),
    ] {
        let refused = refused.unwrap_err();
        assert!(refused.contains("disc.centre"), "{refused}");
    }
}

/// u = (κ x ζ, −νκ y ζ, −κ (x² + ν(ζ² − y²))/2) with ζ and y from the axis under M = E I κ: quadratic elements have it exactly. The moment
/// on the end is the linear traction of a beam.
#[test]
fn a_moment_bends_a_block_as_the_closed_form_says() {
    let (nu, kappa) = (0.3, 1e-6);
    let inertia = SIZE[1] * SIZE[2].powi(3) / 12.0;
    let moment = YOUNG * inertia * kappa;
    let (y, z) = (SIZE[1] / 2.0, SIZE[2] / 2.0);
    let tables = format!(
        "[[clamp]]
        face = 'x_min'
        value = [0.0, '-{nu:?}*{kappa:?}*(y - {y:?})*(z - {z:?})', '-{nu:?}*{kappa:?}/2*((z - {z:?})^2 - (y - {y:?})^2)']
        [[force]]
        face = 'x_max'
        moment = [0.0, {moment:?}, 0.0]"
    );
    let case = Case::of(&block("P2", [4, 3, 3], &tables));
    let found = case.displacement();
    let expected = case.mesh().coordinates.iter().map(|at| {
        let (x, y, z) = (at[0], at[1] - y, at[2] - z);
        let deflection = -kappa * (x * x + nu * (z * z - y * y)) / 2.0;
        [kappa * x * z, -nu * kappa * y * z, deflection]
    });
    let expected: Vec<[f64; 3]> = expected.collect();
    close(found.as_flattened(), expected.as_flattened(), SOLVED);
    close(
        &case.report().forces[0].moment,
        &[0.0, -moment, 0.0],
        SOLVED,
    );
    assert!(case.report().discretisation_error.relative() < 1e-8);
}

/// Springs and the traction K c on the same part move the whole body by c without strain, however the part cuts the cells.
#[test]
fn springs_and_tractions_on_a_part_cut_it_alike() {
    for (element, part) in [
        ("P1", "box = [[0.13, 0.31, 0.0], [0.77, 0.52, 1.0]]"),
        ("P2", "disc = { centre = [0.43, 0.37, 0.5], radius = 0.21 }"),
    ] {
        let tables = format!(
            "[[spring]]\nface = 'z_max'\nnormal = 3e12\ntangential = 2e12\n{part}\n[[traction]]\nface = 'z_max'\nvalue = [2e4, 0.0, -6e4]\n{part}\n"
        );
        let case = Case::of(&block(element, [4, 3, 2], &tables));
        for u in case.displacement() {
            close(&u, &[1e-8, 0.0, -2e-8], 1e2 * SOLVED);
        }
        assert!(case.report().discretisation_error.relative() < 1e-6);
    }
}

#[test]
fn boxes_along_cells_are_faces_and_clamps_take_nodes_of_a_face() {
    let pressed = |part: &str| {
        let tables = format!("{FOOT}[[pressure]]\nface = 'z_max'\nvalue = 1e6\n{part}\n");
        on_mesh(&scene(&block("P1", [5, 4, 2], &tables))).1
    };
    assert_eq!(
        pressed(""),
        pressed("box = [[0.0, 0.0, 0.4], [1.0, 0.8, 0.5]]")
    );
    let half = pressed("box = [[0.0, 0.0, 0.5], [1.0, 0.4, 0.5]]");
    close(
        &[half.iter().map(|force| force[2]).sum()],
        &[-0.4e6],
        ROUNDING,
    );
    let held = "[[clamp]]\nface = 'x_min'\nbox = [[0.0, 0.0, 0.0], [1.0, 0.8, 0.25]]\n";
    let scene = scene(&block("P1", [5, 4, 2], held));
    let (mesh, _) = on_mesh(&scene);
    let nodes = mesh.coordinates.iter().zip(mesh.held_nodes(&scene));
    for (at, held) in nodes {
        assert_eq!(held, [at[0] == 0.0 && at[2] <= 0.25; 3], "{at:?}");
    }
}

/// A block that hangs on half of a face bears loads on the other half, and none on what they share.
#[test]
fn a_face_may_be_loaded_beside_its_contact() {
    let text = |box_of_load: &str| {
        block(
            "P1",
            [8, 4, 4],
            &format!(
                "[[clamp]]
                face = 'x_min'
                [contact]
                face = 'z_min'
                box = [[0.0, 0.0, 0.0], [0.5, 0.8, 0.0]]
                [[pressure]]
                face = 'z_min'
                value = 1e6
                box = {box_of_load}"
            ),
        )
    };
    let case = Case::of(&text("[[0.5, 0.3, 0.0], [0.9, 0.8, 0.0]]"));
    let rows = case.report().forces;
    close(&rows[1].force, &[0.0, 0.0, 0.2e6], ROUNDING);
    let refused = Scene::parse("test", &text("[[0.49, 0.3, 0.0], [0.9, 0.8, 0.0]]"));
    let words = refused.expect_err("a part in contact").to_string();
    assert!(
        words.contains("pressure.0.face") && words.contains("in contact"),
        "{words}"
    );
}

/// Factors scale a force with its moment; values of either replace it alone.
#[test]
fn steps_vary_forces_and_moments() {
    let text = block(
        "P1",
        [2, 2, 2],
        "[[clamp]]
        face = 'z_min'
        [[force]]
        name = 'press'
        face = 'z_max'
        value = [0.0, 0.0, -100.0]
        moment = [4.0, 0.0, 0.0]
        [[step]]
        factor.press = 0.5
        [[step]]
        value.press = [10.0, 0.0, -80.0]
        [[step]]
        factor = { press = 2.0, 'press.moment' = 3.0 }
        value.'force.0.moment' = [0.0, 1.0, 0.0]
        increments = 2",
    );
    let history = scene(&text);
    let ends: Vec<_> = history
        .at_ends()
        .map(|end| end.unwrap().forces[0].clone())
        .collect();
    let numbers =
        |values: &[contact3d::scene::Quantity; 3]| values.clone().map(|v| v.constant().unwrap());
    for (end, force, moment) in [
        (&ends[0], [0.0, 0.0, -50.0], [2.0, 0.0, 0.0]),
        (&ends[1], [10.0, 0.0, -80.0], [2.0, 0.0, 0.0]),
        (&ends[2], [20.0, 0.0, -160.0], [0.0, 3.0, 0.0]),
    ] {
        assert_eq!((numbers(&end.value), numbers(&end.moment)), (force, moment));
    }
    // The loads do twice the strain energy's work along a path from zero on.
    let case = Case::of(&text);
    let resultants = case.report().resultants;
    close(
        &[2.0 * resultants.strain_energy],
        &[resultants.load_work],
        SOLVED,
    );
    close(&resultants.applied_force, &[20.0, 0.0, -160.0], ROUNDING);
}

#[test]
fn forces_change_with_units_and_have_uniform_discs() {
    let mut force = Force::on("z_max", [1.0, 2.0, -30.0]).within([0.5, 0.4, 0.5], 0.2);
    force.moment = [0.4, 0.5, 0.6].map(Into::into);
    let own = scene(&block("P1", [4, 3, 2], FOOT)).with_force(force);
    let change = contact3d::scene::UnitChange {
        length: 2.0,
        displacement: 4.0,
        stress: 8.0,
    };
    let (_, forces) = on_mesh(&own);
    let (_, image) = on_mesh(&own.in_units(change));
    let scaled: Vec<f64> = forces
        .as_flattened()
        .iter()
        .map(|part| 32.0 * part)
        .collect();
    close(image.as_flattened(), &scaled, ROUNDING);
}
