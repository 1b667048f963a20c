//! The error as one problem in the bubbles of all elements.
//!
//! The bubbles of neighbours are joined to continuous functions: two of each edge and one of each side. In their space e solves
//! a(e, v) = ∫ f·v + ∫ t̄·v − a(u_h, v) for all v (R. Bank, R. K. Smith, SIAM J. Numer. Anal. 30 (1993) 921), by conjugate gradients
//! scaled by the diagonal. Nothing is averaged between tetrahedra, and none is alone: the shape of cells hardly matters, and e
//! is always smaller than the error ([`ENERGY_FRACTION`]).

use std::{array::from_fn, collections::HashMap};

use rayon::prelude::*;

use super::{
    Field,
    bubbles::{BUBBLE_COMPONENTS, BUBBLES, BubbleElement, BubbleElements, BubbleVector, CUBIC},
};
use crate::{
    linalg::vectorised,
    mesh::{Mesh, sorted},
    reference::{TETRAHEDRON_EDGES, TETRAHEDRON_SIDES},
};

/// Fraction of the squared error that is in the bubbles: on cells of 1 : 1 to 1 : 100 it was 0.61 to 0.71 where edges of the body
/// decide, 0.52 to 0.94 where the solution is smooth (docs/explanation/errors.md).
const ENERGY_FRACTION: f64 = 0.7;

/// Fields that are solved for side by side; a multiple of what a register holds.
const FIELD_LANES: usize = 8;

/// Rows of one partial sum, whatever the number of threads.
const SUMMED_ROWS: usize = 4096;

/// Numbers of all fields, side by side.
type Lanes = [f32; FIELD_LANES];

/// Where the bubbles of tetrahedra stand among all.
struct BubbleNumbering {
    /// Bubbles of each tetrahedron, `[n_tetrahedra]`.
    of: Vec<[usize; BUBBLES]>,
    /// −1 for the first bubbles of edges that run from the larger node to the smaller, `[n_tetrahedra]`.
    sign: Vec<[f32; 6]>,
    /// The boundary triangle opposite to each corner, `[n_tetrahedra]`.
    facets: Vec<[Option<usize>; 4]>,
    /// All of them.
    n_bubbles: usize,
}

impl BubbleNumbering {
    fn new(mesh: &Mesh) -> Self {
        let n_tetrahedra = mesh.tetrahedra.len();
        let mut it = Self {
            of: vec![[0; BUBBLES]; n_tetrahedra],
            sign: vec![[1.0; 6]; n_tetrahedra],
            facets: vec![[None; 4]; n_tetrahedra],
            n_bubbles: 0,
        };
        let mut of_edge = vec![usize::MAX; mesh.coordinates.len()];
        for (t, corners) in mesh.tetrahedra.iter().enumerate() {
            for (k, middle) in mesh.tetrahedron_nodes(t).skip(4).enumerate() {
                if of_edge[middle] == usize::MAX {
                    of_edge[middle] = it.n_bubbles;
                    it.n_bubbles += 2;
                }
                it.of[t][k] = of_edge[middle];
                it.of[t][CUBIC + k] = of_edge[middle] + 1;
                let [a, b] = TETRAHEDRON_EDGES[k];
                if corners[a] > corners[b] {
                    it.sign[t][k] = -1.0;
                }
            }
        }
        let mut sides: Vec<([usize; 3], usize, usize)> = (0..n_tetrahedra)
            .flat_map(|t| (0..4).map(move |k| (t, k)))
            .map(|(t, k)| {
                (
                    sorted(TETRAHEDRON_SIDES[k].map(|c| mesh.tetrahedra[t][c])),
                    t,
                    k,
                )
            })
            .collect();
        sides.par_sort_unstable();
        let facets: HashMap<[usize; 3], usize> = (0..mesh.facets.len())
            .map(|f| (sorted(mesh.facets[f]), f))
            .collect();
        for shared in sides.chunk_by(|a, b| a.0 == b.0) {
            for &(nodes, t, k) in shared {
                it.of[t][6 + k] = it.n_bubbles;
                if shared.len() == 1 {
                    it.facets[t][k] = facets.get(&nodes).copied();
                }
            }
            it.n_bubbles += 1;
        }
        it
    }

