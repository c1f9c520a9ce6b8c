//! The photos' surroundings as donors of the filling, decoded on demand within a memory budget.

use std::sync::Arc;

use super::donors::SURROUNDINGS_SHARE;
use crate::layer_textures::LayerTextureFiles;
use crate::surroundings::SiteSurroundings;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_layers::fill::region::Region;
use quadratura_layers::fill::surroundings::{
    SurroundingsDonor, SurroundingsFilling, SurroundingsTexels, nearest_first,
};
use quadratura_layers::fill::{FilledRegion, MOST_DONORS};
use quadratura_projection::agreement::Agreement;
use quadratura_projection::dome::DomeSampler;
use quadratura_projection::exposure::SurroundingsGains;
use quadratura_projection::pyramid::PyramidOptions;
use quadratura_projection::twin::sample::Lookup;
use quadratura_projection::{Gains, LayerTextureId, Sources, Texels};

/// Fills the surroundings of a site's photos.
pub(super) struct SurroundingsFiller<'a> {
    files: &'a LayerTextureFiles,
    sources: &'a Sources,
    gains: &'a Gains,
    agreement: Agreement,
    dome: Option<DomeSampler<'a>>,
    to_one_sky: &'a SurroundingsGains,
    /// The most bytes of decoded layers.
    memory: u64,
    /// The photos that were used last, the most recent one at the end; `None` for one that shows no surroundings or
    /// cannot be read.
    recent: Vec<(PhotoId, Option<Arc<SurroundingsDonor>>)>,
}

impl<'a> SurroundingsFiller<'a> {
    /// Makes the filler; `memory` is the filling's budget in bytes, of which decoded layers of surroundings take their share.
    pub fn new(surroundings: &'a SiteSurroundings, gains: &'a Gains, memory: u64) -> Self {
        let memory = memory / SURROUNDINGS_SHARE;
        let (files, sources) = (surroundings.files(), surroundings.sources());
        let evidence = surroundings.whole();
        let none = Agreement::new(&[], sources);
        let mut agreement = none.with_surroundings(&evidence.agreement, sources);
        files.spare_paint(&mut agreement);
        let dome = evidence.dome.as_ref().map(|dome| dome.sampler());
        let to_one_sky = &*evidence.gains;
        Self { files, sources, gains, agreement, dome, to_one_sky, memory, recent: Vec::new() }
    }

    /// Fills a region of a photo's surroundings. Texels of which nothing is known stay empty.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn fill(
        &mut self,
        photo: PhotoId,
        stack: &Stack,
        bits: u8,
        region: Region,
        task: &Task,
    ) -> Result<Option<FilledRegion>> {
        let Some(own) = self.donor(photo, task)? else { return Ok(None) };
        let camera = &own.projector.camera;
        let bytes = 6 * u64::from(camera.width) * u64::from(camera.height);
        let most = ((self.memory / bytes.max(1)) as usize).clamp(1, MOST_DONORS);
        debug_assert!(stack.surroundings().is_some(), "a region of the surroundings is in a layer of them");
        let mut with: Vec<PhotoId> =
            self.sources.servers_of_surroundings().iter().map(|server| server.photo).collect();
        with.dedup();
        let others = with.into_iter().filter(|id| *id != photo && !self.sources.is_dome(*id));
        let order = nearest_first(&own.projector, others.map(|id| (id, self.sources.photo(id))), most);
        let mut donors = Vec::with_capacity(order.len());
        for id in order {
            donors.extend(self.donor(id, task)?);
        }
        let donors: Vec<&SurroundingsDonor> = donors.iter().map(Arc::as_ref).collect();
        let (dome, scale) = (self.dome.as_ref(), self.sources.surroundings_scale);
        SurroundingsFilling { own: &own, bits, donors: &donors, dome, scale }.fill(region, task)
    }

    /// Returns a photo's surroundings, decoded if they are not in the cache.
    fn donor(&mut self, photo: PhotoId, task: &Task) -> Result<Option<Arc<SurroundingsDonor>>> {
        task.check_cancelled()?;
        if let Some(index) = self.recent.iter().position(|(other, _)| *other == photo) {
            let entry = self.recent.remove(index);
            self.recent.push(entry.clone());
            return Ok(entry.1);
        }
        let donor = match self.read(photo) {
            Ok(donor) => donor.map(Arc::new),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                let note = Message::from("its surroundings are not used for filling: ").and(&error);
                task.with_subject(&self.sources.photo(photo).name).note(note);
                None
            }
        };
        self.recent.push((photo, donor.clone()));
        let bytes = |donor: &Option<Arc<SurroundingsDonor>>| {
            let layers = donor.iter().flat_map(|donor| &donor.layers);
            layers.map(|texels| texels.lookup.bytes()).sum::<u64>()
        };
        let mut all: u64 = self.recent.iter().map(|(_, donor)| bytes(donor)).sum();
        while all > self.memory && self.recent.len() > 1 {
            all -= bytes(&self.recent.remove(0).1);
        }
        Ok(donor)
    }

    /// Decodes a photo's surroundings; `None` where it has no layer of them.
    fn read(&self, photo: PhotoId) -> Result<Option<SurroundingsDonor>> {
        let servers = self.sources.servers_of_surroundings().iter().filter(|server| server.photo == photo);
        let texels = |id: LayerTextureId| {
            let (rect, pixels) = (self.sources.layer_texture(id).rect, self.files.layer_texture(id)?);
            Ok(SurroundingsTexels {
                lookup: Lookup::new(rect, &pixels, &PyramidOptions::default()),
                painted: self.files.painted_on(id)?,
                agreement: self.agreement.of(id).cloned(),
            })
        };
        let layers: Vec<SurroundingsTexels> =
            servers.map(|server| texels(server.layer_texture)).collect::<Result<_>>()?;
        let (projector, gain) = (self.sources.photo(photo).clone(), self.gains.of_photo[photo.index()]);
        let optics = self.gains.optics[photo.index()];
        let factors = self.to_one_sky.of_photo.get(photo.index()).cloned().flatten();
        let donor = SurroundingsDonor { photo, projector, layers, gain, optics, factors };
        Ok((!donor.layers.is_empty()).then_some(donor))
    }
}
