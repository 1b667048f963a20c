//! Only the model features that a scene calls for are computed, and those that coincide in a limit
//! agree.

use crate::support;

mod absence;
mod bodies;
mod capped;
mod combinations;
mod contact_frame;
mod datasets;
mod floating;
mod friction;
mod pieces;
mod plates;
mod scenes;
mod words;
