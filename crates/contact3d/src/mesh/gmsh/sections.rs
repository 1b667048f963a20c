//! Sections of mesh files of MSH 4.1, in text and in binary, and of MSH 2.2 in text.

use std::collections::HashMap;

use super::{
    contents::{Contents, ElementKind},
    scanner::{GmshFlaw, Scanner, shown},
};

/// Reads all sections of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, GmshFlaw> {
    let mut scanner = Scanner::new(bytes);
    let is_v4 = read_format(&mut scanner)?;
    let mut contents = Contents {
        memberships: vec![Vec::new()],
        ..Contents::default()
    };
    let mut entities = None;
    let mut missing = vec!["Nodes", "Elements"];
    let mut has_parameters = false;
    while let Some(section) = begin_section(&mut scanner)? {
        let n_missing = missing.len();
        missing.retain(|known| *known != section);
        has_parameters |= section == "ParametricNodes";
        if ["Nodes", "Elements"].contains(&&*section) && missing.len() == n_missing {
            return Err(GmshFlaw::new(
                scanner.place(),
                format!("one section ${section}"),
                "a second one",
                "two meshes stand in one file; merge them in Gmsh and save once",
            ));
        }
        match (section.as_str(), is_v4) {
            ("PhysicalNames", _) => read_names(&mut scanner, &mut contents)?,
            ("Entities", true) => {
                entities = Some(entities_v4(&mut scanner, &mut contents)?);
            }
            ("Nodes", false) => nodes_v2(&mut scanner, &mut contents)?,
            ("Nodes", true) => nodes_v4(&mut scanner, &mut contents)?,
            ("Elements", false) => elements_v2(&mut scanner, &mut contents)?,
            ("Elements", true) => {
                elements_v4(&mut scanner, entities.as_ref(), &mut contents)?;
            }
            _ => {
                skip_section(&mut scanner, &section)?;
                continue;
            }
        }
        end_section(&mut scanner, &section)?;
    }
    match missing.first() {
        None => Ok(contents),
        Some(section) => Err(GmshFlaw::new(
            None,
            format!("a section ${section}"),
            "none",
            if has_parameters {
                "$ParametricNodes are not read; save again with gmsh part.geo -3 -setnumber Mesh.SaveParametric 0"
            } else {
                "the file is cut off or not an MSH file with nodes and elements"
            },
        )),
    }
}

