//! The laws whose ellipses are drawn, and what the panels of friction say of each.

use units::{Dimension, Unit, Units};

use super::scale::UnitScale;
use super::text::Label;

/// The law whose ellipses are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionKind {
    /// Coulomb's law: stresses are drawn over the pressure λ_ν.
    Coulomb,
    /// Coulomb's law up to a pressure: stresses are drawn over the slip bound g = min(λ_ν, p_cap).
    CappedCoulomb,
    /// Tresca's law: stresses are drawn as they are.
    Tresca,
}

impl FrictionKind {
    /// Unit of semi-axes and of the stress in an ellipse.
    pub(super) fn unit(self, units: Units) -> Unit {
        match self {
            Self::Coulomb | Self::CappedCoulomb => Unit::none(),
            Self::Tresca => units.of(Dimension::STRESS),
        }
    }

    /// Unit of the scaled tangential stress.
    pub(super) fn scaled_unit(self, units: Units) -> Unit {
        match self {
            Self::Coulomb | Self::CappedCoulomb => units.of(Dimension::STRESS),
            Self::Tresca => Unit::none(),
        }
    }

    /// F₁ or F₂; of Tresca's law g F₁ or g F₂.
    pub(super) fn semi_axis_symbol(self, axis: usize) -> Label {
        self.before_index().subscript(["1", "2"][axis])
    }

    /// ‖F⁻¹σ_t‖; of Tresca's law ‖(g F)⁻¹σ_t‖.
    pub(super) fn scaled_symbol(self) -> Label {
        let matrix = match self {
            Self::Coulomb | Self::CappedCoulomb => Label::plain("‖").italic("F"),
            Self::Tresca => Label::plain("‖(").italic("gF").upright(")"),
        };
        let stress = matrix.superscript("−1").italic("σ").subscript("t");
        stress.upright("‖")
    }

    /// Title of the panel of the scaled tangential stress, without its symbol.
    pub(super) fn scaled_title(self) -> &'static str {
        match self {
            Self::Coulomb | Self::CappedCoulomb => "(b) Scaled tangential contact stress ",
            Self::Tresca => "(b) Tangential contact stress over its bound ",
        }
    }

    /// Title of a map of semi-axes, without its symbol.
    pub(super) fn semi_axis_title(self) -> &'static str {
        match self {
            Self::Coulomb | Self::CappedCoulomb => "Coefficient of friction ",
            Self::Tresca => "Bound of the tangential stress ",
        }
    }

    /// The legend's words for the ellipses.
    pub(super) fn semi_axes_label(self) -> Label {
        let first = Label::plain("semi-axes ").then(&self.semi_axis_symbol(0));
        first.upright(", ").then(&self.semi_axis_symbol(1))
    }

    /// The legend's words for the line in an ellipse: σ_t/λ_ν, with a cap σ_t/g; of Tresca's law σ_t.
    pub(super) fn stress_label(self) -> Label {
        let stress = Label::default().italic("σ").subscript("t");
        match self {
            Self::Coulomb => stress.upright("/").italic("λ").subscript("ν"),
            Self::CappedCoulomb => stress.upright("/").italic("g"),
            Self::Tresca => stress,
        }
    }

    /// The value of the scale bar of the ellipses.
    pub(super) fn scale_bar_label(self, value: f64, unit: &Unit) -> Label {
        let symbol = self.before_index().upright(" = ");
        let number = UnitScale::new(value, &Unit::none()).number(value);
        symbol.then(&number).upright(unit.beside())
    }

    /// What a pane says of its semi-axes and its stress, both in `unit`.
    pub(super) fn describe(self, semi_axes: [f64; 2], stress: [f64; 2], unit: &Unit) -> String {
        let ([a, b], [t1, t2]) = (semi_axes, stress);
        match self {
            Self::Coulomb => {
                format!("F1 = {a:.4}, F2 = {b:.4}, σt/λν = ({t1:.4}, {t2:.4})")
            }
            Self::CappedCoulomb => {
                format!("F1 = {a:.4}, F2 = {b:.4}, σt/g = ({t1:.4}, {t2:.4})")
            }
            Self::Tresca => {
                format!(
                    "gF1 = {a:.4e}, gF2 = {b:.4e}, σt = ({t1:.4e}, {t2:.4e}){}",
                    unit.beside()
                )
            }
        }
    }

    fn before_index(self) -> Label {
        match self {
            Self::Coulomb | Self::CappedCoulomb => Label::default().italic("F"),
            Self::Tresca => Label::default().italic("gF"),
        }
    }
}
