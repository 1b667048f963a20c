//! Sweeps: shared work, resumed after kills, failed cases, changed axes.

mod axes;
mod changes;
mod kills;
mod program;
mod sharing;
mod size;
mod tables;
mod units;
