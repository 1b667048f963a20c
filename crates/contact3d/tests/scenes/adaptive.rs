//! Adaptive meshes: conforming and shape-regular cuts, what children inherit, starts on finer meshes, and
//! the error that levels reach.

use std::{collections::HashMap, path::Path, time::Instant};

use crate::smallest_eigenvalue;
use contact3d::{
    Problem, ProblemError,
    adaptation::{
        Adaptation, AdaptiveLevel, AdaptiveStatus, LevelForecast, LevelStorage, SolvedLevel,
        Target, adapted, next_cuts, refine,
    },
    contact::transferred,
    elasticity::Loads,
    mesh::{Mesh, Quality, RefinableBody, RefinedLevel, shape, tetrahedron_volume},
    scene::{
        AdaptSettings, ElementOrder, FirstMesh, Functional, MultiplierSpace, Scene, SolveSettings,
    },
    solver::Status,
};
use nalgebra::Vector3;

const PUBLISHED: &str = include_str!("../../../../pipelines/newton.toml");

fn published(element: ElementOrder, n_div: usize) -> Scene {
    let mut scene = Scene::parse("adaptive", PUBLISHED).expect("a scene");
    scene.bodies[0].element = element;
    scene.as_brick_mut().expect("a brick").cells = [3 * n_div, n_div, n_div];
    scene
}

/// A body with curved sides, of a mesh file of the second order.
fn post() -> Scene {
    let text = "title = 'post'
        [body]
        element = 'P2'
        [body.gmsh]
        file = 'post_order2_41.msh'
        [material.isotropic]
        young_modulus = 1e3
        poisson_ratio = 0.3
        [[clamp]]
        face = 'top'
        [body_force]
        value = [0.0, 0.0, -1.0]
        [contact]
        face = 'foot'";
    Scene::parse("post", text).expect("a scene")
}

fn meshes_folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes")
}

/// Every side of a tetrahedron is a side of one other or a boundary triangle, once.
fn assert_conforming(mesh: &Mesh) {
    let mut sides: HashMap<[usize; 3], i32> = HashMap::new();
    for [a, b, c, d] in &mesh.tetrahedra {
        for mut side in [[*b, *c, *d], [*a, *c, *d], [*a, *b, *d], [*a, *b, *c]] {
            side.sort_unstable();
            *sides.entry(side).or_default() += 1;
        }
    }
    for facet in &mesh.facets {
        let mut side = *facet;
        side.sort_unstable();
        *sides.entry(side).or_default() += 1;
    }
    assert!(sides.values().all(|count| *count == 2));
}

fn area_of(mesh: &Mesh, face: &str) -> f64 {
    mesh.facets_on(face).map(|f| mesh.facet_area(f)).sum()
}

/// Which tetrahedra touch a point, as cuts.
fn touching(mesh: &Mesh, point: [f64; 3], cuts: u8) -> Vec<u8> {
    let touches = |nodes: &[usize; 4]| nodes.iter().any(|n| mesh.coordinates[*n] == point);
    mesh.tetrahedra
        .iter()
        .map(|nodes| if touches(nodes) { cuts } else { 0 })
        .collect()
}

#[test]
fn cuts_towards_a_corner_keep_the_mesh_conforming_and_the_shapes_few() {
    let scene = published(ElementOrder::P1, 2);
    let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
    let first = body.mesh().expect("a mesh");
    let mut shapes = vec![Quality::of(&first).smallest_shape];
    for _ in 0..10 {
        let mesh = body.mesh().expect("a mesh");
        body.refine(&touching(&mesh, [0.0; 3], 3));
        let mesh = body.mesh().expect("a mesh");
        assert_conforming(&mesh);
        let quality = Quality::of(&mesh);
        // Sums of volumes and areas in halves and quarters: rounding only.
        assert!((quality.total_volume / 3.0 - 1.0).abs() < 1e-13);
        for (face, area) in [("x_min", 1.0), ("z_min", 3.0), ("y_max", 3.0)] {
            assert!((area_of(&mesh, face) / area - 1.0).abs() < 1e-13, "{face}");
        }
        shapes.push(quality.smallest_shape);
    }
    let mesh = body.mesh().expect("a mesh");
    let quality = Quality::of(&mesh);
    assert!(
        quality.longest_edge / quality.shortest_edge > 500.0,
        "it is graded"
    );
    // Cuts at the longest edges of a brick's tetrahedra come back to their first shapes; none is flat.
    assert_eq!(
        shapes[5..].iter().copied().fold(f64::INFINITY, f64::min),
        shapes[5..].iter().copied().fold(0.0, f64::max)
    );
    assert!(shapes[10] > 0.4 * shapes[0], "{shapes:?}");
    assert!(mesh.tetrahedra.len() < 60 * first.tetrahedra.len());
}

