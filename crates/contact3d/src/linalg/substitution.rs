//! Substitution on one supernode, in loops that compilers turn into vector instructions once they are inlined.

use super::factor::Panel;
use super::scalar::Scalar;

/// Columns treated together: each entry of the running sums is then loaded once for four
/// coefficients.
const COLUMNS: usize = 4;

impl<T: Scalar> Panel<'_, T> {
    /// Replaces the leading part by its solution with the diagonal block and adds −L_below times it
    /// to the rest.
    #[inline(always)]
    pub(super) fn forward(&self, x: &mut [T]) {
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
                        .for_each(|(x, l)| *x -= *l * factor);
                }
            }
            k += block;
        }
    }

    /// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
    #[inline(always)]
    pub(super) fn backward(&self, x: &mut [T]) {
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
                    unknown[c] -= dot(tail(c), known);
                }
            }
            for c in (k..end).rev() {
                let column = &self.values[c * height..(c + 1) * height];
                x[c] = (x[c] - dot(&column[c + 1..end], &x[c + 1..end])) / column[c];
            }
            end = k;
        }
    }
}

/// Rows treated together.
const LANES: usize = 8;

/// y −= Σ columns[k] · factors[k].
#[inline(always)]
fn subtract_four<T: Scalar>(columns: [&[T]; COLUMNS], factors: &[T], y: &mut [T]) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = [factors[0], factors[1], factors[2], factors[3]];
    for i in 0..n {
        y[i] -= (a[i] * fa + b[i] * fb) + (c[i] * fc + d[i] * fd);
    }
}

/// The four products columns[k]ᵀ y, each summed in interleaved parts.
#[inline(always)]
fn four_dots<T: Scalar>(columns: [&[T]; COLUMNS], y: &[T]) -> [T; COLUMNS] {
    let [a, b, c, d] = columns.map(|column| column[..y.len()].as_chunks::<LANES>());
    let (whole, rest) = y.as_chunks::<LANES>();
    let mut sums = [[T::default(); LANES]; COLUMNS];
    for ((((y, a), b), c), d) in whole.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
        add_products(&mut sums[0], a, y);
        add_products(&mut sums[1], b, y);
        add_products(&mut sums[2], c, y);
        add_products(&mut sums[3], d, y);
    }
    let tails = [a.1, b.1, c.1, d.1];
    std::array::from_fn(|k| {
        let [a, b, c, d, e, f, g, h] = sums[k];
        ((a + b) + (c + d)) + ((e + f) + (g + h)) + dot(tails[k], rest)
    })
}

#[inline(always)]
fn add_products<T: Scalar>(sums: &mut [T; LANES], x: &[T; LANES], y: &[T; LANES]) {
    for i in 0..LANES {
        sums[i] += x[i] * y[i];
    }
}

#[inline(always)]
fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    let mut sum = T::default();
    for (x, y) in x.iter().zip(y) {
        sum += *x * *y;
    }
    sum
}
