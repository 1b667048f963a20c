//! Units, their dimensions and the words for them.

use contact3d_units::{Dimension, ForceUnit, LengthUnit, Units};

fn units(length: LengthUnit, force: ForceUnit) -> Units {
    Units { length, force }
}

#[test]
fn the_words_of_si() {
    let words = [
        (Dimension::Number, "1"),
        (Dimension::Time, "s"),
        (Dimension::Memory, "B"),
        (Dimension::LENGTH, "m"),
        (Dimension::AREA, "m^2"),
        (Dimension::VOLUME, "m^3"),
        (Dimension::PER_LENGTH, "1/m"),
        (Dimension::FORCE, "N"),
        (Dimension::STRESS, "Pa"),
        (Dimension::BODY_FORCE, "N/m^3"),
        (Dimension::MOMENT, "N m"),
        (Dimension::Energy, "J"),
        (Dimension::STIFFNESS, "N/m"),
        (Dimension::ROOT_OF_STIFFNESS, "(N/m)^(1/2)"),
        (Dimension::DUAL, "m^3/Pa"),
        (Dimension::COMPLIANCE, "m/Pa"),
        (Dimension::PER_DUAL, "Pa/m^3"),
    ];
    for (dimension, word) in words {
        assert_eq!(Units::SI.word(dimension), word, "{dimension}");
    }
}

#[test]
fn stresses_and_energies_follow() {
    use ForceUnit as F;
    use LengthUnit as L;
    for (length, force, stress, energy) in [
        (L::Millimetre, F::Newton, "MPa", "mJ"),
        (L::Millimetre, F::Kilonewton, "GPa", "J"),
        (L::Metre, F::Kilonewton, "kPa", "kJ"),
        (L::Metre, F::Meganewton, "MPa", "MJ"),
        (L::Micrometre, F::Newton, "TPa", "uJ"),
        (L::Micrometre, F::Millinewton, "GPa", "nJ"),
        (L::Centimetre, F::Newton, "N/cm^2", "N cm"),
        (L::Centimetre, F::Kilonewton, "kN/cm^2", "kN cm"),
        (L::Kilometre, F::Newton, "N/km^2", "kJ"),
        (L::Centimetre, F::KilogramForce, "kgf/cm^2", "kgf cm"),
        (L::Inch, F::PoundForce, "psi", "lbf in"),
        (L::Foot, F::PoundForce, "lbf/ft^2", "lbf ft"),
        (L::Inch, F::Newton, "N/in^2", "N in"),
    ] {
        let units = units(length, force);
        assert_eq!((&*units.stress(), &*units.energy()), (stress, energy));
    }
}

#[test]
fn a_stress_without_a_name_is_not_named_in_composites() {
    let composite = |units: Units| {
        [
            Dimension::DUAL,
            Dimension::COMPLIANCE,
            Dimension::PER_DUAL,
            Dimension::STIFFNESS,
            Dimension::MOMENT,
        ]
        .map(|dimension| units.word(dimension))
    };
    let millimetres = units(LengthUnit::Millimetre, ForceUnit::Newton);
    assert_eq!(
        composite(millimetres),
        ["mm^3/MPa", "mm/MPa", "MPa/mm^3", "N/mm", "N mm"]
    );
    let centimetres = units(LengthUnit::Centimetre, ForceUnit::Newton);
    assert_eq!(
        composite(centimetres),
        ["cm^5/N", "cm^3/N", "N/cm^5", "N/cm", "N cm"]
    );
}

#[test]
fn a_known_stress_is_said_in_any_units() {
    let steel = |length, force| units(length, force).from_pascals(2.1e11);
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-4;
    assert!(near(steel(LengthUnit::Metre, ForceUnit::Newton), 2.1e11));
    assert!(near(
        steel(LengthUnit::Millimetre, ForceUnit::Newton),
        2.1e5
    ));
    // 1 psi = 6894.757 Pa.
    assert!(near(
        steel(LengthUnit::Inch, ForceUnit::PoundForce),
        3.0458e7
    ));
}

#[test]
fn words_read_back() {
    for length in LengthUnit::ALL {
        for force in ForceUnit::ALL {
            let units = units(length, force);
            assert_eq!(units.to_string().parse(), Ok(units));
            let toml = toml::to_string(&units).unwrap();
            assert!(toml.contains(&format!("\"{}\"", length.word())), "{toml}");
            assert_eq!(toml::from_str::<Units>(&toml).unwrap(), units);
        }
    }
    assert!("mm, furlong".parse::<Units>().is_err());
}

#[test]
fn dimensions_are_powers() {
    assert_eq!(Dimension::STRESS.to_string(), "F L^-2");
    assert_eq!(Dimension::DUAL.to_string(), "F^-1 L^5");
    assert_eq!(Dimension::ROOT_OF_STIFFNESS.to_string(), "(F L^-1)^(1/2)");
}