/// Slender cells, as a graded brick has them far from where it is fine, become round where they are cut.
#[test]
fn cuts_make_slender_tetrahedra_rounder() {
    let mut scene = published(ElementOrder::P1, 2);
    scene.as_brick_mut().expect("a brick").cells = [3, 24, 1];
    let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
    let mean_shape = |mesh: &Mesh| -> f64 {
        let corners = mesh.tetrahedra.iter().map(|nodes| mesh.corners(nodes));
        let near = corners.filter(|corners| corners.contains(&[0.0; 3]));
        let shapes: Vec<f64> = near.map(|corners| shape(&corners)).collect();
        shapes.iter().sum::<f64>() / shapes.len() as f64
    };
    let first = mean_shape(&body.mesh().expect("a mesh"));
    for _ in 0..4 {
        let mesh = body.mesh().expect("a mesh");
        body.refine(&touching(&mesh, [0.0; 3], 3));
    }
    let last = mean_shape(&body.mesh().expect("a mesh"));
    assert!(last > 2.0 * first, "{first} {last}");
}

#[test]
fn equal_cuts_halve_every_edge_after_three() {
    let scene = published(ElementOrder::P1, 2);
    let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
    let first = body.mesh().expect("a mesh");
    body.refine(&vec![3; first.tetrahedra.len()]);
    let mesh = body.mesh().expect("a mesh");
    assert_conforming(&mesh);
    assert!(mesh.tetrahedra.len() >= 8 * first.tetrahedra.len());
    for (t, parent) in body.parents().into_iter().enumerate() {
        let volumes = [(&mesh, t), (&first, parent)]
            .map(|(m, t)| tetrahedron_volume(&m.corners(&m.tetrahedra[t])));
        assert!(volumes[0] <= volumes[1] / 8.0 * (1.0 + 1e-12));
        let centre: Vector3<f64> = mesh
            .corners(&mesh.tetrahedra[t])
            .map(Vector3::from)
            .iter()
            .sum::<Vector3<f64>>()
            / 4.0;
        let [a, b, c, d] = first.corners(&first.tetrahedra[parent]).map(Vector3::from);
        let inside = nalgebra::Matrix3::from_columns(&[b - a, c - a, d - a])
            .try_inverse()
            .expect("a volume")
            * (centre - a);
        assert!(
            inside.min() > 0.0 && inside.sum() < 1.0,
            "a child lies in its parent"
        );
    }
}

#[test]
fn children_lie_in_the_region_of_their_parent() {
    let mut scene = published(ElementOrder::P1, 2);
    // A box that cuts through cells: the region is what the first mesh makes of it.
    let region = toml_region("[0.0, 0.0, 0.0], [1.1, 1.0, 0.45]");
    scene.regions = region.regions;
    let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
    let volume = |mesh: &Mesh| -> f64 {
        let inside = mesh
            .tetrahedra
            .iter()
            .zip(&mesh.tetrahedron_region)
            .filter(|(_, r)| **r == 1);
        inside
            .map(|(nodes, _)| tetrahedron_volume(&mesh.corners(nodes)))
            .sum()
    };
    let first = body.mesh().expect("a mesh");
    body.refine(&touching(&first, [1.0, 0.5, 0.5], 7));
    let mesh = body.mesh().expect("a mesh");
    assert!(mesh.tetrahedra.len() > first.tetrahedra.len() + 100);
    assert!(volume(&first) > 0.1);
    assert!((volume(&mesh) / volume(&first) - 1.0).abs() < 1e-13);
}

fn toml_region(corners: &str) -> Scene {
    let text = format!(
        "{PUBLISHED}\n[[region]]\npart = {{ box = [{corners}] }}\n[region.material.isotropic]\nyoung_modulus = 7e10\npoisson_ratio = 0.3\n"
    );
    Scene::parse("regions", &text).expect("a scene with a region")
}

