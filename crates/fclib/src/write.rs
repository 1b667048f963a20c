//! Writing to files that the caller opens, and closes with every error seen.

use std::path::PathBuf;

use hdf5_metno::{
    self as hdf5, H5Type,
    types::{FixedUnicode, VarLenUnicode},
};

use crate::{
    FclibError, FclibSolution, GlobalProblem, Info, LocalProblem, Matrix,
    error::InFile,
    read::{COLUMNS, GLOBAL, GUESSES, LOCAL, PROGRAM, SOLUTION},
};

/// Bytes of a text, the zero at its end included; longer ones are cut off.
const TEXT: usize = 1024;

/// An array that FCLIB does not know, to go with a problem.
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    /// Its name in its group.
    pub name: &'a str,
    /// What it means, in words.
    pub meaning: &'a str,
    /// Its numbers, rows first.
    pub values: &'a [f64],
    /// Numbers in a row; 1 for a vector.
    pub columns: usize,
}

/// Writes a local problem to an empty file, W by compressed columns.
pub fn write_local(file: &hdf5::File, problem: &LocalProblem) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    let dimension = int("components of a contact", problem.space_dimension)?;
    let group = target.group(target.root(), LOCAL)?;
    target.numbers(&group, "spacedim", &[dimension])?;
    target.matrix(&target.group(&group, "W")?, &problem.w, true)?;
    let vectors = target.group(&group, "vectors")?;
    target.numbers(&vectors, "q", &problem.q)?;
    target.numbers(&vectors, "mu", &problem.mu)?;
    target.info(&target.group(&group, "info")?, &problem.info)
}

/// Writes a global problem to an empty file, its matrices as triplets.
pub fn write_global(file: &hdf5::File, problem: &GlobalProblem) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    let dimension = int("components of a contact", problem.space_dimension)?;
    let group = target.group(target.root(), GLOBAL)?;
    target.numbers(&group, "spacedim", &[dimension])?;
    target.matrix(&target.group(&group, "M")?, &problem.m, false)?;
    target.matrix(&target.group(&group, "H")?, &problem.h, false)?;
    let vectors = target.group(&group, "vectors")?;
    target.numbers(&vectors, "f", &problem.f)?;
    target.numbers(&vectors, "w", &problem.w)?;
    target.numbers(&vectors, "mu", &problem.mu)?;
    target.info(&target.group(&group, "info")?, &problem.info)
}

/// Adds `/solution` to a file without one.
pub fn write_solution(file: &hdf5::File, solution: &FclibSolution) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    target.solution(&target.group(target.root(), SOLUTION)?, solution)
}

/// Adds `/guesses` to a file without any.
pub fn write_guesses(file: &hdf5::File, guesses: &[FclibSolution]) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    let group = target.group(target.root(), GUESSES)?;
    target.numbers(
        &group,
        "number_of_guesses",
        &[int("guesses", guesses.len())?],
    )?;
    for (k, guess) in guesses.iter().enumerate() {
        let name = (k + 1).to_string();
        target.solution(&target.group(&group, &name)?, guess)?;
    }
    Ok(())
}

/// Adds further arrays to a group, there or new, which FCLIB's readers pass over.
pub fn write_arrays(
    file: &hdf5::File,
    group: &str,
    arrays: &[Array<'_>],
) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    let group = if file.link_exists(group) {
        file.group(group)
            .in_file(&target.path, || format!("open the group {group}"))?
    } else {
        target.group(target.root(), group)?
    };
    for array in arrays {
        let rows = array.values.len() / array.columns;
        let dataset = match array.columns {
            1 => target.shaped(&group, array.name, array.values, &[rows])?,
            columns => target.shaped(&group, array.name, array.values, &[rows, columns])?,
        };
        target.attribute(&dataset, "meaning", array.meaning)?;
    }
    Ok(())
}

/// Marks a file as written by a program, for [`crate::program_of`].
pub fn write_program(file: &hdf5::File, program: &str) -> Result<(), FclibError> {
    let target = FileWriter::of(file);
    if target.file.attr(PROGRAM).is_ok() {
        let deleted = target.file.delete_attr(PROGRAM);
        deleted.in_file(&target.path, || "replace the mark of a program".into())?;
    }
    target.attribute(target.root(), PROGRAM, program)
}

/// Removes `/solution`, if it is there; its bytes stay in the file.
pub fn remove_solution(file: &hdf5::File) -> Result<(), FclibError> {
    if file.link_exists(SOLUTION) {
        let path = FileWriter::of(file).path;
        let removed = file.unlink(SOLUTION);
        removed.in_file(&path, || format!("remove /{SOLUTION}"))?;
    }
    Ok(())
}

/// A number as files hold it.
fn int(what: &'static str, count: usize) -> Result<i32, FclibError> {
    i32::try_from(count).map_err(|_| FclibError::TooLarge { what, count })
}

