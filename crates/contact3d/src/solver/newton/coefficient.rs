//! A coefficient of friction at a contact node as a point of the graph of its law.

use crate::contact::CoulombLaw;

/// A coefficient of friction at a contact node.
pub(super) struct NodeCoefficient {
    pub(super) node: usize,
    /// The axis of its slip; `None` of an isotropic law, which reads |u_t|.
    pub(super) axis: Option<usize>,
    /// c in 1/m.
    pub(super) steplength: f64,
    /// Least and largest value of F on the face.
    pub(super) range: [f64; 2],
}

impl NodeCoefficient {
    pub(super) fn axes(&self) -> impl Iterator<Item = usize> + use<> {
        self.axis.map_or(0..2, |axis| axis..axis + 1)
    }

    /// F at the slip s of the coefficient's own, others as they are.
    pub(super) fn value(&self, law: &CoulombLaw, pair: [f64; 2], s: f64) -> f64 {
        law.evaluate(self.node, self.at(pair, s))[self.axis.unwrap_or(0)]
    }

    /// Φ(y) and Φ'(y) for a steplength c in 1/m, by bisection: F(s) + c s − y rises where c > −F'; where F falls faster it has several
    /// roots, one of which is found, and Φ' counts as 0.
    ///
    /// The graph that is wider by w, the slip `rise` in m, adds the slip κ (f − F(0)) with κ = w / (max F − min F) to that of f. Its resolvent is
    /// Φ(y) = Φ_b(b/c y + b κ F(0)) for the one Φ_b of the law with b = c / (1 + c κ).
    pub(super) fn resolvent(
        &self,
        law: &CoulombLaw,
        steplength: f64,
        rise: f64,
        pair: [f64; 2],
        y: f64,
    ) -> [f64; 2] {
        let at_rest = self.value(law, pair, 0.0);
        if y <= at_rest {
            return [at_rest, 0.0];
        }
        let height = self.range[1] - self.range[0];
        let widened = if height > 0.0 {
            steplength * rise / height
        } else {
            0.0
        };
        let ratio = (1.0 + widened).recip();
        let (steplength, y) = (ratio * steplength, ratio * (y + widened * at_rest));
        let (mut low, mut high) = (0.0, (y - self.range[0]) / steplength);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.value(law, pair, middle) + steplength * middle < y {
                low = middle;
            } else {
                high = middle;
            }
        }
        let slope = self.slope(law, pair, high).max(0.0);
        // On a steep rise s has fewer digits than f, which is what is left of y.
        let value = (y - steplength * high).clamp(self.range[0], self.range[1]);
        [value, ratio * slope / (slope + steplength)]
    }

    /// (|u_t1|, |u_t2|) with the own slip s.
    fn at(&self, pair: [f64; 2], s: f64) -> [f64; 2] {
        match self.axis {
            Some(axis) => [0, 1].map(|k| if k == axis { s } else { pair[k] }),
            None => match pair[0].hypot(pair[1]) {
                0.0 => [s, 0.0],
                own => pair.map(|p| s * (p / own)),
            },
        }
    }

    /// dF/ds.
    fn slope(&self, law: &CoulombLaw, pair: [f64; 2], s: f64) -> f64 {
        let at = self.at(pair, s);
        let row = law.derivative(self.node, at)[self.axis.unwrap_or(0)];
        match self.axis {
            Some(axis) => row[axis],
            None if s > 0.0 => (row[0] * at[0] + row[1] * at[1]) / s,
            None => row[0],
        }
    }
}
