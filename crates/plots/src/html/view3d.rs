//! A body in 3D in a page: its boundary and fields as compressed arrays, and the script that draws them.
//!
//! Values are in single precision. Of each frame the bits that differ from those of the frame before are stored, lowest bytes first, of
//! all arrays one after the other as one raw deflate stream in Base64. `view3d.js` reads them; nothing is loaded from anywhere.

use std::io::Write;

use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::{Compression, write::DeflateEncoder};
use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use crate::colour::ColourMap;
use crate::panels::zone_colour;
use crate::picture::DrawnZone;

/// The script of a page with a body.
pub(super) const SCRIPT: &str = include_str!("view3d.js");
/// What such a page has beside the style of all pages.
pub(super) const STYLE: &str = include_str!("view3d.css");

/// Colours of a map that the page has, the ends included.
const STOPS: u32 = 33;

/// A body in 3D.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyView {
    /// What it is, for those who do not see it.
    pub title: String,
    /// The name of each frame, an increment.
    pub frames: Vec<String>,
    /// Names of several bodies, each of which may be shown alone; empty for one.
    pub bodies: Vec<String>,
    /// Arrays by the keys that `view3d.js` knows.
    pub arrays: Vec<ViewArray>,
}

/// An array over the frames of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewArray {
    /// Its name in the page and its address.
    pub key: &'static str,
    /// Its name for the reader; empty for what is not shown as a number.
    pub label: &'static str,
    /// Its unit; empty without one.
    pub unit: String,
    /// What has the values.
    pub on: ViewPlace,
    /// What the values are.
    pub values: ViewValues,
    /// Numbers in a row.
    pub columns: usize,
    /// The first frame that has it.
    pub first: usize,
    /// Row after row for each frame, NaN where there is no value. Later frames than the last are as that.
    pub frames: Vec<Vec<f64>>,
}

/// What the rows of an array belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewPlace {
    /// Points of the boundary.
    Point,
    /// Triangles of the boundary.
    Triangle,
    /// Panes of the contact face.
    Pane,
    /// The obstacle.
    Obstacle,
}

/// What the values of an array are, and how the body is coloured by them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewValues {
    /// Whole numbers from 0.
    Indices,
    /// Where something is, the same in all frames.
    Places,
    /// Numbers that no field is made of.
    Plain,
    /// A field of the body, of vectors their lengths.
    OfBody,
    /// A field of the contact face.
    OfFace,
    /// States of contact, 0 open, 1 stick, 2 slip.
    Zones,
}

impl ViewPlace {
    const fn word(self) -> &'static str {
        ["point", "triangle", "pane", "obstacle"][self as usize]
    }
}

