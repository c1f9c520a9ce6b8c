//! The faces that a view shows: see-through ones count only where something of them is there.

use super::Renderer;
use super::program::Program;
use super::target;
use crate::error::Result;
use crate::projection::{Quality, Shot};
use crate::task::Task;

/// Returns the view whose faces are those that a view shows: there is one a pixel, so that trees need not be finer than in previews.
pub(super) fn of_seen(shot: &Shot) -> Shot {
    Shot { quality: Quality::Preview, ..shot.clone() }
}

impl Renderer {
    /// Draws the faces that a view shows, on a site with mattes.
    pub(super) fn drawn_seen(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        let gpu = self.gpu.clone();
        target::judge(&gpu, shot)?;
        gpu.guarded("drawing faces", || {
            // The window draws the picture of the same view first, so that its tables and tiles serve again.
            let ready = self.ready.as_ref().filter(|(of, _)| of == shot).map(|(_, prepared)| *prepared);
            let prepared = match ready {
                Some(prepared) => prepared,
                None => self.prepare(shot, self.cell_px(shot), None, task)?,
            };
            let seen = Program::of_seen_faces(shot, &self.content(false));
            self.draw(&of_seen(shot), [Program::Faces, seen], &prepared, task)?;
            self.target(shot, false).faces(&gpu)
        })
    }
}
