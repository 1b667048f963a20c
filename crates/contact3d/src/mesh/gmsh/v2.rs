//! Sections of MSH 2.2, in text and in binary.

use std::collections::HashMap;

use super::{
    FilePosition, GmshFlaw,
    contents::Contents,
    groups::ElementKind,
    scanner::{Scanner, too_many},
};

/// `$Nodes`: a count, then tag and coordinates of a node on each line.
pub(super) fn nodes(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    let count = scanner.count_line("nodes", 8, 28)?;
    contents.reserve_nodes(count);
    for _ in 0..count {
        scanner.begin_record();
        let place = scanner.place();
        let tag = scanner.size("the tag of a node")?;
        let at = scanner.node_place()?;
        scanner.end_record()?;
        contents.push_node(place, tag, at)?;
    }
    Ok(())
}

/// `$Elements`: a count, then code, number of elements and number of tags of a block, and tag, tags
/// and nodes of each of its elements. In text every element is a block with its tag in front.
///
/// The first of the tags is the physical group (0 for none, negative for the reversed
/// orientation); an element in several groups stands in several lines.
pub(super) fn elements(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    let mut left = scanner.count_line("elements", 8, 12)?;
    let mut memberships = HashMap::from([(0, contents.membership(Vec::new()))]);
    while left > 0 {
        scanner.begin_record();
        let place = scanner.place();
        let own_tag = if scanner.is_text() {
            Some(scanner.size("the tag of an element")?)
        } else {
            None
        };
        let kind = ElementKind::of_code(scanner.int("the type of the element")?, place)?;
        let in_block = match own_tag {
            Some(_) => 1,
            None => block_size(scanner, left, place)?,
        };
        let n_tags = scanner.size("the number of tags of the element")?;
        for _ in 0..in_block {
            let place = scanner.place();
            let tag = match own_tag {
                Some(tag) => tag,
                None => scanner.size("the tag of an element")?,
            };
            let group = read_group(scanner, n_tags)?;
            let membership = memberships.entry(group);
            let membership = *membership.or_insert_with(|| contents.membership(vec![group]));
            contents.read_element(scanner, (place, tag), kind, membership)?;
        }
        scanner.end_record()?;
        left -= in_block;
    }
    Ok(())
}

/// The number of elements of a block of which at most `left` are still to come.
fn block_size(scanner: &mut Scanner, left: usize, place: FilePosition) -> Result<usize, GmshFlaw> {
    let declared = scanner.size("the number of elements of the block")?;
    match usize::try_from(declared) {
        Ok(count @ 1..) if count <= left => Ok(count),
        _ => Err(too_many(place, "elements of the block", declared, left)),
    }
}

/// The physical group among the tags of an element.
fn read_group(scanner: &mut Scanner, n_tags: u64) -> Result<i64, GmshFlaw> {
    let mut group = 0;
    for i in 0..n_tags {
        let tag = scanner.int("a tag of the element")?;
        if i == 0 {
            group = tag.saturating_abs();
        }
    }
    Ok(group)
}
