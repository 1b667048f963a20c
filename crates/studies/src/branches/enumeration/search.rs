//! All solutions of one choice of states, by cutting boxes, with elimination and contraction in intervals.

use nalgebra::DMatrix;

use super::{
    Undecided,
    interval::{Interval, product},
    system::System,
};

/// A box is tried this much larger, so that a solution on its side lies inside.
const LARGER: f64 = 0.1;

/// A box whose sides shrink by less than this is cut.
const SHRINKS: f64 = 0.7;

/// A box this narrow, relative to the whole, is not cut again: two solutions lie in it, or one that is not regular.
const NARROW: f64 = 1e-7;

/// Most boxes of one choice that are too narrow to be cut.
const MOST_UNDECIDED: usize = 8;

/// Most steps that narrow a box around its only solution.
const MOST_STEPS: usize = 30;

/// What was found for one choice of states.
#[derive(Default)]
pub(super) struct StateSolutions {
    pub(super) solutions: Vec<ProvedSolution>,
    /// Boxes that were looked at.
    pub(super) boxes: usize,
    /// Why some box is not decided.
    pub(super) undecided: Option<Undecided>,
}

/// A solution that is alone in its box.
pub(super) struct ProvedSolution {
    /// λ without unit, `[3m]`.
    pub(super) multiplier: Vec<Interval>,
    /// What no inequality is nearer to its end than.
    pub(super) margin: f64,
    /// |det| of the derivative over the product of the lengths of its rows.
    pub(super) determinant: f64,
}

/// A box with exactly one zero of the equations, and where it lies.
struct Zero {
    alone: Vec<Interval>,
    place: Vec<Interval>,
}

/// Cuts the whole box until each part has no solution or exactly one; at most so many boxes.
pub(super) fn search(system: &System<'_>, most_boxes: usize) -> StateSolutions {
    let mut outcome = StateSolutions::default();
    let whole = &system.whole;
    let mut zeros: Vec<Zero> = Vec::new();
    let mut open = vec![whole.clone()];
    let mut too_narrow = 0;
    while let Some(part) = open.pop() {
        if outcome.boxes == most_boxes {
            outcome.undecided = Some(Undecided::TooManyBoxes);
            break;
        }
        if too_narrow == MOST_UNDECIDED {
            break;
        }
        outcome.boxes += 1;
        let Some(part) = possible(system, part) else {
            continue;
        };
        if zeros.iter().any(|zero| is_inside(&part, &zero.alone)) {
            continue;
        }
        let larger = larger(&part, whole);
        let derivative = derivative(system, &larger);
        match narrow(&larger, &at_middle(system, &larger), &derivative) {
            Narrowed::Empty => {}
            Narrowed::Proven(place) => {
                let place = narrowest(system, place);
                let is_known =
                    |zero: &Zero| is_inside(&place, &zero.alone) || is_inside(&zero.place, &larger);
                if !zeros.iter().any(is_known) {
                    zeros.push(Zero {
                        alone: larger,
                        place,
                    });
                }
            }
            Narrowed::Rest(rest) => {
                let common = part.iter().zip(&rest).map(|(a, b)| a.meet(*b));
                let Some(common) = common.collect::<Option<Vec<_>>>() else {
                    continue;
                };
                let shrinks = |(a, b): (&Interval, &Interval)| b.width() <= SHRINKS * a.width();
                if part.iter().zip(&common).any(shrinks) {
                    open.push(common);
                } else if let Some(halves) = halves(&common, whole, &derivative) {
                    open.extend(halves);
                } else {
                    too_narrow += 1;
                }
            }
        }
    }
    let overlaps = |(k, zero): (usize, &Zero)| {
        let mut others = zeros[..k].iter();
        others.any(|other| overlap(&zero.place, &other.place))
    };
    if too_narrow > 0 || zeros.iter().enumerate().any(overlaps) {
        outcome.undecided = outcome.undecided.max(Some(Undecided::Irregular));
    }
    for zero in &zeros {
        let slides = system.slides(&zero.place);
        let signs = system.signs(&zero.place, &slides);
        if signs.iter().any(|sign| sign.high < 0.0) {
            continue;
        }
        let margin = signs.iter().map(|sign| sign.low);
        let margin = margin.fold(f64::INFINITY, f64::min);
        if margin <= 0.0 {
            outcome.undecided = outcome.undecided.max(Some(Undecided::AtEndOfStates));
        }
        outcome.solutions.push(ProvedSolution {
            multiplier: system.multipliers(&slides),
            margin,
            determinant: determinant(system, &zero.place),
        });
    }
    outcome
}

/// The part of a box in which no inequality and no equation fails; `None` where there is none.
fn possible(system: &System<'_>, part: Vec<Interval>) -> Option<Vec<Interval>> {
    let part = system.contracted(part)?;
    let signs = system.signs(&part, &system.slides(&part));
    let fails = |sign: &Interval| sign.high < 0.0;
    (!signs.iter().any(fails)).then_some(part)
}

fn at_middle(system: &System<'_>, part: &[Interval]) -> Vec<Interval> {
    let middle: Vec<_> = part.iter().map(|x| Interval::point(x.middle())).collect();
    let equations = system.equations(&system.slides(&middle));
    equations.iter().map(|left| left.value).collect()
}

/// The derivatives of the equations over a box, row by row.
fn derivative(system: &System<'_>, part: &[Interval]) -> Vec<Vec<Interval>> {
    let equations = system.equations(&system.slides(part));
    let rows = equations.iter().map(|left| &left.slope[..part.len()]);
    rows.map(<[Interval]>::to_vec).collect()
}

