//! A tree of boxes, in which the nearest of many bodies to a point is found.

/// Most bodies of a leaf.
const LEAF: usize = 4;

/// Smallest and largest coordinates in m.
type Bounds = [[f64; 3]; 2];

/// A node of the tree: all bodies between two places in the order.
#[derive(Debug)]
struct Branch {
    bounds: Bounds,
    /// Its bodies as a range of the order.
    bodies: [usize; 2],
    /// Its two parts; `None` for a leaf.
    parts: Option<[usize; 2]>,
}

/// Bodies in boxes.
#[derive(Debug)]
pub(super) struct Tree {
    boxes: Vec<Bounds>,
    /// Bodies in the order of the leaves.
    order: Vec<usize>,
    /// The first is the root.
    branches: Vec<Branch>,
}

impl Tree {
    /// Halves the bodies, at least one, along the longest side of their box until few are left.
    pub(super) fn new(boxes: Vec<Bounds>) -> Self {
        let mut tree = Self {
            order: (0..boxes.len()).collect(),
            boxes,
            branches: Vec::new(),
        };
        tree.add(0, tree.order.len());
        tree
    }

    fn add(&mut self, from: usize, to: usize) -> usize {
        let bodies = &mut self.order[from..to];
        let bounds = bodies.iter().map(|b| self.boxes[*b]).fold(
            [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            |[low, high], [l, h]| {
                [
                    std::array::from_fn(|c| low[c].min(l[c])),
                    std::array::from_fn(|c| high[c].max(h[c])),
                ]
            },
        );
        let number = self.branches.len();
        self.branches.push(Branch {
            bounds,
            bodies: [from, to],
            parts: None,
        });
        if to - from > LEAF {
            let length = |c: usize| bounds[1][c] - bounds[0][c];
            let axis = (0..3).fold(0, |best, c| if length(c) > length(best) { c } else { best });
            let middle = |body: &usize| self.boxes[*body][0][axis] + self.boxes[*body][1][axis];
            let half = (to - from) / 2;
            bodies.select_nth_unstable_by(half, |a, b| {
                middle(a).total_cmp(&middle(b)).then(a.cmp(b))
            });
            let parts = [self.add(from, from + half), self.add(from + half, to)];
            self.branches[number].parts = Some(parts);
        }
        number
    }

    /// Some body whose branch is near a point, to begin a search with.
    pub(super) fn any(&self, point: [f64; 3]) -> usize {
        let mut branch = &self.branches[0];
        while let Some([first, second]) = branch.parts {
            let [near, far] = [first, second].map(|part| &self.branches[part]);
            let is_far = outside(&far.bounds, point) < outside(&near.bounds, point);
            branch = if is_far { far } else { near };
        }
        self.order[branch.bodies[0]]
    }

    /// The nearest body to a point and what the search says of it, where `search` gives the distance of a body, at least
    /// that of its box, with something to keep. A body that holds the point ends the search; `guess` is asked first.
    pub(super) fn nearest<T>(
        &self,
        point: [f64; 3],
        guess: usize,
        search: impl Fn(usize) -> (f64, T),
    ) -> (usize, T) {
        let (mut least, kept) = search(guess);
        let mut best = (guess, kept);
        let mut waiting = vec![0];
        while let Some(branch) = waiting.pop().map(|number: usize| &self.branches[number]) {
            if least == 0.0 {
                break;
            }
            if outside(&branch.bounds, point) >= least {
                continue;
            }
            if let Some([first, second]) = branch.parts {
                let [near, far] =
                    [first, second].map(|part| outside(&self.branches[part].bounds, point));
                // The nearer part is looked at first.
                waiting.extend(if near <= far {
                    [second, first]
                } else {
                    [first, second]
                });
                continue;
            }
            for &body in &self.order[branch.bodies[0]..branch.bodies[1]] {
                if outside(&self.boxes[body], point) >= least {
                    continue;
                }
                let (found, kept) = search(body);
                if found < least {
                    least = found;
                    best = (body, kept);
                }
            }
        }
        best
    }
}

/// The distance of a point from a box in m, 0 inside.
fn outside([low, high]: &Bounds, point: [f64; 3]) -> f64 {
    let beyond = |c: usize| (low[c] - point[c]).max(point[c] - high[c]).max(0.0);
    (0..3).map(|c| beyond(c).powi(2)).sum::<f64>().sqrt()
}
