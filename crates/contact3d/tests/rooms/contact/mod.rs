//! Laws of the contact face and the order of multipliers.

mod law_bounds;
mod layout;
