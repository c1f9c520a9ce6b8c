//! The texels of a chart, drawn by the renderer of views.

use super::camera::camera_of_chart;
use super::layout::PlacedChart;
use super::parts::Parts;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_projection::Renders;
use quadratura_view::{Blend, DisplayMode, Exposure, Mode, Quality, Shot, TreeMethod, Unseen};
use quadratura_views::preview::Preview;

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
    /// The number of charts of which some texels are coarser than photos are, because memory does not hold them.
    pub coarser: usize,
}

impl Painter<'_> {
    /// Draws what a chart's cell shows of its plane, in one exposure: `width` x `height` texels, of which (`gutter`, `gutter`) is the chart's upper left
    /// corner. `put` gets its texels band by band from the top, each whole rows of sRGB and alpha: no chart need fit into memory.
    ///
    /// # Errors
    /// As [`quadratura_projection::Renders::picture`].
    pub fn paint(
        &mut self,
        placed: &PlacedChart,
        [density, gutter]: [f64; 2],
        [width, height]: [u32; 2],
        display: DisplayMode,
        mut put: impl FnMut(&[[u8; 4]]),
        task: &Task,
    ) -> Result<()> {
        let of_part = |&part: &usize| self.parts.faces[part].face;
        let start = -(gutter as i32);
        let cell = PixelRect { x: start, y: start, w: width, h: height };
        let (camera, pose) = camera_of_chart(&placed.chart, density, cell);
        let shot = Shot {
            blend: self.blend(placed),
            quality: Quality::Finer,
            display,
            exposure: Exposure::Common,
            without: self.without.clone(),
            hidden: self.preview.all_but(placed.chart.faces.iter().map(of_part)),
            trees: TreeMethod::None,
            surroundings: false,
            unseen: if self.holes { Unseen::Marked } else { Unseen::Continued },
            ..Shot::new(camera, pose)
        };
        let mut sliced = self.preview.begin_faces(&shot, task)?;
        let mut is_done = false;
        while !is_done {
            task.check_cancelled()?;
            is_done = self.preview.advance(&mut sliced, task)?;
            put(sliced.take_rows().as_chunks().0);
        }
        self.coarser += usize::from(display == DisplayMode::Colour && sliced.is_coarser());
        Ok(())
    }

    /// Returns how photos are blended. Cards show one photo: the view looks at them as that photo did.
    fn blend(&self, placed: &PlacedChart) -> Blend {
        match self.parts.faces[placed.chart.faces[0]].card_of {
            Some(_) => Blend { mode: Mode::Best, lambda: 0.0, ..Blend::default() },
            None => Blend { photos: PHOTOS, ..Blend::default() },
        }
    }
}
