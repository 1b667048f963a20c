//! What damped Newton methods share, with a matrix and without: halved steps, and what a stall is.

/// Halvings of one step before the full step is taken all the same.
const STEP_MAX_HALVINGS: usize = 12;

/// Steps in which the best residual must halve; otherwise Newton's method has stalled.
pub(in crate::solver) const STAGNATION_STEPS: usize = 10;

/// Below this relative residual a stall is rounding.
pub(in crate::solver) const ROUNDING_ZONE: f64 = 1e-9;

/// A step that was taken.
pub(in crate::solver) struct Damped<T> {
    /// What it led to.
    pub(in crate::solver) reached: T,
    /// Its length over that of the full step.
    pub(in crate::solver) length: f64,
    /// Halvings that were tried.
    pub(in crate::solver) halvings: usize,
}

/// Halves the step until `decreases` says so of what a share of it leads to; the full step where nothing does.
pub(in crate::solver) fn halved<T>(
    mut at: impl FnMut(f64) -> T,
    decreases: impl Fn(&T) -> bool,
) -> Damped<T> {
    let mut full = None;
    for halvings in 0..=STEP_MAX_HALVINGS {
        let length = 0.5_f64.powi(halvings as i32);
        let reached = at(length);
        if decreases(&reached) {
            return Damped {
                reached,
                length,
                halvings,
            };
        }
        full.get_or_insert(reached);
    }
    Damped {
        reached: full.expect("the full step is the first"),
        length: 1.0,
        halvings: STEP_MAX_HALVINGS,
    }
}

/// The least residual after each step.
pub(in crate::solver) struct BestResiduals {
    least: Vec<f64>,
    /// The first one that a stall is measured from.
    first: usize,
}

impl BestResiduals {
    pub(in crate::solver) fn new(norm: f64) -> Self {
        Self {
            least: vec![norm],
            first: 0,
        }
    }

    pub(in crate::solver) fn push(&mut self, norm: f64) {
        let least = self.least[self.least.len() - 1];
        self.least.push(least.min(norm));
    }

    /// Measures stalls from the next step on.
    pub(in crate::solver) fn begin_anew(&mut self) {
        self.first = self.least.len();
    }

    /// Whether the last steps, so many, have not halved the residual.
    pub(in crate::solver) fn stalled_for(&self, steps: usize) -> bool {
        let last = self.least.len() - 1;
        last >= self.first + steps && self.least[last] > 0.5 * self.least[last - steps]
    }
}
