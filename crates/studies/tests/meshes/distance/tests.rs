//! Distances against closed forms, symmetries, nested meshes and their interpolation.

use std::path::Path;

use super::*;
use contact3d::{
    Problem,
    mesh::{RefinableBody, tetrahedron_volume},
    scene::{Body, Brick, ElementOrder, Material, Quantity, Scene, Spring},
};
use studies::accuracy::{AccuracySettings, DiscretisationStudy};

/// λ + 2μ = 1.2 and μ = 0.4.
const YOUNG: f64 = 1.0;
const POISSON: f64 = 0.25;
const MODULI: [f64; 2] = [1.2, 0.4];

fn box_scene(cells: [usize; 3], element: ElementOrder) -> Scene {
    let body = Body::brick([1.0, 0.5, 0.75], cells).with_element(element);
    Scene::new(body, Material::isotropic(YOUNG, POISSON))
}

fn with_cells(scene: &Scene, cells: [usize; 3]) -> Scene {
    let brick = scene.as_brick().expect("a brick");
    let brick = Brick::new(brick.size, cells);
    let mut scene = scene.clone();
    scene.bodies[0].brick = Some(brick);
    scene
}

fn file_scene(file: &str, element: ElementOrder) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../contact3d/tests/meshes");
    let body = Body::gmsh(folder.join(file), 1.0).with_element(element);
    Scene::new(body, Material::isotropic(YOUNG, POISSON))
}

fn mesh(scene: &Scene) -> Mesh {
    Mesh::of_scene(scene, Path::new("")).expect("a mesh")
}

/// The mesh with some tetrahedra cut irregularly.
fn cut(scene: &Scene) -> Mesh {
    let mut body = RefinableBody::new(scene, Path::new("")).expect("a body");
    for seed in [3, 5] {
        let all = 0..body.n_tetrahedra();
        let cuts: Vec<u8> = all.map(|t| u8::from(t * t % seed == 1) * 2).collect();
        body.refine(&cuts);
    }
    body.mesh().expect("a mesh")
}

fn nodal(mesh: &Mesh, value: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    mesh.coordinates.iter().map(|x| value(*x)).collect()
}

fn square(x: [f64; 3]) -> [f64; 3] {
    [x[0] * x[0], 0.0, 0.0]
}

fn between(
    (mesh_a, a): (&Mesh, &[[f64; 3]]),
    (mesh_b, b): (&Mesh, &[[f64; 3]]),
    scene: &Scene,
) -> Distance {
    let field = |mesh, displacement| MeshField { mesh, displacement };
    distance(field(mesh_a, a), field(mesh_b, b), scene).expect("springs that hold")
}

/// On the cells of a brick the linear interpolant of x² is that of each interval of length h alone, so that the
/// error is ∫ 1.2 (2x − x₀ − x₁)² = 1.2 V h²/3. The quadratic field is exact on its mesh, which is another one.
#[test]
fn a_parabola_is_as_far_from_its_interpolant_as_it_should_be() {
    let [first, second] = [[3, 2, 2], [8, 4, 6]];
    let (exact, linear) = (
        box_scene(first, ElementOrder::P2),
        box_scene(second, ElementOrder::P1),
    );
    let (fine, coarse) = (cut(&exact), mesh(&linear));
    let (a, b) = (nodal(&fine, square), nodal(&coarse, square));
    let expected = (MODULI[0] * 0.375 / 3.0).sqrt() / 8.0;
    let found = between((&fine, &a), (&coarse, &b), &linear);
    // Roundings of strains of size 2 over differences of size 1/8.
    assert!((found.absolute / expected - 1.0).abs() < 1e-12);

    // The other way round kinks lie inside the tetrahedra that are integrated over.
    let size = (MODULI[0] * 0.375 * 4.0 / 3.0).sqrt();
    let found = between((&coarse, &b), (&fine, &a), &exact);
    assert!((found.absolute / expected - 1.0).abs() < 0.02, "{found:?}");
    assert!((found.reference / size - 1.0).abs() < 1e-12);
}

