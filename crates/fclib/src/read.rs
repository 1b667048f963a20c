//! Reading.

use std::path::Path;

use hdf5_metno::{
    self as hdf5, H5Type,
    types::{FixedAscii, FixedUnicode, TypeDescriptor, VarLenAscii, VarLenUnicode},
};

use runfile::Foreign;

use crate::{FclibError, FclibSolution, GlobalProblem, Info, LocalProblem, Matrix, error::InFile};

/// The attribute of the root that names the program.
pub(crate) const PROGRAM: &str = "program";

/// The groups of problems.
pub(crate) const LOCAL: &str = "fclib_local";
pub(crate) const GLOBAL: &str = "fclib_global";
pub(crate) const SOLUTION: &str = "solution";
pub(crate) const GUESSES: &str = "guesses";

/// What `nz` is of a matrix by compressed columns, and by compressed rows; else it is the number of triplets.
pub(crate) const COLUMNS: i32 = -1;
const ROWS: i32 = -2;

/// Most characters of a text.
const MOST_TEXT: usize = 1 << 16;

/// Bytes of all that may be read of a file, once it is read.
///
/// # Errors
/// A file that cannot be opened, is damaged, or does not hold its own data.
pub fn declared_bytes(path: &Path) -> Result<u64, FclibError> {
    Ok(Source::open(path)?.opened.declared())
}

/// The program that marked an FCLIB file as its own by [`crate::write_program`]; `None` for other files.
#[must_use]
pub fn program_of(path: &Path) -> Option<String> {
    let opened = Foreign::open(path, &[]).ok()?;
    let file = opened.file();
    if !(file.link_exists(LOCAL) || file.link_exists(GLOBAL)) {
        return None;
    }
    let text: VarLenUnicode = file.attr(PROGRAM).ok()?.read_scalar().ok()?;
    Some(text.as_str().to_owned())
}

/// Reads a local problem.
///
/// # Errors
/// [`FclibError`]: what is missing, of another size or type, or of a kind that is not supported (bilateral constraints V, R, s).
pub fn read_local(path: &Path) -> Result<LocalProblem, FclibError> {
    let source = Source::open(path)?;
    if !source.has(LOCAL) {
        return Err(source.no_local_problem());
    }
    for bilateral in ["V", "R"] {
        let part = format!("{LOCAL}/{bilateral}");
        if source.has(&part) {
            return Err(source.unsupported(
                &part,
                "a problem with bilateral constraints (V, R and s)",
                "eliminate them first: W - V R^-1 V' and q - V R^-1 s in place of W and q",
            ));
        }
    }
    let space_dimension = source.count(&format!("{LOCAL}/spacedim"))?;
    let mu = source.vector(&format!("{LOCAL}/vectors/mu"))?;
    let size = source.components(space_dimension, mu.len(), LOCAL)?;
    Ok(LocalProblem {
        space_dimension,
        q: source.vector_of(&format!("{LOCAL}/vectors/q"), size)?,
        w: source.matrix(&format!("{LOCAL}/W"), [size; 2])?,
        mu,
        info: source.info(&format!("{LOCAL}/info"))?,
    })
}

/// Reads a global problem.
///
/// # Errors
/// [`FclibError`]: what is missing, of another size or type, or of a kind that is not supported (equality constraints G, b).
pub fn read_global(path: &Path) -> Result<GlobalProblem, FclibError> {
    let source = Source::open(path)?;
    let equalities = format!("{GLOBAL}/G");
    if source.has(&equalities) {
        let found = "a problem with equality constraints (G and b)";
        return Err(source.unsupported(&equalities, found, "eliminate them first"));
    }
    let space_dimension = source.count(&format!("{GLOBAL}/spacedim"))?;
    let mu = source.vector(&format!("{GLOBAL}/vectors/mu"))?;
    let size = source.components(space_dimension, mu.len(), GLOBAL)?;
    let f = source.vector(&format!("{GLOBAL}/vectors/f"))?;
    Ok(GlobalProblem {
        space_dimension,
        m: source.matrix(&format!("{GLOBAL}/M"), [f.len(); 2])?,
        h: source.matrix(&format!("{GLOBAL}/H"), [f.len(), size])?,
        w: source.vector_of(&format!("{GLOBAL}/vectors/w"), size)?,
        f,
        mu,
        info: source.info(&format!("{GLOBAL}/info"))?,
    })
}

