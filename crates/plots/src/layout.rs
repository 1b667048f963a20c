//! Where the parts of a panel sit; the same for all panels of one picture.

use units::{Dimension, Unit};

use super::axis::{Axis, PlotFrame};
use super::canvas::{Anchor, Canvas, Point};
use super::panes::ContactBox;
use super::picture::ContactPicture;
use super::scale::{Ticks, UnitScale, factor_label};
use super::text::Label;
use super::view::Vector;

/// Width of a panel in pixels.
pub(super) const PANEL_WIDTH: f64 = 640.0;
/// Font size of panel titles.
pub(super) const TITLE_SIZE: f64 = 15.0;
/// Font size of axis labels, colour bar titles and legends.
pub(super) const LABEL_SIZE: f64 = 13.0;
/// Font size of tick labels and notes.
pub(super) const TICK_SIZE: f64 = 12.0;
/// Vertical space of the title of a map and a line of words below it.
const MAP_TOP: f64 = 48.0;
/// Height of a colour bar or legend below the plot.
pub(super) const KEY_HEIGHT: f64 = 62.0;

const AXIS_HEIGHT: f64 = 50.0;
const LEAST_HEIGHT: f64 = 350.0;
/// What is beside a plot.
pub(super) const RIGHT_MARGIN: f64 = 28.0;
/// Plots that are longer than this many times their width are stretched across.
const MOST_SLENDER: f64 = 12.0;

/// Rectangles and axes of the panels of one picture.
#[derive(Clone, Debug)]
pub(super) struct PictureLayout {
    /// Height of every panel.
    pub(super) height: f64,
    /// Where the colour bar or legend begins.
    pub(super) key: Point,
    /// The plot of a map.
    pub(super) frame: PlotFrame,
    /// The part of the contact plane that fills the plot.
    pub(super) contact: ContactBox,
    /// Says which direction is stretched, if any.
    pub(super) note: Option<Label>,
}

impl PictureLayout {
    /// Chooses height and stretch from the shape of the contact part.
    pub(super) fn new(picture: &ContactPicture<'_>) -> Self {
        let contact = ContactBox::framed(picture);
        let [width, height] = contact.extent();
        let stretch = [
            stretch_factor(height / width, MOST_SLENDER),
            stretch_factor(width / height, MOST_SLENDER),
        ];
        let aspect = width * stretch[0] / (height * stretch[1]);
        let names = [
            axis_name(picture.axis_1, "1"),
            axis_name(picture.axis_2, "2"),
        ];
        let scales = axis_scales(&contact, &picture.units.of(Dimension::LENGTH));
        let intervals =
            [0, 1].map(|k| [contact.low[k], contact.high[k]].map(|end| scales[k].scaled(end)));
        let vertical = |pixels: f64| {
            let most = (pixels / 28.0).clamp(2.0, 8.0).floor();
            Ticks::new(intervals[1][0], intervals[1][1], most as usize)
        };
        let left = 46.0 + vertical(200.0).widest(TICK_SIZE);
        let room = PANEL_WIDTH - left - RIGHT_MARGIN;
        let plot_height = (room / aspect).min(380.0);
        let size = [plot_height * aspect, plot_height];
        let needed = MAP_TOP + plot_height + AXIS_HEIGHT + KEY_HEIGHT;
        let panel_height = needed.max(LEAST_HEIGHT).ceil();
        let corner = [
            left + (room - size[0]) / 2.0,
            MAP_TOP + (panel_height - needed) / 2.0,
        ];
        let axis = |k: usize, ticks: &Ticks, direction: Vector| {
            let title = axis_title(&scales[k], &names[k], direction);
            Axis::linear(title, ticks, intervals[k])
        };
        let horizontal = fitting_ticks(intervals[0][0], intervals[0][1], size[0]);
        let axes = [
            axis(0, &horizontal, picture.axis_1),
            axis(1, &vertical(size[1]), picture.axis_2),
        ];
        let note = (0..2).find(|&axis| stretch[axis] > 1.0).map(|axis| {
            names[axis]
                .clone()
                .upright(" stretched × ")
                .then(&factor_label(stretch[axis]))
        });
        let is_part = contact != ContactBox::new(picture);
        let note = match (note, is_part) {
            (note, false) => note,
            (None, true) => Some(Label::plain("around the panes in contact")),
            (Some(note), true) => Some(Label::plain("around the panes in contact, ").then(&note)),
        };
        Self {
            height: panel_height,
            key: [left, corner[1] + plot_height + AXIS_HEIGHT],
            frame: PlotFrame {
                corner,
                size,
                axes,
                has_grid: false,
            },
            contact,
            note,
        }
    }

