//! Origins, ends and kinds of points as stored.

use contact3d::branches::{PathEnd, PathOrigin, PointKind, Switch, Undecided};

use super::super::enumeration::stored_as;

stored_as! {
    /// Where a path begins, as stored.
    pub(super) StoredOrigin of PathOrigin as "path_origin" {
        Solver = 0 => "solver",
        Search = 1 => "search",
        BranchPoint = 2 => "branch_point",
    }
}

stored_as! {
    /// Why there is no proof, as stored.
    pub(super) StoredUndecided of Undecided as "undecided" {
        NotAsked = 0 => "not_asked",
        NotCovered = 1 => "not_covered",
        AtEndOfStates = 2 => "at_end_of_states",
        Irregular = 3 => "irregular",
        TooManyBoxes = 4 => "too_many_boxes",
    }
}

runfile::stored_enum! {
    /// Why a path ends, as stored.
    pub(super) enum StoredEnd as "path_end" {
        /// `range`.
        Range = 0 => "range",
        /// `closed`.
        Closed = 1 => "closed",
        /// `known_point`.
        KnownPoint = 2 => "known_point",
        /// `degenerate`.
        Degenerate = 3 => "degenerate",
        /// `stuck`.
        Stuck = 4 => "stuck",
        /// `uncertified`.
        Uncertified = 5 => "uncertified",
        /// `too_long`.
        TooLong = 6 => "too_long",
        /// `unfinished`.
        Unfinished = 7 => "unfinished",
    }
}

stored_as! {
    /// What is special about a point, as stored.
    pub(super) StoredPointKind of PointKind as "path_point" {
        Start = 0 => "start",
        Regular = 1 => "regular",
        Kink = 2 => "kink",
        Fold = 3 => "fold",
        KinkFold = 4 => "kink_fold",
        BranchPoint = 5 => "branch_point",
        End = 6 => "end",
    }
}

runfile::stored_enum! {
    /// What changes at a point, as stored.
    pub(super) enum StoredSwitch as "switch" {
        /// `opening`.
        Opening = 0 => "opening",
        /// `slipping`.
        Slipping = 1 => "slipping",
        /// `cap`.
        Cap = 2 => "cap",
        /// `reversal_1`.
        Reversal1 = 3 => "reversal_1",
        /// `reversal_2`.
        Reversal2 = 4 => "reversal_2",
        /// `knot_1`.
        Knot1 = 5 => "knot_1",
        /// `knot_2`.
        Knot2 = 6 => "knot_2",
    }
}

pub(super) fn stored_end(end: Option<PathEnd>) -> StoredEnd {
    match end {
        None => StoredEnd::Unfinished,
        Some(PathEnd::Range) => StoredEnd::Range,
        Some(PathEnd::Closed) => StoredEnd::Closed,
        Some(PathEnd::KnownPoint) => StoredEnd::KnownPoint,
        Some(PathEnd::Degenerate) => StoredEnd::Degenerate,
        Some(PathEnd::Stuck) => StoredEnd::Stuck,
        Some(PathEnd::Uncertified) => StoredEnd::Uncertified,
        Some(PathEnd::TooLong) => StoredEnd::TooLong,
    }
}

pub(super) fn end(stored: StoredEnd) -> Option<PathEnd> {
    Some(match stored {
        StoredEnd::Unfinished => return None,
        StoredEnd::Range => PathEnd::Range,
        StoredEnd::Closed => PathEnd::Closed,
        StoredEnd::KnownPoint => PathEnd::KnownPoint,
        StoredEnd::Degenerate => PathEnd::Degenerate,
        StoredEnd::Stuck => PathEnd::Stuck,
        StoredEnd::Uncertified => PathEnd::Uncertified,
        StoredEnd::TooLong => PathEnd::TooLong,
    })
}

pub(super) fn stored_switch(switch: Switch) -> (StoredSwitch, usize) {
    match switch {
        Switch::Opening(pane) => (StoredSwitch::Opening, pane),
        Switch::Slipping(pane) => (StoredSwitch::Slipping, pane),
        Switch::Cap(pane) => (StoredSwitch::Cap, pane),
        Switch::Reversal(node, 0) => (StoredSwitch::Reversal1, node),
        Switch::Reversal(node, _) => (StoredSwitch::Reversal2, node),
        Switch::Knot(node, 0) => (StoredSwitch::Knot1, node),
        Switch::Knot(node, _) => (StoredSwitch::Knot2, node),
    }
}

pub(super) fn switch(stored: StoredSwitch, index: usize) -> Switch {
    match stored {
        StoredSwitch::Opening => Switch::Opening(index),
        StoredSwitch::Slipping => Switch::Slipping(index),
        StoredSwitch::Cap => Switch::Cap(index),
        StoredSwitch::Reversal1 => Switch::Reversal(index, 0),
        StoredSwitch::Reversal2 => Switch::Reversal(index, 1),
        StoredSwitch::Knot1 => Switch::Knot(index, 0),
        StoredSwitch::Knot2 => Switch::Knot(index, 1),
    }
}