/// Children of curved tetrahedra share the sides of their ancestors: the weight of the body, an integral of
/// the Jacobian that the quadrature has exactly, stays the same.
#[test]
fn curved_sides_keep_their_shape() {
    let scene = post();
    let mut body = RefinableBody::new(&scene, &meshes_folder()).expect("a body");
    let weight = |mesh: &Mesh| -> f64 {
        let forces = Loads::of(&scene).nodal_forces(mesh).expect("loads");
        forces.iter().map(|f| f[2]).sum()
    };
    let first = body.mesh().expect("a mesh");
    let n = first.tetrahedra.len();
    body.refine(
        &(0..n)
            .map(|t| u8::from(t % 3 == 0) * 2)
            .collect::<Vec<u8>>(),
    );
    let mesh = body.mesh().expect("a mesh");
    assert_conforming(&mesh);
    assert!(mesh.tetrahedra.len() > 2 * n);
    let used: std::collections::BTreeSet<usize> = (0..mesh.tetrahedra.len())
        .flat_map(|t| mesh.tetrahedron_nodes(t))
        .collect();
    assert_eq!(used.len(), mesh.coordinates.len(), "no node is left over");
    assert!((weight(&mesh) / weight(&first) - 1.0).abs() < 1e-12);
}

#[test]
fn the_largest_indicators_are_cut_most_and_equal_ones_alike() {
    let target = |estimated: f64, wanted: f64| Target {
        estimated,
        wanted,
        element: ElementOrder::P2,
        achieved: None,
    };
    let equal = next_cuts(&[0.1; 100], target(1.0, 0.5));
    assert!(equal.iter().all(|cuts| *cuts == equal[0] && *cuts > 0));
    // An eighth of the error by elements of order 2 takes half the size: three cuts; two for 0.35.
    let quarter = next_cuts(&[0.1; 100], target(1.0, 0.25 / 0.75 * 1.001));
    assert!(quarter.iter().all(|cuts| *cuts == quarter[0]));
    // Where levels come all the way that they aim at, the last one aims at 0.93 of the target; where half of it, at 0.75 as before.
    let fall_of_one = (-2.0_f64 / 3.0).exp2();
    let after = |achieved: Option<f64>| {
        let target = target(1.0, fall_of_one / 0.93 * 1.001);
        next_cuts(&[0.1; 100], Target { achieved, ..target })[0]
    };
    assert_eq!([None, Some(0.5), Some(1.0)].map(after), [2, 2, 1]);
    let mut indicator = vec![1e-3; 100];
    indicator[17] = 1.0;
    let total = indicator.iter().map(|e| e * e).sum::<f64>().sqrt();
    let cuts = next_cuts(&indicator, target(total, 0.9 * total));
    assert!(cuts[17] > 0);
    assert!((0..100).all(|t| t == 17 || cuts[t] == 0));
}

/// A uniform stress on the coarse face is the same one on the fine face, for panes and nodes.
#[test]
fn starts_on_a_finer_mesh_keep_a_uniform_stress() {
    for element in [ElementOrder::P1, ElementOrder::P2] {
        for space in [MultiplierSpace::Panes, MultiplierSpace::Nodal] {
            let mut scene = published(element, 2);
            scene.contacts[0].multipliers = space;
            let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
            let coarse = body.mesh().expect("a mesh");
            body.refine(&touching(&coarse, [1.5, 0.5, 0.0], 4));
            let fine = body.mesh().expect("a mesh");
            let panes = |mesh: &Mesh| mesh.contact.as_ref().map_or(0, |c| c.n_panes());
            let uniform = |m: usize| -> Vec<f64> {
                let pairs = [0.25, -0.5].into_iter().cycle().take(2 * m);
                std::iter::repeat_n(3.0, m).chain(pairs).collect()
            };
            let start = transferred(&coarse, &fine, &body.parents(), &uniform(panes(&coarse)));
            assert!(panes(&fine) > panes(&coarse), "{element:?} {space:?}");
            for (found, wanted) in start.iter().zip(uniform(panes(&fine))) {
                assert!((found - wanted).abs() < 1e-14, "{element:?} {space:?}");
            }
        }
    }
}