    /// Pixel of a point of the contact plane.
    pub(super) fn point(&self, point: [f64; 2]) -> Point {
        let extent = self.contact.extent();
        let right = (point[0] - self.contact.low[0]) / extent[0];
        let up = (point[1] - self.contact.low[1]) / extent[1];
        [
            self.frame.corner[0] + right * self.frame.size[0],
            self.frame.corner[1] + (1.0 - up) * self.frame.size[1],
        ]
    }

    /// Pixels per unit of length along both axes.
    pub(super) fn pixels_per_length(&self) -> [f64; 2] {
        let extent = self.contact.extent();
        [0, 1].map(|k| self.frame.size[k] / extent[k])
    }

    /// An empty panel with its title.
    pub(super) fn panel(&self, title: &Label) -> Canvas {
        titled_panel([PANEL_WIDTH, self.height], title)
    }
}

/// An empty panel of a size with its title.
pub(super) fn titled_panel([width, height]: Point, title: &Label) -> Canvas {
    let mut canvas = Canvas::new(width, height);
    canvas.bold_text([16.0, 26.0], title, TITLE_SIZE, Anchor::Start);
    canvas
}

/// Factor across something whose length is `slenderness` times its width; 1 unless that exceeds
/// `most`.
///
/// Two significant digits, so that the printed factor is the true one.
pub(super) fn stretch_factor(slenderness: f64, most: f64) -> f64 {
    let factor = slenderness / most;
    if !factor.is_finite() || factor <= 1.0 {
        return 1.0;
    }
    let decade = 10f64.powf(factor.log10().floor() - 1.0);
    (factor / decade).round() * decade
}

/// x, y or z when the axis is one of them, otherwise s with an index.
pub(super) fn axis_name(axis: Vector, index: &str) -> Label {
    for (component, name) in ["x", "y", "z"].into_iter().enumerate() {
        let along = axis[component];
        let off_axis = (0..3).filter(|&other| other != component);
        // Tangents that come from a normalisation are off by rounding only.
        if off_axis.map(|other| axis[other].abs()).fold(0.0, f64::max) > 1e-9 {
            continue;
        }
        return if along < 0.0 {
            Label::plain("−").italic(name)
        } else {
            Label::default().italic(name)
        };
    }
    Label::default().italic("s").subscript(index)
}

/// Name and unit of an axis; of one that is none of x, y and z also where it goes.
fn axis_title(scale: &UnitScale, name: &Label, axis: Vector) -> Label {
    const NEARLY: f64 = 0.985; // cosine of 10°
    if axis.iter().any(|part| 1.0 - part.abs() < 1e-12) {
        return scale.title(name);
    }
    if let Some(k) = (0..3).find(|&k| axis[k].abs() > NEARLY) {
        let sign = if axis[k] < 0.0 { " ≈ −" } else { " ≈ " };
        return scale.title(&name.clone().upright(sign).italic(["x", "y", "z"][k]));
    }
    let parts = axis.map(|part| format!("{:.2}", part + 0.0).replace('-', "−"));
    scale
        .title(name)
        .upright(format!(" along ({})", parts.join(", ")))
}

/// One prefix for both axes unless their extents differ by more than 1000.
fn axis_scales(contact: &ContactBox, unit: &Unit) -> [UnitScale; 2] {
    let extent = contact.extent();
    let larger = extent[0].max(extent[1]);
    let alike = extent[0].min(extent[1]) * 1000.0 > larger;
    extent.map(|length| UnitScale::new(if alike { larger } else { length }, unit))
}

/// The densest ticks of an interval that do not touch each other on a horizontal axis.
pub(super) fn fitting_ticks(low: f64, high: f64, pixels: f64) -> Ticks {
    let fits = |ticks: &Ticks| {
        let gaps = (ticks.values.len() - 1) as f64;
        let step = match ticks.values[..] {
            [first, second, ..] => (second - first) / (high - low) * pixels,
            _ => pixels,
        };
        gaps == 0.0 || step >= ticks.widest(TICK_SIZE) + 16.0
    };
    (2..=8)
        .rev()
        .map(|most| Ticks::new(low, high, most))
        .find(fits)
        .unwrap_or_else(|| Ticks::new(low, high, 2))
}
