//! Sweeps with more cases than any folder holds are refused before anything is made.

use std::{fs, path::Path};

use contact3d_pipe::MOST_CASES;

use crate::program::Sweep;

/// Refusals for a sweep, as text.
fn refused(sweep: &str) -> String {
    let sweep = Sweep::new(sweep);
    let (code, text) = sweep.run("out", &[]);
    assert_eq!(code, 2, "{text}");
    assert!(!sweep.path("out").exists(), "nothing on disk changed");
    text
}

/// The axes of a file in `tests/cases`.
fn axes(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let text = fs::read_to_string(path.join(name)).unwrap();
    let (first, axes) = text.split_once('\n').unwrap();
    assert!(first.starts_with("scene"), "{first}");
    axes.to_owned()
}

#[test]
fn one_axis_of_1e18_values_is_refused() {
    let text = refused(&axes("huge18.toml"));
    for words in ["axis 0", "at most 100000 cases", "1000000000000000000"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn three_axes_of_1e5_values_are_refused_together() {
    let text = refused(&axes("huge3.toml"));
    for words in ["at most 100000 cases", "100000 x 100000 x 100000"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// Four axes of 2^16 values have 2^64 cases, which wrap to none in a machine word.
#[test]
fn a_number_of_cases_that_overflows_is_refused() {
    let axis = |component: usize| {
        format!(
            "[[axis]]\nkey = \"body_force.value.{component}\"\nrange = {{ from = 1.0, to = 2.0, count = 65536 }}\n"
        )
    };
    let text = refused(&(0..4).map(axis).collect::<String>());
    assert!(text.contains("65536 x 65536 x 65536 x 65536"), "{text}");
}

/// Zipped axes advance together, so theirs count once: the largest sweep that is planned is not
/// refused for its size.
#[test]
fn zipped_axes_count_once() {
    let count = MOST_CASES + 1;
    let axis = |key: &str, count: usize| {
        format!(
            "[[axis]]\nkey = \"{key}\"\nzip = \"a\"\nrange = {{ from = 1.0, to = 2.0, count = {count} }}\n"
        )
    };
    let pair = |count| axis("traction.0.value.0", count) + &axis("traction.0.value.1", count);
    assert!(refused(&pair(count)).contains("at most 100000 cases"));
    let sweep = Sweep::new(&pair(400));
    assert_eq!(sweep.plan().len(), 400);
}
