//! What happens on each of several contact faces, as columns of a sweep's table.

use runfile::{
    Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, extents,
    fields::{Table, fields, read_if_there, read_value, write_value},
    mesh, post,
    sweep::GROUP,
};

const NAMES: &str = "/cases/face_names";

const FACES: &[Extent] = &[Named("n_cases"), Named("n_case_faces")];
const ZONES: &[Extent] = &[Named("n_cases"), Named("n_case_faces"), extents::ZONES];
const PAIRS: &[Extent] = &[Named("n_cases"), Named("n_case_faces"), Fixed(2)];
const ONE_FACE: &str = "absent where no case has several contact faces";

/// The faces of a case, in the order of the names.
pub(super) const FIELDS: Table<Vec<CaseFace>> = fields! { Vec<CaseFace> => GROUP;
    {Kind::Text} NAMES, &[Named("n_case_faces")], Dimension::Number, "Names of contact faces in cases with several, each once.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.zones)] "/cases/face_zone_counts", ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes of each face; -1 in cases without it.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.normal_force)] "/cases/face_normal_force", FACES, Dimension::FORCE, "Total normal contact force of each face; NaN in cases without it.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.tangential_force)] "/cases/face_tangential_force", PAIRS, Dimension::FORCE, "Sum of area times tangential multiplier along the t1 and t2 of each face; NaN without friction.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.largest_pressure)] "/cases/face_largest_pressure", FACES, Dimension::STRESS, "Largest normal multiplier of each face.".optional(ONE_FACE);
};

/// One of several contact faces of a case; NaN for what its law does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseFace {
    /// Its name.
    pub name: String,
    /// Open, sticking, slipping panes.
    pub zones: [i64; 3],
    /// Normal force in N.
    pub normal_force: f64,
    /// Tangential forces in N.
    pub tangential_force: [f64; 2],
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
}

impl CaseFace {
    /// A face that a case does not have.
    fn absent() -> Self {
        Self {
            name: String::new(),
            zones: [-1; 3],
            normal_force: f64::NAN,
            tangential_force: [f64::NAN; 2],
            largest_pressure: f64::NAN,
        }
    }
}

/// The faces of a finished run file with several, in the order of its results; none with one.
pub(super) fn read(reader: &Reader) -> Result<Vec<CaseFace>, FormatError> {
    if !reader.has(post::FACE_NORMAL_FORCE) {
        return Ok(Vec::new());
    }
    let names = reader.read_text(mesh::CONTACT_FACE_NAMES)?;
    let normal: Vec<f64> = reader.read_vec(post::FACE_NORMAL_FORCE)?;
    let pressure: Vec<f64> = reader.read_vec(post::FACE_LARGEST_PRESSURE)?;
    let zones: Vec<[i64; 3]> = read_value(reader, post::FACE_ZONE_COUNTS)?;
    // Faces with friction come first.
    let pairs: Option<Vec<[f64; 2]>> = read_if_there(reader, post::FACE_TANGENTIAL_FORCE)?;
    let pairs = pairs.unwrap_or_default();
    let numbers = normal.into_iter().zip(pressure).zip(zones);
    let faces = names.lines().zip(numbers).enumerate();
    Ok(faces
        .map(
            |(k, (name, ((normal_force, largest_pressure), zones)))| CaseFace {
                name: name.to_owned(),
                zones,
                normal_force,
                tangential_force: pairs.get(k).copied().unwrap_or([f64::NAN; 2]),
                largest_pressure,
            },
        )
        .collect())
}

/// The names of all faces of some cases, each once.
fn names<'a>(cases: impl Iterator<Item = &'a [CaseFace]>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for face in cases.flatten() {
        if !names.contains(&face.name) {
            names.push(face.name.clone());
        }
    }
    names
}

/// The face of a case with a name, or one of -1 and NaN.
fn named(faces: &[CaseFace], name: &str) -> CaseFace {
    let found = faces.iter().find(|face| face.name == name);
    found.cloned().unwrap_or_else(CaseFace::absent)
}

/// Writes the faces of all cases; nothing where none has several.
pub(super) fn write(writer: &mut GroupWriter<'_>, cases: &[&[CaseFace]]) -> Result<(), StoreError> {
    let names = names(cases.iter().copied());
    if names.is_empty() {
        return Ok(());
    }
    let cells = |of_case: &&[CaseFace]| -> Vec<CaseFace> {
        names.iter().map(|name| named(of_case, name)).collect()
    };
    let cells: Vec<Vec<CaseFace>> = cases.iter().map(cells).collect();
    write_value(writer, NAMES, &names)?;
    FIELDS.write_rows(writer, &cells)
}

/// A figure of each face of a case.
fn each<V>(faces: &[CaseFace], of: fn(&CaseFace) -> V) -> Vec<V> {
    faces.iter().map(of).collect()
}
