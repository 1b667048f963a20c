//! What a mesh file contains, before it is checked as a body.

use std::collections::{BTreeMap, HashMap};

use super::{
    FilePosition, GmshFlaw,
    groups::{ElementKind, MIDDLES, MOST_NODES, MeshElement, Order},
    scanner::{Encoding, Scanner, shown},
    v2, v4,
};

/// What a mesh file says, before it is checked as a body.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub(super) node_tags: Vec<u64>,
    /// Index of each node by its tag.
    pub(super) node_of_tag: HashMap<u64, usize>,
    pub(super) coordinates: Vec<[f64; 3]>,
    pub(super) tetrahedra: Vec<MeshElement<4>>,
    /// Node tags of the mid-edge nodes of each tetrahedron in our order; empty in a mesh of linear ones.
    pub(super) middles: Vec<[u64; 6]>,
    pub(super) triangles: Vec<MeshElement<3>>,
    /// The sets of physical groups that elements are in, increasing; the first one is empty.
    pub(super) memberships: Vec<Vec<i64>>,
    /// Names of physical groups by dimension and tag.
    pub(super) names: BTreeMap<(i64, i64), String>,
}

/// The versions of the format that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GmshVersion {
    V2,
    V4,
}

impl Contents {
    fn new() -> Self {
        Self {
            memberships: vec![Vec::new()],
            ..Self::default()
        }
    }

    /// Adds a set of physical groups and gives its index.
    pub(super) fn membership(&mut self, mut groups: Vec<i64>) -> usize {
        if groups.is_empty() {
            return 0;
        }
        groups.sort_unstable();
        groups.dedup();
        self.memberships.push(groups);
        self.memberships.len() - 1
    }

    /// Makes room for nodes whose count was checked against the file.
    pub(super) fn reserve_nodes(&mut self, count: usize) {
        self.node_tags.reserve(count);
        self.node_of_tag.reserve(count);
        self.coordinates.reserve(count);
    }

    /// Reads all sections of a file.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, GmshFlaw> {
        let mut scanner = Scanner::new(bytes);
        let version = read_format(&mut scanner)?;
        let mut contents = Self::new();
        let mut entities = None;
        let mut missing = vec!["Nodes", "Elements"];
        while let Some(section) = begin_section(&mut scanner)? {
            let n_missing = missing.len();
            missing.retain(|known| *known != section);
            if ["Nodes", "Elements"].contains(&&*section) && missing.len() == n_missing {
                return Err(GmshFlaw::new(
                    scanner.place(),
                    format!("one section ${section}"),
                    "a second one",
                    "two meshes stand in one file; merge them in Gmsh and save once",
                ));
            }
            match (section.as_str(), version) {
                ("PhysicalNames", _) => contents.read_names(&mut scanner)?,
                ("Entities", GmshVersion::V4) => {
                    entities = Some(v4::entities(&mut scanner, &mut contents)?);
                }
                ("Nodes", GmshVersion::V2) => v2::nodes(&mut scanner, &mut contents)?,
                ("Nodes", GmshVersion::V4) => v4::nodes(&mut scanner, &mut contents)?,
                ("Elements", GmshVersion::V2) => v2::elements(&mut scanner, &mut contents)?,
                ("Elements", GmshVersion::V4) => {
                    v4::elements(&mut scanner, entities.as_ref(), &mut contents)?;
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
                "the file is cut off or not an MSH file with nodes and elements",
            )),
        }
    }

    fn read_names(&mut self, scanner: &mut Scanner) -> Result<(), GmshFlaw> {
        const LINE: &str = "dimension, tag and \"name\" of a physical group";
        let count = scanner.text_line().unwrap_or_default();
        let count: u64 = text(count)
            .and_then(|c| c.parse().ok())
            .ok_or_else(|| scanner.syntax("the number of physical names", shown(count)))?;
        for _ in 0..count {
            let line = scanner.text_line().unwrap_or_default();
            let (key, name) =
                physical_name(line).ok_or_else(|| scanner.syntax(LINE, shown(line)))?;
            self.names.insert(key, name);
        }
        Ok(())
    }

    /// Adds a node; its tag must be new and its coordinates finite.
    pub(super) fn push_node(
        &mut self,
        place: FilePosition,
        tag: u64,
        at: [f64; 3],
    ) -> Result<(), GmshFlaw> {
        if let Some(&found) = at.iter().find(|x| !x.is_finite()) {
            let flaw = GmshFlaw::new(
                place,
                "finite coordinates",
                found.to_string(),
                "mesh the geometry again",
            );
            return Err(flaw.of(format!("node {tag}")));
        }
        if self.node_of_tag.insert(tag, self.node_tags.len()).is_some() {
            return Err(GmshFlaw::new(
                place,
                "every node once",
                format!("node {tag} again"),
                "renumber the mesh in Gmsh: Mesh > Renumber, or RenumberMeshNodes",
            ));
        }
        self.node_tags.push(tag);
        self.coordinates.push(at);
        Ok(())
    }

    /// Reads the nodes of one element and adds it if it is a triangle or a tetrahedron.
    pub(super) fn read_element(
        &mut self,
        scanner: &mut Scanner,
        (place, tag): (FilePosition, u64),
        kind: ElementKind,
        membership: usize,
    ) -> Result<(), GmshFlaw> {
        let mut nodes = [0; MOST_NODES];
        for node in &mut nodes[..kind.n_nodes()] {
            *node = scanner.size("the tag of a node of the element")?;
        }
        let [a, b, c, d, ..] = nodes;
        match kind {
            ElementKind::Point | ElementKind::Line(_) => {}
            ElementKind::Triangle(_) => self.triangles.push(MeshElement {
                tag,
                place,
                nodes: [a, b, c],
                membership,
            }),
            ElementKind::Tetrahedron(order) => {
                if order == Order::Second {
                    self.middles.push(MIDDLES.map(|k| nodes[k]));
                }
                self.tetrahedra.push(MeshElement {
                    tag,
                    place,
                    nodes: [a, b, c, d],
                    membership,
                });
                if ![0, self.tetrahedra.len()].contains(&self.middles.len()) {
                    return Err(GmshFlaw::new(
                        place,
                        "tetrahedra of one order",
                        format!("tetrahedron {tag} of another one"),
                        "mesh the whole body with one order: gmsh part.geo -3 -order 2 -format msh41 -o part.msh",
                    ));
                }
            }
        }
        Ok(())
    }
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

/// Reads `$MeshFormat`: version, encoding and size of sizes; in binary also the order of bytes.
fn read_format(scanner: &mut Scanner) -> Result<GmshVersion, GmshFlaw> {
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
    let version = match version.parse() {
        Ok(2.2) => GmshVersion::V2,
        Ok(4.1) => GmshVersion::V4,
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
            "text or little-endian binary with data of 8 bytes",
            found,
            "save it as text, without -bin: gmsh part.geo -3 -format msh41 -o part.msh",
        ))
    };
    match (encoding, version, size) {
        ("0", _, _) => {}
        ("1", _, "8") => {
            scanner.end_text_line();
            scanner.set_encoding(match version {
                GmshVersion::V2 => Encoding::Ints,
                GmshVersion::V4 => Encoding::Sizes,
            });
            if scanner.int("the number 1 that shows the order of bytes")? != 1 {
                return refuse("big-endian binary");
            }
        }
        ("1", _, size) => return refuse(&format!("binary with sizes of {size} bytes")),
        (other, ..) => return refuse(&format!("encoding {}", shown(other.as_bytes()))),
    }
    end_section(scanner, "MeshFormat")?;
    Ok(version)
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
