//! A study of accuracy of format 1.9, whose groups `rungs` and `ways` are `solves` and `sequences` today.

use contact3d_pipe::{LAYOUT, read_accuracy};
use runfile::Reader;

use super::program::Scratch;

const FILE: &str = "accuracy_1.9.h5";

/// 5 series of 11 tolerances, one mesh of the brick, and 6 sequences of meshes with their reference.
#[test]
fn former_names_are_read() {
    let scratch = Scratch::with(&[FILE]);
    let reader = Reader::open(&scratch.path(FILE), LAYOUT).expect("a run file");
    let accuracy = read_accuracy(&reader).expect("a study");
    let solves = accuracy.algebraic.expect("contact").entries;
    assert_eq!(solves.len(), 55);
    let applications = |k: usize| solves[k].result.expect("a solve").applications;
    assert_eq!([0, 10, 54].map(applications), [37, 179, 408]);
    let levels = accuracy.discretisation.expect("a brick").levels;
    assert_eq!(levels[0].applications, 49);
    let sequences = accuracy.sequences.expect("asked for");
    let last = sequences.sequences.last().expect("six kinds");
    assert_eq!(last.levels[0].n_free, 16_308);
    assert_eq!(sequences.reference.level.n_multipliers, 324);
    let forces = sequences.reference.forces.expect("contact");
    assert!(forces.normal > 5e7 && sequences.reference.potential_energy < -7.8e3);
}

#[test]
fn its_page_is_made_and_a_new_study_has_today_s_names() {
    let scratch = Scratch::with(&[FILE, "scenes", "table1.toml"]);
    scratch.done(&["check", FILE]);
    scratch.done(&["report", FILE, "-o", "page.html"]);
    let page = std::fs::read_to_string(scratch.path("page.html")).expect("a page");
    assert!(page.contains("Sequences of meshes") && page.contains("P2 graded, adaptive"));
    let small = ["--set", "body.brick.cells=[6,2,2]", "--coarsest", "2"];
    let budget = ["--finest", "2", "--budget", "0.01", "--no-figures"];
    let study = ["accuracy", "table1.toml", FILE];
    scratch.done(&[&study[..], &small, &budget].concat());
    scratch.done(&["check", FILE]);
    let file = hdf5_metno::File::open(scratch.path(FILE)).expect("HDF5");
    let names = file
        .group("accuracy")
        .and_then(|group| group.member_names());
    let names = names.expect("a group");
    assert!(names.contains(&"solves".to_owned()) && names.contains(&"n_solves".to_owned()));
    assert!(!names.contains(&"rungs".to_owned()) && !names.contains(&"ways".to_owned()));
}
