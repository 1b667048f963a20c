//! Tests of the mechanics of the table on a small sample format.

mod damage;
mod linked;
mod round_trip;
mod rules;
mod sample;
mod transactions;
