//! A stroke of the brush in a view of the model (see `docs/formats.md`).

use serde::{Deserialize, Serialize};

use super::camera_path::LONGEST_SIDE;
use super::stack::StackCamera;
use quadratura_base::geometry::{Pinhole, Pose};

/// The version of the format that this program reads.
pub const STROKE_VERSION: u32 = 1;

/// What a brush does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BrushMode {
    /// It paints with one colour.
    #[default]
    Colour,
    /// It paints with what the view shows beside the source.
    Clone,
    /// It clones, and adapts the colours to those around the stroke.
    Heal,
    /// It removes the paint of earlier strokes.
    Erase,
    /// In a photo's own view: one sees through the layer with a matte that is under it.
    #[serde(rename = "see-through")]
    SeeThrough,
    /// In a photo's own view: that layer is solid.
    Solid,
    /// In a photo's own view: how much of that layer is there is solved from the photo's colours, with the matte around
    /// the stroke.
    Solve,
}

impl BrushMode {
    /// Returns the word for it in lists.
    pub fn word(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Clone => "clone",
            Self::Heal => "heal",
            Self::Erase => "erase",
            Self::SeeThrough => "see-through",
            Self::Solid => "solid",
            Self::Solve => "solve",
        }
    }

    /// Returns true when it changes mattes: in the view of a photo alone.
    pub fn is_of_matte(self) -> bool {
        matches!(self, Self::SeeThrough | Self::Solid | Self::Solve)
    }

    /// Returns true when it paints with what the view shows elsewhere.
    pub fn has_source(self) -> bool {
        matches!(self, Self::Clone | Self::Heal)
    }
}

/// A stroke: where a brush was in the picture of a view, and what it does there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// The format's version, [`STROKE_VERSION`].
    pub version: u32,
    /// The view in which it is painted.
    pub view: StrokeView,
    /// The brush.
    pub brush: Brush,
    /// The position of the source that belongs to the first sample, in pixels of the view; clone and heal need it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<[f64; 2]>,
    /// The token of the image layer whose matte it changes, for modes of the matte brush; `None` for the nearest one with a matte
    /// at each pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// The positions of the brush, in order.
    pub samples: Vec<StrokeSample>,
}

/// The view of a stroke.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrokeView {
    /// The width of its picture in pixels.
    pub width: u32,
    /// The height of its picture in pixels.
    pub height: u32,
    /// The camera, world to camera.
    pub camera: StackCamera,
}

/// A brush.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Brush {
    /// What it does.
    pub mode: BrushMode,
    /// The radius in pixels of the view at the first sample. It has the same size on the surface all along the stroke.
    pub radius: f64,
    /// The share of the radius within which it has its full effect, 0 to 1; from there it fades out.
    #[serde(default = "half")]
    pub hardness: f64,
    /// The share of the new colour, 0 to 1.
    #[serde(default = "one")]
    pub opacity: f64,
    /// The colour in sRGB as the view shows it; only mode `colour` uses it.
    #[serde(default)]
    pub colour: [u8; 3],
}

/// A position of the brush.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrokeSample {
    /// The position in pixels of the view.
    pub at: [f64; 2],
    /// The pressure, 0 to 1, by which the radius is multiplied.
    #[serde(default = "one")]
    pub pressure: f64,
}

fn half() -> f64 {
    0.5
}

fn one() -> f64 {
    1.0
}

