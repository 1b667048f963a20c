use std::path::Path;
use contact3d::{branches::*, scene::*};

fn show(name: &str, scene: &Scene, folder: &Path, from: f64, to: f64, all: bool, set: impl Fn(&mut Scene, f64)) {
    let at = |v: f64| { let mut s = scene.clone(); set(&mut s, v); Ok(s) };
    let family = Family::new(ParameterRange { key: "k".into(), from, to }, &at, folder).unwrap();
    let mut b = Branches::new(&family, all).unwrap();
    let t = std::time::Instant::now();
    b.follow(&family, &mut |_| {}).unwrap();
    println!("== {name} {from} {to}: {} paths, enumerated {}, {:.2} s", b.paths.len(), b.is_enumerated, t.elapsed().as_secs_f64());
    for p in &b.paths {
        println!(" path {:?} {} points end {:?}", p.origin, p.points.len(), p.end);
        for q in &p.points {
            if q.kind != PointKind::Regular {
                println!("   {:?} γ={:.12} zones {:?} det {} ρ {:.4} res {:.1e} N {:.6e} T {:.4e} {:?}", q.kind, q.parameter, q.zones, q.determinant, q.spectral_radius, q.residual, q.normal_force, q.tangential_force[0], q.switches.iter().take(5).collect::<Vec<_>>());
            }
        }
    }
    for v in [from, to] {
        println!(" at {v}: {} solutions, degree {}", b.end_solutions(v).len(), b.degree(v));
    }
}

#[test]
fn scratch() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    let read = |name: &str| SceneFile::read(&folder.join(name)).unwrap().scene;
    let one = read("one_node.toml");
    let f = |s: &mut Scene, v: f64| s.friction.as_mut().unwrap().coefficient = Some(Coefficient::Constant(v));
    show("one node F", &one, &folder, 0.5, 4.0, true, f);
    show("two nodes F", &read("two_nodes.toml"), &folder, 0.3, 3.0, true, f);
    show("one node load", &one, &folder, -1.0, 1.0, true, |s, v| s.tractions[0].value[2] = (v * 4e-3).into());
    let mut brick = read("brick.toml");
    brick.body = { let mut b = brick.body.clone(); if let Shape::Brick(b) = &mut b.shape { b.cells = [12, 4, 4]; } b };
    let f2 = |s: &mut Scene, v: f64| { let f = s.friction.as_mut().unwrap(); f.coefficient_1 = Some(Coefficient::Constant(v)); f.coefficient_2 = Some(Coefficient::Constant(v)); };
    show("brick F", &brick, &folder, 0.3, 3.0, false, f2);
}
