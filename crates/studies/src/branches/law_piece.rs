//! Smooth pieces of a friction law, and where they end.

use super::{
    piece::{AdjacentPiece, EndDistance, LawChange, NodePiece, Switch},
    point::FamilyMember,
};
use contact3d::{
    contact::CoulombLaw,
    scene::{Coefficient, FrictionLaw, LawPoint, SlipDerivative},
};

/// Shares of a segment at which a straight line through it is fixed.
const INSIDE: [f64; 2] = [0.25, 0.75];

/// A law of friction with its knots.
pub(super) struct LawPieces<'a> {
    pub(super) law: &'a CoulombLaw,
    /// Positive slips at which straight pieces of each coefficient meet, along its own slip or both.
    pub(super) knots: Vec<[Vec<f64>; 2]>,
}

/// 1/F₁ and 1/F₂ at a node and their derivatives by both slips there in 1/m.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodalInverse {
    pub(super) value: [f64; 2],
    pub(super) slope: [[f64; 2]; 2],
}

impl<'a> LawPieces<'a> {
    pub(super) fn new(member: &'a FamilyMember) -> Self {
        let law = member.law();
        let knots = law.only().coefficients().iter().map(|coefficient| {
            // Those of ramps and tables are along the own slip alone, whichever axis that is.
            let kinks = coefficient.kinks(0);
            kinks.map(|knots| knots.into_iter().filter(|k| *k > 0.0).collect())
        });
        Self {
            law,
            knots: knots.collect(),
        }
    }

    /// Whether coefficients read the length of the slip and not its components.
    pub(super) fn is_radial(&self) -> bool {
        matches!(&self.law.only().law, FrictionLaw::Isotropic(law) if !matches!(law, Coefficient::Grid(_)))
    }

    /// The knots along the slip of each axis, or along its length.
    pub(super) fn knots_along(&self) -> [Vec<f64>; 2] {
        let last = self.knots.len() - 1;
        [0, 1].map(|axis| {
            let [own, other] = &self.knots[axis.min(last)];
            if axis == 1 && !other.is_empty() {
                other.clone()
            } else {
                own.clone()
            }
        })
    }

    /// The piece on which a node with given slips and signs of u_t lies.
    pub(super) fn piece_of(&self, node: usize, slip: [f64; 2], negative: [bool; 2]) -> NodePiece {
        let mut piece = NodePiece {
            negative,
            ..NodePiece::default()
        };
        let coefficients = self.law.only().coefficients().iter().zip(&self.knots);
        for (coefficient, (law, knots)) in coefficients.enumerate() {
            if let Coefficient::Expression(formula) = law {
                let (at, _) = self.at(coefficient, node, slip);
                piece.branch[coefficient] = formula.branch(&at);
            }
            let along = self.slips(coefficient, slip);
            let segment = |axis: usize| knots[axis].partition_point(|knot| *knot < along[axis]);
            piece.segment[coefficient] = [0, 1].map(segment);
        }
        piece
    }

    /// The slips that the knots of a coefficient are measured along: its own one, or both of a grid.
    pub(super) fn slips(&self, coefficient: usize, slip: [f64; 2]) -> [f64; 2] {
        match &self.law.only().coefficients()[coefficient] {
            Coefficient::Grid(_) => slip,
            _ => [self.own(coefficient, slip).0, 0.0],
        }
    }

    /// The own slip of a coefficient and its derivatives by both slips.
    fn own(&self, coefficient: usize, slip: [f64; 2]) -> (f64, [f64; 2]) {
        let axis = match &self.law.only().law {
            FrictionLaw::Orthotropic(_) => coefficient,
            FrictionLaw::Isotropic(_) if slip[1] == 0.0 => 0,
            FrictionLaw::Isotropic(_) if slip[0] == 0.0 => 1,
            FrictionLaw::Isotropic(_) => {
                let size = slip[0].hypot(slip[1]);
                return (size, slip.map(|s| s / size));
            }
        };
        let mut by = [0.0; 2];
        by[axis] = 1.0;
        (slip[axis], by)
    }

