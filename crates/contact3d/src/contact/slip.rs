//! Slips φ = (r_h|u_t1|, r_h|u_t2|) with Lagrange's interpolation r_h (HKL §3), and where those of a load history begin.

use std::borrow::Cow;

use crate::scene::SlipMeasure;

/// How slips φ are made of the signed (u_t1, u_t2) at the contact nodes.
#[derive(Debug, Clone, Default)]
pub struct SlipMap {
    /// Where the step begins; `None` in the first of a load history, and without a history.
    pub previous: Option<PreviousIncrement>,
}

impl SlipMap {
    /// The slips that coefficients follow at the contact nodes, for the signed (u_t1, u_t2) there, in m. A path of
    /// sliding from former steps is added by the law.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let counted = self.counted(tangential);
        counted.iter().map(|u| u.map(f64::abs)).collect()
    }

    /// The derivative of [`Self::slip`] by (u_t1, u_t2) at the same node: the signs of both, 0 for 0.
    #[must_use]
    pub fn derivative(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let sign = |u: f64| if u == 0.0 { 0.0 } else { u.signum() };
        let counted = self.counted(tangential);
        counted.iter().map(|u| u.map(sign)).collect()
    }

    /// u_t less where the slip is counted from, where the law counts from there.
    fn counted<'u>(&self, tangential: &'u [[f64; 2]]) -> Cow<'u, [[f64; 2]]> {
        match &self.previous {
            Some(previous) if previous.follows != SlipMeasure::TotalSlip => {
                previous.slip(tangential).into()
            }
            _ => tangential.into(),
        }
    }
}

/// The change of slips whose derivatives are signs, with a change of (u_t1, u_t2) at the nodes.
pub fn change_of_slips(signs: &[[f64; 2]], moved: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
    let nodes = signs.iter().enumerate();
    let change = nodes.map(|(node, sign)| {
        let moved = moved(node);
        [sign[0] * moved[0], sign[1] * moved[1]]
    });
    change.collect()
}

/// Where the contact nodes are when a step begins, and how far they have slid.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviousIncrement {
    /// (u_t1, u_t2) that the slip of the step is counted from, `[n_contact_nodes]`, in m.
    pub tangential: Vec<[f64; 2]>,
    /// Lengths of the path of sliding: Σ r_h|Δu_t1|, Σ r_h|Δu_t2| and the sum of the roots of their squares,
    /// `[n_contact_nodes]`, in m.
    pub path: Vec<[f64; 3]>,
    /// The slip that coefficients of friction follow.
    pub follows: SlipMeasure,
}

impl PreviousIncrement {
    /// u_t − u_tⁿ⁻¹ at the contact nodes in m.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let pairs = tangential.iter().zip(&self.tangential);
        pairs
            .map(|(u, from)| [u[0] - from[0], u[1] - from[1]])
            .collect()
    }

    /// u_t1 or u_t2 where the step begins, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn component(&self, k: usize) -> Vec<f64> {
        self.tangential.iter().map(|u| u[k]).collect()
    }
}
