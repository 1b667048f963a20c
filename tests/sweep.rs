//! Sweeps: shared work, resumed after kills, failed cases, changed axes.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use assert_cmd::cargo::CommandCargoExt;
use contact3d_pipe::{
    format::{LAYOUT, SWEEP_LAYOUT},
    store::{Layout, Reader, Stage},
};
use tempfile::TempDir;

/// A folder with a scene and a sweep over it.
struct Sweep {
    folder: TempDir,
}

impl Sweep {
    fn new(sweep: &str) -> Self {
        let folder = TempDir::new().expect("scratch folder");
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/newton.toml");
        fs::copy(scene, folder.path().join("scene.toml")).expect("a scene");
        let this = Self { folder };
        this.write(sweep);
        this
    }

    /// Replaces the sweep file.
    fn write(&self, sweep: &str) {
        let text = format!("scene = \"scene.toml\"\n{sweep}");
        fs::write(self.path("sweep.toml"), text).expect("a sweep file");
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("contact3d-pipe").expect("built program");
        command
            .current_dir(self.folder.path())
            .arg("sweep")
            .args(arguments)
            .stderr(Stdio::piped())
            .stdout(Stdio::piped());
        command
    }

    /// Runs the sweep to a folder and returns its exit code and what it said.
    fn run(&self, out: &str, more: &[&str]) -> (i32, String) {
        let mut arguments = vec!["sweep.toml", "--out", out];
        arguments.extend(more);
        let output = self.command(&arguments).output().expect("a process");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code().expect("an exit code"), text)
    }

    fn plan(&self) -> Vec<serde_json::Value> {
        let output = self.command(&["plan", "sweep.toml", "--out", "x"]).output();
        let output = output.expect("a process");
        serde_json::from_slice(&output.stdout).expect("JSON")
    }

    /// Whether a run file holds a half-done solve.
    fn has_checkpoint(&self, out: &str) -> bool {
        let folder = self.path(out);
        let files = if folder.exists() {
            names(&folder, ".h5")
        } else {
            Vec::new()
        };
        files.iter().any(|name| {
            let reader = Reader::open(&folder.join(name), LAYOUT);
            reader.is_ok_and(|r| matches!(r.stage_record(Stage::Checkpoint), Ok(Some(_))))
        })
    }

    /// The digest of every stage of every run file, and of the table.
    fn digests(&self, out: &str) -> BTreeMap<String, Vec<String>> {
        let mut digests = BTreeMap::new();
        for name in names(&self.path(out), ".h5") {
            if !name.contains('-') {
                let layout = if name == "summary.h5" {
                    SWEEP_LAYOUT
                } else {
                    LAYOUT
                };
                let file = self.path(out).join(&name);
                digests.insert(name, stage_digests(&file, layout));
            }
        }
        digests
    }
}

/// Digests of all stages, each checked against the digests of its datasets.
fn stage_digests(file: &Path, layout: Layout) -> Vec<String> {
    let reader = Reader::open(file, layout).expect("a whole file");
    let stages = Stage::ALL.into_iter();
    let held = stages.filter(|s| matches!(reader.stage_record(*s), Ok(Some(_))));
    held.map(|stage| {
        let stored = reader.check_stage(stage).expect("a sound stage");
        format!("{stage} {}", stored.digest)
    })
    .collect()
}

fn names(folder: &Path, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(ending)).collect()
}

/// Two laws (one needs the contact compliance), two loads, three coefficients; small meshes.
const FRICTION: &str = r#"
[set]
"body.brick.cells" = [12, 4, 4]
[[axis]]
key = "friction.coefficient_2"
values = [{ constant = 0.3 }, { ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 1000.0 } }]
[[axis]]
key = "traction.0.value"
values = [[1e7, 0.0, 2e7], [9e6, 3e6, 2e7]]
[[axis]]
key = "friction.coefficient_1"
values = [{ constant = 0.1 }, { constant = 0.3 }, { constant = 0.9 }]
"#;

/// Successive approximations with KPRGP to many digits: solves that last long enough to be killed.
const SLOW: &str = r#"
[set]
"body.brick.cells" = [12, 4, 4]
"solve.method" = "fixed-point"
"solve.epsilon" = 1e-9
"solve.precision" = "fixed"
[[axis]]
key = "assemble.dual_operator"
values = ["implicit", "explicit"]
[[axis]]
key = "friction.coefficient_1.ramp.residual"
values = [0.1, 0.2]
"#;

