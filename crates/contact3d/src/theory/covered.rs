//! What HKL's theory covers.

use crate::scene::{ElementOrder, FrictionModel, Invalid, ModelFeatures, Quantity, Scene, Written};

/// Refuses what HKL §2 and §3 do not cover.
pub(super) fn require_covered(scene: &Scene) -> Result<(), Invalid> {
    scene.require_no_history("the theory")?;
    let faces = ModelFeatures::of(scene).contact;
    if faces.len() > 1 {
        return Err(Invalid {
            key: "contact".into(),
            expected: "one contact face, as in HKL section 2".into(),
            found: format!("{} faces", faces.len()),
            help: "the norms and constants of HKL section 3 belong to one flat face with one law; leave the others out"
                .into(),
        });
    }
    match faces.first().map(|face| &face.friction) {
        Some(FrictionModel::Coulomb { .. } | FrictionModel::CappedCoulomb { .. }) => {}
        other => {
            return Err(Invalid {
                key: "friction".into(),
                expected: "Coulomb friction on a contact face".into(),
                found: match other {
                    None => "no contact".into(),
                    Some(model) => model.word().into(),
                },
                help: "other scenes are one minimisation: their solution is unique, and there is no mapping to study".into(),
            });
        }
    }
    let obstacle = faces.first().and_then(|face| face.obstacle.as_ref());
    if let Some(obstacle) = obstacle {
        return Err(Invalid {
            key: "contact.obstacle".into(),
            expected: "no obstacle, as in HKL section 2".into(),
            found: obstacle.word().into(),
            help: "there the contact face is flat and touches its foundation everywhere at first; leave the obstacle out".into(),
        });
    }
    let gap = faces.first().and_then(|face| face.gap.clone());
    if let Some(gap) = gap {
        return Err(Invalid {
            key: "contact.gap".into(),
            expected: "no gap, as in HKL section 2".into(),
            found: match gap {
                Quantity::Constant(value) => Written(&value).to_string(),
                _ => "a gap that varies".into(),
            },
            help:
                "the radii of Lemma 3.3 compare u with 0 and 2u, which a gap excludes; set it to 0"
                    .into(),
        });
    }
    if scene.body.element == ElementOrder::P2 {
        return Err(Invalid {
            key: "body.element".into(),
            expected: "\"P1\"".into(),
            found: "\"P2\"".into(),
            help: "quadratic interpolation does not preserve signs, which HKL (3.2) asks for"
                .into(),
        });
    }
    Ok(())
}
