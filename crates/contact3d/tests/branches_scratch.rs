use contact3d::{branches::*, scene::*};
use std::path::Path;

fn show(
    name: &str,
    scene: &Scene,
    folder: &Path,
    from: f64,
    to: f64,
    all: bool,
    set: impl Fn(&mut Scene, f64),
) {
    let at = |v: f64| {
        let mut s = scene.clone();
        set(&mut s, v);
        Ok(s)
    };
    let family = Family::new(
        ParameterRange {
            key: "k".into(),
            from,
            to,
        },
        &at,
        folder,
    )
    .unwrap();
    let mut b = Branches::new(&family, all).unwrap();
    let t = std::time::Instant::now();
    let mut count = 0;
    b.follow(&family, &mut |b| {
        count += 1;
        let p = b.paths.last().unwrap();
        let q = p.points.last().unwrap();
        if count < 400 || count % 500 == 0 {
            eprintln!(
                "{count} path {} n {} {:?} γ={:.9} z {:?} d {} r {:.1e} {:?} {:?}",
                b.paths.len(),
                p.points.len(),
                q.kind,
                q.parameter,
                q.zones,
                q.determinant,
                q.residual,
                q.switches,
                p.end
            );
        }
    })
    .unwrap();
    println!(
        "== {name} {from} {to}: {} paths, enumerated {}, {:.2} s",
        b.paths.len(),
        b.is_enumerated,
        t.elapsed().as_secs_f64()
    );
    for p in &b.paths {
        println!(
            " path {:?} {} points end {:?}",
            p.origin,
            p.points.len(),
            p.end
        );
        for q in &p.points {
            if q.kind != PointKind::Regular {
                println!(
                    "   {:?} γ={:.12} zones {:?} det {} ρ {:.4} res {:.1e} N {:.6e} T {:.4e} {:?}",
                    q.kind,
                    q.parameter,
                    q.zones,
                    q.determinant,
                    q.spectral_radius,
                    q.residual,
                    q.normal_force,
                    q.tangential_force[0],
                    q.switches.iter().take(5).collect::<Vec<_>>()
                );
            }
        }
    }
    for v in [from, to] {
        println!(
            " at {v}: {} solutions, degree {}",
            b.end_solutions(v).len(),
            b.degree(v)
        );
    }
}

#[test]
fn scratch() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    let read = |name: &str| SceneFile::read(&folder.join(name)).unwrap().scene;
    let one = read("one_node.toml");
    let f = |s: &mut Scene, v: f64| {
        s.friction.as_mut().unwrap().coefficient = Some(Coefficient::Constant(v))
    };
    let cells = |scene: &Scene, n: usize| {
        let mut s = scene.clone();
        s.body = {
            let mut b = s.body.clone();
            if let Shape::Brick(b) = &mut b.shape {
                b.cells = [3 * n, n, n];
            }
            b
        };
        s
    };
    let brick = read("brick.toml");
    let f2 = |s: &mut Scene, v: f64| {
        let f = s.friction.as_mut().unwrap();
        f.coefficient_1 = Some(Coefficient::Constant(v));
        f.coefficient_2 = Some(Coefficient::Constant(v));
    };
    let ramp = |s: &mut Scene, i: f64, r: f64, rate: f64| {
        let f = s.friction.as_mut().unwrap();
        let c = Some(Coefficient::Ramp(Ramp {
            initial: i,
            residual: r,
            onset: 0.0,
            rate,
        }));
        f.coefficient_1 = c.clone();
        f.coefficient_2 = c;
    };
    show(
        "brick 4 load",
        &cells(&brick, 4),
        &folder,
        0.0,
        1e7,
        false,
        |s, v| s.tractions[0].value[0] = v.into(),
    );
    show("brick 4 F", &cells(&brick, 4), &folder, 0.3, 1e6, true, f2);
    show(
        "brick 4 weakening in initial",
        &cells(&brick, 4),
        &folder,
        0.02,
        5.0,
        true,
        |s, v| ramp(s, v, 0.01, 4.99e5),
    );
    show("brick 8 F", &cells(&brick, 8), &folder, 0.3, 1e6, true, f2);
    show(
        "brick 8 weakening in initial",
        &cells(&brick, 8),
        &folder,
        0.02,
        5.0,
        true,
        |s, v| ramp(s, v, 0.01, 4.99e5),
    );
}
