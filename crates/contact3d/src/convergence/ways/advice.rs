//! Which way is the cheapest to a given accuracy.

use std::fmt;

use super::{Way, WayKind, WayLevel};

/// The relative errors that advice is given for.
pub const TARGETS: [f64; 3] = [0.05, 0.02, 0.01];

/// The cheapest way to one accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cheapest {
    /// The relative error in the energy norm.
    pub target: f64,
    /// The way and its seconds; `None` where no way reached it within the budget.
    pub way: Option<(WayKind, f64)>,
}

/// The cheapest way to each of [`TARGETS`].
#[derive(Debug, Clone, PartialEq)]
pub struct WayAdvice {
    /// One for each target.
    pub cheapest: Vec<Cheapest>,
}

impl WayAdvice {
    /// Reads the advice off the ways.
    #[must_use]
    pub fn new(ways: &[Way]) -> Self {
        let cheapest = TARGETS.map(|target| {
            let reached = ways
                .iter()
                .filter_map(|way| Some((way.kind, way.seconds_to(target)?)));
            Cheapest {
                target,
                way: reached.min_by(|(_, a), (_, b)| a.total_cmp(b)),
            }
        });
        Self {
            cheapest: cheapest.to_vec(),
        }
    }
}

impl Way {
    /// Seconds to a relative error: those of the first mesh where that is as accurate, else between two meshes along a
    /// straight line in the plane of the logarithms; `None` where no mesh reaches it.
    ///
    /// The estimated error counts where the true one is not known.
    #[must_use]
    pub fn seconds_to(&self, target: f64) -> Option<f64> {
        let error = |level: &WayLevel| level.error.unwrap_or(level.estimated_error);
        let reached = self
            .levels
            .iter()
            .position(|level| error(level) <= target)?;
        let fine = &self.levels[reached];
        let Some(coarse) = reached.checked_sub(1).map(|k| &self.levels[k]) else {
            return Some(fine.cost.seconds);
        };
        if error(fine) == 0.0 {
            return Some(fine.cost.seconds);
        }
        let share = (error(coarse) / target).ln() / (error(coarse) / error(fine)).ln();
        let [from, to] = [coarse, fine].map(|level| level.cost.seconds.ln());
        Some((from + share * (to - from)).exp())
    }
}

impl fmt::Display for WayAdvice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, cheapest) in self.cheapest.iter().enumerate() {
            let separator = if k == 0 { "" } else { "; " };
            let percent = 100.0 * cheapest.target;
            write!(f, "{separator}{percent} %: ")?;
            match cheapest.way {
                Some((kind, seconds)) => write!(f, "{}, {seconds:.2} s", kind.words())?,
                None => f.write_str("not reached within the budget")?,
            }
        }
        Ok(())
    }
}
