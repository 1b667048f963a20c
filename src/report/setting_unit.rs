//! Units of the keys of a scene.

use units::{Dimension, Unit, Units};

/// The unit of the values of a key of the scene; none for numbers.
pub fn setting_unit(key: &str, units: Units) -> Unit {
    let words: Vec<&str> = key
        .split('.')
        .filter(|word| word.parse::<usize>().is_err())
        .collect();
    let dimension = match words.as_slice() {
        ["pressure" | "traction", "value"]
        | [
            ..,
            "young_modulus" | "young_moduli" | "shear_moduli" | "stiffness",
        ]
        | [.., "slip_bound" | "pressure_cap"] => Dimension::STRESS,
        ["clamp", "value"]
        | [.., "height", "value"]
        | ["body", "brick", "coordinates", _]
        | [
            ..,
            "gap" | "size" | "box" | "radius" | "onset" | "centre" | "point",
        ]
        | [.., "slip" | "slip_1" | "slip_2"] => Dimension::LENGTH,
        // Stiffnesses of springs are stresses over displacements.
        ["body_force", "value"] | ["spring", "normal" | "tangential" | "tensor"] => {
            Dimension::BODY_FORCE
        }
        [.., "rate"] => Dimension::PER_LENGTH,
        ["step", "time"] => Dimension::Time,
        _ => Dimension::Number,
    };
    units.of(dimension)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_and_lengths_have_units() {
        let unit = |key: &str| setting_unit(key, Units::SI).word().to_owned();
        assert_eq!(unit("pressure.0.value"), "Pa");
        assert_eq!(unit("material.isotropic.young_modulus"), "Pa");
        assert_eq!(unit("contact.0.friction.slip_bound"), "Pa");
        assert_eq!(unit("friction.pressure_cap"), "Pa");
        assert_eq!(unit("contact.gap"), "m");
        assert_eq!(unit("body.brick.size.0"), "m");
        assert_eq!(unit("friction.coefficient_1.table.slip.1"), "m");
        assert_eq!(unit("friction.coefficient.ramp.rate"), "1/m");
        assert_eq!(unit("body_force.value.2"), "N/m^3");
        assert_eq!(unit("spring.0.normal"), "N/m^3");
        assert!(setting_unit("friction.coefficient.constant", Units::SI).is_none());
    }
}
