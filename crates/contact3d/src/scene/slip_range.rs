use super::Coefficient;

impl Coefficient {
    /// Which of |u_t1|, |u_t2| the coefficient is a function of; `axis` is that of its own slip.
    #[must_use]
    pub fn slips_used(&self, axis: usize) -> [bool; 2] {
        let own = [axis == 0, axis == 1];
        match self {
            Self::Constant(_) => [false; 2],
            Self::Ramp(_) | Self::Table(_) => own,
            Self::Grid(_) => [true; 2],
            Self::Expression(formula) => {
                let uses = |name| formula.expression().uses(name);
                [0, 1].map(|k| uses(["s1", "s2"][k]) || own[k] && uses("s"))
            }
        }
    }

    /// The slips |u_t1| and |u_t2| in m at which straight pieces of the coefficient meet; none for
    /// constants and expressions.
    #[must_use]
    pub fn kinks(&self, axis: usize) -> [Vec<f64>; 2] {
        let mut kinks = [Vec::new(), Vec::new()];
        match self {
            Self::Constant(_) | Self::Expression(_) => {}
            Self::Ramp(ramp) => kinks[axis] = vec![ramp.onset, ramp.end()],
            Self::Table(table) => kinks[axis].clone_from(&table.slip),
            Self::Grid(grid) => kinks = [grid.slip_1.clone(), grid.slip_2.clone()],
        }
        kinks
    }

    /// Whether the coefficient is a formula, whose extremes can only be searched for.
    #[must_use]
    pub fn is_formula(&self) -> bool {
        matches!(self, Self::Expression(_))
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Coefficient, Formula, Ramp};

    #[test]
    fn slips_and_kinks_of_each_kind() {
        let ramp = Coefficient::Ramp(Ramp {
            initial: 0.5,
            residual: 0.25,
            onset: 1.0,
            rate: 0.125,
        });
        assert_eq!(ramp.slips_used(1), [false, true]);
        assert_eq!(ramp.kinks(1), [vec![], vec![1.0, 3.0]]);
        let formula = |text| Coefficient::Expression(Formula::parse(text).unwrap());
        assert_eq!(formula("0.3 + s").slips_used(0), [true, false]);
        assert_eq!(formula("0.3 + x + s2").slips_used(0), [false, true]);
        assert!(formula("0.3").is_formula() && !ramp.is_formula());
    }
}