    /// 1/F at a node on a piece.
    pub(super) fn inverse(&self, node: usize, slip: [f64; 2], piece: &NodePiece) -> NodalInverse {
        let last = self.law.only().coefficients().len() - 1;
        let both = [0, 1].map(|k| {
            let coefficient = k.min(last);
            let (at, own_by) = self.at(coefficient, node, slip);
            let (value, derivative) = self.on_piece(coefficient, &at, piece);
            let slope = [0, 1].map(|l| {
                let by = derivative.own * own_by[l] + derivative.pair[l];
                -by / (value * value)
            });
            (value.recip(), slope)
        });
        NodalInverse {
            value: both.map(|(value, _)| value),
            slope: both.map(|(_, slope)| slope),
        }
    }

    /// What a coefficient depends on at a node, and the derivatives of its own slip by both slips.
    pub(super) fn at(
        &self,
        coefficient: usize,
        node: usize,
        slip: [f64; 2],
    ) -> (LawPoint, [f64; 2]) {
        let (own_slip, own_by) = self.own(coefficient, slip);
        let at = LawPoint {
            position: self.law.only().positions[node],
            slip,
            own_slip,
        };
        (at, own_by)
    }

    /// A coefficient as the polynomial that it is on a segment, a formula on its branch, constant below
    /// zero.
    fn on_piece(
        &self,
        coefficient: usize,
        at: &LawPoint,
        piece: &NodePiece,
    ) -> (f64, SlipDerivative) {
        let law = &self.law.only().coefficients()[coefficient];
        let segment = piece.segment[coefficient];
        let inside = |axis: usize| ends_inside(&self.knots[coefficient][axis], segment[axis]);
        match law {
            Coefficient::Constant(value) => (*value, SlipDerivative::default()),
            Coefficient::Ramp(_) | Coefficient::Table(_) => {
                let ends = inside(0);
                let values = ends.map(|own_slip| law.evaluate(&LawPoint { own_slip, ..*at }));
                let slope = (values[1] - values[0]) / (ends[1] - ends[0]);
                let derivative = SlipDerivative {
                    own: slope,
                    ..SlipDerivative::default()
                };
                (values[0] + slope * (at.own_slip - ends[0]), derivative)
            }
            Coefficient::Grid(_) => {
                let (first, second) = (inside(0), inside(1));
                let value = |slip| law.evaluate(&LawPoint { slip, ..*at });
                let line = |s: f64| {
                    let values = second.map(|t| value([s, t]));
                    let slope = (values[1] - values[0]) / (second[1] - second[0]);
                    (values[0] + slope * (at.slip[1] - second[0]), slope)
                };
                let [low, high] = first.map(line);
                let share = (at.slip[0] - first[0]) / (first[1] - first[0]);
                let derivative = SlipDerivative {
                    own: 0.0,
                    pair: [
                        (high.0 - low.0) / (first[1] - first[0]),
                        low.1 + share * (high.1 - low.1),
                    ],
                };
                (low.0 + share * (high.0 - low.0), derivative)
            }
            Coefficient::Expression(formula) => {
                let found = formula.on_branch(&kept(at), piece.branch[coefficient]);
                let [own, first, second] = found.slopes;
                let pair = [first, second];
                above_zero(at, found.value, SlipDerivative { own, pair })
            }
        }
    }
}

/// The point where slips are not negative that is nearest.
pub(super) fn kept(at: &LawPoint) -> LawPoint {
    LawPoint {
        position: at.position,
        slip: at.slip.map(|s| s.max(0.0)),
        own_slip: at.own_slip.max(0.0),
    }
}

/// A value with its derivatives, none by slips below zero.
fn above_zero(at: &LawPoint, value: f64, mut derivative: SlipDerivative) -> (f64, SlipDerivative) {
    for (own, slip) in derivative.pair.iter_mut().zip(at.slip) {
        if slip < 0.0 {
            *own = 0.0;
        }
    }
    if at.own_slip < 0.0 {
        derivative.own = 0.0;
    }
    (value, derivative)
}

