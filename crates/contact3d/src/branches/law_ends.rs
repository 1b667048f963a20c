//! How far a node is from the ends of its piece of the law of friction.

use super::{
    law_piece::{LawPieces, kept},
    piece::{Beyond, Distance, NodePiece, Switch},
};
use crate::scene::{Coefficient, FrictionLaw};

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
        out: &mut Vec<Distance>,
    ) {
        let unit = self.scale(unit);
        for axis in 0..2 {
            if self.is_nodal && self.bends_at_reversal(axis, slip) {
                out.push(Distance {
                    switch: Switch::Reversal(node, axis),
                    value: slip[axis] / unit,
                    beyond: Beyond::Negative {
                        axis,
                        negative: !piece.negative[axis],
                    },
                });
            }
        }
        self.fork_distances(node, slip, piece, unit, out);
        for (coefficient, knots) in self.knots.iter().enumerate() {
            let slips = self.slips(coefficient, slip);
            for along in 0..2 {
                let segment = piece.segment[coefficient][along];
                let mut end = |value: f64, segment: usize| {
                    out.push(Distance {
                        switch: Switch::Knot(node, coefficient),
                        value: value / unit,
                        beyond: Beyond::Segment {
                            coefficient,
                            along,
                            segment,
                        },
                    });
                };
                if let Some(upper) = knots[along].get(segment) {
                    end(upper - slips[along], segment + 1);
                }
                if let Some(lower) = segment.checked_sub(1).map(|below| knots[along][below]) {
                    end(slips[along] - lower, segment - 1);
                }
            }
        }
    }

    /// How far a node is from the forks of its formulas: to first order the slip to them.
    fn fork_distances(
        &self,
        node: usize,
        slip: [f64; 2],
        piece: &NodePiece,
        unit: f64,
        out: &mut Vec<Distance>,
    ) {
        for (coefficient, law) in self.law.only().coefficients().iter().enumerate() {
            let Coefficient::Expression(formula) = law else {
                continue;
            };
            let (at, own_by) = self.at(coefficient, node, slip);
            for end in formula
                .on_branch(&kept(&at), piece.branch[coefficient])
                .ends
            {
                let [own, first, second] = end.slopes;
                let slope = (own * own_by[0] + first).hypot(own * own_by[1] + second);
                // Where the slip does not move the fork it ends nothing.
                let far = f64::MAX.copysign(end.margin);
                let way = end.margin / slope;
                out.push(Distance {
                    switch: Switch::Knot(node, coefficient),
                    value: if way.is_finite() { way / unit } else { far },
                    beyond: Beyond::Fork {
                        coefficient,
                        fork: end.fork,
                        less: !end.less,
                    },
                });
            }
        }
    }

    /// Whether the law has a kink where u_t along an axis changes its sign.
    fn bends_at_reversal(&self, axis: usize, slip: [f64; 2]) -> bool {
        let coefficients = self.law.only().coefficients().iter().enumerate();
        let mut bends =
            coefficients.map(
                |(k, coefficient)| match (self.law.only().law(), coefficient) {
                    (FrictionLaw::Isotropic(_), Coefficient::Ramp(_) | Coefficient::Table(_)) => {
                        slip[1 - axis] == 0.0
                    }
                    (FrictionLaw::Isotropic(_), coefficient) => {
                        coefficient.slips_used(0)[axis] || coefficient.slips_used(1)[axis]
                    }
                    (FrictionLaw::Orthotropic(_), coefficient) => coefficient.slips_used(k)[axis],
                },
            );
        bends.any(|bends| bends)
    }
}
