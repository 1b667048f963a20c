//! Changes that rounding keeps from falling.

/// Steps in which changes must halve; a contraction of 0.993 a step does that.
const PATIENCE: usize = 100;

/// A larger change is not rounding: 1e-8 is left where the body's motion as a whole takes half the digits.
const LARGEST: f64 = 1e-8;

/// Watches the changes of successive approximations whose inner problems are solved to rounding.
#[derive(Debug, Default)]
pub(super) struct Stall {
    /// The last change that was half the one before it in this row, and the steps since.
    best: Option<f64>,
    idle: usize,
}

impl Stall {
    /// Whether small changes have not halved in [`PATIENCE`] steps, all with inner problems solved to rounding.
    pub(super) fn is_at_rounding(&mut self, change: f64, inner_at_rounding: bool) -> bool {
        let falls = self.best.is_none_or(|best| change <= 0.5 * best);
        if falls || !inner_at_rounding || change > LARGEST {
            self.best = Some(self.best.map_or(change, |best| best.min(change)));
            self.idle = 0;
            return false;
        }
        self.idle += 1;
        self.idle >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_seen_and_slow_convergence_is_not_noise() {
        let mut noise = Stall::default();
        let at =
            (0..).position(|k| noise.is_at_rounding(if k % 2 == 0 { 1e-10 } else { 2e-10 }, true));
        assert_eq!(at, Some(PATIENCE));
        let mut slow = Stall::default();
        assert!((0..2000).all(|k| !slow.is_at_rounding(1e-9 * 0.99_f64.powi(k), true)));
        let mut large = Stall::default();
        assert!((0..2000).all(|_| !large.is_at_rounding(1e-3, true)));
        let mut loose = Stall::default();
        assert!((0..2000).all(|_| !loose.is_at_rounding(1e-10, false)));
    }
}