/// The target is met, with the estimate near the error against a twice as accurate answer, by fewer unknowns
/// than the uniform mesh needs; and the multipliers on patches of a refined face are as stable as those of
/// cells: the smallest eigenvalue of S scaled to a unit diagonal.
#[test]
fn levels_meet_the_target_with_stable_multipliers() {
    let uniform = {
        let scene = published(ElementOrder::P2, 4);
        let assembled = Problem::new(scene)
            .and_then(Problem::assemble)
            .expect("a problem");
        let contact = assembled.system.contact.as_ref().expect("contact");
        smallest_eigenvalue(contact.explicit().expect("a dense S"))
    };
    let mut scene = published(ElementOrder::P2, 2);
    scene.adapt = Some(AdaptSettings {
        error: 0.06,
        start: FirstMesh::Scene,
        of: None,
    });
    let (answer, levels) = adapted(scene.clone(), Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Met);
    let last = levels.adaptation.levels.last().expect("a level");
    assert!(last.estimated_error <= 0.06);
    // 3 n_div = 24, 37,008 unknowns, has an estimate of 5.5 %.
    assert!(last.n_free < 25_000, "{}", last.n_free);
    assert!(answer.report.certificate.worst() < 1e-12);
    let contact = answer.problem.system.contact.as_ref();
    let dual = contact.expect("contact").explicit().expect("a dense S");
    let stability = smallest_eigenvalue(dual);
    assert!(stability > 0.5 * uniform, "{stability} {uniform}");
    // The start has no influence on the answer.
    let again = answer
        .problem
        .solve(&SolveSettings::default())
        .expect("a solve");
    let difference = again.multiplier.iter().zip(&answer.solution.multiplier);
    let difference: f64 = difference.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let size = again.multiplier.iter().map(|l| l * l).sum::<f64>().sqrt();
    assert!(difference < 1e-11 * size);
}

/// A brick that a scene leaves open is meshed anew with graded cells where these come near the target; what the stored counts
/// give again is the mesh of the answer.
#[test]
fn an_open_brick_of_quadratic_elements_is_meshed_anew() {
    let cells = |error: f64, start: FirstMesh, of: Option<Functional>| {
        let mut scene = published(ElementOrder::P2, 2);
        scene.adapt = Some(AdaptSettings { error, start, of });
        let (answer, levels) = adapted(scene.clone(), Path::new("")).expect("levels");
        assert_eq!(levels.status, AdaptiveStatus::Met);
        let refinement = &levels.adaptation.refinement;
        let again = Mesh::refined(&scene, Path::new(""), refinement).expect("a mesh");
        assert_eq!(again.coordinates, answer.problem.mesh().coordinates);
        refinement.clone()
    };
    let once = |cells| vec![RefinedLevel::Cells(cells)];
    assert_eq!(cells(0.1, FirstMesh::Coarse, None), once([9, 3, 3]));
    let of_force = cells(0.002, FirstMesh::Coarse, Some(Functional::NormalForce));
    assert!(
        matches!(of_force[0], RefinedLevel::Cells(_)),
        "{of_force:?}"
    );
    let of_scene = cells(0.1, FirstMesh::Scene, None);
    assert!(
        of_scene
            .iter()
            .all(|level| matches!(level, RefinedLevel::Cuts(_)))
    );
}

/// A body that a clamp moves as a whole, across a gap and onto nothing, has rounding for an energy: any target is met at once.
#[test]
fn bodies_moved_as_a_whole_need_no_finer_mesh() {
    for (element, extra) in [
        ("P1", ""),
        ("P2", ""),
        (
            "P1",
            "[contact]\n face = 'z_min'\n gap = 0.1\n [friction]\n coefficient.constant = 0.3",
        ),
    ] {
        let text = format!(
            "title = 'moved'
            [body]
            element = '{element}'
            [body.brick]
            size = [3.0, 1.0, 1.0]
            cells = [6, 2, 3]
            [material.isotropic]
            young_modulus = 2.1e11
            poisson_ratio = 0.3
            [[clamp]]
            face = 'x_min'
            value = [0.013, -0.007, 0.011]
            [adapt]
            error = 0.05
            {extra}"
        );
        let scene = Scene::parse("moved", &text).unwrap_or_else(|error| panic!("{error}"));
        let (_, found) = adapted(scene, Path::new("")).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(found.status, AdaptiveStatus::Met);
        assert_eq!(found.adaptation.levels.len(), 1);
        assert_eq!(found.adaptation.levels[0].estimated_error, 0.0);
    }
}

/// Adds the keys of one table to another, table by table.
fn merge(into: &mut toml::Table, more: toml::Table) {
    for (key, value) in more {
        match (into.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => merge(inner, value),
            (_, value) => {
                into.insert(key, value);
            }
        }
    }
}