    /// The sign of a component of a tetrahedron's bubbles.
    fn sign(&self, t: usize, component: usize) -> f32 {
        *self.sign[t].get(component / 3).unwrap_or(&1.0)
    }

    /// The place of a component of a tetrahedron's bubbles among all.
    fn place(&self, t: usize, component: usize) -> usize {
        3 * self.of[t][component / 3] + component % 3
    }
}

/// The errors of fields in the bubbles.
pub(super) struct HierarchicalErrors {
    /// a_T(e, e_k) of the error e of the first field and that e_k of each, in J for the first itself, as if the bubbles saw all of
    /// it, `[n_tetrahedra][n_fields]`.
    pub(super) products: Vec<Vec<f64>>,
    /// Coefficients of the bubbles in units of `scale` and `size`, `[3 n_bubbles]`.
    scaled: Vec<Lanes>,
    /// D^−½, `[3 n_bubbles]`.
    scale: Vec<f64>,
    /// The largest scaled load of each field.
    size: Vec<f64>,
    numbering: BubbleNumbering,
    /// a(e, e) of each field in J, likewise, `[n_fields]`.
    pub(super) energies: Vec<f64>,
}

impl HierarchicalErrors {
    pub(super) fn new(mesh: &Mesh, elements: &BubbleElements<'_>, fields: &[Field<'_>]) -> Self {
        assert!(
            fields.len() <= FIELD_LANES,
            "an answer has fewer quantities"
        );
        let numbering = BubbleNumbering::new(mesh);
        let tetrahedra = 0..mesh.tetrahedra.len();
        let parts = tetrahedra.clone().into_par_iter().map(|t| {
            let element = elements.element(t, numbering.facets[t], fields);
            ElementPart::new(element, |i| f64::from(numbering.sign(t, i)))
        });
        let parts: Vec<ElementPart> = parts.collect();
        let scale = scales(&numbering, &parts);
        let (right, size) = scaled_loads(&numbering, &parts, &scale, fields.len());
        let stiffness = ScaledStiffness::new(&numbering, &scale, parts);
        let (scaled, energies) = stiffness.solve(right);
        let energies = energies.iter().zip(&size);
        let energies = energies
            .map(|(energy, size)| energy * size * size / ENERGY_FRACTION)
            .collect();
        let products = tetrahedra.into_par_iter().map(|t| {
            let local = stiffness.gathered(t, &scaled);
            let forces = vectorised(
                #[inline(always)]
                || stiffness.product(t, &local),
            );
            let of = |lane: usize| -> f64 {
                let terms = local.iter().zip(&forces);
                let sum: f64 = terms
                    .map(|(e, f)| f64::from(e[lane]) * f64::from(f[0]))
                    .sum();
                sum * size[lane] * size[0] / ENERGY_FRACTION
            };
            let mut products: Vec<f64> = (0..size.len()).map(of).collect();
            products[0] = products[0].max(0.0);
            products
        });
        Self {
            products: products.collect(),
            scaled,
            scale,
            size,
            numbering,
            energies,
        }
    }

    /// The error of a field in a tetrahedron, likewise.
    pub(super) fn field(&self, t: usize, field: usize) -> BubbleVector {
        BubbleVector::from_fn(|i, _| {
            let place = self.numbering.place(t, i);
            let scaled = f64::from(self.numbering.sign(t, i) * self.scaled[place][field]);
            scaled * self.scale[place] * self.size[field] / ENERGY_FRACTION.sqrt()
        })
    }
}

/// What a tetrahedron adds, its bubbles with the signs of all.
struct ElementPart {
    /// Over `size`.
    stiffness: LocalMatrix,
    size: f64,
    diagonal: BubbleVector,
    loads: Vec<BubbleVector>,
    held: [bool; BUBBLE_COMPONENTS],
}