impl BodyView {
    /// Controls, pictures and data; hidden until the script has begun.
    pub(super) fn markup(&self) -> Markup {
        let (data, arrays) = self.encoded();
        // Inside a script only "<" could end it.
        let data = data.to_string().replace('<', "\\u003c");
        html! {
            p #view3d-without {
                "Turning the body needs JavaScript and a browser of 2023 or newer; the rest of the page needs neither."
            }
            div.view3d #view3d-figure hidden {
                div.controls {
                    label { "field " select #view3d-field {} }
                    label {
                        "increment " input #view3d-increment type="range" min="1" step="1";
                        output #view3d-increment-said {}
                    }
                    label {
                        "displacement " input #view3d-scale type="range" min="0";
                        output #view3d-scale-said {}
                    }
                    label { "pane " input #view3d-pane type="number" min="0" step="1"; }
                    label { "bodies " select #view3d-only { option value="" { "all" } } }
                    label { input #view3d-obstacle type="checkbox"; " obstacle" }
                    label { input #view3d-mesh type="checkbox"; " mesh lines" }
                    button #view3d-home type="button" { "reset view" }
                }
                div.stage {
                    canvas #view3d-body tabindex="0" role="img" {}
                    canvas #view3d-marks aria-hidden="true" {}
                }
                div.key {
                    span #view3d-key-label {}
                    output #view3d-low {}
                    canvas #view3d-key width="330" height="14" aria-hidden="true" {}
                    output #view3d-high {}
                }
                p #view3d-values role="status" {}
                p.help {
                    "Drag or arrow keys turn, with Shift they move; + and −, and the wheel once the picture has the focus, zoom; \
                     Home resets. A click keeps a pane. Dashed: the body at rest. Gaps are as many times larger as \
                     displacements. Colours span all increments."
                }
            }
            script #view3d-data type="application/json" { (PreEscaped(data)) }
            script #view3d-arrays type="text/plain" { (STANDARD.encode(&arrays)) }
        }
    }

    /// What the page says of the arrays, and their compressed codes.
    fn encoded(&self) -> (Value, Vec<u8>) {
        let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
        let mut rows = Vec::new();
        for array in &self.arrays {
            // Writing to memory does not fail.
            let _ = packed.write_all(&array.planes());
            rows.push(array.described());
        }
        let map = |map: ColourMap| -> Vec<String> {
            let last = f64::from(STOPS - 1);
            (0..STOPS)
                .map(|k| map.at(f64::from(k) / last).hex())
                .collect()
        };
        let data = json!({
            "title": self.title, "frames": self.frames, "bodies": self.bodies, "arrays": rows,
            "maps": { "body": map(ColourMap::Plasma), "face": map(ColourMap::Viridis) },
        });
        (data, packed.finish().unwrap_or_default())
    }
}

impl ViewArray {
    fn described(&self) -> Value {
        let rows = self
            .frames
            .first()
            .map_or(0, |values| values.len() / self.columns);
        let mut said = json!({
            "key": self.key, "label": self.label, "unit": self.unit, "on": self.on.word(), "rows": rows,
            "columns": self.columns, "first": self.first, "frames": self.frames.len(),
        });
        match self.values {
            ViewValues::Indices | ViewValues::Places | ViewValues::Plain => {}
            ViewValues::OfBody => said["map"] = "body".into(),
            ViewValues::OfFace => said["map"] = "face".into(),
            ViewValues::Zones => {
                let zones = [DrawnZone::Open, DrawnZone::Stick, DrawnZone::Slip];
                let class = |zone: DrawnZone| json!({ "label": zone.word(), "colour": zone_colour(zone).hex() });
                said["classes"] = zones.map(class).to_vec().into();
            }
        }
        said
    }

    /// The bytes of the array, frame after frame.
    fn planes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut before: Vec<u32> = Vec::new();
        for values in &self.frames {
            before.resize(values.len(), 0);
            let bits: Vec<u32> = values
                .iter()
                .map(|value| (*value as f32).to_bits())
                .collect();
            for plane in 0..4 {
                let changes = bits.iter().zip(&before);
                bytes.extend(changes.map(|(now, before)| ((now ^ before) >> (8 * plane)) as u8));
            }
            before = bits;
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::DeflateDecoder;

    use super::*;

    fn array(values: ViewValues, columns: usize, frames: Vec<Vec<f64>>) -> ViewArray {
        ViewArray {
            key: "a",
            label: "an array",
            unit: "m".into(),
            on: ViewPlace::Point,
            values,
            columns,
            first: 0,
            frames,
        }
    }

    /// The values of all arrays, frame after frame, as the script of the page finds them.
    fn decoded(view: &BodyView) -> Vec<Vec<f64>> {
        let (data, packed) = view.encoded();
        let mut bytes = Vec::new();
        DeflateDecoder::new(packed.as_slice())
            .read_to_end(&mut bytes)
            .expect("a deflate stream");
        let mut bytes = bytes.as_slice();
        let mut all = Vec::new();
        for said in data["arrays"].as_array().expect("arrays") {
            let whole = |key: &str| said[key].as_u64().expect("a number") as usize;
            let count = whole("rows") * whole("columns");
            let mut bits = vec![0_u32; count];
            for _ in 0..whole("frames") {
                let (planes, rest) = bytes.split_at(4 * count);
                bytes = rest;
                for (k, bits) in bits.iter_mut().enumerate() {
                    let change =
                        (0..4).map(|plane| u32::from(planes[plane * count + k]) << (8 * plane));
                    *bits ^= change.sum::<u32>();
                }
                all.push(
                    bits.iter()
                        .map(|bits| f64::from(f32::from_bits(*bits)))
                        .collect(),
                );
            }
        }
        assert!(bytes.is_empty());
        all
    }

    #[test]
    fn what_the_page_finds_is_what_was_given_in_single_precision() {
        let wave = |frame: usize| -> Vec<f64> {
            let values = (0..300).map(|k| (k as f64 * 0.1 + frame as f64).sin() * 1e-6);
            values.chain([f64::NAN, 0.0, 1e-6]).collect()
        };
        let whole = vec![0.0, 70000.0, f64::NAN, 16_777_216.0, 1.0, 0.0];
        let arrays = vec![
            array(ViewValues::Plain, 3, (0..4).map(wave).collect()),
            array(ViewValues::Indices, 2, vec![whole]),
            array(ViewValues::Plain, 1, vec![vec![-7.5; 5], vec![-7.5; 5]]),
            array(ViewValues::OfFace, 1, vec![vec![f64::NAN; 3]]),
            array(ViewValues::Plain, 1, vec![vec![]]),
        ];
        let given: Vec<Vec<f64>> = arrays
            .iter()
            .flat_map(|array| array.frames.clone())
            .collect();
        let view = BodyView {
            bodies: Vec::new(),
            title: "t".into(),
            frames: vec![],
            arrays,
        };
        let found = decoded(&view);
        assert_eq!(found.len(), given.len());
        for (k, (found, given)) in found.iter().zip(&given).enumerate() {
            assert_eq!(found.len(), given.len());
            for (found, given) in found.iter().zip(given) {
                // Half a unit in the last place.
                let agree = (found - given).abs() <= 0.6e-7 * given.abs()
                    || (found.is_nan() && given.is_nan());
                assert!(agree, "array {k}: {found} for {given}");
            }
        }
    }

    #[test]
    fn words_of_a_body_cannot_end_its_script() {
        let view = BodyView {
            bodies: Vec::new(),
            title: "</script><!--".into(),
            frames: vec!["<script>".into()],
            arrays: vec![],
        };
        let markup = view.markup().into_string();
        assert_eq!(markup.matches("</script>").count(), 2, "{markup}");
        assert_eq!(markup.matches("<script").count(), 2, "{markup}");
        assert!(!markup.contains("<!--"), "{markup}");
    }
}