/// Reads the solution with so many components of u and r; `None` where there is none.
pub fn read_solution(path: &Path, components: usize) -> Result<Option<FclibSolution>, FclibError> {
    let source = Source::open(path)?;
    if !source.has(SOLUTION) {
        return Ok(None);
    }
    source.solution(SOLUTION, components).map(Some)
}

/// Reads the guesses with so many components of u and r.
pub fn read_guesses(path: &Path, components: usize) -> Result<Vec<FclibSolution>, FclibError> {
    let source = Source::open(path)?;
    if !source.has(GUESSES) {
        return Ok(Vec::new());
    }
    let count = source.count(&format!("{GUESSES}/number_of_guesses"))?;
    (1..=count)
        .map(|k| source.solution(&format!("{GUESSES}/{k}"), components))
        .collect()
}

/// An open file.
struct Source<'a> {
    path: &'a Path,
    opened: Foreign,
}

impl<'a> Source<'a> {
    /// Opens a file and examines what is read of it.
    fn open(path: &'a Path) -> Result<Self, FclibError> {
        let opened = Foreign::open(path, &[LOCAL, GLOBAL, SOLUTION, GUESSES])?;
        Ok(Self { path, opened })
    }

    /// Whether a path of groups ends at something.
    fn has(&self, path: &str) -> bool {
        self.opened.has(&format!("/{path}"))
    }

    /// A problem that is not supported, by the group or dataset that makes it so.
    fn unsupported(&self, path: &str, found: &str, help: &'static str) -> FclibError {
        FclibError::Unsupported {
            file: self.path.to_owned(),
            path: format!("/{path}"),
            found: found.into(),
            help,
        }
    }

    fn missing(&self, path: &str) -> FclibError {
        FclibError::Missing {
            file: self.path.to_owned(),
            path: format!("/{path}"),
            help: "give a file of FCLIB, such as those of its public collection",
        }
    }

    fn unexpected(&self, path: &str, expected: impl Into<String>, found: String) -> FclibError {
        FclibError::Unexpected {
            file: self.path.to_owned(),
            path: format!("/{path}"),
            expected: expected.into(),
            found,
        }
    }

    /// A file without a local problem, said with what it holds instead.
    fn no_local_problem(&self) -> FclibError {
        let others = [
            (GLOBAL, "a global problem"),
            (
                "fclib_global_rolling",
                "a global problem with rolling friction",
            ),
            (
                "fclib_local_rolling",
                "a local problem with rolling friction",
            ),
        ];
        let other = others.into_iter().find(|(group, _)| self.has(group));
        match other {
            Some((group, found)) => self.unsupported(
                group,
                found,
                "give a file with /fclib_local; W = H' M^-1 H and q = H' M^-1 f + w make a local problem of a global one",
            ),
            None => self.missing(LOCAL),
        }
    }

    fn dataset(&self, path: &str) -> Result<hdf5::Dataset, FclibError> {
        if !self.has(path) {
            return Err(self.missing(path));
        }
        let dataset = self.opened.file().dataset(path);
        dataset.in_file(self.path, || format!("open /{path}"))
    }

