//! How many cases a sweep may have.

use std::path::Path;

use super::{StageError, SweepAxis};

/// Most cases of one sweep: each is a file of the folder, and a plan holds the scene of each, some
/// kilobytes.
pub const MOST_CASES: usize = 100_000;

/// Refuses axes whose product is larger than [`MOST_CASES`], without making anything of that size.
pub(super) fn check(axes: &[SweepAxis], file: &Path) -> Result<(), StageError> {
    let refuse = |place: String, found: String| StageError::Axis {
        file: file.to_owned(),
        place,
        expected: format!("at most {MOST_CASES} cases in a sweep"),
        found,
    };
    let mut lengths: Vec<(Option<&str>, usize)> = Vec::new();
    for (index, axis) in axes.iter().enumerate() {
        let (zip, length) = (axis.zip.as_deref(), axis.length());
        if length > MOST_CASES {
            return Err(refuse(format!("axis {index}"), length.to_string()));
        }
        if zip.is_none() || lengths.iter().all(|(other, _)| *other != zip) {
            lengths.push((zip, length));
        }
    }
    let product = lengths
        .iter()
        .try_fold(1_usize, |product, (_, length)| product.checked_mul(*length));
    match product.filter(|cases| *cases <= MOST_CASES) {
        Some(_) => Ok(()),
        None => {
            let lengths: Vec<String> = lengths.iter().map(|(_, n)| n.to_string()).collect();
            let found = format!("{} of them", lengths.join(" x "));
            Err(refuse("the axes together".into(), found))
        }
    }
}
