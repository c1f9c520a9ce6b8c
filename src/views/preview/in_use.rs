//! What a preview's pictures are made with, for other renderers of the same project.

use std::sync::Arc;

use super::Preview;
use super::estimates::shown_gains;
use crate::continuation::SiteContinuation;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Model, Photo, PhotoId};
use quadratura_base::task::Task;
use quadratura_projection::Gains;
use quadratura_projection::exposure::{Shares, ViewExposure, shares_of_view};
use quadratura_projection::peeling::Peels;
use quadratura_projection::relief::Relief;
use quadratura_projection::skirts::Skirts;
use quadratura_sites::site_parts::SiteParts;
use quadratura_view::Shot;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::optics::Optics;

impl Preview {
    /// Returns the gains and, where surfaces are shown with it, the relief that pictures without these photos are made with.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::Cancelled`].
    pub fn estimates_without(
        &mut self,
        photos: &[PhotoId],
        task: &Task,
    ) -> Result<(Gains, Option<Arc<Relief>>)> {
        self.leave_out(photos, task)?;
        Ok((self.gains_in_use.clone(), self.relief_in_use.clone().filter(|_| self.shows_relief)))
    }

    /// Returns how much each photo contributes to a view, and the view's exposure.
    pub fn shares_and_exposure(&self, shot: &Shot, model: &Arc<Model>) -> (Shares, ViewExposure) {
        let shot = &self.sources.beyond_backdrops(shot);
        let flat = Relief::default();
        let relief = self.relief_in_use.as_deref().filter(|_| shot.relief).unwrap_or(&flat);
        let shares = shares_of_view(shot, model, &self.sources, &self.surface(), relief);
        let gains = shown_gains(&self.gains_in_use, self.shows_gains, &self.around);
        let exposure = gains.exposed(shot, &self.sources.photos, || shares.clone());
        (shares, exposure)
    }

    /// Returns a view as pictures show it, with surroundings in the place of far backdrops.
    pub fn beyond_backdrops(&self, shot: &Shot) -> Shot {
        self.sources.beyond_backdrops(shot)
    }

    /// Returns the renderer as one that peels layers off, ready for views with the exclusions of a shot.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] where the renderer does not peel layers off, and those of making it ready.
    pub fn peels(&mut self, shot: &Shot, task: &Task) -> Result<&mut dyn Peels> {
        self.make_ready(shot, task)?;
        let cannot = || Error::Request("this renderer does not show what is behind surfaces".into());
        self.renderer.peels().ok_or_else(cannot)
    }

    /// Returns whether every texel that is shown comes from a photo: nobody painted, and nothing is filled.
    pub fn shows_only_photos(&self) -> bool {
        self.files.are_only_photos()
    }

    /// Returns how far other photos confirm a photo of a site, where that counts in a view.
    pub fn agreement(&self, shot: &Shot, photo: &Photo, id: PhotoId) -> Option<AgreementGrid> {
        let evidence = self.evidence.get(id.index()).filter(|_| shot.blend.agreement)?;
        Some(evidence.agreement.whole([photo.camera.width, photo.camera.height]))
    }

    /// Returns the vignetting and offset of a photo that a view removes from its colours.
    pub fn optics(&self, shot: &Shot, photo: PhotoId) -> Optics {
        shown_gains(&self.gains_in_use, self.shows_gains, &self.around).optics(shot, photo)
    }
}

impl Preview {
    /// Returns all that pictures without these photos are made of.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::Cancelled`], and those of reading photos.
    pub fn parts(&mut self, without: &[PhotoId], task: &Task) -> Result<SiteParts> {
        self.leave_out(without, task)?;
        let gains = shown_gains(&self.gains_in_use, self.shows_gains, &self.around);
        let continuation = SiteContinuation::new(&self.folder, &self.site, task)?.without(without, &gains);
        let surface = self.surface();
        Ok(SiteParts {
            skirts: Skirts::new(&self.site.model, &self.sources, &surface),
            gains,
            relief: self.relief_in_use.clone().filter(|_| self.shows_relief).unwrap_or_default(),
            agreement: self.agreement_of_layers.present.clone(),
            texels: Arc::new(self.files.clone()),
            dome: self.around.dome.clone(),
            continuation,
        })
    }
}
