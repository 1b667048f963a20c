//! Seconds and peak memory of a piece of work, by repeated runs.

use std::{fs, time::Instant};

/// Most runs of the same work, of which the median counts.
const REPEATS: usize = 3;

/// What a piece of work took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Median wall-clock seconds of the runs.
    pub seconds: f64,
    /// Number of runs.
    pub repeats: usize,
    /// Largest resident memory of the process during the first run in bytes, with what it held
    /// before; `None` where the system does not tell (it does on Linux).
    pub peak_bytes: Option<f64>,
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
    let peak_bytes = peak();
    while seconds.len() < REPEATS && seconds[0] <= cheap {
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

/// Largest resident memory of this process since [`forget_peak`] in bytes.
fn peak() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
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
        assert!(cost.peak_bytes.unwrap() >= bytes as f64);
    }
}
