//! The renderer of a project's views that `render` and `score` are asked for.

use std::path::Path;

use super::site_view::{LdiView, LdiViewOptions};
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_projection::{Renders, Sliced};
use quadratura_view::{Picture, Shot};
use quadratura_views::preview::Preview;

/// A renderer of a project's views, with the model or from layered depth images.
pub enum Viewer<'a> {
    /// Photos projected onto the model.
    Model(Box<Preview>),
    /// Layered depth images.
    Ldi(Box<LdiView<'a>>),
}

impl<'a> Viewer<'a> {
    /// Chooses the renderer of the project in `folder`, which `preview` shows.
    ///
    /// # Errors
    /// Those of [`LdiView::new`].
    pub fn new(
        folder: &Path,
        project: &'a Project,
        site: &'a Site,
        preview: Preview,
        of_images: Option<LdiViewOptions>,
    ) -> Result<Self> {
        Ok(match of_images {
            None => Self::Model(Box::new(preview)),
            Some(options) => Self::Ldi(Box::new(LdiView::new(folder, project, site, preview, options)?)),
        })
    }

    /// Returns the projective renderer.
    pub fn preview(&self) -> &Preview {
        match self {
            Self::Model(preview) => preview,
            Self::Ldi(view) => view.preview(),
        }
    }

    /// Returns the share of a view that is continued where no photo shows it ([`Preview::continued_share`]); `None` where the
    /// view is not drawn from the model.
    ///
    /// # Errors
    /// As [`Renders::picture`].
    pub fn continued_share(&mut self, shot: &Shot, task: &Task) -> Result<Option<f64>> {
        match self {
            Self::Model(preview) => preview.continued_share(shot, task).map(Some),
            Self::Ldi(_) => Ok(None),
        }
    }

    fn renders(&mut self) -> &mut dyn Renders {
        match self {
            Self::Model(preview) => preview.as_mut(),
            Self::Ldi(view) => view.as_mut(),
        }
    }
}

impl Renders for Viewer<'_> {
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        self.renders().picture(shot, task)
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.renders().faces(shot, task)
    }

    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.renders().seen_faces(shot, task)
    }

    fn depths(&mut self, shot: &Shot, task: &Task) -> Result<Option<Vec<f32>>> {
        self.renders().depths(shot, task)
    }

    fn begin(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        self.renders().begin(shot, task)
    }

    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        self.renders().advance(sliced, task)
    }
}
