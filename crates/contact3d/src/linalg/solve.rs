//! Forward and backward substitution with one right-hand side.

use super::factor::{CholeskyFactor, Panel};

/// Columns treated together: each entry of the running sums is then loaded once for four
/// coefficients.
const COLUMNS: usize = 4;

/// Memory of a solve, kept between calls.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// The right-hand side, later the solution, in the new numbering.
    pub(super) permuted: Vec<f64>,
    /// The part of it that one supernode touches.
    panel: Vec<f64>,
}

impl CholeskyFactor {
    /// Solves A x = b in place: x = Pᵀ L⁻ᵀ L⁻¹ P b, on one thread.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown.
    pub fn solve_in_place(&self, rhs: &mut [f64], work: &mut Workspace) {
        assert_eq!(rhs.len(), self.size(), "length of the right-hand side");
        work.permuted.clear();
        work.permuted
            .extend(self.permutation.iter().map(|&old| rhs[old]));
        self.forward(0..self.supernodes(), work);
        self.backward((0..self.supernodes()).rev(), work);
        for (&old, &value) in self.permutation.iter().zip(&work.permuted) {
            rhs[old] = value;
        }
    }

    /// L⁻¹ on `work.permuted` over the given ascending supernodes.
    pub(super) fn forward(&self, supernodes: impl Iterator<Item = usize>, work: &mut Workspace) {
        for s in supernodes {
            let panel = self.panel(s);
            let (own, below) = panel.rows.split_at(panel.width);
            let sums = &mut work.panel;
            sums.clear();
            sums.extend_from_slice(&work.permuted[panel.first..panel.first + own.len()]);
            sums.resize(panel.rows.len(), 0.0);
            panel.forward(sums);
            work.permuted[panel.first..panel.first + own.len()].copy_from_slice(&sums[..own.len()]);
            for (&row, &sum) in below.iter().zip(&sums[own.len()..]) {
                work.permuted[row] += sum;
            }
        }
    }

    /// L⁻ᵀ on `work.permuted` over the given descending supernodes.
    pub(super) fn backward(&self, supernodes: impl Iterator<Item = usize>, work: &mut Workspace) {
        for s in supernodes {
            let panel = self.panel(s);
            let known = &mut work.panel;
            known.clear();
            known.extend(panel.rows.iter().map(|&row| work.permuted[row]));
            panel.backward(known);
            work.permuted[panel.first..panel.first + panel.width]
                .copy_from_slice(&known[..panel.width]);
        }
    }
}

impl Panel<'_> {
    /// Replaces the leading part by its solution with the diagonal block and adds −L_below times it
    /// to the rest.
    fn forward(&self, x: &mut [f64]) {
        let height = self.rows.len();
        let mut k = 0;
        while k < self.width {
            let block = COLUMNS.min(self.width - k);
            for c in k..k + block {
                let column = &self.values[c * height..(c + 1) * height];
                x[c] /= column[c];
                let factor = x[c];
                for i in c + 1..k + block {
                    x[i] -= column[i] * factor;
                }
            }
            let (solved, rest) = x.split_at_mut(k + block);
            let tail = |c: usize| &self.values[c * height + k + block..(c + 1) * height];
            if block == COLUMNS {
                subtract_four(
                    [tail(k), tail(k + 1), tail(k + 2), tail(k + 3)],
                    &solved[k..],
                    rest,
                );
            } else {
                for c in k..k + block {
                    let factor = solved[c];
                    rest.iter_mut()
                        .zip(tail(c))
                        .for_each(|(x, l)| *x -= l * factor);
                }
            }
            k += block;
        }
    }

    /// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
    fn backward(&self, x: &mut [f64]) {
        let height = self.rows.len();
        let mut end = self.width;
        while end > 0 {
            // the incomplete block comes last in the forward pass, so first here
            let block = if end.is_multiple_of(COLUMNS) {
                COLUMNS
            } else {
                end % COLUMNS
            };
            let k = end - block;
            let (unknown, known) = x.split_at_mut(end);
            let tail = |c: usize| &self.values[c * height + end..(c + 1) * height];
            if block == COLUMNS {
                let dots = four_dots([tail(k), tail(k + 1), tail(k + 2), tail(k + 3)], known);
                unknown[k..]
                    .iter_mut()
                    .zip(dots)
                    .for_each(|(x, dot)| *x -= dot);
            } else {
                for c in k..end {
                    unknown[c] -= tail(c).iter().zip(&*known).map(|(l, x)| l * x).sum::<f64>();
                }
            }
            for c in (k..end).rev() {
                let column = &self.values[c * height..(c + 1) * height];
                let dot: f64 = (c + 1..end).map(|i| column[i] * x[i]).sum();
                x[c] = (x[c] - dot) / column[c];
            }
            end = k;
        }
    }
}

/// y −= Σ columns[k] · factors[k].
fn subtract_four(columns: [&[f64]; COLUMNS], factors: &[f64], y: &mut [f64]) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = [factors[0], factors[1], factors[2], factors[3]];
    for i in 0..n {
        y[i] -= (a[i] * fa + b[i] * fb) + (c[i] * fc + d[i] * fd);
    }
}

/// The four products columns[k]ᵀ y, each summed in four interleaved parts.
fn four_dots(columns: [&[f64]; COLUMNS], y: &[f64]) -> [f64; COLUMNS] {
    const LANES: usize = 4;
    let mut sums = [[0.0; LANES]; COLUMNS];
    let n = y.len();
    let columns = columns.map(|column| &column[..n]);
    let whole = n - n % LANES;
    for i in (0..whole).step_by(LANES) {
        for k in 0..COLUMNS {
            for lane in 0..LANES {
                sums[k][lane] += columns[k][i + lane] * y[i + lane];
            }
        }
    }
    std::array::from_fn(|k| {
        let [a, b, c, d] = sums[k];
        let rest: f64 = columns[k][whole..]
            .iter()
            .zip(&y[whole..])
            .map(|(l, x)| l * x)
            .sum();
        (a + b) + (c + d) + rest
    })
}
