//! The slips that the law of friction follows on a piece.

use super::piece::NodePiece;
use crate::contact::{SlipOperator, SlipOperatorDerivative};

/// φ at the contact nodes and how it moves with u_t there; nothing where the law does not follow it.
///
/// At the nodes themselves (Lagrange) φ_k is u_tk times its sign on the piece, so it goes on below zero beyond a reversal. Means of
/// |u_tk| over the triangles around a node (Clément) have a continuous derivative wherever u_tk does not vanish on a whole triangle:
/// no sign ends a piece there.
pub(super) struct Slips {
    /// φ in m, `[n_contact_nodes]`, or empty.
    pub(super) value: Vec<[f64; 2]>,
    derivative: Option<SlipOperatorDerivative>,
}

impl Slips {
    /// From u_t at the contact nodes in m; empty where the law does not follow it.
    pub(super) fn on_piece(
        operator: &SlipOperator,
        displacement: &[[f64; 2]],
        nodes: &[Option<NodePiece>],
    ) -> Self {
        if displacement.is_empty() {
            return Self {
                value: Vec::new(),
                derivative: None,
            };
        }
        match operator {
            SlipOperator::Clement(_) => Self {
                value: operator.slip(displacement),
                derivative: Some(operator.derivative(displacement)),
            },
            SlipOperator::Lagrange => {
                let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
                let nodes = displacement.iter().zip(nodes);
                let signs: Vec<[f64; 2]> = nodes
                    .map(|(u, piece)| match piece {
                        Some(piece) => piece.negative.map(sign),
                        None => u.map(|u| sign(u < 0.0)),
                    })
                    .collect();
                let nodes = displacement.iter().zip(&signs);
                Self {
                    value: nodes
                        .map(|(u, sign)| [sign[0] * u[0], sign[1] * u[1]])
                        .collect(),
                    derivative: Some(SlipOperatorDerivative::Signs(signs)),
                }
            }
        }
    }

    /// The change of φ with a change of u_t, given as pairs of the contact nodes.
    pub(super) fn change(&self, moved: &[f64]) -> Vec<[f64; 2]> {
        let derivative = self.derivative.as_ref();
        derivative.map_or_else(Vec::new, |derivative| {
            derivative.apply(|node| [moved[2 * node], moved[2 * node + 1]])
        })
    }
}
