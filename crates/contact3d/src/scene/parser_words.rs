//! What the TOML parser says, in the words of a scene.

use super::body::SHAPES;

/// What is wrong at a key, and what to do about it.
pub(super) struct ParserWords {
    /// The key; none in text that is not TOML.
    pub(super) key: Option<String>,
    pub(super) message: String,
    pub(super) help: String,
}

/// Tables that hold exactly one kind of several: the end of the key, the kinds, an example.
const CHOICES: [(&str, &[&str], &str); 5] = [
    (
        "material",
        &["isotropic", "orthotropic", "voigt"],
        "material.isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 }",
    ),
    (
        "part",
        &["group", "box"],
        "part.box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]",
    ),
    (
        "coefficient",
        &["constant", "ramp", "table", "grid", "expression"],
        "friction.coefficient.constant = 0.3",
    ),
    (
        "obstacle",
        &["half_space", "sphere", "cylinder", "height"],
        "contact.obstacle.sphere = { centre = [0.0, 0.0, -1.0], radius = 1.0 }",
    ),
    // Beside one of these a body may have `element`.
    ("body", SHAPES, "body.gmsh = { file = \"foot.msh\" }"),
];

/// Words that need a box beside them, as they are found without one, and how to write it.
const WITH_BOX: [(&str, &str); 2] = [
    (
        "\"mean_pressure\"",
        "of = { mean_pressure = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]] } }",
    ),
    (
        "\"mean_displacement\"",
        "of = { mean_displacement = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], component = \"z\" } }",
    ),
];

/// The words of the parser for types, and ours.
const TYPES: [(&str, &str); 11] = [
    ("a boolean", "true or false"),
    ("f64", "a number"),
    ("usize", "a whole number from 0 on"),
    ("u64", "a whole number from 0 on"),
    ("sequence", "a list"),
    ("map", "a table"),
    ("a map", "a table"),
    ("a sequence", "a list"),
    ("unit variant", "a word"),
    ("newtype variant", "a table"),
    ("floating point", "number"),
];

/// What a number that no scene can hold should be; `None` where something else is wrong.
#[must_use]
pub fn number_limit(error: &toml::de::Error) -> Option<String> {
    match error.message() {
        "floating-point number overflowed" => {
            Some(format!("numbers up to {:e}, the largest double", f64::MAX))
        }
        "integer number overflowed" => Some(format!("whole numbers up to {}", i64::MAX)),
        // A number that the parser knows and the format does not.
        wide if wide.starts_with("invalid type: integer") && wide.contains("128") => {
            Some(format!("whole numbers up to {}", i64::MAX))
        }
        _ => None,
    }
}

/// The parser's message about a key, which `page` lists with the others; `found_at` gives the keys of the table at a key, or the text
/// of another value.
pub(super) fn in_words(
    message: &str,
    key: Option<String>,
    page: &str,
    found_at: impl Fn(&str) -> Vec<String>,
) -> ParserWords {
    let choice = key.as_deref().and_then(choice);
    // What the parser says of something else in the place of a kind or a word.
    let is_no_word = ["wanted string or table", "invalid type: unit variant"]
        .iter()
        .any(|m| message.starts_with(m));
    let is_no_kind = message.starts_with("wanted exactly 1 element");
    let keys = format!("{page} lists the keys with their types and defaults");
    let plain = |words: String| ParserWords {
        key: key.clone(),
        message: words,
        help: match nearest(message) {
            Some(meant) => format!("did you mean `{meant}`? {keys}"),
            None => keys.clone(),
        },
    };
    let Some((place, kinds, example)) = choice else {
        let found = key.as_deref().map(&found_at).unwrap_or_default();
        if let [found] = found.as_slice()
            && let Some((_, example)) = WITH_BOX.iter().find(|(word, _)| found == word)
        {
            return ParserWords {
                key: key.clone(),
                message: format!("expected a table with the box of the mean, found {found}"),
                help: format!("write {example}; --of takes what is right of the sign ="),
            };
        }
        return plain(match found.as_slice() {
            [found] if is_no_word => format!("expected a word, found {found}"),
            _ if is_no_word || is_no_kind => "expected a word, found a table".to_owned(),
            _ => translated(message),
        });
    };
    let expected = format!("expected exactly one of {}", kinds.join(", "));
    let (found, help) = if is_no_kind {
        let mut found = found_at(&place);
        found.retain(|found| kinds.contains(&found.as_str()));
        let help = if found.is_empty() {
            format!("give one of them, such as {example}")
        } else {
            format!("leave one of them; --set '{place}={{ ... }}' replaces the whole table")
        };
        (found, help)
    } else if is_no_word {
        (
            found_at(&place),
            format!("name the kind, such as {example}"),
        )
    } else {
        return plain(translated(message));
    };
    let found = match found.as_slice() {
        [] => "none".to_owned(),
        found => found.join(" and "),
    };
    ParserWords {
        key: Some(place),
        message: format!("{expected}; found {found}"),
        help,
    }
}