#[test]
fn cases_share_the_files_of_mesh_and_factor() {
    let sweep = Sweep::new(FRICTION);
    let (code, text) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{text}");
    let out = sweep.path("out");
    let shared = |stage: &str| {
        names(&out, ".h5")
            .iter()
            .filter(|n| n.starts_with(stage))
            .count()
    };
    assert_eq!((shared("mesh-"), shared("assemble-")), (1, 2));
    assert_eq!(names(&out, ".h5").len(), 12 + 3 + 1);
    let table = fs::read_to_string(out.join("summary.csv")).unwrap();
    assert_eq!(table.lines().count(), 13);
    assert_eq!(table.matches(",converged,").count(), 12);
    // The same case alone, without sharing, has the same solution and report.
    let plan = sweep.plan();
    for case in [&plan[4], &plan[11]] {
        let mut run = Command::cargo_bin("contact3d-pipe").unwrap();
        run.current_dir(sweep.path("")).args([
            "run",
            "scene.toml",
            "alone.h5",
            "--quiet",
            "--no-figures",
        ]);
        run.args(["--set", "body.brick.cells=[12,4,4]"]);
        for (key, value) in case["settings"].as_object().unwrap() {
            let value: toml::Value = serde_json::from_value(value.clone()).unwrap();
            run.args(["--set", &format!("{key}={value}")]);
        }
        assert!(run.status().unwrap().success());
        let file = out.join(format!("{}.h5", case["id"].as_str().unwrap()));
        assert_eq!(
            stage_digests(&file, LAYOUT),
            stage_digests(&sweep.path("alone.h5"), LAYOUT)
        );
    }
}

#[test]
fn number_of_jobs_and_self_containedness_change_no_digest() {
    let warm = format!("warm_start = true\n{FRICTION}");
    for text in [FRICTION, &warm] {
        let sweep = Sweep::new(text);
        assert_eq!(sweep.run("one", &["--jobs", "1", "--threads", "1"]).0, 0);
        assert_eq!(
            sweep.run("three", &["--jobs", "3", "--memory", "1e-9"]).0,
            0
        );
        assert_eq!(sweep.run("whole", &["--self-contained"]).0, 0);
        assert_eq!(sweep.digests("one"), sweep.digests("three"));
        assert_eq!(sweep.digests("one"), sweep.digests("whole"));
        let reader = |out: &str| {
            let name = format!("{}.h5", sweep.plan()[0]["id"].as_str().unwrap());
            Reader::open(&sweep.path(out).join(name), LAYOUT).unwrap()
        };
        assert!(reader("one").linked_file(Stage::Assemble).is_some());
        assert!(reader("whole").linked_file(Stage::Assemble).is_none());
    }
}

#[test]
fn warm_starts_need_fewer_steps_and_agree_with_cold_ones() {
    let text = r#"
[set]
"body.brick.cells" = [12, 4, 4]
"solve.method" = "fixed-point"
"solve.epsilon" = 1e-7
"solve.precision" = "fixed"
[[axis]]
key = "friction.coefficient_1.ramp.residual"
values = [0.2, 0.201, 0.202, 0.203]
"#;
    let results = |text: &str| {
        let sweep = Sweep::new(text);
        assert_eq!(sweep.run("out", &[]).0, 0);
        let reader = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
        let actions: i64 = reader
            .read_vec::<i64>("/cases/actions")
            .unwrap()
            .iter()
            .sum();
        (
            actions,
            reader.read_vec::<f64>("/cases/normal_force").unwrap(),
        )
    };
    let (cold, cold_force) = results(text);
    let (warm, warm_force) = results(&format!("warm_start = true\n{text}"));
    assert!(warm < cold, "{warm} actions instead of {cold}");
    for (a, b) in warm_force.iter().zip(&cold_force) {
        // ε = 1e-7 for both, times the contraction of the outer loop and the condition of S.
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
}

#[test]
fn failed_cases_are_recorded_and_tried_again_only_on_demand() {
    let text = "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"body_force\"\nvalues = \
                [{ value = [0.0, 0.0, 0.0] }, { value = [\"1/(x-x)\", 0.0, 0.0] }, { value = [1.0, 0.0, 0.0] }]";
    let sweep = Sweep::new(text);
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("2 computed, 0 kept, 1 failed"), "{said}");
    let table = fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    assert!(
        table.contains("failed") && table.contains("finite"),
        "{table}"
    );
    let stamp = |id: &str| {
        fs::metadata(sweep.path(&format!("out/{id}.error.txt")))
            .unwrap()
            .modified()
            .unwrap()
    };
    let failed = sweep.plan()[1]["id"].as_str().unwrap().to_owned();
    let first = stamp(&failed);
    let (_, said) = sweep.run("out", &[]);
    assert!(said.contains("0 computed, 2 kept, 1 failed"), "{said}");
    assert_eq!(stamp(&failed), first);
    let (_, said) = sweep.run("out", &["--retry-failed"]);
    assert!(said.contains("0 computed, 2 kept, 1 failed"), "{said}");
    assert!(stamp(&failed) > first);
}