impl StrokeView {
    /// Describes a view.
    pub fn new(camera: &Pinhole, pose: &Pose) -> Self {
        let Pinhole { width, height, fx, fy, cx, cy } = *camera;
        let rows = pose.rotation.transpose().to_cols_array_2d();
        let camera = StackCamera {
            K: [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
            R: rows,
            t: pose.translation.to_array(),
        };
        Self { width, height, camera }
    }
}

impl Stroke {
    /// Returns what is wrong with it, and where; `None` for a stroke that can be applied.
    pub fn problem(&self) -> Option<(String, String)> {
        let wrong = |place: &str, found: String| Some((place.to_owned(), found));
        let share = |value: f64| (0.0..=1.0).contains(&value);
        let brush = &self.brush;
        if self.version != STROKE_VERSION {
            let found = format!("version {}, this program reads version {STROKE_VERSION}", self.version);
            return wrong("version", found);
        }
        if !(brush.radius > 0.0 && brush.radius.is_finite()) {
            return wrong("brush.radius", format!("{}, expected a number of pixels above 0", brush.radius));
        }
        if !share(brush.hardness) || !share(brush.opacity) {
            let found = format!("hardness {} and opacity {}, expected 0 to 1", brush.hardness, brush.opacity);
            return wrong("brush", found);
        }
        if brush.mode.has_source() && self.source.is_none() {
            return wrong("source", format!("there is none, and mode {} needs it", brush.mode.word()));
        }
        if self.samples.is_empty() {
            return wrong("samples", "there are none".into());
        }
        let bad =
            |sample: &StrokeSample| !(sample.at.iter().all(|at| at.is_finite()) && share(sample.pressure));
        if let Some(index) = self.samples.iter().position(bad) {
            let found = "expected two pixel coordinates and a pressure from 0 to 1".into();
            return wrong(&format!("samples[{index}]"), found);
        }
        let focal = [self.view.camera.K[0][0], self.view.camera.K[1][1]];
        let StrokeView { width, height, .. } = self.view;
        if [width, height].iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) {
            return wrong(
                "view",
                format!("{width} x {height} pixels, expected sides of 1 to {LONGEST_SIDE}"),
            );
        }
        if focal.iter().any(|f| !(*f > 0.0 && f.is_finite())) {
            return wrong("view", "expected focal lengths above 0".into());
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STROKE: &str = r#"{"version": 1,
        "view": {"width": 64, "height": 48, "camera":
            {"K": [[64, 0, 32], [0, 64, 24], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 0]}},
        "brush": {"mode": "heal", "radius": 5},
        "source": [3, 4],
        "samples": [{"at": [10, 20]}, {"at": [12, 20], "pressure": 0.5}]}"#;

    #[test]
    fn a_stroke_is_read_with_usual_values_for_what_is_left_out() {
        let stroke: Stroke = serde_json::from_str(STROKE).unwrap();
        assert_eq!(
            (stroke.brush.hardness, stroke.brush.opacity, stroke.samples[0].pressure),
            (0.5, 1.0, 1.0)
        );
        assert_eq!(stroke.problem(), None);
    }

    #[test]
    fn what_cannot_be_applied_is_named_with_its_place() {
        let place = |change: &dyn Fn(&mut Stroke)| {
            let mut stroke: Stroke = serde_json::from_str(STROKE).unwrap();
            change(&mut stroke);
            stroke.problem().map(|(place, _)| place).unwrap_or_default()
        };
        assert_eq!(place(&|stroke| stroke.version = 2), "version");
        assert_eq!(place(&|stroke| stroke.brush.radius = 0.0), "brush.radius");
        assert_eq!(place(&|stroke| stroke.brush.opacity = 1.5), "brush");
        assert_eq!(place(&|stroke| stroke.source = None), "source");
        assert_eq!(place(&|stroke| stroke.view.width = LONGEST_SIDE + 1), "view");
        assert_eq!(place(&|stroke| stroke.view.height = 0), "view");
        assert_eq!(place(&|stroke| stroke.view.camera.K[1][1] = f64::NAN), "view");
        assert_eq!(place(&|stroke| stroke.samples.clear()), "samples");
        assert_eq!(place(&|stroke| stroke.samples[1].pressure = f64::NAN), "samples[1]");
        assert_eq!(place(&|stroke| stroke.view.camera.K[0][0] = 0.0), "view");
    }
}