/// On any tetrahedron with the interpolant's slope g: ∫ 1.2 (2x − g_x)² + 0.4 (g_y² + g_z²).
#[test]
fn unstructured_meshes_have_the_closed_form_too() {
    let linear = file_scene("foot_41.msh", ElementOrder::P1);
    let quadratic = file_scene("foot_41.msh", ElementOrder::P2);
    let (fine, coarse) = (cut(&quadratic), mesh(&linear));
    let (a, b) = (nodal(&fine, square), nodal(&coarse, square));
    let energy = |nodes: &[usize; 4]| {
        let corners = coarse.corners(nodes);
        let simplex = Simplex::new(&corners);
        let slope: Vector3<f64> = (0..4)
            .map(|k| simplex.gradients[k] * corners[k][0].powi(2))
            .sum();
        let sum: f64 = corners.iter().map(|x| x[0]).sum();
        let squares: f64 = corners.iter().map(|x| x[0] * x[0]).sum();
        let [mean, mean_square] = [sum / 4.0, (squares + sum * sum) / 20.0];
        let along = 4.0 * mean_square - 4.0 * slope.x * mean + slope.x.powi(2);
        let across = slope.y.powi(2) + slope.z.powi(2);
        tetrahedron_volume(&corners) * (MODULI[0] * along + MODULI[1] * across)
    };
    let expected = coarse.tetrahedra.iter().map(energy).sum::<f64>().sqrt();
    let found = between((&fine, &a), (&coarse, &b), &linear);
    // Places in metres of a mesh far smaller than a metre from the origin are cancelled.
    assert!(
        (found.absolute / expected - 1.0).abs() < 1e-9,
        "{found:?} {expected}"
    );
}

#[test]
fn points_outside_take_the_nearest_strain_and_rigid_motions_do_not_count() {
    let curved = file_scene("post_order2_41.msh", ElementOrder::P2);
    let round = mesh(&curved);
    // The same corners on straight sides: a body that is smaller by the curves.
    let straight = Mesh {
        mid_edges: None,
        contact: None,
        ..round.clone()
    };
    let stretch = |x: [f64; 3]| [0.3 * x[0] + 0.1 * x[1], 0.2 * x[2], 0.5 * x[2] - 0.4 * x[0]];
    let turned = |x: [f64; 3]| {
        let [u, v, w] = stretch(x);
        [u + 4.0 - 0.7 * x[1], v + 0.7 * x[0] - 1.0, w + 2.0]
    };
    let (a, b) = (nodal(&straight, turned), nodal(&round, stretch));
    let found = between((&straight, &a), (&round, &b), &curved);
    assert!(found.reference > 0.1);
    // Displacements of size 5 over tetrahedra of size 0.1.
    assert!(found.relative() < 1e-12, "{found:?}");
}

#[test]
fn moving_both_meshes_changes_nothing_nor_do_threads() {
    let [first, second] = [[3, 2, 2], [4, 3, 5]];
    let (one, other) = (
        box_scene(first, ElementOrder::P2),
        box_scene(second, ElementOrder::P1),
    );
    let (fine, coarse) = (cut(&one), mesh(&other));
    let (a, b) = (
        nodal(&fine, square),
        nodal(&coarse, |x| [x[1] * x[2], x[0].sin(), 0.0]),
    );
    let here = between((&fine, &a), (&coarse, &b), &other);
    let moved = |mesh: &Mesh| Mesh {
        coordinates: nodal(mesh, |x| [x[0] - 2.0, x[1] + 8.0, x[2] + 0.5]),
        ..mesh.clone()
    };
    let (far_a, far_b) = (moved(&fine), moved(&coarse));
    let there = between((&far_a, &a), (&far_b, &b), &other);
    // Roundings of places of size 8; a point on a side may fall to either tetrahedron.
    assert!(
        (there.absolute / here.absolute - 1.0).abs() < 1e-10,
        "{here:?} {there:?}"
    );

    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    let again = alone.install(|| between((&fine, &a), (&coarse, &b), &other));
    assert_eq!(
        (again.absolute.to_bits(), again.reference.to_bits()),
        (here.absolute.to_bits(), here.reference.to_bits())
    );
}

