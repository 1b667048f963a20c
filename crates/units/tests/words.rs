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

/// Four digits, the prefix of SI that leaves one to three digits before the point, squares for areas, and other units as they are.
#[test]
fn values_are_told_with_prefixes() {
    let si = |dimension| Units::SI.of(dimension);
    let millimetres = units(LengthUnit::Millimetre, ForceUnit::Newton);
    let inches = units(LengthUnit::Inch, ForceUnit::PoundForce);
    let told = [
        (si(Dimension::FORCE).told(&[5.915629e7]), "59.16 MN"),
        (
            si(Dimension::FORCE).told(&[-9.153384e6, -27.7, 5.915629e7]),
            "(-9.15, 0, 59.16) MN",
        ),
        (si(Dimension::FORCE).told(&[0.0]), "0 N"),
        (si(Dimension::LENGTH).told(&[3.2969e-4]), "329.7 µm"),
        (si(Dimension::LENGTH).told(&[1.0]), "1 m"),
        (si(Dimension::AREA).told(&[6.0004e-6]), "6 mm²"),
        (si(Dimension::AREA).told(&[2.3621]), "2.362 m²"),
        (si(Dimension::AREA).told(&[0.531938]), "0.5319 m²"),
        (
            millimetres.of(Dimension::STRESS).told(&[80.71]),
            "80.71 MPa",
        ),
        (millimetres.of(Dimension::AREA).told(&[0.25]), "0.25 mm²"),
        (
            millimetres.of(Dimension::LENGTH).told(&[1750.0, 20.0]),
            "(1750, 20) mm",
        ),
        (inches.of(Dimension::STRESS).told(&[12345.6]), "12346 psi"),
        (si(Dimension::STRESS).told(&[1e-12]), "1.000e-12 Pa"),
        (si(Dimension::Number).told(&[0.98765]), "0.9877"),
    ];
    for (told, expected) in told {
        assert_eq!(told, expected);
    }
}