fn read_names(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    const LINE: &str = "dimension, tag and \"name\" of a physical group";
    let count = scanner.text_line().unwrap_or_default();
    let count: u64 = text(count)
        .and_then(|c| c.parse().ok())
        .ok_or_else(|| scanner.syntax("the number of physical names", shown(count)))?;
    for _ in 0..count {
        let line = scanner.text_line().unwrap_or_default();
        let (key, name) = physical_name(line).ok_or_else(|| scanner.syntax(LINE, shown(line)))?;
        contents.names.insert(key, name);
    }
    Ok(())
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// Takes `2 7 "left end"` apart.
fn physical_name(line: &[u8]) -> Option<((i64, i64), String)> {
    let (numbers, quoted) = text(line)?.split_once('"')?;
    let (name, after) = quoted.rsplit_once('"')?;
    let mut numbers = numbers.split_ascii_whitespace().map(str::parse);
    let key = (numbers.next()?.ok()?, numbers.next()?.ok()?);
    let complete = numbers.next().is_none() && after.is_empty() && !name.is_empty();
    complete.then(|| (key, name.to_owned()))
}

/// Reads `$MeshFormat`: version, encoding and size of sizes, in binary also the order of bytes; whether the version is 4.1, or 2.2.
fn read_format(scanner: &mut Scanner) -> Result<bool, GmshFlaw> {
    let first = scanner.text_line().unwrap_or_default();
    if first != b"$MeshFormat" {
        return Err(scanner.syntax("$MeshFormat at the beginning", shown(first)));
    }
    let line = scanner.text_line().unwrap_or_default();
    let words: Vec<&str> = text(line)
        .unwrap_or_default()
        .split_ascii_whitespace()
        .collect();
    let &[version, encoding, size] = words.as_slice() else {
        return Err(scanner.syntax(
            "version, encoding and data size such as 4.1 0 8",
            shown(line),
        ));
    };
    let place = scanner.place();
    let is_v4 = match version.parse() {
        Ok(2.2) => false,
        Ok(4.1) => true,
        _ => {
            return Err(GmshFlaw::new(
                place,
                "MSH format 4.1 or 2.2",
                shown(version.as_bytes()),
                "save it again: gmsh part.geo -3 -format msh41 -o part.msh",
            ));
        }
    };
    let refuse = |found: &str| {
        Err(GmshFlaw::new(
            place,
            "text or little-endian binary of MSH 4.1 with data of 8 bytes",
            found,
            "save it as text, without -bin: gmsh part.geo -3 -format msh41 -o part.msh",
        ))
    };
    match (encoding, size) {
        ("0", _) => {}
        ("1", _) if !is_v4 => return refuse("binary of MSH 2.2"),
        ("1", "8") => {
            scanner.end_text_line();
            scanner.is_text = false;
            if scanner.int("the number 1 that shows the order of bytes")? != 1 {
                return refuse("big-endian binary");
            }
        }
        ("1", size) => return refuse(&format!("binary with sizes of {size} bytes")),
        (other, _) => return refuse(&format!("encoding {}", shown(other.as_bytes()))),
    }
    end_section(scanner, "MeshFormat")?;
    Ok(is_v4)
}

/// The name of the next section; none at the end of the file.
fn begin_section(scanner: &mut Scanner) -> Result<Option<String>, GmshFlaw> {
    let Some(line) = scanner.text_line() else {
        return Ok(None);
    };
    let name = line.strip_prefix(b"$").and_then(text);
    let Some(name) = name.filter(|n| !n.is_empty() && !n.starts_with("End")) else {
        return Err(scanner.syntax("the beginning of a section such as $Nodes", shown(line)));
    };
    scanner.end_text_line();
    Ok(Some(name.to_owned()))
}

fn end_section(scanner: &mut Scanner, section: &str) -> Result<(), GmshFlaw> {
    let line = scanner.text_line().unwrap_or_default();
    let end = format!("$End{section}");
    if line == end.as_bytes() {
        return Ok(());
    }
    let found = if line.is_empty() {
        "the end of the file".to_owned()
    } else {
        shown(line)
    };
    Err(scanner.syntax(end, found))
}

/// Passes a section that is not used, to the end of its last line.
fn skip_section(scanner: &mut Scanner, section: &str) -> Result<(), GmshFlaw> {
    let end = format!("$End{section}");
    if scanner.skip_behind(end.as_bytes()) {
        return Ok(());
    }
    Err(scanner.syntax(end, "the end of the file"))
}

/// `$Nodes` of MSH 2.2: a count, then tag and coordinates of a node on each line.
fn nodes_v2(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    let count = count_line(scanner, "nodes", 8)?;
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

/// `$Elements` of MSH 2.2: a count, then tag, code, number of tags, tags and nodes of an element on each line.
///
/// The first of the tags is the physical group (0 for none, negative for the reversed
/// orientation); an element in several groups stands in several lines.
fn elements_v2(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
    let mut memberships = HashMap::new();
    for _ in 0..count_line(scanner, "elements", 8)? {
        scanner.begin_record();
        let place = scanner.place();
        let tag = scanner.size("the tag of an element")?;
        let kind = ElementKind::of_code(scanner.int("the type of the element")?, place)?;
        let n_tags = scanner.size("the number of tags of the element")?;
        let group = read_group(scanner, n_tags)?;
        let membership = memberships.entry(group);
        let membership = *membership.or_insert_with(|| contents.membership(vec![group]));
        contents.read_element(scanner, (place, tag), kind, membership)?;
        scanner.end_record()?;
    }
    Ok(())
}

/// A count on a line of its own, of items of at least so many bytes.
fn count_line(scanner: &mut Scanner, what: &str, bytes: usize) -> Result<usize, GmshFlaw> {
    scanner.begin_record();
    let count = scanner.count(what, bytes, bytes)?;
    scanner.end_record()?;
    Ok(count)
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

/// `$Entities` of MSH 4.1: points, curves, surfaces and volumes with their physical groups; the membership of each by its dimension and
/// tag.
fn entities_v4(
    scanner: &mut Scanner,
    contents: &mut Contents,
) -> Result<HashMap<(i64, i64), usize>, GmshFlaw> {
    scanner.begin_record();
    let mut counts = [0; 4];
    for (count, what) in counts
        .iter_mut()
        .zip(["points", "curves", "surfaces", "volumes"])
    {
        *count = scanner.count(what, 2, 36)?;
    }
    scanner.end_record()?;
    let mut entities = HashMap::new();
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

/// `$Nodes` of MSH 4.1: blocks of one entity each, first all tags of the block, then all coordinates.
fn nodes_v4(scanner: &mut Scanner, contents: &mut Contents) -> Result<(), GmshFlaw> {
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

/// `$Elements` of MSH 4.1: blocks of one entity and one type each, tag and nodes of an element on each line.
fn elements_v4(
    scanner: &mut Scanner,
    entities: Option<&HashMap<(i64, i64), usize>>,
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
            2 + 2 * kind.n_nodes,
            8 + 8 * kind.n_nodes,
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
