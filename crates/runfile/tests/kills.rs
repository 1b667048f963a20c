//! A process that is killed while it writes leaves a readable file.
//!
//! A program of its own: a child process holds the locks of its parent until it runs its own program, so tests of locks
//! cannot run beside it.

#[expect(dead_code, reason = "the sample serves the other tests too")]
#[path = "file/sample.rs"]
mod sample;

use std::env;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use contact3d_runfile::install_signal_handlers;
use sample::*;

/// Names the file for the child process.
const FILE: &str = "STORE_TEST_FILE";

/// A grid in the run file and a field beside it, in one step.
fn save_both(file: &Path, n_nodes: usize) {
    change(file, |transaction| {
        let writer = transaction.group(GRID).unwrap();
        write_grid(writer, n_nodes).unwrap();
        transaction.keep_beside(FIELD);
        let writer = transaction.group(FIELD).unwrap();
        write_field(writer, n_nodes, &[0.5]).unwrap();
    });
}

/// Run as a child process only: replaces both groups until it is killed.
#[test]
#[ignore = "the body of the child process of the other tests"]
fn child_that_writes_until_killed() {
    let Some(file) = env::var_os(FILE) else {
        return;
    };
    install_signal_handlers(|| ()).unwrap();
    for round in 0.. {
        save_both(file.as_ref(), SIZES[round % 2]);
    }
}

/// Numbers of nodes of the states that follow each other.
const SIZES: [usize; 2] = [20_000, 20_001];

fn child(file: &Path) -> Child {
    let name = "child_that_writes_until_killed";
    Command::new(env::current_exe().unwrap())
        .args(["--ignored", "--exact", name])
        .env(FILE, file)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

/// Sends a signal at different moments of the writing and checks what is left.
fn survives(signal: &str, number: i32) {
    use std::os::unix::process::ExitStatusExt;
    let (folder, file) = folder();
    save_both(&file, SIZES[1]);
    for round in 0..8 {
        let mut child = child(&file);
        while hidden(folder.path()).is_empty() {
            assert!(
                child.try_wait().unwrap().is_none(),
                "the child ended by itself"
            );
            thread::yield_now();
        }
        thread::sleep(Duration::from_millis(round));
        let kill = Command::new("sh")
            .args(["-c", &format!("kill -{signal} {}", child.id())])
            .status()
            .unwrap();
        assert!(kill.success());
        assert_eq!(
            child.wait().unwrap().signal(),
            Some(number),
            "the signal itself ends the process"
        );
        let reader = open(&file).unwrap();
        reader.require_group(GRID).unwrap();
        reader.require_group(FIELD).unwrap();
        let n_nodes = stiffness_in(&file).shape[0];
        assert!(SIZES.contains(&n_nodes));
        assert_eq!(coordinates_in(&file), coordinates(n_nodes));
        for temporary in hidden(folder.path()) {
            let _ = fs::remove_file(temporary);
        }
    }
    save_both(&file, 5);
    let left = fs::read_dir(folder.path()).unwrap();
    let left = left.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let left: Vec<_> = left.filter(|name| !name.starts_with("field-")).collect();
    // The run file and its lock.
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn kill_leaves_the_previous_state() {
    survives("KILL", 9);
}

#[test]
fn terminate_leaves_the_previous_state() {
    survives("TERM", 15);
}

#[test]
fn interrupt_leaves_the_previous_state() {
    survives("INT", 2);
}