/// Rows of a local matrix that are multiplied together: each of their sums stays in a register.
const MATRIX_ROWS: usize = 8;

/// The columns of eight rows, then those of the next eight: `[component / 8][component][component % 8]`.
type LocalMatrix = [[[f32; MATRIX_ROWS]; BUBBLE_COMPONENTS]; BUBBLE_COMPONENTS / MATRIX_ROWS];

impl ElementPart {
    fn new(element: BubbleElement, sign: impl Fn(usize) -> f64) -> Self {
        let BubbleElement {
            stiffness,
            mut loads,
            held,
        } = element;
        let signs = BubbleVector::from_fn(|i, _| sign(i));
        for load in &mut loads {
            load.component_mul_assign(&signs);
        }
        let diagonal = stiffness.diagonal();
        let size = diagonal.max();
        let entry = |i: usize, j: usize| (signs[i] * stiffness[(i, j)] * signs[j] / size) as f32;
        Self {
            stiffness: from_fn(|block| {
                from_fn(|column| from_fn(|row| entry(MATRIX_ROWS * block + row, column)))
            }),
            size,
            diagonal,
            loads,
            held,
        }
    }
}

/// D^−½, zero at what is held, `[3 n_bubbles]`.
fn scales(numbering: &BubbleNumbering, parts: &[ElementPart]) -> Vec<f64> {
    let mut scale = vec![0.0; 3 * numbering.n_bubbles];
    for (t, part) in parts.iter().enumerate() {
        (0..BUBBLE_COMPONENTS).for_each(|i| scale[numbering.place(t, i)] += part.diagonal[i]);
    }
    scale.iter_mut().for_each(|d| *d = d.sqrt().recip());
    for (t, part) in parts.iter().enumerate() {
        for i in (0..BUBBLE_COMPONENTS).filter(|&i| part.held[i]) {
            scale[numbering.place(t, i)] = 0.0;
        }
    }
    scale
}

/// D^−½ times the loads over the largest of each field, and these.
fn scaled_loads(
    numbering: &BubbleNumbering,
    parts: &[ElementPart],
    scale: &[f64],
    n_fields: usize,
) -> (Vec<Lanes>, Vec<f64>) {
    let mut right = vec![[0.0; FIELD_LANES]; scale.len()];
    let mut sizes = Vec::with_capacity(n_fields);
    for lane in 0..n_fields {
        let mut load = vec![0.0; scale.len()];
        for (t, part) in parts.iter().enumerate() {
            for (i, of) in part.loads[lane].iter().enumerate() {
                let place = numbering.place(t, i);
                load[place] += of * scale[place];
            }
        }
        let largest = load.iter().fold(0.0, |most: f64, l| most.max(l.abs()));
        if largest > 0.0 {
            let all = right.iter_mut().zip(&load);
            all.for_each(|(right, load)| right[lane] = (load / largest) as f32);
        }
        sizes.push(largest);
    }
    (right, sizes)
}

/// D^−½ K D^−½ by its elements, with the diagonal D of K; zero at what is held.
struct ScaledStiffness<'a> {
    numbering: &'a BubbleNumbering,
    /// `[n_tetrahedra]`.
    elements: Vec<LocalMatrix>,
    /// Where the parts of each component begin and end, `[3 n_bubbles + 1]`.
    first: Vec<u32>,
    /// Components of elements, all in a row, that add up to each component, `[48 n_tetrahedra]`.
    parts: Vec<u32>,
}

