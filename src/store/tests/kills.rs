//! A process that is killed while it writes leaves a readable file.

use std::env;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use super::sample::*;
use crate::store::{Stage, install_signal_handlers};

/// Names the file for the child process.
const FILE: &str = "STORE_TEST_FILE";

/// Run as a child process only: replaces the mesh until it is killed.
#[test]
#[ignore = "the body of the child process of the other tests"]
fn child_that_writes_until_killed() {
    let Some(file) = env::var_os(FILE) else {
        return;
    };
    install_signal_handlers().unwrap();
    loop {
        save_mesh(file.as_ref(), 20_000);
    }
}

fn child(file: &std::path::Path) -> Child {
    let name = "store::tests::kills::child_that_writes_until_killed";
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
    save_mesh(&file, 20_000);
    let temporary = folder.path().join(".run.h5.part");
    for round in 0..8 {
        let mut child = child(&file);
        while !temporary.exists() {
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
        reader.check_stage(Stage::Mesh).unwrap();
        assert_eq!(
            reader.read_vec::<f64>("/mesh/coordinates").unwrap(),
            coordinates(20_000)
        );
        let _ = fs::remove_file(&temporary);
    }
    save_mesh(&file, 5);
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
