//! The multipliers that a solve starts from.

/// The multipliers that a solve starts from.
#[derive(Debug)]
pub(super) enum StartFrom {
    /// λ = 0; a stored solve stays fresh, whatever it started from.
    Any,
    /// λ = 0, and nothing else.
    Zero,
    /// Those of a similar problem, `[n_multipliers]` in Pa.
    Given {
        multiplier: Vec<f64>,
        digest: String,
    },
}

impl StartFrom {
    /// From these multipliers, or from λ = 0 if there are none.
    pub(super) fn multipliers(multiplier: Vec<f64>) -> Self {
        if multiplier.is_empty() {
            return Self::Zero;
        }
        let bytes: Vec<u8> = multiplier.iter().flat_map(|v| v.to_le_bytes()).collect();
        Self::Given {
            multiplier,
            digest: blake3::hash(&bytes).to_hex().to_string(),
        }
    }

    pub(super) fn multiplier(&self) -> Option<&[f64]> {
        match self {
            Self::Any | Self::Zero => None,
            Self::Given { multiplier, .. } => Some(multiplier),
        }
    }

    /// The digest of the multipliers; `None` for λ = 0.
    pub(super) fn digest(&self) -> Option<&str> {
        match self {
            Self::Any | Self::Zero => None,
            Self::Given { digest, .. } => Some(digest),
        }
    }
}