/// A scene that leaves its mesh open starts from few cells of the same shape; one that names more keeps its own.
#[test]
fn the_first_mesh_is_coarse_where_the_scene_leaves_it_open() {
    let first_cells = |element: &str, more: &str| {
        let more = format!("body.element = '{element}'\nadapt.error = 0.05\n{more}");
        let mut table: toml::Table = PUBLISHED.parse().expect("TOML");
        merge(&mut table, more.parse().expect("TOML"));
        let scene = Scene::parse("open", &table.to_string()).expect("a scene");
        let scene = scene.with_first_mesh();
        assert_eq!(scene.clone().with_first_mesh(), scene, "chosen once");
        scene.as_brick().expect("a brick").cells
    };
    assert_eq!(first_cells("P2", ""), [6, 2, 2]);
    assert_eq!(first_cells("P1", ""), [12, 4, 4]);
    for fixed in [
        "adapt.start = 'scene'",
        "body.brick.grading.x_min = 1.5",
        "contact.gap = '1e-6 * x'",
        "contact.obstacle.half_space = { point = [0, 0, 0], normal = [0, 0, 1] }",
        "contact.box = [[0, 0, 0], [1.5, 1, 0]]",
        "region = [{ part.box = [[0, 0, 0], [1, 1, 1]], material.isotropic = { young_modulus = 1e11, poisson_ratio = 0.3 } }]",
    ] {
        assert_eq!(first_cells("P2", fixed), [48, 16, 16], "{fixed}");
    }
    let mut slender = Scene::parse("slender", PUBLISHED).expect("a scene");
    slender.adapt = Some(AdaptSettings {
        error: 0.05,
        start: FirstMesh::Coarse,
        of: None,
    });
    for (cells, fewest) in [([200, 4, 2], [200, 4, 2]), ([40, 10, 8], [20, 6, 4])] {
        slender.as_brick_mut().expect("a brick").cells = cells;
        let first = slender.clone().with_first_mesh();
        assert_eq!(first.as_brick().expect("a brick").cells, fewest);
    }
}

/// Sees forecasts, and solves nothing.
#[derive(Default)]
struct Forecasts(Vec<(usize, LevelForecast)>);

impl LevelStorage for Forecasts {
    type Error = ProblemError;

    fn solved(&mut self, level: usize, _: &Adaptation) -> Result<SolvedLevel<'_>, ProblemError> {
        panic!("level {level} is over the budget");
    }

    fn forecast(&mut self, level: usize, forecast: &LevelForecast) {
        self.0.push((level, *forecast));
    }

    fn checkpoint(&mut self, _: &Adaptation, _: Mesh) {}
}

/// What an interrupted computation has left to be solved is not begun where it would end too late.
#[test]
fn a_level_that_is_gone_on_with_is_held_against_the_budget() {
    let mut scene = published(ElementOrder::P2, 2);
    scene.adapt = Some(AdaptSettings {
        error: 0.1,
        start: FirstMesh::Scene,
        of: None,
    });
    let mesh = Mesh::of_scene(&scene, Path::new("")).expect("a mesh");
    let known = Adaptation {
        levels: vec![AdaptiveLevel {
            n_free: 100,
            estimated_error: 0.5,
            status: Status::Converged,
            seconds: 1.0,
            ..AdaptiveLevel::default()
        }],
        refinement: vec![RefinedLevel::Cuts(vec![3; mesh.tetrahedra.len()])],
        starts: vec![Vec::new()],
    };
    let deadline = Some(Instant::now());
    let mut seen = Forecasts::default();
    let folder = Path::new("");
    let refined = refine(&scene, folder, deadline, known.clone(), &mut seen).expect("levels");
    assert_eq!(refined.status, AdaptiveStatus::OverBudget);
    assert_eq!(
        (refined.level, &refined.adaptation.levels),
        (0, &known.levels)
    );
    assert!(refined.adaptation.refinement.is_empty());
    assert!(refined.adaptation.starts.is_empty());
    let [(level, forecast)] = seen.0[..] else {
        panic!("{:?}", seen.0);
    };
    // Three cuts of each tetrahedron halve all edges.
    assert_eq!((level, forecast.cells), (1, None));
    assert!(
        forecast.n_free > 400 && forecast.seconds > 4.0,
        "{forecast:?}"
    );
}
