//! A body of one's own from Gmsh: a steel stem on a rubber pad, in millimetres, shaken sideways by its own weight.
//!
//! `cargo run --release -p contact3d --example own_mesh -- pipelines/meshes/foot.msh`: physical surfaces name the faces,
//! physical volumes the regions.

use std::path::Path;

use contact3d::{
    Problem, ProblemError,
    mesh::Quality,
    post::ContactReport,
    scene::{Body, Clamp, Contact, Friction, Material, Part, Scene, SolveSettings},
};

/// Force per volume in N/m³.
pub(crate) const FORCE: [f64; 3] = [1e6, 0.0, -4e6];

/// The mesh's quality, and what the body does.
pub(crate) fn solve(mesh_file: &Path) -> Result<(Quality, ContactReport), ProblemError> {
    let scene = Scene::new(
        Body::gmsh(mesh_file, 1e-3),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_region(Part::Group("rubber".into()), Material::isotropic(5e6, 0.45))
    .with_clamp(Clamp::face("held end"))
    .with_body_force(FORCE)
    .with_contact(Contact::on("contact"))
    .with_friction(Friction::coulomb(0.2));
    let problem = Problem::new(scene)?;
    let quality = Quality::of(problem.mesh());
    let (_, report) = problem
        .assemble()?
        .solve_and_report(&SolveSettings::default())?;
    Ok((quality, report))
}

fn main() -> Result<(), ProblemError> {
    let default = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../pipelines/meshes/foot.msh"
    );
    let file = std::env::args().nth(1).unwrap_or(default.to_owned());
    let (quality, report) = solve(Path::new(&file))?;
    println!(
        "volume {:.4e} m^3, worst shape of a tetrahedron {:.2}",
        quality.total_volume, quality.smallest_shape
    );
    let r = report.resultants;
    println!("load       {:?} N", r.applied_force);
    println!("clamps     {:?} N", r.clamp_force);
    if let Some(contact) = r.contact {
        println!("foundation {:?} N", contact.contact_force);
    }
    println!("largest displacement {:?} m", r.largest_displacement_along);
    Ok(())
}
