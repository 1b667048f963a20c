//! Quantities of an answer that the mesh can be refined for.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Component, ElementOrder, InvalidValue, Measure, Scene, validate::require};

/// A quantity of an answer whose discretisation error is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Functional {
    /// The total normal contact force.
    NormalForce,
    /// The length of the total tangential contact force of one contact face.
    TangentialForce,
    /// The mean pressure around the place of the largest one, in a cube whose edges are a tenth of the contact face's extent.
    LargestPressure,
    /// The largest von Mises stress of a node.
    LargestVonMises,
    /// The area of the panes in contact.
    ContactArea,
    /// The area of the panes that stick.
    StickArea,
    /// The mean displacement around the place of the largest one, along it, in a cube whose edges are a tenth of the body's extent.
    PeakDisplacement,
    /// The strain energy of body and springs.
    StrainEnergy,
    /// The energy that friction takes in a load history.
    Dissipation,
    /// The mean of a component of the displacement over the part of the body in a box.
    #[schemars(extend("examples" = ["of = { mean_displacement = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], component = \"z\" } }"]))]
    MeanDisplacement {
        /// Two opposite corners [min, max] in m.
        #[serde(rename = "box")]
        #[schemars(extend("measures" = Measure::Length))]
        corners: [[f64; 3]; 2],
        /// Along which axis.
        component: Component,
    },
    /// The mean pressure over the part of the contact faces in a box.
    #[schemars(extend("examples" = ["of = { mean_pressure = { box = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]] } }"]))]
    MeanPressure {
        /// Two opposite corners [min, max] in m.
        #[serde(rename = "box")]
        #[schemars(extend("measures" = Measure::Length))]
        corners: [[f64; 3]; 2],
    },
}

impl Functional {
    /// Those that need no box.
    pub const NAMED: [Self; 9] = [
        Self::NormalForce,
        Self::TangentialForce,
        Self::LargestPressure,
        Self::LargestVonMises,
        Self::ContactArea,
        Self::StickArea,
        Self::PeakDisplacement,
        Self::StrainEnergy,
        Self::Dissipation,
    ];

    /// Its name in scenes, files and on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::NormalForce => "normal_force",
            Self::TangentialForce => "tangential_force",
            Self::LargestPressure => "largest_pressure",
            Self::LargestVonMises => "largest_von_mises",
            Self::ContactArea => "contact_area",
            Self::StickArea => "stick_area",
            Self::PeakDisplacement => "peak_displacement",
            Self::StrainEnergy => "strain_energy",
            Self::Dissipation => "dissipation",
            Self::MeanDisplacement { .. } => "mean_displacement",
            Self::MeanPressure { .. } => "mean_pressure",
        }
    }

    /// Whether its value belongs to a box in the body: one that a mean is over, the pane of the largest pressure, or a node.
    #[must_use]
    pub fn has_place(self) -> bool {
        self.is_largest() || self == Self::PeakDisplacement || self.corners().is_some()
    }

    /// Whether it is an area of the contact face.
    #[must_use]
    pub fn is_area(self) -> bool {
        matches!(self, Self::ContactArea | Self::StickArea)
    }

    /// Whether it is the largest of some values, which is known where it has settled from one mesh to the next.
    #[must_use]
    pub fn is_largest(self) -> bool {
        matches!(self, Self::LargestPressure | Self::LargestVonMises)
    }

    /// The box that it is a mean over; `None` where it has none or follows the answer.
    #[must_use]
    pub fn corners(self) -> Option<[[f64; 3]; 2]> {
        match self {
            Self::MeanDisplacement { corners, .. } | Self::MeanPressure { corners } => {
                Some(corners)
            }
            _ => None,
        }
    }

    /// Refuses a quantity that no solution of the scene has.
    pub(super) fn check(self, scene: &Scene) -> Result<(), InvalidValue> {
        let has_volume = self.corners().is_none_or(|[low, high]| {
            let may_be_flat = matches!(self, Self::MeanPressure { .. });
            (0..3).all(|c| low[c] < high[c] || may_be_flat && low[c] == high[c])
        });
        let refusal = match self {
            Self::NormalForce
            | Self::LargestPressure
            | Self::ContactArea
            | Self::MeanPressure { .. }
                if !scene.has_contact() =>
            {
                Some((
                    "a quantity of a scene without contact",
                    "without a contact face there are the strain energy and displacements",
                ))
            }
            Self::TangentialForce | Self::StickArea if !scene.has_friction() => Some((
                "a quantity of a scene without friction",
                "without friction tangential forces are zero and no pane sticks",
            )),
            Self::TangentialForce if scene.contact_order().len() > 1 => Some((
                "a quantity of a scene with several contact faces",
                "tangential forces of several faces, each in axes of its own, have no sum",
            )),
            Self::NormalForce
            | Self::TangentialForce
            | Self::LargestPressure
            | Self::MeanPressure { .. }
                if scene.element() == ElementOrder::P1 =>
            {
                Some((
                    "a quantity whose error linear tetrahedra show",
                    "local errors of linear elements do not reach the contact face: set body.element = \"P2\", with a mesh file of quadratic \
                 tetrahedra (gmsh -order 2), or refine for displacements, the strain energy or areas",
                ))
            }
            Self::Dissipation => Some((
                "a quantity of one increment or of a static problem",
                "friction takes energy over a load history, whose error gathers over all increments: its adjoint runs backwards \
             through them, which is not available; refine for the energy norm or a force, and compare two targets",
            )),
            _ if !has_volume => Some((
                "a box with the smaller coordinates first and a volume",
                "write box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], for example",
            )),
            _ => None,
        };
        let (expected, help) = refusal.unwrap_or_default();
        require(refusal.is_none(), "adapt.of", expected, self.word(), help)
    }
}
