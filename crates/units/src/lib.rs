#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod dimension;
mod unit;
mod worded;

pub use dimension::Dimension;
pub use unit::{Unit, in_digits, rounded};

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

crate::worded! {
    /// A unit of length.
    #[derive(Default, Serialize, Deserialize, JsonSchema)]
    pub enum LengthUnit {
        /// Metre.
        #[default]
        #[serde(rename = "m")]
        Metre = "m",
        /// Millimetre.
        #[serde(rename = "mm")]
        Millimetre = "mm",
        /// Centimetre.
        #[serde(rename = "cm")]
        Centimetre = "cm",
        /// Micrometre.
        #[serde(rename = "um")]
        Micrometre = "um",
        /// Nanometre.
        #[serde(rename = "nm")]
        Nanometre = "nm",
        /// Kilometre.
        #[serde(rename = "km")]
        Kilometre = "km",
        /// Inch.
        #[serde(rename = "in")]
        Inch = "in",
        /// Foot.
        #[serde(rename = "ft")]
        Foot = "ft",
    }
}

impl LengthUnit {
    /// Its length in metres, by definition.
    const fn in_metres(self) -> f64 {
        [1.0, 1e-3, 1e-2, 1e-6, 1e-9, 1e3, 0.0254, 0.3048][self as usize]
    }

    /// The power of ten of metres that it is, where it is one.
    const fn metres(self) -> Option<i32> {
        match self {
            Self::Inch | Self::Foot => None,
            _ => Some([0, -3, -2, -6, -9, 3][self as usize]),
        }
    }
}

crate::worded! {
    /// A unit of force.
    #[derive(Default, Serialize, Deserialize, JsonSchema)]
    pub enum ForceUnit {
        /// Newton.
        #[default]
        #[serde(rename = "N")]
        Newton = "N",
        /// Kilonewton.
        #[serde(rename = "kN")]
        Kilonewton = "kN",
        /// Meganewton.
        #[serde(rename = "MN")]
        Meganewton = "MN",
        /// Millinewton.
        #[serde(rename = "mN")]
        Millinewton = "mN",
        /// Kilogram-force.
        #[serde(rename = "kgf")]
        KilogramForce = "kgf",
        /// Pound-force.
        #[serde(rename = "lbf")]
        PoundForce = "lbf",
    }
}

impl ForceUnit {
    /// Its size in newtons, by definition.
    const fn in_newtons(self) -> f64 {
        [1.0, 1e3, 1e6, 1e-3, 9.806_65, 4.448_221_615_260_5][self as usize]
    }

    /// The power of ten of newtons that it is, where it is one.
    const fn newtons(self) -> Option<i32> {
        match self {
            Self::KilogramForce | Self::PoundForce => None,
            _ => Some([0, 3, 6, -3][self as usize]),
        }
    }
}

/// The units of a scene, from which those of all quantities follow: stresses are forces per squared length,
/// energies forces times lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of lengths.
    #[serde(default)]
    pub length: LengthUnit,
    /// Unit of forces.
    #[serde(default)]
    pub force: ForceUnit,
}

impl Units {
    /// Metres and newtons, the default.
    pub const SI: Self = Self {
        length: LengthUnit::Metre,
        force: ForceUnit::Newton,
    };

    /// Whether these are the units of a scene that names none.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::SI
    }

    /// The unit of a quantity.
    #[must_use]
    pub fn of(self, dimension: Dimension) -> Unit {
        Unit::new(self, dimension)
    }

    /// The word for the unit of a quantity, `1` for a number without unit.
    #[must_use]
    pub fn word(self, dimension: Dimension) -> String {
        self.of(dimension).word().to_owned()
    }

    /// The word for lengths.
    #[must_use]
    pub fn length(self) -> &'static str {
        self.length.word()
    }

    /// The word for forces.
    #[must_use]
    pub fn force(self) -> &'static str {
        self.force.word()
    }

    /// The word for stresses.
    #[must_use]
    pub fn stress(self) -> String {
        self.word(Dimension::STRESS)
    }

    /// A stress known in pascals, for advice only: no number of a scene is ever converted.
    #[must_use]
    pub fn from_pascals(self, stress: f64) -> f64 {
        stress * self.length.in_metres().powi(2) / self.force.in_newtons()
    }

    /// The word for energies.
    #[must_use]
    pub fn energy(self) -> String {
        self.word(Dimension::Energy)
    }
}

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.length(), self.force())
    }
}

impl FromStr for Units {
    type Err = String;

    /// The inverse of `Display`, such as `mm, N`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once(", ").and_then(|(length, force)| {
            Some(Self {
                length: LengthUnit::named(length)?,
                force: ForceUnit::named(force)?,
            })
        });
        parsed.ok_or_else(|| format!("{text:?} names no unit of length and unit of force"))
    }
}
