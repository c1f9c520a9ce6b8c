//! What there is to say about an orthophoto.

use std::path::PathBuf;

use serde::Serialize;

use quadratura_view::legend::Origin;

/// The shares of a picture's surfaces by where their pixels come from, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SourceShares {
    /// Record: photos show it, the photo of the texel itself.
    pub photographed: f64,
    /// Record: filled from other photos, which show it.
    pub filled: f64,
    /// Reconstruction: painted.
    pub painted: f64,
    /// Reconstruction: inpainted.
    pub inpainted: f64,
    /// Shown by no photo: continued from what is around it, or left empty.
    pub nothing: f64,
}

impl SourceShares {
    /// Counts a pixel.
    pub(super) fn add(&mut self, origin: Option<Origin>) {
        *match origin {
            Some(Origin::Photo) => &mut self.photographed,
            Some(Origin::OtherPhoto) => &mut self.filled,
            Some(Origin::Paint | Origin::Propagated) => &mut self.painted,
            Some(Origin::Example | Origin::Diffused) => &mut self.inpainted,
            None => &mut self.nothing,
        } += 1.0;
    }

    /// Returns the shares of counted pixels.
    pub(super) fn of_one(self) -> Self {
        let Self { photographed, filled, painted, inpainted, nothing } = self;
        let all = (photographed + filled + painted + inpainted + nothing).max(1.0);
        Self {
            photographed: photographed / all,
            filled: filled / all,
            painted: painted / all,
            inpainted: inpainted / all,
            nothing: nothing / all,
        }
    }

    /// Returns the share that photos record.
    pub fn record(&self) -> f64 {
        self.photographed + self.filled
    }

    /// Returns the share that was reconstructed.
    pub fn reconstruction(&self) -> f64 {
        self.painted + self.inpainted
    }
}

/// The place of a picture in the site's frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlaceInFrame {
    /// The upper left corner of the upper left pixel, in the frame's unit.
    pub corner: [f64; 3],
    /// The step from one pixel to the next to the right, in the frame's unit.
    pub right: [f64; 3],
    /// The step from one pixel to the next below.
    pub down: [f64; 3],
}

/// An orthophoto that was made. It is also the file beside it, `NAME.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrthoReport {
    /// What it is of.
    pub subject: String,
    /// The folder of the files.
    #[serde(skip)]
    pub folder: PathBuf,
    /// The names of the files.
    pub files: Vec<String>,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// The side of a pixel in metres.
    pub pixel_m: f64,
    /// The number of the scale: 50 for 1:50.
    pub scale: f64,
    /// Pixels per inch of a print at that scale.
    pub dpi: f64,
    /// The place in the site's frame.
    pub place: PlaceInFrame,
    /// The number of the projected system in EPSG's register, of plans of sites that have one; `corner` and its offset are east and north.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
    /// East and north of the upper left corner on the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_corner: Option<[f64; 2]>,
    /// Where its pixels come from.
    pub shares: SourceShares,
    /// The side of a pixel of the best photo on the surface in metres, in the median: what can be told apart, and so the uncertainty of a
    /// point that is measured in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub photo_pixel_m: Option<f64>,
    /// The size of the page in mm, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_mm: Option<[f64; 2]>,
    /// What was left out and why, in sentences.
    pub left_out: Vec<String>,
}
