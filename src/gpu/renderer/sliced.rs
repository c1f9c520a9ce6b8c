//! Drawing of an image in slices on the device; [`Sliced`] holds what is drawn so far.

use std::time::Instant;

use super::Renderer;
use super::prepared::{DrawnSurfaces, Prepared};
use super::render_target::{self, RenderTarget};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::exposure::{resolution, visible_shares};
use quadratura_projection::{Renders, Sliced};
use quadratura_view::{Picture, Shot};

impl Renderer {
    pub(super) fn begun(&mut self, shot: &Shot) -> Result<Sliced> {
        render_target::judge_size(shot)?;
        self.face(shot);
        let cells = || self.cells(shot, self.cell_px(shot), &[], self.store(shot));
        if !shot.supersampled {
            let exposure = self
                .exposure(shot, || visible_shares(shot, &self.model, &self.sources, &self.surface, &cells()));
            return Ok(Sliced::new(shot, exposure));
        }
        let cells = cells();
        let exposure =
            self.exposure(shot, || visible_shares(shot, &self.model, &self.sources, &self.surface, &cells));
        let samples = resolution(shot, &self.model, &self.sources, &self.surface, &cells);
        Ok(Sliced::finer(shot, samples, exposure))
    }

    pub(super) fn advanced(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        let start = Instant::now();
        let (tile, prepared) = self.prepared_tile(sliced, task)?;
        let whole = sliced.drawn();
        let is_complete = if tile.linear {
            let drawn = self.drawn(&tile, whole, prepared, RenderTarget::linear_picture, task)?;
            sliced.add_linear(drawn)
        } else {
            let drawn = self.drawn(&tile, whole, prepared, RenderTarget::picture, task)?;
            sliced.add(drawn)
        };
        let px = f64::from(tile.camera.width) * f64::from(tile.camera.height);
        sliced.costs(start.elapsed().as_secs_f64() / px);
        Ok(is_complete)
    }

    /// Prepares the next tile of an image: a smaller one where memory does not hold the texels of the usual one.
    fn prepared_tile(&mut self, sliced: &mut Sliced, task: &Task) -> Result<(Shot, Prepared)> {
        let side_px = self.cell_px(sliced.drawn());
        loop {
            let tile = sliced.tile(side_px);
            render_target::judge(&self.gpu, &tile)?;
            let shown = match sliced.is_divisible(side_px) {
                true => DrawnSurfaces::NearestIfTheyFit,
                false => DrawnSurfaces::Nearest,
            };
            let prepared = self.prepare_picture(&tile, side_px, Some(sliced.exposure()), shown, task)?;
            if !prepared.is_short {
                return Ok((tile, prepared));
            }
            if !sliced.halve(side_px) {
                sliced.becomes_coarser();
                return Ok((tile, prepared));
            }
        }
    }

    /// Draws an image in slices, while nobody else waits for the device.
    pub(super) fn sliced_picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        let mut sliced = self.begin(shot, task)?.alone();
        while !self.advance(&mut sliced, task)? {}
        Ok(sliced.picture())
    }
}
