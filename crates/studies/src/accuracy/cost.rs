//! What accuracy costs: seconds and peak memory by repeated runs, and the settings that follow from them.

use std::{fmt, fs, time::Instant};

use serde::Serialize;

use super::{Accuracy, AlgebraicStudy, EPSILONS, Level, RunResult};
use contact3d::scene::ElementOrder;

/// What a piece of work took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Median wall-clock seconds of the runs.
    pub seconds: f64,
    /// Number of runs.
    pub repeats: usize,
    /// Largest resident memory of the process during the first run in bytes, with what it held
    /// before; NaN where the system does not tell (it does on Linux).
    pub peak_bytes: f64,
}

/// Does a piece of work, again up to three times as long as one run takes no more than `cheap`
/// seconds. The value is that of the last run.
pub(super) fn measure<T, E>(
    cheap: f64,
    mut work: impl FnMut() -> Result<T, E>,
) -> Result<(T, Cost), E> {
    forget_peak();
    let started = Instant::now();
    let mut value = work()?;
    let mut seconds = vec![started.elapsed().as_secs_f64()];
    let peak_bytes = process_bytes("VmHWM:").map_or(f64::NAN, |bytes| bytes as f64);
    // Most runs of the same work, of which the median counts.
    while seconds.len() < 3 && seconds[0] <= cheap {
        drop(value);
        let started = Instant::now();
        value = work()?;
        seconds.push(started.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let cost = Cost {
        seconds: seconds[seconds.len() / 2],
        repeats: seconds.len(),
        peak_bytes,
    };
    Ok((value, cost))
}

/// Makes the kernel forget the largest resident memory so far; see proc(5), `clear_refs`.
fn forget_peak() {
    // Where it is not allowed the peak is that of the whole process: never too small.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Bytes that Linux says of this process in a line such as `VmHWM:`, the largest resident memory since it was forgotten; see proc(5).
#[must_use]
pub fn process_bytes(line: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let found = status.lines().find_map(|all| all.strip_prefix(line))?;
    let kibibytes: u64 = found.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// What the studies mean for someone who has the scene's mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice<'a> {
    /// The scene's mesh.
    pub mesh: &'a Level,
    /// The relative discretisation error in the energy norm, extrapolated; where no order is
    /// observed, the difference to the finest mesh, which it exceeds.
    pub discretisation_error: Option<f64>,
    /// The loosest ε from which on every method's algebraic error stays below a tenth of the
    /// discretisation error.
    pub sufficient_epsilon: Option<f64>,
    /// The next mesh.
    pub finer: Option<&'a Level>,
    /// Whether the elements are linear and the error is large enough for quadratic ones to pay.
    pub wants_quadratic: bool,
}

impl<'a> Advice<'a> {
    /// Reads the advice off both studies.
    #[must_use]
    pub fn new(accuracy: &'a Accuracy, element: ElementOrder) -> Self {
        let study = &accuracy.discretisation;
        let mesh = &study.levels[study.scene_level];
        let finer = study.levels.get(study.scene_level + 1);
        let at_least = finer.map(|_| mesh.energy_difference);
        let at_least = at_least.filter(|error| !error.is_nan());
        let error = mesh.energy_error.or(at_least);
        let judged = accuracy.algebraic.as_ref().zip(error);
        Self {
            mesh,
            discretisation_error: error,
            // An algebraic error of this share of the discretisation error is too small to matter: errors add
            // as squares, so it changes the whole by half a per cent.
            sufficient_epsilon: judged
                .and_then(|(study, error)| sufficient_epsilon(study, 0.1 * error)),
            finer,
            // On cells twice as wide, and with fewer unknowns, quadratic elements had 1.2 to 3.2 times smaller errors in 50 of 50 cases of 25 scenes.
            wants_quadratic: element == ElementOrder::P1 && error.is_some_and(|error| error > 0.1),
        }
    }
}

/// The loosest ε from which on every solve that ran has an energy error of at most `bound`.
fn sufficient_epsilon(study: &AlgebraicStudy, bound: f64) -> Option<f64> {
    let good = |epsilon: f64| {
        let entries = study.entries.iter();
        let results = entries.filter(|entry| entry.epsilon == epsilon);
        let results = results.filter_map(|entry| entry.result);
        let mut solved = results.filter(|result| result.status.is_solved());
        let good = |result: RunResult| result.energy_error <= bound;
        solved.next().is_some_and(good) && solved.all(good)
    };
    let strict_first = EPSILONS.into_iter().rev();
    strict_first.take_while(|&epsilon| good(epsilon)).last()
}

impl fmt::Display for Advice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mesh = self.mesh;
        write!(
            f,
            "At this mesh ({}) the discretisation error is ",
            mesh.name()
        )?;
        match self.discretisation_error {
            None if mesh.estimated_error.is_nan() => f.write_str("not known")?,
            None => write!(
                f,
                "about {:.1} % by the estimate alone, for no other mesh was solved",
                100.0 * mesh.estimated_error
            )?,
            Some(error) => {
                let percent = 100.0 * error;
                // Two digits are what an extrapolation tells.
                let digits = (1.0 - percent.log10().floor()).clamp(0.0, 9.0);
                let unit = 10_f64.powf(-digits);
                let (least, told) = match mesh.energy_error {
                    Some(_) => ("", percent),
                    // A bound claims no more than it is.
                    None => ("at least ", (percent / unit).floor() * unit),
                };
                write!(f, "{least}{told:.*} % in the energy norm", digits as usize)?;
            }
        }
        if let Some(epsilon) = self.sufficient_epsilon {
            write!(f, "; epsilon below {epsilon:.0e} buys nothing")?;
        }
        if let Some(finer) = self.finer {
            let times = finer.cost.seconds / mesh.cost.seconds;
            let name = finer.name();
            write!(f, "; refining to {name} costs {times:.1} times the time")?;
            if let (Some(here), Some(there)) = (mesh.energy_error, finer.energy_error) {
                write!(f, " and divides the error by {:.1}", here / there)?;
            }
        }
        f.write_str(".")?;
        if self.wants_quadratic {
            f.write_str(" body.element = \"P2\" reaches the same error with fewer unknowns.")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dear_work_runs_once_and_cheap_work_three_times() {
        let mut runs = 0;
        let mut count = |cheap: f64| {
            measure(cheap, || {
                runs += 1;
                Ok::<_, ()>(runs)
            })
        };
        let (last, cost) = count(60.0).unwrap();
        assert_eq!((last, cost.repeats), (3, 3));
        let (last, cost) = count(-1.0).unwrap();
        assert_eq!((last, cost.repeats), (4, 1));
    }

    #[test]
    fn bounds_are_rounded_down_and_errors_to_the_nearest() {
        let told = |error: f64, energy_error: Option<f64>| {
            let mesh = Level {
                energy_error,
                ..Level::default()
            };
            let advice = Advice {
                mesh: &mesh,
                discretisation_error: Some(error),
                sufficient_epsilon: None,
                finer: None,
                wants_quadratic: false,
            };
            advice.to_string()
        };
        assert!(told(0.248, None).contains("at least 24 %"));
        assert!(told(0.0796, None).contains("at least 7.9 %"));
        assert!(told(0.248, Some(0.248)).contains("is 25 %"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_sees_memory_that_was_used_and_given_back() {
        let bytes = 64_000_000;
        let (sum, cost) = measure(-1.0, || {
            let touched = vec![1_u8; bytes];
            Ok::<_, ()>(touched.iter().map(|&b| usize::from(b)).sum::<usize>())
        })
        .unwrap();
        assert_eq!(sum, bytes);
        assert!(cost.peak_bytes >= bytes as f64);
    }
}