#[test]
fn changed_axes_add_cases_and_keep_old_ones() {
    let axis = |values: &str| {
        format!(
            "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"friction.coefficient_1\"\nvalues = [{values}]"
        )
    };
    let sweep = Sweep::new(&axis("{ constant = 0.1 }, { constant = 0.2 }"));
    assert_eq!(sweep.run("out", &[]).0, 0);
    let before = sweep.digests("out");
    sweep.write(&axis("{ constant = 0.2 }, { constant = 0.3 }"));
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("1 computed, 1 kept"), "{said}");
    let after = sweep.digests("out");
    for (name, digests) in before.iter().filter(|(name, _)| *name != "summary.h5") {
        assert_eq!(after.get(name), Some(digests), "{name}");
    }
    let reader = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
    assert_eq!(reader.read_vec::<u8>("/cases/planned").unwrap(), [1, 1, 0]);
}

#[test]
fn single_cases_give_the_files_of_the_whole_sweep() {
    let text = format!("warm_start = true\n{FRICTION}");
    let sweep = Sweep::new(&text);
    assert_eq!(sweep.run("whole", &[]).0, 0);
    for case in sweep.plan().iter().rev() {
        let id = case["id"].as_str().unwrap();
        let run = sweep
            .command(&["run-case", "sweep.toml", "--out", "parts", id])
            .output()
            .unwrap();
        assert!(run.status.success(), "{run:?}");
    }
    let summary = sweep
        .command(&["summary", "sweep.toml", "--out", "parts"])
        .output()
        .unwrap();
    assert!(summary.status.success());
    assert_eq!(sweep.digests("parts"), sweep.digests("whole"));
    let unknown = sweep
        .command(&["run-case", "sweep.toml", "--out", "parts", "0123"])
        .output()
        .unwrap();
    assert_eq!(unknown.status.code(), Some(2));
}

#[test]
fn a_case_is_redone_when_the_one_it_started_from_has_changed() {
    let text = format!("warm_start = true\n{FRICTION}");
    let sweep = Sweep::new(&text);
    assert_eq!(sweep.run("whole", &[]).0, 0);
    let plan = sweep.plan();
    let file = |case: &serde_json::Value| {
        let id = case["id"].as_str().unwrap();
        sweep.path("out").join(format!("{id}.h5"))
    };
    // A folder in the place of a run file makes its case fail; the next one starts from zero then.
    fs::create_dir_all(file(&plan[0])).unwrap();
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    fs::remove_dir(file(&plan[0])).unwrap();
    let (code, said) = sweep.run("out", &["--retry-failed"]);
    assert_eq!(code, 0, "{said}");
    let redone = plan.iter().take(2).collect::<Vec<_>>();
    assert_eq!(redone[1]["start"], redone[0]["id"]);
    assert_eq!(sweep.digests("out"), sweep.digests("whole"), "{said}");
    assert!(sweep.run("out", &[]).1.contains("0 computed"));
}

#[test]
fn an_altered_shared_file_is_made_again() {
    let sweep = Sweep::new(FRICTION);
    assert_eq!(sweep.run("out", &[]).0, 0);
    let before = sweep.digests("out");
    let out = sweep.path("out");
    let assembled = |name: &String| name.starts_with("assemble-");
    let shared = names(&out, ".h5").into_iter().find(assembled).unwrap();
    let mut bytes = fs::read(out.join(&shared)).unwrap();
    // The factor's values are most of the file, uncompressed.
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(out.join(&shared), bytes).unwrap();
    for case in sweep.plan() {
        fs::remove_file(out.join(format!("{}.h5", case["id"].as_str().unwrap()))).unwrap();
    }
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(sweep.digests("out"), before);
}

#[test]
fn unusable_sweeps_are_refused_before_anything_is_run() {
    for (text, word) in [
        (
            "[[axis]]\nkey = \"solve.epsilon\"\nvalues = [1e-6, 1e-6]",
            "equal",
        ),
        (
            "[[axis]]\nkey = \"solve.epsilon\"\nvalues = [-1.0]",
            "epsilon",
        ),
        (
            "[[axis]]\nkey = \"solve.epsilom\"\nvalues = [1e-6]",
            "epsilom",
        ),
        (
            "[[axis]]\nkey = \"traction.7.value\"\nvalues = [1.0]",
            "no item 7",
        ),
        ("axes = 3", "axes"),
    ] {
        let sweep = Sweep::new(text);
        let (code, said) = sweep.run("out", &[]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(word), "{said}");
        assert!(!sweep.path("out").exists());
    }
}

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
