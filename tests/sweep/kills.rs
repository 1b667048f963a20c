//! Sweeps killed at random moments.

use std::{
    thread::sleep,
    time::{Duration, Instant},
};

use crate::program::{FRICTION, SLOW, Sweep, names};
/// Numbers with no pattern that matters, the same in every run of the test.
struct Lottery(u64);

impl Lottery {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }
}

/// Kills a sweep at random moments until it has ended by itself, and compares with an undisturbed one.
///
/// Returns the number of kills and how many of them left a checkpoint.
fn survives_kills(text: &str, least_kills: usize) -> [usize; 2] {
    let sweep = Sweep::new(text);
    let started = Instant::now();
    let (code, said) = sweep.run("whole", &[]);
    assert_eq!(code, 0, "{said}");
    let whole = started.elapsed();
    let mut lottery = Lottery(0x9e37_79b9_7f4a_7c15);
    let mut kills = 0;
    let mut checkpoints = 0;
    let mut rounds = 0;
    while kills < least_kills {
        rounds += 1;
        let out = format!("killed{rounds}");
        loop {
            let mut child = sweep
                .command(&["sweep.toml", "--out", &out])
                .spawn()
                .unwrap();
            // Up to half of the time that the whole takes: every round is killed some times.
            sleep(Duration::from_micros(
                lottery.below(whole.as_micros() as u64 / 2),
            ));
            if child.try_wait().unwrap().is_some() {
                break;
            }
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
            checkpoints += usize::from(sweep.has_checkpoint(&out));
        }
        let (code, said) = sweep.run(&out, &[]);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("0 computed"), "{said}");
        assert_eq!(
            sweep.digests(&out),
            sweep.digests("whole"),
            "round {rounds}, {kills} kills"
        );
        assert!(names(&sweep.path(&out), ".part").is_empty());
    }
    [kills, checkpoints]
}

/// Ten kills, or as many as the environment variable says.
fn kills_wanted() -> usize {
    let wanted = std::env::var("SWEEP_KILLS").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(10)
}

#[test]
fn a_killed_sweep_goes_on_to_the_same_bits() {
    let [kills, _] = survives_kills(FRICTION, kills_wanted());
    eprintln!("{kills} kills, no differing digest");
}

#[test]
fn a_killed_solve_goes_on_from_its_checkpoint_to_the_same_bits() {
    let [kills, checkpoints] = survives_kills(SLOW, kills_wanted());
    eprintln!("{kills} kills, {checkpoints} left a checkpoint, no differing digest");
    assert!(checkpoints > 0, "no kill met a solve under way");
}
