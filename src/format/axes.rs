//! Axes whose entries have names.

use runfile::{Axis, Extent};

/// The global axes.
pub(super) const XYZ: Extent = Extent::Labelled(&Axis {
    name: "axis",
    labels: &["x", "y", "z"],
});

/// The axes of friction.
pub(super) const FRICTION_AXES: Extent = Extent::Labelled(&Axis {
    name: "friction_axis",
    labels: &["t1", "t2"],
});

/// The normal and the axes of friction.
pub(super) const CONTACT_AXES: Extent = Extent::Labelled(&Axis {
    name: "contact_axis",
    labels: &["nu", "t1", "t2"],
});

/// The components of a stress.
pub(super) const STRESS_COMPONENTS: Extent = Extent::Labelled(&Axis {
    name: "stress_component",
    labels: &["xx", "yy", "zz", "yz", "xz", "xy"],
});

/// What panes do.
pub(super) const ZONES: Extent = Extent::Labelled(&Axis {
    name: "zone",
    labels: &["open", "stick", "slip"],
});

/// The figures of a certificate.
pub(super) const CERTIFICATE_FIGURES: Extent = Extent::Labelled(&Axis {
    name: "figure",
    labels: &super::CERTIFICATE,
});

/// Where forces come from.
pub(super) const FORCE_SOURCES: Extent = Extent::Labelled(&Axis {
    name: "source",
    labels: &["contact", "applied", "clamp"],
});
