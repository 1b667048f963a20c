//! How far a study is, and how long the rest of it will take.

use std::time::Instant;

/// What an observer of a study sees.
#[derive(Debug, Clone, PartialEq)]
pub enum StudyStep {
    /// A piece of work begins.
    Piece {
        /// What is done.
        words: String,
        /// Its number, from 1 on.
        number: usize,
        /// How many there are as far as is known.
        of: usize,
        /// Seconds of this piece and all after it, by what those before took; `None` as long as nothing tells.
        seconds_left: Option<f64>,
    },
    /// A first result.
    Figure(String),
}

/// Pieces of one kind, whose seconds go with their effort.
#[derive(Debug, Clone, Default)]
struct Kind {
    /// Number and effort of the pieces to come.
    ahead: (usize, f64),
    /// Effort and seconds of those done.
    done: (f64, f64),
    /// Seconds that a piece of effort 1 takes at most, where that is known beforehand.
    most: Option<f64>,
}

/// The pieces of a study: they are announced, timed, and told to an observer.
pub(crate) struct Pieces<'a> {
    kinds: Vec<Kind>,
    begun: usize,
    /// Kind and effort of the piece at work, and when it began.
    current: Option<(usize, f64, Instant)>,
    observe: &'a mut dyn FnMut(StudyStep),
}

impl<'a> Pieces<'a> {
    /// A study without pieces yet.
    pub(crate) fn new(observe: &'a mut dyn FnMut(StudyStep)) -> Self {
        Self {
            kinds: Vec::new(),
            begun: 0,
            current: None,
            observe,
        }
    }

    /// A new kind of pieces, with the seconds that effort 1 takes at most.
    pub(crate) fn kind(&mut self, most: Option<f64>) -> usize {
        self.kinds.push(Kind {
            most,
            ..Kind::default()
        });
        self.kinds.len() - 1
    }

    /// Announces a piece.
    pub(crate) fn announce(&mut self, kind: usize, effort: f64) {
        let (count, sum) = &mut self.kinds[kind].ahead;
        (*count, *sum) = (*count + 1, *sum + effort);
    }

    /// Ends the piece at work and begins one of a kind.
    pub(crate) fn begin(&mut self, kind: usize, effort: f64, words: String) {
        self.end();
        self.leave_out(kind, effort);
        self.begun += 1;
        self.current = Some((kind, effort, Instant::now()));
        self.say(words);
    }

    /// Says more of the piece at work.
    pub(crate) fn say(&mut self, words: String) {
        let ahead = self.kinds.iter().map(|kind| kind.ahead.0);
        let step = StudyStep::Piece {
            words,
            number: self.begun,
            of: self.begun + ahead.sum::<usize>(),
            seconds_left: self.seconds_left(),
        };
        (self.observe)(step);
    }

    /// Shows a result.
    pub(crate) fn figure(&mut self, text: String) {
        (self.observe)(StudyStep::Figure(text));
    }

    /// Takes back the announcement of a piece.
    pub(crate) fn leave_out(&mut self, kind: usize, effort: f64) {
        let (count, sum) = &mut self.kinds[kind].ahead;
        (*count, *sum) = (count.saturating_sub(1), *sum - effort);
    }

    /// Ends the piece at work.
    pub(crate) fn end(&mut self) {
        if let Some((kind, effort, began)) = self.current.take() {
            let (done, seconds) = &mut self.kinds[kind].done;
            *done += effort;
            *seconds += began.elapsed().as_secs_f64();
        }
    }

    fn seconds_left(&self) -> Option<f64> {
        let mut left = 0.0;
        for (number, kind) in self.kinds.iter().enumerate() {
            let mut effort = if kind.ahead.0 > 0 { kind.ahead.1 } else { 0.0 };
            if let Some((at_work, of_it, _)) = self.current
                && at_work == number
            {
                effort += of_it;
            }
            if effort > 0.0 {
                let (done, seconds) = kind.done;
                let measured = (done > 0.0).then(|| seconds / done);
                left += effort * measured.or(kind.most)?;
            }
        }
        Some(left)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// Half of the effort took a second, so the rest takes one too; a kind of which nothing is known leaves the time open.
    #[test]
    fn the_rest_takes_as_long_as_its_effort() {
        let mut seen = Vec::new();
        let mut observe = |step| seen.push(step);
        let mut pieces = Pieces::new(&mut observe);
        let (small, bounded) = (pieces.kind(None), pieces.kind(Some(10.0)));
        let efforts = [1.0, 2.0, 3.0].into_iter();
        efforts.for_each(|effort| pieces.announce(small, effort));
        pieces.announce(bounded, 2.0);
        pieces.begin(small, 1.0, String::new());
        let (_, _, began) = pieces.current.as_mut().unwrap();
        *began -= Duration::from_secs(1);
        pieces.begin(small, 2.0, String::new());
        pieces.leave_out(bounded, 2.0);
        pieces.say(String::new());
        let of = |step: &StudyStep| match step {
            StudyStep::Piece {
                number,
                of,
                seconds_left,
                ..
            } => (*number, *of, seconds_left.map(f64::round)),
            StudyStep::Figure(_) => panic!("no figure was shown"),
        };
        let seen: Vec<_> = seen.iter().map(of).collect();
        assert_eq!(seen, [(1, 4, None), (2, 4, Some(25.0)), (2, 3, Some(5.0))]);
    }
}
