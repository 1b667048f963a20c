//! Meshes made by Gmsh: MSH 4.1 in text and in binary, MSH 2.2 in text, checked as a body.
//!
//! Linear or quadratic tetrahedra are the body and physical volumes name its parts; triangles in physical
//! surfaces name the boundary; points and lines are passed over, and so are sections other than
//! `$PhysicalNames`, `$Entities`, `$Nodes` and `$Elements`.
//!
//! Format: Gmsh reference manual, chapter "MSH file format" and appendix "Legacy formats".

mod body;
mod boundary;
mod contents;
mod groups;
mod scanner;
mod sections;
mod surface;

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use miette::Diagnostic;
use thiserror::Error;

pub use scanner::{FilePosition, GmshFlaw};
pub(super) use surface::triangles;

use super::RawMesh;
use crate::scene::{GmshFile, other_file, require_regular};

/// Why a Gmsh mesh cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum GmshError {
    /// The file cannot be read.
    #[error("cannot read the mesh {}: {source}", path.display())]
    #[diagnostic(help("check the path; one in a scene counts from the folder of the scene file"))]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The mesh of another program.
    #[error("{}: expected a Gmsh file, found {found}", path.display())]
    #[diagnostic(help("{help}"))]
    OtherFormat {
        path: PathBuf,
        found: &'static str,
        help: String,
    },
    /// The file is not the one the scene means.
    #[error("{}: expected the blake3 digest {expected}, found {found}", path.display())]
    #[diagnostic(help(
        "the mesh has changed since its digest was written down; check it and update the digest"
    ))]
    Digest {
        path: PathBuf,
        expected: String,
        found: String,
    },
    /// The unit of the file is no length.
    #[error("unit of the mesh: expected a positive length, found {found}")]
    #[diagnostic(help(
        "a mesh in millimetres has unit 0.001 in a scene in metres; coordinates times the unit must stay finite"
    ))]
    Unit { found: f64 },
    /// What is wrong in the file of this path.
    #[error("{}: {flaw}", path.display())]
    #[diagnostic(forward(flaw))]
    InFile { path: PathBuf, flaw: Box<GmshFlaw> },
}

/// Reads the mesh of a scene whose paths count from `folder`; coordinates come out in m.
///
/// # Errors
/// [`GmshError::Read`], [`GmshError::Digest`] and [`GmshError::Unit`] for the file as a whole;
/// [`GmshError::InFile`] with what [`parse`] says about its contents.
pub(super) fn read(file: &GmshFile, folder: &Path) -> Result<RawMesh, GmshError> {
    let path = folder.join(&file.file);
    let bytes = require_regular(&path).and_then(|()| fs::read(&path));
    let bytes = bytes.map_err(|source| GmshError::Read {
        path: path.clone(),
        source,
    })?;
    if let Some(expected) = &file.digest {
        let found = blake3::hash(&bytes).to_hex();
        if !expected.eq_ignore_ascii_case(&found) {
            return Err(GmshError::Digest {
                path,
                expected: expected.clone(),
                found: found.to_string(),
            });
        }
    }
    let is_msh = path.extension().is_some_and(|extension| extension == "msh");
    if !is_msh && !bytes.starts_with(b"$MeshFormat") {
        let is_scene = path
            .extension()
            .is_some_and(|extension| extension == "toml");
        let (found, help) = match other_file(&bytes, &path) {
            Some((found, help)) => (found, help.to_owned()),
            None if is_scene => (
                "a scene",
                "`run` takes scenes, `inspect` and body.gmsh.file take meshes".to_owned(),
            ),
            None => {
                let [from, to] = [path.clone(), path.with_extension("msh")];
                let (from, to) = (from.display(), to.display());
                let convert = format!(
                    "pip install '.[convert]' in a clone, then: python -m contact3d.convert {from} {to}"
                );
                ("another format", convert)
            }
        };
        return Err(GmshError::OtherFormat { path, found, help });
    }
    let mut mesh =
        parse_volume(&bytes, file.volume.as_deref()).map_err(|flaw| GmshError::InFile {
            path,
            flaw: Box::new(flaw),
        })?;
    scale(&mut mesh, file.unit)?;
    Ok(mesh)
}

/// The names of the physical volumes in a file; none of one that cannot be read.
pub(super) fn volume_names(path: &Path) -> Vec<String> {
    let contents = fs::read(path).ok().and_then(|it| sections::read(&it).ok());
    contents.map_or_else(Vec::new, |contents| contents.volume_names())
}

/// The blake3 digest of a file in hexadecimal digits, as a scene may demand it.
///
/// # Errors
/// What the system says when the file cannot be read, `InvalidInput` for a folder, pipe or device.
pub fn digest_of(path: &Path) -> io::Result<String> {
    require_regular(path)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(fs::File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The mesh in the bytes of an MSH file, in the unit of the file.
///
/// Nodes are numbered by increasing tag, without those that no tetrahedron uses; tetrahedra keep
/// the order of the file, boundary triangles follow that of their tetrahedra, and groups are
/// numbered by increasing physical tag.
///
/// # Errors
/// The first flaw found, with its line and its tags in the file.
pub fn parse(bytes: &[u8]) -> Result<RawMesh, GmshFlaw> {
    parse_volume(bytes, None)
}

/// As [`parse`], of one physical volume alone where it is named.
fn parse_volume(bytes: &[u8], volume: Option<&str>) -> Result<RawMesh, GmshFlaw> {
    let mut contents = sections::read(bytes)?;
    if let Some(volume) = volume {
        contents.keep_volume(volume)?;
    }
    let body = body::GmshBody::new(&contents)?;
    let boundary = boundary::GmshBoundary::new(&body, &contents)?;
    boundary::check(&body, &boundary, &contents)?;
    boundary.require_one_piece(&contents)?;
    let (tetrahedron_group, group_names) = groups::volumes(&contents)?;
    let (facet_face, face_names) = groups::surfaces(&contents, &body, &boundary)?;
    Ok(RawMesh {
        coordinates: body.coordinates,
        tetrahedra: body.tetrahedra,
        tetrahedron_group,
        group_names,
        facets: boundary.facets,
        facet_face,
        face_names,
        mid_edges: body.mid_edges,
        ..RawMesh::default()
    })
}

/// Turns coordinates into metres.
fn scale(mesh: &mut RawMesh, unit: f64) -> Result<(), GmshError> {
    let coordinates = mesh.coordinates.as_flattened_mut();
    coordinates.iter_mut().for_each(|x| *x *= unit);
    if unit > 0.0 && coordinates.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(GmshError::Unit { found: unit })
    }
}
