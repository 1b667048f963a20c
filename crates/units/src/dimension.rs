//! What a quantity is measured in, whatever the units of the scene.

use std::fmt;

/// The dimension of a quantity. Density, time and temperature do not occur in statics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A number without unit, a count or a text.
    Number,
    /// Wall-clock time, always in seconds.
    Time,
    /// Memory, always in bytes.
    Memory,
    /// Force^`force` × length^`length`.
    Product {
        /// Exponent of the force.
        force: i8,
        /// Exponent of the length.
        length: i8,
    },
    /// Force × length where it is work and not a moment.
    Energy,
    /// The square root of force^`force` × length^`length`, such as an entry of a Cholesky factor.
    Root {
        /// Exponent of the force below the root.
        force: i8,
        /// Exponent of the length below the root.
        length: i8,
    },
}

impl Dimension {
    /// Coordinates, displacements, gaps, slips.
    pub const LENGTH: Self = Self::product(0, 1);
    /// Areas.
    pub const AREA: Self = Self::product(0, 2);
    /// Volumes.
    pub const VOLUME: Self = Self::product(0, 3);
    /// Derivatives of numbers by lengths.
    pub const PER_LENGTH: Self = Self::product(0, -1);
    /// Forces.
    pub const FORCE: Self = Self::product(1, 0);
    /// Stresses, pressures, multipliers, moduli.
    pub const STRESS: Self = Self::product(1, -2);
    /// Forces per volume.
    pub const BODY_FORCE: Self = Self::product(1, -3);
    /// Moments of forces.
    pub const MOMENT: Self = Self::product(1, 1);
    /// Entries of the stiffness matrix.
    pub const STIFFNESS: Self = Self::product(1, -1);
    /// Entries of the Cholesky factor of the stiffness matrix.
    pub const ROOT_OF_STIFFNESS: Self = Self::Root {
        force: 1,
        length: -1,
    };
    /// Entries of the dual operator: area times displacement over stress.
    pub const DUAL: Self = Self::product(-1, 5);
    /// Displacement over stress.
    pub const COMPLIANCE: Self = Self::product(-1, 3);
    /// The inverse of [`Self::DUAL`]: steplengths of gradient steps.
    pub const PER_DUAL: Self = Self::product(1, -5);

    const fn product(force: i8, length: i8) -> Self {
        Self::Product { force, length }
    }
}

impl fmt::Display for Dimension {
    /// In powers of force F and length L, such as `F L^-2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Number => f.write_str("1"),
            Self::Time => f.write_str("time"),
            Self::Memory => f.write_str("memory"),
            Self::Energy => f.write_str("F L"),
            Self::Product { force, length } => f.write_str(&powers(force, length)),
            Self::Root { force, length } => write!(f, "({})^(1/2)", powers(force, length)),
        }
    }
}

fn powers(force: i8, length: i8) -> String {
    let power = |symbol: &str, exponent: i8| match exponent {
        0 => None,
        1 => Some(symbol.to_owned()),
        exponent => Some(format!("{symbol}^{exponent}")),
    };
    let factors = [power("F", force), power("L", length)];
    factors.into_iter().flatten().collect::<Vec<_>>().join(" ")
}