/// Two slips within a segment; beyond the last knot, two of its size.
fn ends_inside(knots: &[f64], segment: usize) -> [f64; 2] {
    let low = segment.checked_sub(1).map_or(0.0, |k| knots[k]);
    let width = match knots.get(segment) {
        Some(high) => high - low,
        None if low > 0.0 => low,
        None => 1.0,
    };
    INSIDE.map(|share| low + share * width)
}

/// Distances to knots are measured by no less than this share of the slips of the face, whose rounding is 1e-15 of it.
const FINEST: f64 = 1e-3;

impl LawPieces<'_> {
    /// The slip in m that distances to knots are measured by: that of the whole face, or the narrowest segment of the law, since the
    /// coefficient changes as much within it; not below a share of the first that rounding leaves alone.
    fn scale(&self, unit: f64) -> f64 {
        let widths = |knots: &Vec<f64>| {
            let below = [0.0].into_iter().chain(knots.iter().copied());
            let gaps = knots.iter().zip(below).map(|(knot, below)| knot - below);
            gaps.fold(f64::INFINITY, f64::min)
        };
        let narrowest = self.knots.iter().flatten().map(widths);
        let narrowest = narrowest.fold(f64::INFINITY, f64::min);
        narrowest.clamp(FINEST * unit, unit)
    }

    /// How far a node is from the ends of its piece, for slips of the size `unit` in m.
    pub(super) fn distances(
        &self,
        node: usize,
        slip: [f64; 2],
        piece: &NodePiece,
        unit: f64,
    ) -> Vec<EndDistance> {
        let unit = self.scale(unit);
        let mut ends = Vec::new();
        let mut end = |switch: Switch, value: f64, change: LawChange| {
            ends.push(EndDistance {
                switch,
                value,
                beyond: AdjacentPiece::Law(change),
            });
        };
        for axis in 0..2 {
            if self.bends_at_reversal(axis, slip) {
                let beyond = LawChange::Negative(axis, !piece.negative[axis]);
                end(Switch::Reversal(node, axis), slip[axis] / unit, beyond);
            }
        }
        // To branch points of formulas it is to first order the slip to them.
        for (coefficient, law) in self.law.only().coefficients().iter().enumerate() {
            let Coefficient::Expression(formula) = law else {
                continue;
            };
            let (at, own_by) = self.at(coefficient, node, slip);
            let found = formula.on_branch(&kept(&at), piece.branch[coefficient]);
            for reached in found.ends {
                let [own, first, second] = reached.slopes;
                let slope = (own * own_by[0] + first).hypot(own * own_by[1] + second);
                let distance = reached.margin / slope;
                // Where the slip does not move the branch point it ends nothing.
                let value = if distance.is_finite() {
                    distance / unit
                } else {
                    f64::MAX.copysign(reached.margin)
                };
                let beyond = LawChange::Fork(coefficient, reached.branch_point, !reached.less);
                end(Switch::Knot(node, coefficient), value, beyond);
            }
        }
        for (coefficient, knots) in self.knots.iter().enumerate() {
            let slips = self.slips(coefficient, slip);
            let switch = Switch::Knot(node, coefficient);
            for along in 0..2 {
                let segment = piece.segment[coefficient][along];
                if let Some(upper) = knots[along].get(segment) {
                    let beyond = LawChange::Segment(coefficient, along, segment + 1);
                    end(switch, (upper - slips[along]) / unit, beyond);
                }
                if let Some(below) = segment.checked_sub(1) {
                    let beyond = LawChange::Segment(coefficient, along, below);
                    end(switch, (slips[along] - knots[along][below]) / unit, beyond);
                }
            }
        }
        ends
    }

    /// Whether the law has a kink where u_t along an axis changes its sign.
    fn bends_at_reversal(&self, axis: usize, slip: [f64; 2]) -> bool {
        match &self.law.only().law {
            FrictionLaw::Isotropic(Coefficient::Ramp(_) | Coefficient::Table(_)) => {
                slip[1 - axis] == 0.0
            }
            FrictionLaw::Isotropic(law) => law.slips_used(0)[axis] || law.slips_used(1)[axis],
            FrictionLaw::Orthotropic(pair) => (0..2).any(|k| pair[k].slips_used(k)[axis]),
        }
    }
}
