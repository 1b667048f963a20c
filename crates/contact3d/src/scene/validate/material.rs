//! Checks of materials and regions.

use nalgebra::Vector3;
use units::Units;

use super::{positive, require};
use crate::scene::{InvalidValue, Isotropic, Material, Orthotropic, Part, Scene, Voigt, Written};

/// Relative rounding allowed to hand-typed numbers: symmetry of C, right angles of axes.
const TYPED_DIGITS: f64 = 1e-6;

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    check_law(&scene.material, "material", scene.units)?;
    for (i, region) in scene.regions.iter().enumerate() {
        check_law(
            &region.material,
            &format!("region.{i}.material"),
            scene.units,
        )?;
        check_part(&region.part, &format!("region.{i}.part"), scene)?;
    }
    Ok(())
}

fn check_part(part: &Part, key: &str, scene: &Scene) -> Result<(), InvalidValue> {
    match part {
        Part::Group(name) => require(
            scene.body.mesh_file().is_some(),
            format!("{key}.group"),
            "a box, since a brick has no physical volumes",
            Written(name),
            "write box = [[x, y, z], [x, y, z]] with two opposite corners",
        ),
        Part::Box([low, high]) => require(
            (0..3).all(|c| low[c] < high[c] && low[c].is_finite() && high[c].is_finite()),
            format!("{key}.box"),
            &format!(
                "two corners [min, max], min below max in x, y and z [{}]",
                scene.units.length()
            ),
            Written(&[low, high]),
            "give the lower corner first",
        ),
    }
}

fn check_law(material: &Material, key: &str, units: Units) -> Result<(), InvalidValue> {
    match material {
        Material::Isotropic(constants) => {
            check_isotropic(constants, &format!("{key}.isotropic"), units)
        }
        Material::Orthotropic(constants) => {
            check_orthotropic(constants, &format!("{key}.orthotropic"), units)?;
            check_definite(material, &format!("{key}.orthotropic"), units)
        }
        Material::Voigt(voigt) => {
            check_voigt(voigt, &format!("{key}.voigt"), units)?;
            check_definite(material, &format!("{key}.voigt"), units)
        }
    }
}

fn check_isotropic(material: &Isotropic, key: &str, units: Units) -> Result<(), InvalidValue> {
    require(
        positive(material.young_modulus),
        format!("{key}.young_modulus"),
        &format!("a positive modulus [{}]", units.stress()),
        Written(&material.young_modulus),
        &format!(
            "steel has {:.1e} {}",
            units.from_pascals(2.1e11),
            units.stress()
        ),
    )?;
    require(
        material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5,
        format!("{key}.poisson_ratio"),
        "a ratio with -1 < ratio < 0.5",
        Written(&material.poisson_ratio),
        "at 0.5 the material is incompressible and this displacement method has no solution; rubber has 0.49 to 0.4999, on quadratic \
         tetrahedra (body.element = \"P2\")",
    )
}

fn check_orthotropic(material: &Orthotropic, key: &str, units: Units) -> Result<(), InvalidValue> {
    for (name, moduli) in [
        ("young_moduli", material.young_moduli),
        ("shear_moduli", material.shear_moduli),
    ] {
        require(
            moduli.iter().all(|&m| positive(m)),
            format!("{key}.{name}"),
            &format!("three positive moduli [{}]", units.stress()),
            Written(&moduli),
            "the order is E1, E2, E3 and G23, G13, G12",
        )?;
    }
    require(
        material.poisson_ratios.iter().all(|n| n.is_finite()),
        format!("{key}.poisson_ratios"),
        "three finite ratios",
        Written(&material.poisson_ratios),
        "the order is nu23, nu13, nu12",
    )?;
    let [first, second] = material.axes.map(Vector3::from);
    let right_angle = first.dot(&second).abs() <= TYPED_DIGITS * first.norm() * second.norm();
    require(
        positive(first.norm()) && positive(second.norm()) && right_angle,
        format!("{key}.axes"),
        "two orthogonal vectors of positive length",
        Written(&material.axes),
        "the third material axis is their cross product",
    )
}

fn check_voigt(material: &Voigt, key: &str, units: Units) -> Result<(), InvalidValue> {
    let c = &material.stiffness;
    let largest = c
        .iter()
        .flatten()
        .fold(0.0_f64, |most, v| most.max(v.abs()));
    let symmetric =
        (0..6).all(|i| (0..i).all(|j| (c[i][j] - c[j][i]).abs() <= TYPED_DIGITS * largest));
    require(
        positive(largest) && c.iter().flatten().all(|v| v.is_finite()) && symmetric,
        format!("{key}.stiffness"),
        &format!(
            "a symmetric 6 x 6 matrix of finite numbers [{}]",
            units.stress()
        ),
        Written(c),
        "rows and columns are xx, yy, zz, yz, xz, xy, with engineering shear strains",
    )
}

/// Refuses an elasticity tensor whose smallest eigenvalue is not positive beyond rounding.
fn check_definite(material: &Material, key: &str, units: Units) -> Result<(), InvalidValue> {
    let eigenvalues = material.elasticity().map(|c| c.symmetric_eigenvalues());
    let definite =
        eigenvalues.is_some_and(|e| e.min() > 6.0 * f64::EPSILON * e.max() && e.max().is_finite());
    require(
        definite,
        key,
        "a positive definite elasticity tensor",
        eigenvalues.map_or("no inverse of the compliance".to_owned(), |e| {
            let (least, most) = (e.min(), e.max());
            format!(
                "eigenvalues from {least:.3e} to {most:.3e} {}",
                units.stress()
            )
        }),
        "every strain must store energy: reduce the Poisson ratios (|nu_ij| < sqrt(E_i/E_j)) or the off-diagonal entries",
    )
}
