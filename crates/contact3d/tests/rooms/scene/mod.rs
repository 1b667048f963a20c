//! Keys of a scene, and the formulas and laws behind them.

mod coefficient;
mod contact;
mod expression;
mod formula_branches;
mod friction;
mod grading;
mod load_path;
mod material;
mod messages;
mod units_change;
mod written;