impl<'a> ScaledStiffness<'a> {
    fn new(numbering: &'a BubbleNumbering, scale: &[f64], parts: Vec<ElementPart>) -> Self {
        let n_elements = parts.len();
        let place =
            |part: usize| numbering.place(part / BUBBLE_COMPONENTS, part % BUBBLE_COMPONENTS);
        let mut first = vec![0; scale.len() + 1];
        (0..n_elements * BUBBLE_COMPONENTS).for_each(|part| first[place(part) + 1] += 1);
        for k in 0..scale.len() {
            first[k + 1] += first[k];
        }
        let (mut next, mut sorted) = (first.clone(), vec![0; n_elements * BUBBLE_COMPONENTS]);
        for part in 0..n_elements * BUBBLE_COMPONENTS {
            let next = &mut next[place(part)];
            sorted[*next as usize] = part as u32;
            *next += 1;
        }
        let element = |(t, part): (usize, ElementPart)| {
            let size = part.size.sqrt();
            let factor: [f32; BUBBLE_COMPONENTS] =
                from_fn(|i| (size * scale[numbering.place(t, i)]) as f32);
            let mut matrix = part.stiffness;
            for (block, rows) in matrix.iter_mut().zip(factor.as_chunks::<MATRIX_ROWS>().0) {
                for (column, by) in block.iter_mut().zip(factor) {
                    let all = column.iter_mut().zip(rows);
                    all.for_each(|(entry, factor)| *entry *= by * factor);
                }
            }
            matrix
        };
        Self {
            numbering,
            elements: parts.into_par_iter().enumerate().map(element).collect(),
            first,
            parts: sorted,
        }
    }

    fn gathered(&self, t: usize, all: &[Lanes]) -> [Lanes; BUBBLE_COMPONENTS] {
        from_fn(|i| all[self.numbering.place(t, i)])
    }

    #[inline(always)]
    fn product(&self, t: usize, local: &[Lanes; BUBBLE_COMPONENTS]) -> [Lanes; BUBBLE_COMPONENTS] {
        let mut product = [[0.0; FIELD_LANES]; BUBBLE_COMPONENTS];
        let sums = product.as_chunks_mut::<MATRIX_ROWS>().0;
        for (sums, columns) in sums.iter_mut().zip(&self.elements[t]) {
            for (column, lanes) in columns.iter().zip(local) {
                for (sum, entry) in sums.iter_mut().zip(column) {
                    (0..FIELD_LANES).for_each(|l| sum[l] = entry.mul_add(lanes[l], sum[l]));
                }
            }
        }
        product
    }

    /// The product with all lanes; `of_elements` is room for its parts.
    fn times(
        &self,
        all: &[Lanes],
        of_elements: &mut Vec<[Lanes; BUBBLE_COMPONENTS]>,
        result: &mut Vec<Lanes>,
    ) {
        let tetrahedra = (0..self.elements.len()).into_par_iter();
        let product = |t| {
            vectorised(
                #[inline(always)]
                || self.product(t, &self.gathered(t, all)),
            )
        };
        tetrahedra.map(product).collect_into_vec(of_elements);
        let of_elements = of_elements.as_flattened();
        result.resize(all.len(), [0.0; FIELD_LANES]);
        let blocks = result.par_chunks_mut(SUMMED_ROWS).enumerate();
        blocks.for_each(|(block, result)| {
            vectorised(
                #[inline(always)]
                || {
                    for (place, sum) in (block * SUMMED_ROWS..).zip(result) {
                        let [first, end] = [place, place + 1].map(|at| self.first[at] as usize);
                        *sum = [0.0; FIELD_LANES];
                        for &part in &self.parts[first..end] {
                            let part = &of_elements[part as usize];
                            (0..FIELD_LANES).for_each(|l| sum[l] += part[l]);
                        }
                    }
                },
            );
        });
    }

