//! Triangles of STL files, in text and binary (3D Systems, *StereoLithography Interface Specification*, 1988).
//!
//! Read here, as `stl_io` rounds the digits of text to single precision, and takes binary files whose first line begins with "solid", as
//! some CAD systems write it, for text.

use nalgebra::Vector3;

/// Bytes of a binary file before its triangles, and of each of them.
const HEADER: usize = 84;
const RECORD: usize = 50;

/// The triangles of a file in its unit: the normal that it gives, which may be zero, then the corners.
///
/// # Errors
/// What was found in place of an STL.
pub(super) fn parse(bytes: &[u8]) -> Result<Vec<[Vector3<f64>; 4]>, String> {
    // The mark of UTF-8 before a text.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let announced = bytes.get(HEADER - 4..HEADER).map(|count| {
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
        count as usize
    });
    let needed = |count: usize| HEADER.saturating_add(count.saturating_mul(RECORD));
    let begins = bytes.trim_ascii_start().get(..5);
    let begins = begins.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Names may be in any encoding; a binary file has zeros.
    let is_text = begins && !bytes.contains(&0);
    let words = is_text.then(|| String::from_utf8_lossy(bytes));
    match (announced, words.as_deref()) {
        (Some(count), _) if count > 0 && bytes.len() == needed(count) => Ok(binary(bytes)),
        (_, Some(words)) => text(words),
        (Some(count), None) if count > 0 && bytes.len() > needed(count) => {
            Ok(binary(&bytes[..needed(count)]))
        }
        (Some(count), None) if begins || bytes.len() / RECORD > count / 2 => Err(format!(
            "{} bytes, {count} triangles of a binary STL take {}",
            bytes.len(),
            needed(count)
        )),
        _ => Err("neither \"solid\" of a text nor the length of a binary STL".into()),
    }
}

fn binary(bytes: &[u8]) -> Vec<[Vector3<f64>; 4]> {
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    let vector = |at: &[u8]| Vector3::from_iterator(at.chunks_exact(4).map(number));
    let records = bytes[HEADER..].chunks_exact(RECORD);
    let of_record = |record: &[u8]| [0, 12, 24, 36].map(|from| vector(&record[from..from + 12]));
    records.map(of_record).collect()
}

fn text(text: &str) -> Result<Vec<[Vector3<f64>; 4]>, String> {
    let (mut triangles, mut normal, mut corners) = (Vec::new(), Vector3::zeros(), Vec::new());
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    for (number, line) in text.lines().enumerate() {
        let lower = line.to_ascii_lowercase();
        let mut words = lower.split_ascii_whitespace();
        let flaw = |expected: &str| {
            let line: String = line.trim().chars().take(60).collect();
            format!("\"{line}\" in line {} in place of {expected}", number + 1)
        };
        match words.next() {
            Some("facet") => {
                normal = vector(words.skip(1)).unwrap_or_default();
                corners.clear();
            }
            Some("vertex") => {
                let place = vector(words).ok_or_else(|| flaw("vertex and three numbers"))?;
                corners.push(place);
            }
            Some("endfacet") => {
                let [a, b, c] = corners[..] else {
                    return Err(flaw("three corners"));
                };
                triangles.push([normal, a, b, c]);
                corners.clear();
            }
            Some("solid" | "endsolid" | "outer" | "endloop") | None => {}
            Some(_) => return Err(flaw("facet, vertex or endfacet")),
        }
    }
    match corners.is_empty() {
        true => Ok(triangles),
        false => Err("an end within a triangle".into()),
    }
}

/// Three numbers, and nothing else.
fn vector<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vector3<f64>> {
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    let numbers: [f64; 3] = numbers?.try_into().ok()?;
    Some(numbers.into())
}
