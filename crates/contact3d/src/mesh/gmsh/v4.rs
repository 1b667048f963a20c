//! Sections of MSH 4.1, in text and in binary.

use std::collections::HashMap;

use super::{GmshFlaw, contents::Contents, groups::ElementKind, scanner::Scanner};

/// The membership of each geometric entity, by dimension and tag.
pub(super) type Entities = HashMap<(i64, i64), usize>;

/// `$Entities`: points, curves, surfaces and volumes with their physical groups.
pub(super) fn entities(
    scanner: &mut Scanner,
    contents: &mut Contents,
) -> Result<Entities, GmshFlaw> {
    scanner.begin_record();
    let mut counts = [0; 4];
    for (count, what) in counts
        .iter_mut()
        .zip(["points", "curves", "surfaces", "volumes"])
    {
        *count = scanner.count(what, 2, 36)?;
    }
    scanner.end_record()?;
    let mut entities = Entities::new();
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            scanner.begin_record();
            let tag = scanner.int("the tag of an entity")?;
            // A point has its place, the others the corners of their boxes.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                scanner.real("a coordinate of the entity")?;
            }
            let groups = tags(scanner, "physical groups of the entity")?;
            if dimension > 0 {
                tags(scanner, "bounding entities")?;
            }
            scanner.end_record()?;
            entities.insert((dimension, tag), contents.membership(groups));
        }
    }
    Ok(entities)
}

/// A count and as many tags, without their signs, which say orientations.
fn tags(scanner: &mut Scanner, what: &str) -> Result<Vec<i64>, GmshFlaw> {
    let count = scanner.count(what, 2, 4)?;
    (0..count)
        .map(|_| Ok(scanner.int(what)?.saturating_abs()))
        .collect()
}

/// `$Nodes`: blocks of one entity each, first all tags of the block, then all coordinates.
pub(super) fn nodes(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    scanner.begin_record();
    let n_blocks = scanner.size("the number of blocks of nodes")?;
    let count = scanner.count("nodes", 8, 32)?;
    skip_range(scanner)?;
    contents.reserve_nodes(count);
    for _ in 0..n_blocks {
        scanner.begin_record();
        let dimension = scanner.int("the dimension of the entity")?;
        scanner.int("the tag of the entity")?;
        let parametric = scanner.int("0 or 1 for parametric coordinates")? != 0;
        let in_block = scanner.count("nodes of the block", 8, 32)?;
        scanner.end_record()?;
        let mut block_tags = Vec::with_capacity(in_block);
        for _ in 0..in_block {
            scanner.begin_record();
            block_tags.push(scanner.size("the tag of a node")?);
            scanner.end_record()?;
        }
        let n_parameters = if parametric { dimension.clamp(0, 3) } else { 0 };
        for tag in block_tags {
            scanner.begin_record();
            let place = scanner.place();
            let at = scanner.node_place()?;
            for _ in 0..n_parameters {
                scanner.real("a parametric coordinate of the node")?;
            }
            scanner.end_record()?;
            contents.push_node(place, tag, at)?;
        }
    }
    agree(
        scanner,
        "nodes in all blocks",
        count,
        contents.node_tags.len(),
    )
}

/// `$Elements`: blocks of one entity and one type each, tag and nodes of an element on each line.
pub(super) fn elements(
    scanner: &mut Scanner,
    entities: Option<&Entities>,
    contents: &mut Contents,
) -> Result<(), GmshFlaw> {
    scanner.begin_record();
    let n_blocks = scanner.size("the number of blocks of elements")?;
    let count = scanner.count("elements", 4, 16)?;
    skip_range(scanner)?;
    let mut found = 0;
    for _ in 0..n_blocks {
        scanner.begin_record();
        let place = scanner.place();
        let dimension = scanner.int("the dimension of the entity")?;
        let entity = scanner.int("the tag of the entity")?;
        let kind = ElementKind::of_code(scanner.int("the type of the elements")?, place)?;
        let in_block = scanner.count(
            "elements of the block",
            2 + 2 * kind.n_nodes(),
            8 + 8 * kind.n_nodes(),
        )?;
        scanner.end_record()?;
        let membership = match entities.map(|all| all.get(&(dimension, entity))) {
            None => 0,
            Some(Some(&membership)) => membership,
            Some(None) => {
                return Err(GmshFlaw::new(
                    place,
                    "an entity of $Entities",
                    format!("entity {entity} of dimension {dimension}"),
                    "partitioned meshes are not read: save the mesh without partitions (Unpartition)",
                ));
            }
        };
        for _ in 0..in_block {
            scanner.begin_record();
            let place = scanner.place();
            let tag = scanner.size("the tag of an element")?;
            contents.read_element(scanner, (place, tag), kind, membership)?;
            scanner.end_record()?;
        }
        found += in_block;
    }
    agree(scanner, "elements in all blocks", count, found)
}

/// Passes the smallest and largest tag at the end of a section's first line.
fn skip_range(scanner: &mut Scanner) -> Result<(), GmshFlaw> {
    scanner.size("the smallest tag")?;
    scanner.size("the largest tag")?;
    scanner.end_record()
}

fn agree(scanner: &Scanner, what: &str, declared: usize, found: usize) -> Result<(), GmshFlaw> {
    if declared == found {
        return Ok(());
    }
    Err(scanner.syntax(format!("{declared} {what}"), found.to_string()))
}