/// Motions without strain stretch springs alone: ∫ (u_a − u_b)·K (u_a − u_b) in closed form, on meshes that are not nested.
#[test]
fn springs_count_what_moves_them() {
    let with_springs = |cells, element| {
        let growing = || Some(Quantity::formula("2*x").expect("a formula"));
        let mut scene = box_scene(cells, element);
        scene.springs = vec![
            Spring {
                face: "x_max".to_owned(),
                normal: Some(3.0.into()),
                ..Spring::default()
            },
            Spring {
                face: "z_max".to_owned(),
                normal: growing(),
                tangential: growing(),
                ..Spring::default()
            },
        ];
        scene
    };
    let one = with_springs([3, 2, 2], ElementOrder::P2);
    let other = with_springs([4, 3, 5], ElementOrder::P1);
    let (mesh_a, mesh_b) = (cut(&one), mesh(&other));
    // Moved along x and turned about it.
    let (a, b) = (
        nodal(&mesh_a, |[_, y, z]| [0.5, -z, y]),
        nodal(&mesh_b, |_| [0.1, 0.0, 0.0]),
    );
    // x_max, 0.5 by 0.75: 3 · 0.4². z_max at z = 0.75, 1 by 0.5: 2x (0.4² + 0.75² + y²), and 2x · 0.1² for the reference.
    let squares: [f64; 2] = [
        0.375 * 3.0 * 0.16 + 0.5 * (0.16 + 0.5625) + 0.125 / 3.0,
        0.375 * 3.0 * 0.01 + 0.5 * 0.01,
    ];
    let found = between((&mesh_a, &a), (&mesh_b, &b), &other);
    for (found, square) in [found.absolute, found.reference].iter().zip(squares) {
        // Strains of rigid motions are rounding, and products of degree 3 are integrated exactly.
        assert!(
            (found / square.sqrt() - 1.0).abs() < 1e-12,
            "{found} {square}"
        );
    }
}

/// The study of nested meshes interpolates the coarse solution on the fine mesh.
#[test]
fn nested_meshes_are_as_far_apart_as_their_study_says() {
    let text = include_str!("../../../../../pipelines/regions.toml");
    let scene = Scene::parse("regions.toml", text).expect("a pipeline");
    for element in [ElementOrder::P1, ElementOrder::P2] {
        let mut scene = with_cells(&scene, [12, 4, 4]);
        scene.bodies[0].element = element;
        let settings = AccuracySettings {
            coarsest: Some(4),
            finest: Some(8),
            ..AccuracySettings::default()
        };
        let study = DiscretisationStudy::measure(&scene, Path::new(""), &settings, &mut |_| {});
        let study = study.expect("solves");
        let solved = [[12, 4, 4], [24, 8, 8]].map(|cells| {
            let problem = Problem::new(with_cells(&scene, cells)).expect("a problem");
            let assembled = problem.assemble().expect("a factor");
            let solution = assembled.solve_and_report(&scene.solve);
            let (_, report) = solution.expect("a solve");
            (assembled.mesh().as_ref().clone(), report.displacement)
        });
        let [(mesh_a, a), (mesh_b, b)] = &solved;
        let found = between((mesh_a, a), (mesh_b, b), &scene).relative();
        let expected = study.levels[0].energy_difference;
        // Solves to 1e-12 of a difference of some per cent, and sums of some thousand terms.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{element:?}: {found:e} {expected:e}"
        );
    }
}

/// Children of a curved tetrahedron lie on its own map, so the function of its mesh is one of theirs too.
#[test]
fn a_function_on_curved_sides_is_one_on_its_children() {
    let scene = file_scene("post_order2_41.msh", ElementOrder::P2);
    let (coarse, fine) = (mesh(&scene), cut(&scene));
    let pieces: Vec<SearchedTetrahedron> = (0..coarse.tetrahedra.len())
        .map(|t| SearchedTetrahedron::of(&coarse, t))
        .collect();
    assert!(pieces.iter().any(|piece| piece.map.is_some()));
    let tree = Tree::new(pieces.iter().map(|piece| piece.bounds).collect());
    let values = nodal(&coarse, |x| [(3.0 * x[2]).sin(), x[0] * x[1], x[0].cos()]);
    let same: Vec<[f64; 3]> = fine
        .coordinates
        .iter()
        .map(|x| {
            let (t, at) = tree.nearest(*x, tree.any(*x), |t| pieces[t].nearest(*x));
            let shape = quadratic_tetrahedron(&at);
            let nodes = coarse.tetrahedron_nodes(t).zip(shape);
            nodes.fold([0.0; 3], |sum, (n, w)| {
                std::array::from_fn(|c| sum[c] + w * values[n][c])
            })
        })
        .collect();
    for (one, other) in [
        ((&coarse, &values), (&fine, &same)),
        ((&fine, &same), (&coarse, &values)),
    ] {
        let found = between((one.0, one.1), (other.0, other.1), &scene);
        assert!(found.reference > 0.1);
        // Newton's method ends at 1e-13, places up to 1e-10 outside count as inside, and slopes jump across sides.
        assert!(found.relative() < 1e-6, "{found:?}");
    }
}