    /// Conjugate gradients for every lane on its own, from zero, with the energies of the solutions; what one lane comes to does not
    /// depend on the others.
    ///
    /// They end when four steps together gain less than 0.2 % of the squared error, since an estimate within a percent serves: cubes take
    /// ten steps, cells of 1 : 100 some three hundred. After 500 the error found so far is the estimate: energies only grow from step to
    /// step, so it is too small rather than too large.
    fn solve(&self, mut residual: Vec<Lanes>) -> (Vec<Lanes>, [f64; FIELD_LANES]) {
        let mut solution = vec![[0.0; FIELD_LANES]; residual.len()];
        let mut direction = residual.clone();
        let (mut of_elements, mut image) = (Vec::new(), Vec::new());
        let mut squares = dots(&residual, &residual);
        let mut energy = [0.0; FIELD_LANES];
        let mut gains: Vec<[f64; FIELD_LANES]> = Vec::new();
        let mut goes_on = [true; FIELD_LANES];
        while gains.len() < 500 {
            self.times(&direction, &mut of_elements, &mut image);
            let length = quotients(squares, dots(&direction, &image));
            let length = from_fn(|l| if goes_on[l] { length[l] } else { 0.0 });
            let gain: [f64; FIELD_LANES] = from_fn(|l| length[l] * squares[l]);
            (0..FIELD_LANES).for_each(|l| energy[l] += gain[l]);
            gains.push(gain);
            add(&mut solution, length, &direction);
            let last = &gains[gains.len().saturating_sub(4)..];
            let gained = |l: usize| last.iter().map(|gain| gain[l]).sum::<f64>();
            if last.len() == 4 {
                goes_on = from_fn(|l| goes_on[l] && gained(l) > 2e-3 * energy[l]);
            }
            if goes_on == [false; FIELD_LANES] {
                break;
            }
            add(&mut residual, length.map(|by| -by), &image);
            let next = dots(&residual, &residual);
            let turn = quotients(next, squares).map(|by| by as f32);
            squares = next;
            in_blocks(&mut direction, &residual, |d, r| {
                (0..FIELD_LANES).for_each(|l| d[l] = r[l] + turn[l] * d[l]);
            });
        }
        (solution, energy)
    }
}

/// Quotients of what is not negative; 0 over nothing.
fn quotients(over: [f64; FIELD_LANES], under: [f64; FIELD_LANES]) -> [f64; FIELD_LANES] {
    from_fn(|l| {
        if under[l] > 0.0 {
            over[l] / under[l]
        } else {
            0.0
        }
    })
}

/// Adds a multiple of vectors to others.
fn add(to: &mut [Lanes], by: [f64; FIELD_LANES], of: &[Lanes]) {
    let by = by.map(|b| b as f32);
    in_blocks(to, of, |to, of| {
        (0..FIELD_LANES).for_each(|l| to[l] += by[l] * of[l]);
    });
}

/// Changes rows by those of another vector.
fn in_blocks(to: &mut [Lanes], of: &[Lanes], change: impl Fn(&mut Lanes, &Lanes) + Sync) {
    let blocks = to
        .par_chunks_mut(SUMMED_ROWS)
        .zip(of.par_chunks(SUMMED_ROWS));
    blocks.for_each(|(to, of)| {
        vectorised(
            #[inline(always)]
            || to.iter_mut().zip(of).for_each(|(to, of)| change(to, of)),
        );
    });
}

/// Scalar products of all lanes.
fn dots(a: &[Lanes], b: &[Lanes]) -> [f64; FIELD_LANES] {
    let blocks = a
        .par_chunks(SUMMED_ROWS)
        .zip(b.par_chunks(SUMMED_ROWS))
        .map(|(a, b)| {
            vectorised(
                #[inline(always)]
                || {
                    let mut sum = [0.0; FIELD_LANES];
                    for (a, b) in a.iter().zip(b) {
                        (0..FIELD_LANES).for_each(|l| sum[l] += f64::from(a[l]) * f64::from(b[l]));
                    }
                    sum
                },
            )
        });
    let blocks: Vec<[f64; FIELD_LANES]> = blocks.collect();
    let sum = |sum: [f64; FIELD_LANES], block: &[f64; FIELD_LANES]| from_fn(|l| sum[l] + block[l]);
    blocks.iter().fold([0.0; FIELD_LANES], sum)
}
