//! A preview as a renderer: each view is made ready before it is drawn.

use super::Preview;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::{Renders, Sliced};
use quadratura_view::{Picture, Shot};

impl Renders for Preview {
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        let shot = &self.sources.beyond_backdrops(shot);
        self.make_ready(shot, task)?;
        self.renderer.picture(shot, task)
    }

    // Of the model as it is: what is clicked on, and compared, may be a far backdrop.
    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.renderer.faces(shot, task)
    }

    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        let shot = &self.sources.beyond_backdrops(shot);
        self.make_ready(shot, task)?;
        self.renderer.seen_faces(shot, task)
    }

    fn depths(&mut self, shot: &Shot, task: &Task) -> Result<Option<Vec<f32>>> {
        let shot = &self.sources.beyond_backdrops(shot);
        self.make_ready(shot, task)?;
        self.renderer.depths(shot, task)
    }

    fn begin(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        let shot = &self.sources.beyond_backdrops(shot);
        self.make_ready(shot, task)?;
        self.renderer.begin(shot, task)
    }

    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        self.make_ready(sliced.shot(), task)?;
        self.renderer.advance(sliced, task)
    }
}