    /// Numbers of one type, in however many dimensions.
    fn numbers<T: H5Type>(&self, path: &str, expected: &str) -> Result<Vec<T>, FclibError> {
        let dataset = self.dataset(path)?;
        let descriptor = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
        let descriptor = descriptor.in_file(self.path, || format!("read the type of /{path}"))?;
        let fits = match T::type_descriptor() {
            TypeDescriptor::Integer(_) => {
                matches!(
                    descriptor,
                    TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)
                )
            }
            _ => matches!(descriptor, TypeDescriptor::Float(_)),
        };
        if !fits {
            return Err(self.unexpected(path, expected, format!("{descriptor}")));
        }
        let values = dataset.read_raw::<T>();
        values.in_file(self.path, || format!("read /{path}"))
    }

    /// One whole number.
    fn integer(&self, path: &str) -> Result<i32, FclibError> {
        match self.numbers::<i32>(path, "a whole number")?[..] {
            [value] => Ok(value),
            ref other => {
                let found = format!("{} of them", other.len());
                Err(self.unexpected(path, "one whole number", found))
            }
        }
    }

    /// A whole number that is not negative.
    fn count(&self, path: &str) -> Result<usize, FclibError> {
        let value = self.integer(path)?;
        let found = value.to_string();
        usize::try_from(value).map_err(|_| self.unexpected(path, "a number >= 0", found))
    }

    fn vector(&self, path: &str) -> Result<Vec<f64>, FclibError> {
        self.numbers(path, "floating-point numbers")
    }

    fn vector_of(&self, path: &str, length: usize) -> Result<Vec<f64>, FclibError> {
        let values = self.vector(path)?;
        if values.len() == length {
            Ok(values)
        } else {
            let found = format!("{} numbers", values.len());
            Err(self.unexpected(path, format!("{length} numbers"), found))
        }
    }

    /// Components of u and r at so many contacts.
    fn components(
        &self,
        space_dimension: usize,
        contacts: usize,
        group: &str,
    ) -> Result<usize, FclibError> {
        match space_dimension {
            2 | 3 => Ok(space_dimension * contacts),
            other => {
                Err(self.unexpected(&format!("{group}/spacedim"), "2 or 3", other.to_string()))
            }
        }
    }

    /// A matrix of a size that the vectors of the problem decide: what it declares is believed as little as any other header.
    fn matrix(&self, path: &str, [rows, columns]: [usize; 2]) -> Result<Matrix, FclibError> {
        let declared = [
            self.count(&format!("{path}/m"))?,
            self.count(&format!("{path}/n"))?,
        ];
        if declared != [rows, columns] {
            let expected = format!("{rows} rows and {columns} columns, as the vectors have them");
            let found = format!("{} rows and {} columns", declared[0], declared[1]);
            return Err(self.unexpected(path, expected, found));
        }
        let nz = self.integer(&format!("{path}/nz"))?;
        let p = self.numbers::<i32>(&format!("{path}/p"), "whole numbers")?;
        let i = self.numbers::<i32>(&format!("{path}/i"), "whole numbers")?;
        let x = self.numbers::<f64>(&format!("{path}/x"), "floating-point numbers")?;
        if nz < ROWS {
            let expected = "-1 (compressed columns), -2 (compressed rows) or a number of triplets";
            return Err(self.unexpected(&format!("{path}/nz"), expected, nz.to_string()));
        }
        let found = || {
            format!(
                "{rows} rows, {columns} columns, nz = {nz}, and {}, {} and {} numbers in p, i and x",
                p.len(),
                i.len(),
                x.len()
            )
        };
        let entries = entries([rows, columns], nz, &p, &i, &x);
        let entries = entries.ok_or_else(|| {
            let expected = "arrays p, i and x that describe a sparse matrix";
            self.unexpected(path, expected, found())
        })?;
        Ok(Matrix::from_entries(rows, columns, entries))
    }

    fn solution(&self, path: &str, components: usize) -> Result<FclibSolution, FclibError> {
        let v = format!("{path}/v");
        Ok(FclibSolution {
            v: if self.has(&v) {
                Some(self.vector(&v)?)
            } else {
                None
            },
            u: self.vector_of(&format!("{path}/u"), components)?,
            r: self.vector_of(&format!("{path}/r"), components)?,
        })
    }

    fn info(&self, path: &str) -> Result<Info, FclibError> {
        if !self.has(path) {
            return Ok(Info::default());
        }
        let group = self.opened.file().group(path);
        let group = group.in_file(self.path, || format!("open /{path}"))?;
        let degrees = group.attr("numberOfDegreeOfFreedom").ok();
        let degrees = degrees.filter(|attribute| attribute.size() == 1);
        let degrees = degrees.and_then(|attribute| attribute.read_raw::<i32>().ok());
        let text = |name: &str| {
            let dataset = group.link_exists(name).then(|| group.dataset(name).ok());
            dataset.flatten().and_then(|dataset| text_of(&dataset))
        };
        Ok(Info {
            title: text("title"),
            description: text("description"),
            math_info: text("math_info"),
            degrees_of_freedom: degrees.and_then(|values| usize::try_from(*values.first()?).ok()),
        })
    }
}

