//! Sweeps killed at random moments.

use std::{
    process::Command,
    thread::sleep,
    time::{Duration, Instant},
};

use contact3d_pipe::SWEEP_LAYOUT;
use runfile::Reader;

use crate::program::{FRICTION, SLOW, STEPPED, Sweep, names};

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

/// Kills a sweep at random moments, until it has ended by itself or was killed often enough, lets it end and compares
/// with an undisturbed one.
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
        let ended = loop {
            let mut child = sweep.command(&["sweep.toml", &out]).spawn().unwrap();
            // Up to half of the time that the whole takes: every round is killed some times.
            sleep(Duration::from_micros(
                lottery.below(whole.as_micros() as u64 / 2),
            ));
            if child.try_wait().unwrap().is_some() {
                break true;
            }
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
            checkpoints += usize::from(sweep.has_checkpoint(&out));
            if kills >= least_kills {
                break false;
            }
        };
        let (code, said) = sweep.run(&out, &[]);
        assert_eq!(code, 0, "{said}");
        assert!(!ended || said.contains("0 computed"), "{said}");
        assert_eq!(
            sweep.digests(&out),
            sweep.digests("whole"),
            "round {rounds}, {kills} kills"
        );
        let left = names(&sweep.path(&out), "");
        assert!(!left.iter().any(|name| name.contains(".part")), "{left:?}");
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
    // About half of the kills meet a solve that has a checkpoint.
    let [kills, checkpoints] = survives_kills(SLOW, 2 * kills_wanted());
    eprintln!("{kills} kills, {checkpoints} left a checkpoint, no differing digest");
    assert!(checkpoints > 0, "no kill met a solve under way");
}

/// Each case has a history of its own, and goes on after its last stored increment.
#[test]
#[ignore = "six seconds: increments are stored no earlier than after one"]
fn a_killed_sweep_of_histories_goes_on_to_the_same_bits() {
    let sweep = Sweep::new(STEPPED);
    let (code, said) = sweep.run("whole", &[]);
    assert_eq!(code, 0, "{said}");
    let mut child = sweep.command(&["sweep.toml", "killed"]).spawn();
    let child = child.as_mut().expect("a process");
    while !sweep.has_checkpoint("killed") {
        assert!(
            child.try_wait().expect("a child").is_none(),
            "ended before it was killed"
        );
        sleep(Duration::from_millis(5));
    }
    child.kill().expect("a child");
    child.wait().expect("a child");
    let (code, said) = sweep.run("killed", &[]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(sweep.digests("killed"), sweep.digests("whole"));
}

/// Forty cases of about a tenth of a second.
const FORTY: &str = "[set]\n\"body.brick.cells\" = [24, 8, 8]\n[[axis]]\nkey = \"traction.0.value.0\"\n\
                     range = { from = 1e6, to = 1e7, count = 40 }\n";

/// Killed as soon as its table has a finished case, which the end of the sweep alone would have had to write before.
#[test]
fn a_killed_sweep_shows_the_cases_that_are_done() {
    let sweep = Sweep::new(FORTY);
    let mut child = sweep.command(&["sweep.toml", "out"]).spawn().unwrap();
    let done = || {
        let table = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT);
        let statuses = table.and_then(|it| it.read_texts("/cases/status"));
        let statuses = statuses.unwrap_or_default().into_iter();
        statuses.filter(|status| status == "converged").count()
    };
    while done() == 0 {
        let ended = child.try_wait().unwrap();
        assert!(ended.is_none(), "it ended before its table had a case");
        sleep(Duration::from_millis(5));
    }
    let at_work = sweep.said(&["status", "out"]);
    assert!(at_work.contains("a sweep is at work"), "{at_work}");
    child.kill().unwrap();
    child.wait().unwrap();
    let shown = done();
    let counts = |shown: usize| format!("40 cases: {shown} converged, {} missing", 40 - shown);
    let status = sweep.said(&["status", "out"]);
    assert!(status.contains(&counts(shown)), "{status}");
    assert!(status.contains("no sweep is at work"), "{status}");
    sweep.said(&["report", "out", "page.html"]);
    let page = std::fs::read_to_string(sweep.path("page.html")).unwrap();
    assert!(page.contains(&counts(shown)));
    sweep.said(&["sweep", "summary", "sweep.toml", "out"]);
    assert!((shown..40).contains(&done()), "{shown}, {}", done());
}

/// Interrupted once the first case has a file.
#[test]
fn an_interrupted_sweep_says_how_many_cases_it_keeps() {
    let sweep = Sweep::new(FORTY);
    let child = sweep.command(&["sweep.toml", "out"]).spawn();
    let child = child.unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let first = sweep.path(&format!("out/{}", sweep.plan()[0]["id"].as_str().unwrap()));
    while !first.with_extension("h5").exists() {
        assert!(Instant::now() < deadline, "no case was done in a minute");
        sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), None, "ended by the signal");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("interrupted: out keeps all cases that ended ("),
        "{said}"
    );
    assert!(said.contains("of 40 in this run)"), "{said}");
}
