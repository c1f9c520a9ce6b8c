//! The texels of a chart, drawn by the renderer of views.

use super::camera::camera_of_chart;
use super::layout::PlacedChart;
use super::parts::Parts;
use crate::preview::Preview;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_view::{Blend, DisplayMode, Exposure, Mode, Quality, Shot, TreeMethod, Unseen};

/// The side of the pictures of which charts are drawn, in texels.
const PICTURE: u32 = 1024;

/// The sides of pictures are multiples of this, so that the renderer needs few targets.
const STEP: u32 = 64;

/// The number of photos that share a texel: one where it is alone, and a second one where it takes over. More would blur.
const PHOTOS: u32 = 2;

/// Draws charts.
pub(super) struct Painter<'a> {
    pub preview: &'a mut Preview,
    pub parts: &'a Parts,
    /// The photos that are not used.
    pub without: Vec<PhotoId>,
    /// Whether what no photo shows is left empty.
    pub holes: bool,
}

impl Painter<'_> {
    /// Draws the part of the plane that a chart's cell shows: colours and alpha, `size` texels, of which (`gutter`, `gutter`) is the chart's upper left corner.
    pub fn paint(
        &mut self,
        placed: &PlacedChart,
        [density, gutter]: [f64; 2],
        [width, height]: [u32; 2],
        display: DisplayMode,
        task: &Task,
    ) -> Result<Vec<[u8; 4]>> {
        let mut texels = vec![[0; 4]; width as usize * height as usize];
        let hidden = self.preview.all_but(placed.chart.faces.iter().map(|&part| self.parts.faces[part].face));
        let gutter = gutter as i32;
        for (y, x) in starts(height).flat_map(|y| starts(width).map(move |x| (y, x))) {
            let size = [width - x, height - y].map(|rest| rest.min(PICTURE));
            let part = PixelRect {
                x: x as i32 - gutter,
                y: y as i32 - gutter,
                w: size[0].next_multiple_of(STEP),
                h: size[1].next_multiple_of(STEP),
            };
            let (camera, pose) = camera_of_chart(&placed.chart, density, part);
            let shot = Shot {
                blend: self.blend(placed),
                quality: Quality::Finer,
                display,
                exposure: Exposure::Common,
                without: self.without.clone(),
                hidden: hidden.clone(),
                trees: TreeMethod::None,
                surroundings: false,
                unseen: if self.holes { Unseen::Marked } else { Unseen::Continued },
                ..Shot::new(camera, pose)
            };
            let picture = self.preview.picture_of_faces(&shot, task)?;
            let rows = picture.rgba.as_chunks::<4>().0.chunks(part.w as usize);
            for (row, pixels) in rows.take(size[1] as usize).enumerate() {
                let start = (y as usize + row) * width as usize + x as usize;
                texels[start..start + size[0] as usize].copy_from_slice(&pixels[..size[0] as usize]);
            }
        }
        Ok(texels)
    }

    /// Returns how photos are blended. Cards show one photo: the view looks at them as that photo did.
    fn blend(&self, placed: &PlacedChart) -> Blend {
        match self.parts.faces[placed.chart.faces[0]].card_of {
            Some(_) => Blend { mode: Mode::Best, lambda: 0.0, ..Blend::default() },
            None => Blend { photos: PHOTOS, ..Blend::default() },
        }
    }
}

/// Returns where the pictures along one side begin.
fn starts(side: u32) -> impl Iterator<Item = u32> + Clone {
    (0..side).step_by(PICTURE as usize)
}
