//! Laws of the contact face, ellipses of friction, the order of multipliers.

mod ellipse;
mod law_bounds;
mod layout;