/// The place of the only zero in a box, as narrow as rounding and the uncertainty of the problem allow.
fn narrowest(system: &System<'_>, mut place: Vec<Interval>) -> Vec<Interval> {
    for _ in 0..MOST_STEPS {
        let derivative = derivative(system, &place);
        let next = match narrow(&place, &at_middle(system, &place), &derivative) {
            Narrowed::Empty => break,
            Narrowed::Proven(next) | Narrowed::Rest(next) => next,
        };
        let halves = |(a, b): (&Interval, &Interval)| b.width() <= 0.5 * a.width();
        let goes_on = place.iter().zip(&next).any(halves);
        place = next;
        if !goes_on {
            break;
        }
    }
    place
}

fn larger(part: &[Interval], whole: &[Interval]) -> Vec<Interval> {
    let sides = part.iter().zip(whole);
    let sides = sides.map(|(x, all)| {
        let more = LARGER * x.width() + NARROW * (all.width() + f64::EPSILON * all.size());
        Interval::new(x.low - more, x.high + more)
    });
    sides.collect()
}

/// A box cut across the unknown that moves the equations most; `None` where all its sides are too short.
fn halves(
    part: &[Interval],
    whole: &[Interval],
    derivative: &[Vec<Interval>],
) -> Option<[Vec<Interval>; 2]> {
    let n = part.len();
    let moves = |i: usize, j: usize| derivative[i][j].size() * part[j].width();
    let all: Vec<f64> = (0..n).map(|i| (0..n).map(|j| moves(i, j)).sum()).collect();
    let share = |j: usize| (0..n).map(|i| moves(i, j) / all[i]).sum::<f64>();
    let is_wide = |j: &usize| part[*j].width() > NARROW * whole[*j].width();
    let wide = (0..n).filter(is_wide);
    let side = wide.max_by(|a, b| share(*a).total_cmp(&share(*b)))?;
    let cut = part[side].middle();
    let [mut low, mut high] = [part.to_vec(), part.to_vec()];
    low[side].high = cut;
    high[side].low = cut;
    Some([low, high])
}

fn is_inside(inner: &[Interval], outer: &[Interval]) -> bool {
    inner.iter().zip(outer).all(|(a, b)| a.is_inside(*b))
}

fn overlap(a: &[Interval], b: &[Interval]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.meet(*b).is_some())
}

/// |det| of the middle of the derivative over the product of the lengths of its rows; 1 without unknowns.
fn determinant(system: &System<'_>, place: &[Interval]) -> f64 {
    let derivative = derivative(system, place);
    let n = derivative.len();
    let middle = DMatrix::from_fn(n, n, |i, j| derivative[i][j].middle());
    let lengths: f64 = middle.row_iter().map(|row| row.norm()).product();
    (middle.determinant() / lengths).abs()
}

/// The solutions of a symmetric system for several right-hand sides, `[n_rhs][n]`, by elimination without exchange of rows; `None`
/// where some matrix in the intervals may not be positive definite.
pub(super) fn solve(
    mut matrix: Vec<Vec<Interval>>,
    mut rhs: Vec<Vec<Interval>>,
) -> Option<Vec<Vec<Interval>>> {
    let n = matrix.len();
    for k in 0..n {
        let pivot = matrix[k][k];
        if pivot.low.is_nan() || pivot.low <= 0.0 {
            return None;
        }
        let row = matrix[k].clone();
        for i in k + 1..n {
            let share = matrix[i][k] * pivot.recip();
            for j in k + 1..n {
                matrix[i][j] = matrix[i][j] - share * row[j];
            }
            rhs.iter_mut().for_each(|b| b[i] = b[i] - share * b[k]);
        }
    }
    for b in &mut rhs {
        for k in (0..n).rev() {
            let known = product(&matrix[k][k + 1..], &b[k + 1..]);
            b[k] = (b[k] - known) * matrix[k][k].recip();
        }
    }
    Some(rhs)
}

/// What a box has in common with the solutions of F = 0 in it, by a step of the method of Gauss and Seidel on F(m) + F'(box)(x − m),
/// multiplied by the inverse of the middle of F'.
pub(super) enum Narrowed {
    /// There is none.
    Empty,
    /// Exactly one, and it lies here.
    Proven(Vec<Interval>),
    /// All lie here.
    Rest(Vec<Interval>),
}

/// One such step, from F at the middle of a box and F' over it. If every component of the result lies inside of the box, then every F' in
/// the intervals is regular and there is exactly one solution (A. Neumaier, *Interval Methods for Systems of PieceEquations*, 1990, §5.1).
pub(super) fn narrow(
    region: &[Interval],
    at_middle: &[Interval],
    derivative: &[Vec<Interval>],
) -> Narrowed {
    let n = region.len();
    let middle = DMatrix::from_fn(n, n, |i, j| derivative[i][j].middle());
    let mut now = region.to_vec();
    let Some(inverse) = middle.try_inverse() else {
        return Narrowed::Rest(now);
    };
    let mut is_proven = true;
    for i in 0..n {
        let row: Vec<Interval> = (0..n).map(|k| Interval::point(inverse[(i, k)])).collect();
        let entry = |j: usize| -> Interval { (0..n).map(|k| row[k] * derivative[k][j]).sum() };
        let mut known = product(&row, at_middle);
        for j in (0..n).filter(|j| *j != i) {
            known = known + entry(j) * (now[j] - Interval::point(region[j].middle()));
        }
        let Some(quotient) = known.over(entry(i)) else {
            is_proven = false;
            continue;
        };
        let found = Interval::point(region[i].middle()) - quotient;
        is_proven &= found.is_strictly_inside(region[i]);
        match now[i].meet(found) {
            Some(both) => now[i] = both,
            None => return Narrowed::Empty,
        }
    }
    if is_proven {
        Narrowed::Proven(now)
    } else {
        Narrowed::Rest(now)
    }
}
