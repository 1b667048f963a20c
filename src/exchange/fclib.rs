//! Files of FCLIB, the Friction Contact Library: frictional contact problems, their solutions and guesses, in HDF5.
//!
//! V. Acary, M. Brémond, T. Koziara, F. Pérignon, *FCLIB: a collection of discrete 3D frictional contact problems*, INRIA
//! RT-0444 (2014).
//!
//! * `/fclib_local` or `/fclib_global`: the problem, components N, T1, T2 contact after contact;
//! * `/solution` and `/guesses/1`: v, u and r.
//!
//! Whole numbers are 32-bit. A matrix has `nz` = −1 by compressed columns and otherwise `nz` triplets, of which `p` holds columns and
//! `i` rows, as the library's own code has it (the comment in its header says the opposite). Its reader of global problems takes
//! triplets only.

use contact3d::linalg::CscMatrix;
use hdf5_metno::{
    Error, File, Group, H5Type, Location, Result,
    types::{FixedUnicode, VarLenUnicode},
};

use super::frozen::{Equations, FrozenProblem, SPACE_DIMENSION};

/// Bytes of a text, the zero at its end included, in the library's reader; longer ones are cut off.
const INFO_TEXT_BYTES: usize = 1024;

/// Forces of a problem and what they lead to.
pub(super) struct FclibSolution {
    /// v, `[m]`; `None` for a local problem.
    pub(super) v: Option<Vec<f64>>,
    /// u, `[3 n]`.
    pub(super) u: Vec<f64>,
    /// r, `[3 n]`.
    pub(super) r: Vec<f64>,
}

/// The most entries of a matrix, which 32-bit indices have to count.
pub(super) fn most_entries(problem: &FrozenProblem) -> usize {
    match &problem.equations {
        Equations::Local { w, .. } => w.data.len(),
        Equations::Global { m, h, .. } => m.data.len().max(h.data.len()),
    }
}

/// Writes a problem whose entries 32-bit indices count to an empty file, with texts about it by their names and the degrees of freedom of
/// the body.
pub(super) fn write_problem(
    file: &File,
    problem: &FrozenProblem,
    info: [(&str, &str); 3],
    degrees_of_freedom: usize,
) -> Result<()> {
    let name = match &problem.equations {
        Equations::Local { .. } => "fclib_local",
        Equations::Global { .. } => "fclib_global",
    };
    let group = &new_group(file, name)?;
    write(group, "spacedim", &[SPACE_DIMENSION as i32])?;
    let vectors = match &problem.equations {
        Equations::Local { w, q } => {
            write_matrix(&new_group(group, "W")?, w, -1, &w.indptr)?;
            vec![("q", q)]
        }
        Equations::Global { m, h, f, w, .. } => {
            write_triplets(&new_group(group, "M")?, m)?;
            write_triplets(&new_group(group, "H")?, h)?;
            vec![("f", f), ("w", w)]
        }
    };
    let vector_group = new_group(group, "vectors")?;
    for (name, values) in vectors.into_iter().chain([("mu", &problem.scaling.mu)]) {
        write(&vector_group, name, values)?;
    }
    let group = &new_group(group, "info")?;
    for (name, text) in info {
        write_text(group, name, text)?;
    }
    let attribute = group.new_attr::<i32>().shape(1);
    let attribute = attribute.create("numberOfDegreeOfFreedom")?;
    attribute.write_raw(&[degrees_of_freedom as i32])
}

/// Adds `/solution` and, as its only guess, a start.
pub(super) fn write_solutions(
    file: &File,
    solution: &FclibSolution,
    start: &FclibSolution,
) -> Result<()> {
    write_solution(&new_group(file, "solution")?, solution)?;
    let guesses = new_group(file, "guesses")?;
    write(&guesses, "number_of_guesses", &[1])?;
    write_solution(&new_group(&guesses, "1")?, start)
}

fn write_solution(group: &Group, solution: &FclibSolution) -> Result<()> {
    if let Some(v) = &solution.v {
        write(group, "v", v)?;
    }
    write(group, "u", &solution.u)?;
    write(group, "r", &solution.r)
}

/// Makes a group.
pub(super) fn new_group(parent: &Group, name: &str) -> Result<Group> {
    let group = parent.create_group_builder().obj_track_times(false);
    group.create(name)
}

/// Adds an array with rows of so many numbers, and its meaning, which FCLIB's readers pass over.
pub(super) fn write_array(
    group: &Group,
    name: &str,
    meaning: &str,
    values: &[f64],
    columns: usize,
) -> Result<()> {
    let dataset = group.new_dataset::<f64>().obj_track_times(false);
    let dataset = match columns {
        1 => dataset.shape(values.len()),
        columns => dataset.shape((values.len() / columns, columns)),
    };
    let dataset = dataset.create(name)?;
    dataset.write_raw(values)?;
    write_attribute(&dataset, "meaning", meaning)
}

/// Adds a text as an attribute.
pub(super) fn write_attribute(object: &Location, name: &str, text: &str) -> Result<()> {
    let text: VarLenUnicode = text
        .parse()
        .map_err(|error| Error::from(format!("{error}")))?;
    object
        .new_attr::<VarLenUnicode>()
        .create(name)?
        .write_scalar(&text)
}

fn write<T: H5Type>(group: &Group, name: &str, values: &[T]) -> Result<()> {
    let dataset = group.new_dataset::<T>().obj_track_times(false);
    dataset.shape(values.len()).create(name)?.write_raw(values)
}

fn write_triplets(group: &Group, matrix: &CscMatrix) -> Result<()> {
    let columns = (0..matrix.cols).flat_map(|column| {
        let entries = matrix.indptr[column]..matrix.indptr[column + 1];
        entries.map(move |_| column)
    });
    let columns: Vec<usize> = columns.collect();
    write_matrix(group, matrix, matrix.data.len() as i32, &columns)
}

/// A matrix whose array `p` is given, with the `nz` that says what it is.
fn write_matrix(group: &Group, matrix: &CscMatrix, nz: i32, p: &[usize]) -> Result<()> {
    let ints = |counts: &[usize]| counts.iter().map(|count| *count as i32).collect::<Vec<_>>();
    write(group, "nzmax", &[matrix.data.len() as i32])?;
    write(group, "m", &[matrix.rows as i32])?;
    write(group, "n", &[matrix.cols as i32])?;
    write(group, "nz", &[nz])?;
    write(group, "p", &ints(p))?;
    write(group, "i", &ints(&matrix.indices))?;
    write(group, "x", &matrix.data)
}

fn write_text(group: &Group, name: &str, text: &str) -> Result<()> {
    // The library reads up to the first zero.
    let mut kept: String = text.chars().filter(|c| *c != '\0').collect();
    while kept.len() >= INFO_TEXT_BYTES {
        kept.pop();
    }
    let fixed = kept.parse::<FixedUnicode<INFO_TEXT_BYTES>>();
    let fixed = fixed.map_err(|error| Error::from(error.to_string()))?;
    let dataset = group.new_dataset::<FixedUnicode<INFO_TEXT_BYTES>>();
    dataset
        .obj_track_times(false)
        .create(name)?
        .write_scalar(&fixed)
}
