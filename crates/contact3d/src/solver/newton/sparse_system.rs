//! The sparse linear system of one step of Newton's method, for contacts between many bodies.

use super::system::{NewtonSystem, PairRows};
use crate::linalg::{CscMatrix, solve_sparse};

/// The rows of R' that a multiplier's own r enters.
#[derive(Clone, Copy)]
enum Place<'a> {
    /// None: an open contact, or an ellipse that is a point.
    Nowhere,
    /// A row ρ_ν (S d)_ν.
    Normal(usize),
    /// Both rows of a pair, as its component k.
    Pair(&'a PairRows, usize),
}

impl NewtonSystem<'_> {
    /// The Newton equation solved for the free unknowns, the others as they are in `step`; `None` when R' is singular.
    ///
    /// S is sparse, friction follows no slip, and no body floats.
    pub(super) fn solve_sparse(&self, operator: &CscMatrix, step: &[f64]) -> Option<Vec<f64>> {
        let places = self.places(step.len());
        let mut rhs = self.free_rhs();
        for j in self.eliminated(step) {
            for (row, entry) in self.sparse_column(operator, &places, j) {
                rhs[row] -= entry * step[j];
            }
        }
        let mut matrix = CscMatrix::empty(rhs.len());
        matrix.cols = rhs.len();
        for &j in &self.free {
            for (row, entry) in self.sparse_column(operator, &places, j) {
                matrix.indices.push(row);
                matrix.data.push(entry);
            }
            matrix.indptr.push(matrix.indices.len());
        }
        solve_sparse(&matrix, &mut rhs, &mut self.map.sparse_lu.borrow_mut())?;
        Some(rhs)
    }

    fn places(&self, n_unknowns: usize) -> Vec<Place<'_>> {
        let mut places = vec![Place::Nowhere; n_unknowns];
        for at in &self.rows {
            if let Some(row) = at.normal_row {
                places[at.pane] = Place::Normal(row);
            }
            if let Some(pair) = &at.pair {
                for (k, &unknown) in pair.unknowns.iter().enumerate() {
                    places[unknown] = Place::Pair(pair, k);
                }
            }
        }
        places
    }

    /// The coefficients of unknown j, by ascending rows.
    fn sparse_column(
        &self,
        operator: &CscMatrix,
        places: &[Place<'_>],
        j: usize,
    ) -> Vec<(usize, f64)> {
        let steplengths = &self.map.conditions.steplengths;
        let mut entries: Vec<(usize, f64)> = Vec::new();
        let mut add_to_pair = |pair: &PairRows, of: [f64; 2]| {
            entries.extend([(pair.row, of[0]), (pair.row + 1, of[1])]);
        };
        let (rows, values) = operator.column(j);
        let mut normal_entries = Vec::new();
        for (&i, value) in rows.iter().zip(values) {
            let change = steplengths[i] * value;
            match places[i] {
                Place::Nowhere => {}
                Place::Normal(row) => normal_entries.push((row, change)),
                Place::Pair(pair, k) => add_to_pair(pair, pair.by_point.map(|p| p[k] * change)),
            }
        }
        match places[j] {
            Place::Nowhere => {}
            Place::Normal(_) => {
                let layout = self.map.dual.layout;
                let own = layout.tangential(j).map(|[first, _]| places[first]);
                if let Some(Place::Pair(pair, _)) = own {
                    add_to_pair(pair, pair.by_bound.map(|by| -by));
                }
            }
            Place::Pair(pair, k) => {
                let held = if steplengths[j] > 0.0 { 1.0 } else { 0.0 };
                let unit = |row: usize| if row == k { 1.0 } else { 0.0 };
                add_to_pair(
                    pair,
                    [0, 1].map(|row| unit(row) - held * pair.by_point[row][k]),
                );
            }
        }
        entries.extend(normal_entries);
        entries.sort_by_key(|(row, _)| *row);
        entries.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        entries
    }
}