/// A file to write to.
struct FileWriter<'a> {
    path: PathBuf,
    file: &'a hdf5::File,
}

impl<'a> FileWriter<'a> {
    fn of(file: &'a hdf5::File) -> Self {
        let path = file.filename().into();
        Self { path, file }
    }

    fn root(&self) -> &'a hdf5::Group {
        self.file
    }

    fn group(&self, parent: &hdf5::Group, name: &str) -> Result<hdf5::Group, FclibError> {
        let group = parent.create_group_builder().obj_track_times(false);
        let group = group.create(name);
        group.in_file(&self.path, || format!("make the group {name}"))
    }

    /// A vector.
    fn numbers<T: H5Type>(
        &self,
        group: &hdf5::Group,
        name: &str,
        values: &[T],
    ) -> Result<(), FclibError> {
        self.shaped(group, name, values, &[values.len()]).map(drop)
    }

    fn shaped<T: H5Type>(
        &self,
        group: &hdf5::Group,
        name: &str,
        values: &[T],
        shape: &[usize],
    ) -> Result<hdf5::Dataset, FclibError> {
        let dataset = group.new_dataset::<T>().obj_track_times(false);
        let dataset = dataset.shape(shape).create(name);
        let written = dataset.and_then(|dataset| {
            dataset.write_raw(values)?;
            Ok(dataset)
        });
        written.in_file(&self.path, || format!("write {}/{name}", group.name()))
    }

    /// Writes a matrix by compressed columns, or as triplets.
    fn matrix(
        &self,
        group: &hdf5::Group,
        matrix: &Matrix,
        by_columns: bool,
    ) -> Result<(), FclibError> {
        let ints = |what, counts: Vec<usize>| -> Result<Vec<i32>, FclibError> {
            counts.into_iter().map(|count| int(what, count)).collect()
        };
        let entries = int("entries", matrix.values.len())?;
        let (nz, p) = if by_columns {
            (COLUMNS, ints("entries", matrix.starts.clone())?)
        } else {
            let columns = matrix.entries().map(|(_, column, _)| column);
            (entries, ints("columns", columns.collect())?)
        };
        self.numbers(group, "nzmax", &[entries])?;
        self.numbers(group, "m", &[int("rows", matrix.rows)?])?;
        self.numbers(group, "n", &[int("columns", matrix.columns)?])?;
        self.numbers(group, "nz", &[nz])?;
        self.numbers(group, "p", &p)?;
        self.numbers(group, "i", &ints("rows", matrix.indices.clone())?)?;
        self.numbers(group, "x", &matrix.values)
    }

    fn solution(&self, group: &hdf5::Group, solution: &FclibSolution) -> Result<(), FclibError> {
        if let Some(v) = &solution.v {
            self.numbers(group, "v", v)?;
        }
        self.numbers(group, "u", &solution.u)?;
        self.numbers(group, "r", &solution.r)
    }

    fn info(&self, group: &hdf5::Group, info: &Info) -> Result<(), FclibError> {
        self.text(group, "title", info.title.as_deref())?;
        self.text(group, "description", info.description.as_deref())?;
        self.text(group, "math_info", info.math_info.as_deref())?;
        let Some(degrees) = info.degrees_of_freedom else {
            return Ok(());
        };
        let degrees = int("degrees of freedom", degrees)?;
        let attribute = group.new_attr::<i32>().shape(1);
        let attribute = attribute.create("numberOfDegreeOfFreedom");
        let written = attribute.and_then(|attribute| attribute.write_raw(&[degrees]));
        written.in_file(&self.path, || {
            "write the number of degrees of freedom".into()
        })
    }

    fn text(&self, group: &hdf5::Group, name: &str, text: Option<&str>) -> Result<(), FclibError> {
        let Some(text) = text else {
            return Ok(());
        };
        // The library reads up to the first zero.
        let mut kept: String = text.chars().filter(|c| *c != '\0').collect();
        while kept.len() >= TEXT {
            kept.pop();
        }
        let fixed = kept.parse::<FixedUnicode<TEXT>>();
        let fixed = fixed.map_err(|error| hdf5::Error::from(error.to_string()));
        let written = fixed.and_then(|text| {
            let dataset = group.new_dataset::<FixedUnicode<TEXT>>();
            let dataset = dataset.obj_track_times(false).create(name)?;
            dataset.write_scalar(&text)
        });
        written.in_file(&self.path, || format!("write {name}"))
    }

    fn attribute(&self, object: &hdf5::Location, name: &str, text: &str) -> Result<(), FclibError> {
        let unicode: Result<VarLenUnicode, _> = text.parse();
        let unicode = unicode.map_err(|error| hdf5::Error::from(format!("{error}")));
        let written = unicode.and_then(|text| {
            let attribute = object.new_attr::<VarLenUnicode>().create(name)?;
            attribute.write_scalar(&text)
        });
        written.in_file(&self.path, || format!("write the attribute {name}"))
    }
}
