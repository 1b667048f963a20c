//! Sections of MSH 2.2.

use std::collections::HashMap;

use super::{GmshError, contents::Contents, element::Kind, scanner::Scanner};

/// `$Nodes`: a count, then tag and coordinates of a node on each line.
pub(super) fn nodes(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshError> {
    scanner.begin_record();
    let count = scanner.count("nodes", 8, 28)?;
    scanner.end_record()?;
    contents.reserve_nodes(count);
    for _ in 0..count {
        scanner.begin_record();
        let place = scanner.place();
        let tag = scanner.size("the tag of a node")?;
        let mut at = [0.0; 3];
        for x in &mut at {
            *x = scanner.real("a coordinate of the node")?;
        }
        scanner.end_record()?;
        contents.push_node(place, tag, at)?;
    }
    Ok(())
}

/// `$Elements`: a count, then tag, code, tags of groups and nodes of an element on each line.
///
/// The first tag is the physical group (0 for none, negative for the reversed orientation); an
/// element in several groups stands on several lines.
pub(super) fn elements(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshError> {
    scanner.begin_record();
    let count = scanner.count("elements", 8, 12)?;
    scanner.end_record()?;
    let mut membership_of_group = HashMap::new();
    for _ in 0..count {
        scanner.begin_record();
        let place = scanner.place();
        let tag = scanner.size("the tag of an element")?;
        let kind = Kind::of_code(scanner.int("the type of the element")?, place)?;
        let group = read_tags(scanner)?;
        let membership = *membership_of_group.entry(group).or_insert_with(|| {
            let groups = if group == 0 { vec![] } else { vec![group] };
            contents.membership(groups)
        });
        contents.read_element(scanner, (place, tag), kind, membership)?;
        scanner.end_record()?;
    }
    Ok(())
}

/// The physical group among the tags of an element.
fn read_tags(scanner: &mut Scanner) -> Result<i64, GmshError> {
    let count = scanner.size("the number of tags of the element")?;
    let mut group = 0;
    for i in 0..count {
        let tag = scanner.int("a tag of the element")?;
        if i == 0 {
            group = tag.saturating_abs();
        }
    }
    Ok(group)
}
