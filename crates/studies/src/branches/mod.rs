//! Paths of solutions in a parameter of a scene, and all solutions at one value of it.
//!
//! The solutions of a contact problem with Coulomb friction need not be unique, and where a key of the scene changes they form
//! paths that turn back at folds, break at kinks where panes change their zones, and may branch.
//! [`Branches::follow`] follows them by piecewise-smooth continuation:
//!
//! | step | algorithm | source |
//! |---|---|---|
//! | equations | on each piece, given by the zones of all panes and the segments of the law, R(λ, γ) = 0 is smooth and continued beyond its ends | — |
//! | tangent | R' bordered by the last tangent, dense LU | E. Allgower, K. Georg, *Introduction to Numerical Continuation Methods*, SIAM 2003 |
//! | corrector | Newton's method with the Moore–Penrose inverse | A. Dhooge, W. Govaerts, Yu. Kuznetsov, *ACM Trans. Math. Softw.* 29 (2003) 141 |
//! | kinks | the end of the piece is located, and the half paths of all pieces that meet there are sought | T. Ligurský, Y. Renard, *Comput. Methods Appl. Mech. Eng.* 280 (2014) 222; *Comput. Mech.* 56 (2015) 39 |
//! | folds, branch points | signs of the parameter's rate and of the bordered determinant | the same |
//!
//! Lengths of steps are measured by ‖λ‖²/Λ² + s², where Λ is the size of the stresses of the glued face and s runs from 0 to 1
//! over the range; so no unit matters.

#[expect(clippy::module_inception)]
mod branches;
mod corrector;
mod enumeration;
mod equations;
mod family;
mod kink;
mod law_piece;
mod locate;
mod path;
mod piece;
mod point;
mod search;
mod slip_stress;

pub use branches::{Branches, EndSolution, Path, Pending};
pub use enumeration::{CompletenessProof, Undecided};
pub use family::{Family, ParameterRange, SceneAt};
pub use path::PathEnd;
pub use piece::Switch;
pub use point::{PathOrigin, PathPoint, PointKind};
