//! What is said of keys that are unknown, missing or of another type.

use contact3d::scene::{Scene, SceneError, SyntaxProblem};

/// Why a scene cannot be read in which one text stands for another.
fn refused(old: &str, new: &str) -> SyntaxProblem {
    let text = r#"
        title = "block"
        clamp = [{ face = "x_min" }]
        body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
        material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }
        region = [{ part.group = "core", material.isotropic = { young_modulus = 2.0, poisson_ratio = 0.3 } }]
        contact = { face = "z_min", multipliers = "nodal" }
        friction.coefficient.constant = 0.3
    "#;
    assert!(text.contains(old), "{old}");
    match Scene::parse("block", &text.replacen(old, new, 1)) {
        Err(SceneError::Syntax { problem, .. }) => *problem,
        other => panic!("{new}: {other:?}"),
    }
}

#[test]
fn types_have_the_names_of_scenes() {
    for (old, new, expected) in [
        (
            "young_modulus = 1.0",
            "young_modulus = \"a\"",
            "expected a number, found string \"a\"",
        ),
        (
            "title = \"block\"",
            "title = 3",
            "title: expected a string, found integer `3`",
        ),
        (
            "cells = [2, 2, 2]",
            "cells = [0.5, 2, 2]",
            "expected a whole number from 0 on, found number `0.5`",
        ),
        (
            "cells = [2, 2, 2]",
            "cells = [1e20, 2, 2]",
            "expected a whole number from 0 on, found number `1e20`",
        ),
        (
            "cells = [2, 2, 2]",
            "cells = [-1, 2, 2]",
            "expected a whole number from 0 on, found integer `-1`",
        ),
        (
            "{ size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }",
            "[]",
            "expected a table, found a list",
        ),
        (
            "size = [1.0, 1.0, 1.0]",
            "size = [1.0, 1.0]",
            "expected 3 values, found 2",
        ),
        (
            "size = [1.0, 1.0, 1.0]",
            "size = 3.0",
            "expected a list of 3 values, found number `3.0`",
        ),
        ("size = [1.0, 1.0, 1.0], ", "", "missing key `size`"),
    ] {
        let found = refused(old, new).message;
        assert!(found.ends_with(expected), "{found}");
    }
}

#[test]
fn mistyped_words_bring_the_nearest_one() {
    let key = refused("young_modulus", "young_modul");
    assert!(key.help.contains("did you mean `young_modulus`?"));
    let word = refused("\"nodal\"", "\"nodl\"");
    assert!(word.help.contains("did you mean `nodal`?"));
    for (old, new) in [
        ("multipliers = \"nodal\"", "weight = 1.0"),
        ("size = [1.0, 1.0, 1.0], ", ""),
    ] {
        let other = refused(old, new);
        assert!(!other.help.contains("did you mean"), "{}", other.help);
    }
}

#[test]
fn every_kind_is_named() {
    for (table, other, none) in [
        (
            "material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }",
            "material.other = 0",
            "material = {}",
        ),
        ("part.group = \"core\"", "part.other = 0", "part = {}"),
        (
            "friction.coefficient.constant = 0.3",
            "friction.coefficient.other = 0",
            "friction.coefficient = {}",
        ),
    ] {
        let unknown = refused(table, other).message;
        let marked: Vec<&str> = unknown.split('`').skip(3).step_by(2).collect();
        let listed = refused(table, none).message;
        let kinds = listed
            .split_once("expected exactly one of ")
            .expect("kinds");
        let (kinds, _) = kinds.1.split_once("; found none").expect("none");
        assert_eq!(marked.join(", "), kinds, "{unknown}");
    }
}