/// The entries of a matrix; `None` where its arrays describe none.
fn entries(
    [rows, columns]: [usize; 2],
    nz: i32,
    p: &[i32],
    i: &[i32],
    x: &[f64],
) -> Option<Vec<(usize, usize, f64)>> {
    let at = |value: i32, below: usize| usize::try_from(value).ok().filter(|v| *v < below);
    if let Ok(count) = usize::try_from(nz) {
        let (p, i, x) = (p.get(..count)?, i.get(..count)?, x.get(..count)?);
        let triplets = p.iter().zip(i).zip(x);
        return triplets
            .map(|((&column, &row), &value)| Some((at(row, rows)?, at(column, columns)?, value)))
            .collect();
    }
    let by_rows = nz == ROWS;
    let (lines, across) = if by_rows {
        (rows, columns)
    } else {
        (columns, rows)
    };
    let starts: Vec<usize> = p
        .iter()
        .map(|&start| usize::try_from(start).ok())
        .collect::<Option<_>>()?;
    if starts.len() != lines + 1 || starts[0] != 0 {
        return None;
    }
    let mut entries = Vec::with_capacity(x.len());
    for (line, ends) in starts.windows(2).enumerate() {
        let range = ends[0]..ends[1];
        let (inner, values) = (i.get(range.clone())?, x.get(range)?);
        for (&index, &value) in inner.iter().zip(values) {
            let index = at(index, across)?;
            entries.push(if by_rows {
                (line, index, value)
            } else {
                (index, line, value)
            });
        }
    }
    Some(entries)
}

/// A text of any kind that HDF5 knows; `None` for what is none. Texts only describe, so none of them makes a file unusable.
fn text_of(dataset: &hdf5::Dataset) -> Option<String> {
    let descriptor = dataset.dtype().ok()?.to_descriptor().ok()?;
    match descriptor {
        TypeDescriptor::VarLenUnicode => {
            let text = dataset.read_scalar::<VarLenUnicode>().ok()?;
            Some(text.as_str().to_owned())
        }
        TypeDescriptor::VarLenAscii => {
            let text = dataset.read_scalar::<VarLenAscii>().ok()?;
            Some(text.as_str().to_owned())
        }
        TypeDescriptor::FixedAscii(length) if length <= MOST_TEXT => {
            let text = dataset.read_scalar::<FixedAscii<MOST_TEXT>>().ok()?;
            Some(fixed(text.as_bytes()))
        }
        TypeDescriptor::FixedUnicode(length) if length <= MOST_TEXT => {
            let text = dataset.read_scalar::<FixedUnicode<MOST_TEXT>>().ok()?;
            Some(fixed(text.as_bytes()))
        }
        _ => None,
    }
}

fn fixed(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0);
    String::from_utf8_lossy(&bytes[..end.unwrap_or(bytes.len())]).into_owned()
}
