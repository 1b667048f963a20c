//! Substitution on one supernode, in loops that compilers turn into vector instructions once they are inlined.

use super::factor::Panel;
use super::scalar::Scalar;
use super::unknown::{COLUMNS, Unknown};

impl<T: Scalar> Panel<'_, T> {
    /// Replaces the leading part by its solution with the diagonal block and adds −L_below times it
    /// to the rest.
    #[inline(always)]
    pub(super) fn forward<V: Unknown<T>>(&self, x: &mut [V]) {
        let height = self.rows.len();
        let mut k = 0;
        while k < self.width {
            let block = COLUMNS.min(self.width - k);
            for c in k..k + block {
                let column = &self.values[c * height..(c + 1) * height];
                x[c] = x[c] / column[c];
                let factor = x[c];
                for i in c + 1..k + block {
                    x[i] -= factor * column[i];
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
                        .for_each(|(x, l)| *x -= factor * *l);
                }
            }
            k += block;
        }
    }

    /// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
    #[inline(always)]
    pub(super) fn backward<V: Unknown<T>>(&self, x: &mut [V]) {
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
                let dots = V::four_dots([tail(k), tail(k + 1), tail(k + 2), tail(k + 3)], known);
                unknown[k..]
                    .iter_mut()
                    .zip(dots)
                    .for_each(|(x, dot)| *x -= dot);
            } else {
                for c in k..end {
                    unknown[c] -= V::dot(tail(c), known);
                }
            }
            for c in (k..end).rev() {
                let column = &self.values[c * height..(c + 1) * height];
                let known = V::dot(&column[c + 1..end], &x[c + 1..end]);
                x[c] -= known;
                x[c] = x[c] / column[c];
            }
            end = k;
        }
    }
}

/// y −= Σ columns[k] · factors[k].
#[inline(always)]
fn subtract_four<T: Scalar, V: Unknown<T>>(columns: [&[T]; COLUMNS], factors: &[V], y: &mut [V]) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = [factors[0], factors[1], factors[2], factors[3]];
    for i in 0..n {
        y[i] -= (fa * a[i] + fb * b[i]) + (fc * c[i] + fd * d[i]);
    }
}
