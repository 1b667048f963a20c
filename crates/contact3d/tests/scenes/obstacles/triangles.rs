//! Obstacles from triangles against those that they stand for.

use std::fmt::Write;

use contact3d::{
    Problem,
    mesh::{ContactSurface, Mesh},
    scene::Scene,
};
use tempfile::TempDir;

use super::{
    moved::MATERIAL,
    solved::{Solved, distance},
};

type Triangle = [[f64; 3]; 3];

/// A text with as many digits as the numbers have, and with the mark of UTF-8 that some editors write.
fn stl(triangles: &[Triangle]) -> Vec<u8> {
    let mut text = String::from("\u{feff}solid\n");
    for corners in triangles {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for [x, y, z] in corners {
            let _ = writeln!(text, "      vertex {x:?} {y:?} {z:?}");
        }
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid\n").into_bytes()
}

/// A binary file whose first line begins as a text does, and with bytes behind its triangles.
fn binary(triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = b"solid of a CAD system".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        let numbers = corners.as_flattened().iter();
        bytes.extend(numbers.flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Quarters of triangles, again and again, with new corners that a map moves.
fn refined(
    triangles: &[Triangle],
    times: usize,
    map: &dyn Fn([f64; 3]) -> [f64; 3],
) -> Vec<Triangle> {
    let mut all = triangles.to_vec();
    for _ in 0..times {
        let quarters = all.iter().flat_map(|&[a, b, c]| {
            let middle = |x: [f64; 3], y: [f64; 3]| map([0, 1, 2].map(|k| (x[k] + y[k]) / 2.0));
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        all = quarters.collect();
    }
    all
}

/// A ball of radius r by subdivision of an octahedron that is turned, so that its corners lie above no node.
fn ball(centre: [f64; 3], radius: f64, times: usize) -> Vec<Triangle> {
    let axes = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    let place = |axis: usize, sign: f64| axes[axis].map(|c| sign * c);
    let mut octants = Vec::new();
    for [sx, sy, sz] in [
        [1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, -1.0, 1.0],
        [1.0, -1.0, -1.0],
    ] {
        for sx in [sx, -sx] {
            let corners = [place(0, sx), place(1, sy), place(2, sz)];
            let [a, b, c] = corners;
            octants.push(if sx * sy * sz > 0.0 {
                [a, b, c]
            } else {
                [a, c, b]
            });
        }
    }
    let round = |x: [f64; 3]| {
        let length = x.iter().map(|c| c * c).sum::<f64>().sqrt();
        x.map(|c| c / length)
    };
    let unit = refined(&octants, times, &round);
    let moved = |x: [f64; 3]| [0, 1, 2].map(|k| centre[k] + radius * x[k]);
    unit.into_iter().map(|corners| corners.map(moved)).collect()
}

/// The twelve triangles of a box.
fn cuboid([low, high]: [[f64; 3]; 2]) -> Vec<Triangle> {
    let corner = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 1 { high[c] } else { low[c] });
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = sides
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|corners| corners.map(corner)).collect()
}

fn folder(file: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tool.stl"), file).unwrap();
    folder
}

fn scene(contact: &str) -> String {
    format!(
        "title = 'triangles'\n[body.brick]\nsize = [1.0, 0.8, 0.6]\ncells = [8, 8, 4]\n{MATERIAL}[[clamp]]\nface = 'z_min'\n\
         [contact]\nface = 'z_max'\n{contact}"
    )
}

const TOOL: &str = "obstacle.surface = { file = 'tool.stl' }\n";

fn surface(contact: &str, file: &[u8]) -> Result<ContactSurface, String> {
    let folder = folder(file);
    let scene = Scene::parse("test", &scene(contact)).map_err(|error| error.to_string())?;
    let mesh = Mesh::of_scene(&scene, folder.path()).map_err(|error| error.to_string())?;
    Ok(mesh.contact.expect("contact"))
}

/// The largest differences of distances and of normals.
fn differences(found: &ContactSurface, expected: &ContactSurface) -> [f64; 2] {
    let nodes = 0..found.nodes.len();
    let apart = |a: f64, b: f64| (a - b).abs();
    let normals = nodes.flat_map(|node| {
        let [n, m] = [found, expected].map(|surface| surface.normal_at(node));
        (0..3).map(move |c| apart(n[c], m[c]))
    });
    let distances = found.clearance.iter().zip(&expected.clearance);
    let distances = distances.map(|(a, b)| apart(*a, *b));
    [distances.fold(0.0, f64::max), normals.fold(0.0, f64::max)]
}

#[test]
fn two_triangles_are_a_plane() {
    let height = |x: f64, y: f64| 0.7 + 0.1 * x - 0.05 * y;
    let corner = |x: f64, y: f64| [x, y, height(x, y)];
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(-1.0, 2.0),
        corner(2.0, 2.0),
        corner(2.0, -1.0),
    ];
    let plane = "obstacle.half_space = { point = [0.0, 0.0, 0.7], normal = [0.1, -0.05, -1.0] }\n";
    let expected = surface(plane, &[]).unwrap();
    let found = surface(TOOL, &stl(&[[a, b, c], [a, c, d]])).unwrap();
    assert_eq!(found.normals.len(), 1);
    let [distances, normals] = differences(&found, &expected);
    // Some roundings of corners and places near one.
    assert!(
        distances < 1e-15 && normals < 1e-15,
        "{distances:e} {normals:e}"
    );
    // Beyond its border an open surface is nothing.
    let short = surface(TOOL, &stl(&[[a, b, c]])).unwrap_err();
    assert!(short.contains("reaches beyond"), "{short}");
}

/// Normals are exact, and quarters of triangles leave a sixteenth of the error of distances, of the depth of facets a quarter.
#[test]
fn a_ball_of_facets_is_a_ball() {
    let (centre, radius) = ([0.4, 0.3, 2.5], 1.8);
    let sphere = format!("obstacle.sphere = {{ centre = {centre:?}, radius = {radius} }}\n");
    let expected = surface(&sphere, &[]).unwrap();
    let mut before = 1.0;
    for times in 3..6 {
        let facets = ball(centre, radius, times);
        let found = surface(TOOL, &stl(&facets)).unwrap();
        let errors = differences(&found, &expected);
        let edge = 2.0_f64.sqrt() * radius / f64::from(1 << times);
        let depth = edge * edge / (8.0 * radius);
        assert!(
            errors[0] < 0.1 * depth,
            "{times}: {errors:?}, facets {depth:e}"
        );
        // 16 in the limit; roundings of corners two from the origin over edges of a twentieth.
        assert!(
            errors[0] < before / 14.0 && errors[1] < 1e-13,
            "{times}: {errors:?} {before:e}"
        );
        before = errors[0];
    }
    // A binary file has the digits of single precision: 6e-8 of a place.
    let facets = ball(centre, radius, 4);
    let [by_text, by_binary] =
        [stl(&facets), binary(&facets)].map(|file| surface(TOOL, &file).unwrap());
    let [distances, normals] = differences(&by_text, &by_binary);
    assert!(
        distances > 0.0 && distances < 1e-6 && normals < 1e-5,
        "{distances:e} {normals:e}"
    );
    // In millimetres.
    let large: Vec<Triangle> = facets
        .iter()
        .map(|it| it.map(|x| x.map(|c| 1e3 * c)))
        .collect();
    let scaled = surface(
        "obstacle.surface = { file = 'tool.stl', unit = 0.001 }\n",
        &stl(&large),
    )
    .unwrap();
    assert!(differences(&scaled, &by_text)[0] < 1e-14);
    let unit = surface(TOOL, &stl(&large)).unwrap_err();
    assert!(unit.contains("unit = 0.001"), "{unit}");
}

/// A file is moved to its place as its triangles would be.
#[test]
fn a_file_is_placed_and_turned() {
    let (angle, axis, origin) = (2.1_f64, [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0], [0.3, 0.5, 2.4]);
    let facets = ball([0.01, -0.02, 0.03], 0.18, 3);
    // Rodrigues' formula.
    let turned = |x: [f64; 3]| {
        let along: f64 = (0..3).map(|k| axis[k] * x[k]).sum();
        let across = [1, 2, 0].map(|k: usize| axis[k] * x[(k + 1) % 3] - axis[(k + 1) % 3] * x[k]);
        let (sin, cos) = angle.sin_cos();
        [0, 1, 2].map(|k| cos * x[k] + sin * across[k] + (1.0 - cos) * along * axis[k])
    };
    let moved = |x: [f64; 3]| {
        let turned = turned(x.map(|c| 10.0 * c));
        [0, 1, 2].map(|k| origin[k] + turned[k])
    };
    let in_place: Vec<Triangle> = facets.iter().map(|it| it.map(moved)).collect();
    let expected = surface(TOOL, &stl(&in_place)).unwrap();
    let turn = axis.map(|c| angle * c);
    let place = |turn: [f64; 3]| {
        let keys = format!("unit = 10.0, origin = {origin:?}, turn = {turn:?}");
        let contact = format!("obstacle.surface = {{ file = 'tool.stl', {keys} }}\n");
        surface(&contact, &stl(&facets)).unwrap()
    };
    // Some hundred roundings.
    let [distances, normals] = differences(&place(turn), &expected);
    assert!(
        distances < 1e-14 && normals < 1e-12,
        "{distances:e} {normals:e}"
    );
    let back = turn.map(|c| -c);
    assert!(differences(&place(back), &expected)[0] > 1e-3);
}

/// The text of a mesh of MSH 2.2: the type, the physical surface and the nodes of each element.
fn msh(elements: &[(usize, usize, Vec<[f64; 3]>)]) -> Vec<u8> {
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    let mut text = String::new();
    for (number, (code, group, places)) in elements.iter().enumerate() {
        let _ = write!(text, "{} {code} 2 {group} 1", number + 1);
        for place in places {
            let known = nodes.iter().position(|node| node == place);
            let tag = known.unwrap_or_else(|| {
                nodes.push(*place);
                nodes.len() - 1
            });
            let _ = write!(text, " {}", tag + 1);
        }
        text += "\n";
    }
    let places = nodes.iter().enumerate();
    let places = places.map(|(tag, [x, y, z])| format!("{} {x:?} {y:?} {z:?}\n", tag + 1));
    let names = "2\n2 1 \"ball\"\n2 2 \"other\"\n";
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{names}$EndPhysicalNames\n$Nodes\n{}\n{}$EndNodes\n\
         $Elements\n{}\n{text}$EndElements\n",
        nodes.len(),
        places.collect::<String>(),
        elements.len()
    )
    .into_bytes()
}

/// What the file is its first line tells.
#[test]
fn a_face_of_a_mesh_is_the_surface_of_its_triangles() {
    const FACE: &str = "obstacle.surface = { file = 'tool.stl', face = 'ball' }\n";
    let (centre, radius) = ([0.4, 0.3, 2.5], 1.8);
    let facets = ball(centre, radius, 2);
    let expected = surface(TOOL, &stl(&facets)).unwrap();
    let own = |triangle: &Triangle| (2, 1, triangle.to_vec());
    let far = [[9.0, 0.0, 9.0], [9.0, 1.0, 9.0], [8.0, 0.0, 9.0]];
    let mut elements: Vec<_> = facets.iter().map(own).collect();
    elements.push((2, 2, far.to_vec()));
    let found = surface(FACE, &msh(&elements)).unwrap();
    assert!(found == expected);
    // Tetrahedra tell the outside where triangles go round either way; a triangle in two groups stands there twice.
    let turned = facets.iter().enumerate().map(|(k, &[a, b, c])| {
        (
            2,
            1,
            if k % 3 == 0 {
                vec![a, c, b]
            } else {
                vec![a, b, c]
            },
        )
    });
    let inner = facets
        .iter()
        .map(|&[a, b, c]| (4, 0, vec![a, b, c, centre]));
    let mut elements: Vec<_> = turned.chain(inner).collect();
    elements.push(elements[1].clone());
    let by_tetrahedra = surface(FACE, &msh(&elements)).unwrap();
    // The order of sums differs.
    let errors = differences(&by_tetrahedra, &expected);
    assert!(errors.iter().all(|error| *error < 1e-14), "{errors:?}");
    // Triangles of the second order are four; the turned ones have their middles in their places.
    let quarters = ball(centre, radius, 3);
    let quadratic = quarters.chunks_exact(4).enumerate().map(|(k, quarter)| {
        let [[a, ab, ca], [_, b, bc], [_, _, c], _] = quarter[..] else {
            unreachable!()
        };
        let nodes = [vec![a, b, c, ab, bc, ca], vec![c, b, a, bc, ab, ca]];
        (9, 1, nodes[usize::from(k % 3 == 0)].clone())
    });
    let inner = facets
        .iter()
        .map(|&[a, b, c]| (4, 0, vec![a, b, c, centre]));
    let elements: Vec<_> = quadratic.chain(inner).collect();
    let found = surface(FACE, &msh(&elements)).unwrap();
    let errors = differences(&found, &surface(TOOL, &stl(&quarters)).unwrap());
    assert!(errors.iter().all(|error| *error < 1e-14), "{errors:?}");
    for (file, words) in [
        (
            msh(&elements),
            ["one of the physical surfaces: ball", "face = \"wall\""],
        ),
        (
            stl(&facets),
            ["obstacle.surface.face", "no face beside an STL"],
        ),
    ] {
        let error = surface(&FACE.replace("ball", "wall"), &file).unwrap_err();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

/// Before its flat side, and beyond edges and corners, distances are exact.
#[test]
fn a_box_has_sharp_edges() {
    let [low, high] = [[0.3, 0.2, 0.65], [0.7, 2.0, 1.5]];
    let found = surface(TOOL, &stl(&cuboid([low, high]))).unwrap();
    let brick = Scene::parse("test", &scene("")).unwrap();
    let mesh = Mesh::of_scene(&brick, std::path::Path::new("")).unwrap();
    for (local, &node) in found.nodes.iter().enumerate() {
        let x = mesh.coordinates[node];
        let offset = [0, 1, 2].map(|c| x[c].clamp(low[c], high[c]) - x[c]);
        let exact = offset.iter().map(|c| c * c).sum::<f64>().sqrt();
        let normal = found.normal_at(local);
        assert!((found.clearance[local] - exact).abs() < 1e-15);
        assert!(
            (0..3).all(|c| (normal[c] - offset[c] / exact).abs() < 1e-14),
            "{x:?} {normal:?}"
        );
    }
}

/// A wedge 0.01 deep in the middle of a block, and a groove 0.02 above it, from both flanks of which nodes lie as far: by formula and by
/// triangles, no lateral force but for rounding, and the same pressures.
#[test]
fn a_wedge_pushes_to_no_side() {
    let sharp = "obstacle.surface = { file = 'tool.stl', sharp_angle = 2.0 }\n";
    for (slope, apex) in [(0.05, 0.59), (-0.1, 0.62)] {
        let at = |x: f64, y: f64| [x, y, apex + slope * (x - 0.5_f64).abs()];
        let [a, b] = [-1.0, 2.0].map(|y| at(0.5, y));
        let [[left, further], [right, beyond]] = [-0.5, 1.5].map(|x| [at(x, -1.0), at(x, 2.0)]);
        // One triangle more on one side.
        let middle = at(1.5, 0.5);
        let flanks = [
            [a, b, middle],
            [b, beyond, middle],
            [a, middle, right],
            [a, left, b],
            [b, left, further],
        ];
        let height = format!(
            "obstacle.height = {{ value = '{apex:?} + ({slope:?})*abs(x - 0.5)', direction = '-z' }}\n"
        );
        let folder = folder(&stl(&flanks));
        let [by_height, by_facets] = [height.as_str(), sharp].map(|obstacle| {
            let contact = format!("{obstacle}interference = true\n");
            Solved::in_folder(&scene(&contact), folder.path()).unwrap()
        });
        let (surface, mesh) = (by_height.surface(), by_height.problem.mesh());
        let errors = differences(by_facets.surface(), surface);
        // Roundings of places one from the origin.
        assert!(errors.iter().all(|error| *error < 1e-14), "{errors:?}");
        let middle = surface.nodes.iter().enumerate();
        let middle = middle.filter(|(_, node)| mesh.coordinates[**node][0] == 0.5);
        for (local, _) in middle {
            assert!(surface.normal_at(local)[0].abs() < 1e-14);
            assert!((surface.clearance[local] - (apex - 0.6)).abs() < 1e-14);
        }
        let force = by_height.force();
        // Some thousand roundings.
        assert!(force[0].abs() < 1e-11 * force[2].abs(), "{force:?}");
        let off = distance(&by_facets.multiplier, &by_height.multiplier);
        assert!(off < 1e-9, "{off:e}");
    }
}

/// Nodes that the edge of a wedge touches have the normal between its flanks, whichever of them rounding prefers; those at the edge of a flat
/// punch that of its flat side.
#[test]
fn a_sharp_edge_has_no_side() {
    for rounding in [0.0, 1e-10, -1e-10] {
        let at = |x: f64, y: f64| [x, y, 0.6 + 0.5 * (x - 0.5_f64).abs() + rounding];
        let [a, b] = [-1.0, 2.0].map(|y| at(0.5, y));
        let [[left, further], [right, beyond]] = [-0.5, 1.5].map(|x| [at(x, -1.0), at(x, 2.0)]);
        let flanks = [
            [a, b, right],
            [b, beyond, right],
            [a, left, b],
            [b, left, further],
        ];
        let interference = "interference = true\n";
        let height = "value = '0.6 + 0.5*abs(x - 0.5) + shift', direction = '-z'";
        let by_height = format!(
            "{interference}obstacle.height = {{ {height} }}\n[parameters]\nshift = {rounding}\n"
        );
        for contact in [interference.to_owned() + TOOL, by_height] {
            let found = surface(&contact, &stl(&flanks)).unwrap();
            let normals = (0..found.nodes.len()).map(|local| found.normal_at(local));
            // Flanks have tan 0.5.
            let upright = normals.filter(|n| n[2] > 0.95);
            let off = upright.map(|n| n[0].abs().max(n[1].abs()));
            let off: Vec<f64> = off.collect();
            assert_eq!(off.len(), 9, "{contact}");
            assert!(off.iter().all(|off| *off < 1e-12), "{off:?}");
        }
    }
    let punch = cuboid([[0.25, 0.2, 0.6], [0.75, 0.6, 1.5]]);
    let found = surface(TOOL, &stl(&punch)).unwrap();
    let touching = (0..found.nodes.len()).filter(|local| found.clearance[*local] < 1e-9);
    let upright: Vec<bool> = touching
        .map(|local| found.normal_at(local)[2] > 1.0 - 1e-12)
        .collect();
    assert_eq!(upright, [true; 25]);
}

/// A ball that is pressed and dragged, its normals and distances taken anew at each increment.
#[test]
fn a_tool_of_facets_moves_as_the_ball_does() {
    let (centre, radius) = ([0.3, 0.4, 1.4], 0.8);
    let history = "tool = 'ball'\nmultipliers = 'nodal'\n[[tool]]\nname = 'ball'\npoint = [0.3, 0.4, 1.4]\nfree = ['z']\n\
                   force = [0.0, 0.0, -0.002]\ndisplacement = [0.3, 0.0, 0.0]\n[friction]\ncoefficient.constant = 0.2\n\
                   [[step]]\nfactor = { 'ball.force' = 1.0, 'ball.displacement' = 0.0 }\n\
                   [[step]]\nincrements = 2\nfactor = { 'ball.displacement' = 1.0 }\n";
    let sphere = format!("obstacle.sphere = {{ centre = {centre:?}, radius = {radius} }}\n");
    let folder = folder(&stl(&ball(centre, radius, 4)));
    let [by_facets, by_sphere] = [TOOL, &sphere].map(|obstacle| {
        let scene = Scene::parse("test", &scene(&(obstacle.to_owned() + history))).unwrap();
        let problem = Problem::in_folder(scene, folder.path())
            .unwrap()
            .assemble()
            .unwrap();
        problem.solve_history(&Default::default()).unwrap().records
    });
    // Facets of a tenth of the radius: gaps to 1e-7 of it.
    assert_eq!(by_facets.len(), 3);
    for (found, expected) in by_facets.iter().zip(&by_sphere) {
        let off = distance(&found.multiplier, &expected.multiplier);
        assert!(off < 1e-3, "{off:e}");
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let facets = ball([0.4, 0.3, 2.5], 1.8, 2);
    // Corners beside others by more than the digits of files: half of the ball, and three of its corners.
    let apart = |k: usize, x: [f64; 3]| [x[0], x[1], x[2] + if k < 64 { 1e-4 } else { 0.0 }];
    let halves = facets.iter().enumerate();
    let halves: Vec<Triangle> = halves.map(|(k, it)| it.map(|x| apart(k, x))).collect();
    let beside = ball([0.4, 2.0, 2.5], 1.8, 3);
    // Along an axis of the octahedron, so that edges meet edges in the mirror plane.
    let axis = [0.36, 0.48, -0.8];
    let mirrored = ball(
        [0, 1, 2].map(|k| [0.4, 0.3, 2.5][k] + 1.7 * axis[k]),
        1.8,
        2,
    );
    let cases: [(Vec<u8>, &[&str]); 12] = [
        (
            stl(&[facets.as_slice(), &mirrored].concat()),
            &["cut each other"],
        ),
        (stl(&halves), &["cracks: ", "up to 1.0e-4 beside", "weld"]),
        (
            stl(&[facets.as_slice(), &beside].concat()),
            &["cut each other", "unite"],
        ),
        (Vec::new(), &["an STL or Gmsh file", "neither"]),
        (b"solid\nendsolid\n".to_vec(), &["none"]),
        (
            b"solid\nfacet normal 0 0 1\nvertex 0 0 x\n".to_vec(),
            &["vertex 0 0 x", "line 3"],
        ),
        (
            binary(&facets)[..900].to_vec(),
            &["900 bytes", "128 triangles"],
        ),
        (
            stl(&[[[0.0; 3], [1.0, 0.0, 1.0], [2.0, 0.0, 2.0]]]),
            &["without area"],
        ),
        (
            stl(&[facets.as_slice(), &facets[..1]].concat()),
            &["more than two triangles"],
        ),
        (
            stl(&facets
                .iter()
                .enumerate()
                .map(|(k, &[a, b, c])| if k == 5 { [a, c, b] } else { [a, b, c] })
                .collect::<Vec<_>>()),
            &["opposite senses"],
        ),
        (
            String::from_utf8(stl(&[[
                [-1.0, -1.0, 0.7],
                [-1.0, 3.0, 0.7],
                [3.0, -1.0, 0.7],
            ]]))
            .unwrap()
            .replace("normal 0 0 0", "normal 0 0 1")
            .into_bytes(),
            &["normals against the order"],
        ),
        (
            stl(&facets
                .iter()
                .map(|&[a, b, c]| [a, c, b])
                .collect::<Vec<_>>()),
            &["contact.obstacle.surface", "counter-clockwise"],
        ),
    ];
    for (file, words) in cases {
        let error = surface(TOOL, &file).unwrap_err();
        assert!(
            words.iter().all(|word| error.contains(word)),
            "{words:?}: {error}"
        );
    }
    // Parts that touch cut nothing: a box on a larger one, and one whose corner touches its edge.
    let touching = [
        [[-1.0, -1.0, 0.7], [2.0, 2.0, 1.7]],
        [[0.1, 0.2, 1.7], [0.9, 0.8, 2.0]],
        [[2.0, 0.3, 1.7], [3.0, 0.6, 2.0]],
    ];
    let parts = touching.map(cuboid).concat();
    surface(TOOL, &stl(&parts)).unwrap();
    let digest = surface(
        "obstacle.surface = { file = 'tool.stl', digest = 'f00' }\n",
        &stl(&facets),
    )
    .unwrap_err();
    assert!(
        digest.contains("contact.obstacle.surface.digest"),
        "{digest}"
    );
    let missing = surface("obstacle.surface = { file = 'other.stl' }\n", &[]).unwrap_err();
    assert!(
        missing.contains("contact.obstacle.surface.file") && missing.contains("other.stl"),
        "{missing}"
    );
    let both = surface(
        "obstacle = { surface = { file = 'tool.stl' }, sphere = { centre = [0, 0, 9], radius = 1 } }\n",
        &[],
    );
    assert!(both.is_err());
}
