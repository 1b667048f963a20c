//! Problems with their sparse matrices, solutions, and what is said about them.

/// A sparse matrix by compressed columns, row indices strictly increasing inside each column.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Start of each column in `indices` and `values`, `[columns + 1]`.
    pub starts: Vec<usize>,
    /// Row of each entry.
    pub indices: Vec<usize>,
    /// Each entry.
    pub values: Vec<f64>,
}

impl Matrix {
    /// From entries (row, column, value) in any order; those at the same place are added.
    ///
    /// # Panics
    /// Where an entry lies outside.
    #[must_use]
    pub fn from_entries(
        rows: usize,
        columns: usize,
        mut entries: Vec<(usize, usize, f64)>,
    ) -> Self {
        entries.sort_by_key(|&(row, column, _)| (column, row));
        let mut matrix = Self {
            rows,
            columns,
            starts: vec![0; columns + 1],
            indices: Vec::with_capacity(entries.len()),
            values: Vec::with_capacity(entries.len()),
        };
        let mut last = None;
        for (row, column, value) in entries {
            assert!(
                row < rows && column < columns,
                "an entry outside its matrix"
            );
            if last == Some((row, column)) {
                *matrix.values.last_mut().expect("an entry before") += value;
                continue;
            }
            last = Some((row, column));
            matrix.indices.push(row);
            matrix.values.push(value);
            matrix.starts[column + 1] += 1;
        }
        for column in 0..columns {
            matrix.starts[column + 1] += matrix.starts[column];
        }
        matrix
    }

    /// The entries (row, column, value), column after column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.columns).flat_map(move |column| {
            let range = self.starts[column]..self.starts[column + 1];
            range.map(move |k| (self.indices[k], column, self.values[k]))
        })
    }
}

/// What a file says about its problem.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Info {
    /// Title.
    pub title: Option<String>,
    /// Where the problem comes from.
    pub description: Option<String>,
    /// What is known of its solutions.
    pub math_info: Option<String>,
    /// Degrees of freedom of the bodies, an attribute of the group.
    pub degrees_of_freedom: Option<usize>,
}

/// A problem in the unknowns of its contacts alone: u = W r + q with Coulomb's law between u and r.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalProblem {
    /// Components of u and r at each contact: 2 or 3, the normal one first.
    pub space_dimension: usize,
    /// W, symmetric and positive semidefinite, `[d n, d n]` for n contacts.
    pub w: Matrix,
    /// q, `[d n]`.
    pub q: Vec<f64>,
    /// Coefficients of friction, `[n]`.
    pub mu: Vec<f64>,
    /// What the file says about it.
    pub info: Info,
}

/// A problem with the degrees of freedom of its bodies: M v = H r + f, u = Hᵀ v + w with Coulomb's law between u and r.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalProblem {
    /// Components of u and r at each contact: 2 or 3, the normal one first.
    pub space_dimension: usize,
    /// M, symmetric and positive definite, `[m, m]`.
    pub m: Matrix,
    /// H, `[m, d n]` for n contacts.
    pub h: Matrix,
    /// f, `[m]`.
    pub f: Vec<f64>,
    /// w, `[d n]`.
    pub w: Vec<f64>,
    /// Coefficients of friction, `[n]`.
    pub mu: Vec<f64>,
    /// What the file says about it.
    pub info: Info,
}

/// A solution or a guess.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FclibSolution {
    /// v, `[m]`; `None` for a local problem.
    pub v: Option<Vec<f64>>,
    /// u, `[d n]`.
    pub u: Vec<f64>,
    /// r, `[d n]`.
    pub r: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_sorted_and_those_at_one_place_added() {
        let matrix = Matrix::from_entries(
            2,
            3,
            vec![(1, 2, 5.0), (0, 0, 1.0), (1, 2, -2.0), (1, 0, 4.0)],
        );
        assert_eq!(matrix.starts, [0, 2, 2, 3]);
        assert_eq!(matrix.indices, [0, 1, 1]);
        assert_eq!(matrix.values, [1.0, 4.0, 3.0]);
        let entries: Vec<_> = matrix.entries().collect();
        assert_eq!(entries, [(0, 0, 1.0), (1, 0, 4.0), (1, 2, 3.0)]);
    }
}