/// Least similarity (Jaro and Winkler's, 1 for equal words) of a word that may have been meant.
const SIMILAR: f64 = 0.8;

/// The known key or word that is most like the unknown one that a message names first.
fn nearest(message: &str) -> Option<&str> {
    let mut named = message.split('`').skip(1).step_by(2);
    let unknown = named.next().filter(|_| message.starts_with("unknown "))?;
    let similarity = |known: &str| strsim::jaro_winkler(unknown, known);
    let best = named.max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(best) >= SIMILAR).then_some(best)
}

/// The table with kinds that a key leads to or through, its kinds, and an example.
fn choice(key: &str) -> Option<(String, &'static [&'static str], &'static str)> {
    let parts: Vec<&str> = key.split('.').collect();
    let last = parts.len() - 1;
    (last.saturating_sub(1)..=last).rev().find_map(|at| {
        let name = parts[at].trim_end_matches("_1").trim_end_matches("_2");
        let (_, kinds, example) = CHOICES.iter().find(|(end, ..)| *end == name)?;
        Some((parts[..=at].join("."), *kinds, *example))
    })
}

/// Types and keys by the names they have in scenes, what was expected first.
fn translated(message: &str) -> String {
    let message = message
        .replace("unknown field", "unknown key")
        .replace("missing field", "missing key")
        .replace("unknown variant", "unknown word");
    let Some((found, expected)) = message
        .strip_prefix("invalid type: ")
        .or_else(|| message.strip_prefix("invalid value: "))
        .and_then(|rest| rest.split_once(", expected "))
    else {
        return match message
            .strip_prefix("invalid length ")
            .and_then(|rest| rest.split_once(", expected an array of length "))
        {
            Some((found, expected)) => format!("expected {expected} values, found {found}"),
            None => message,
        };
    };
    let word = |text: &str| {
        let known = TYPES.iter().find(|(theirs, _)| *theirs == text);
        known.map(|(_, ours)| (*ours).to_owned())
    };
    let length = expected.strip_prefix("an array of length ");
    let expected = match (length, expected.starts_with("struct ")) {
        (Some(length), _) => format!("a list of {length} values"),
        (None, true) => "a table".to_owned(),
        (None, false) => word(expected).unwrap_or_else(|| expected.to_owned()),
    };
    let found = match found.split_once(" `") {
        Some((kind, value)) => {
            // The parser writes out all digits.
            let number = value.trim_end_matches('`').parse::<f64>().ok();
            let number = number.filter(|_| kind == "floating point");
            let value = number.map_or_else(|| format!("`{value}"), |n| format!("`{n:?}`"));
            format!("{} {value}", word(kind).unwrap_or_else(|| kind.to_owned()))
        }
        None => word(found).unwrap_or_else(|| found.to_owned()),
    };
    format!("expected {expected}, found {found}")
}
