//! Smaller boxes around the same solutions.

use super::{
    interval::Interval,
    system::{Sliding, Slipping, System},
};

impl System<'_> {
    /// A box around all solutions in a box, by each equation alone for one of its unknowns; `None` where there are none.
    pub(super) fn contracted(&self, mut at: Vec<Interval>) -> Option<Vec<Interval>> {
        let sliding = self.sliding(&at);
        for pane in &self.slipping {
            at[pane.pressure] = self.pressure(pane, &sliding, &at)?;
        }
        let carried = Self::carried(&self.sliding(&at));
        for pane in &self.slipping {
            if let Some(place) = pane.angle {
                let [_, first, second] = self.gradient_of(pane.pane).map(|row| row.at(&carried));
                let friction = pane.friction_in(&at);
                let slip = [-(friction[0] * first), -(friction[1] * second)];
                at[place] = pane.chart.narrowed(at[place], slip)?;
            }
        }
        if self.problem.follows_slip() {
            let slips = self.slips_at(&carried);
            for pane in &self.slipping {
                let found = self.problem.friction(pane.pane, &slips).value;
                for (k, place) in pane.unknown_friction() {
                    at[place] = at[place].meet(found[k])?;
                }
            }
        }
        Some(at)
    }

    /// λ_ν of a pane by r_ν = 0, given directions and 𝓕.
    fn pressure(&self, pane: &Slipping, sliding: &[Sliding], at: &[Interval]) -> Option<Interval> {
        let row = self.gradient_of(pane.pane)[0];
        let (mut known, mut own) = (row.constant, Interval::ZERO);
        let columns = row.slope.as_chunks().0.iter();
        for ((other, here), [normal, first, second]) in
            self.slipping.iter().zip(sliding).zip(columns)
        {
            let share = here.shares();
            let factor = *normal + *first * share[0] + *second * share[1];
            if other.pane == pane.pane {
                own = factor;
            } else {
                known = known + factor * at[other.pressure];
            }
        }
        match (-known).over(own) {
            Some(found) => at[pane.pressure].meet(found),
            None => Some(at[pane.pressure]),
        }
    }
}
