//! How far a project's photos confirm each other, estimated once and then cached in `cache/`: the agreement by which
//! pictures weight photos, and the regions that other photos contradict, which are suggested as masks.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::budget::Budget;
use super::far_backdrops::FarBackdrops;
use super::gains;
use super::inputs::Inputs;
use super::shared::Shared;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::{Photo, PhotoId, PhotoPixels, Samples, Site};
use quadratura_base::task::Task;
use quadratura_document::{Decisions, Project, Stack};
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_files::hash::hash_bytes;
use quadratura_io::reference::reference;
use quadratura_io::unmasked::read_unmasked;
use quadratura_layers::agreement::{
    AgreementOptions, PhotoEvidence, ReducedPhoto, ReducedPhotos, contradicted_regions, outlines,
    photo_agreement, things, undecided_share, votes,
};
use quadratura_layers::fill::{Donor, DonorContent, FillSurfaces};
use quadratura_projection::framing::scaled;
use quadratura_projection::relief::Relief;
use quadratura_projection::{Gains, Projector};
use quadratura_view::hidden::HiddenFaces;

/// A counter of changes in how the same photos are compared, or in the relief on which they are.
const VERSION: u32 = 5;

/// The file `cache/agreement.bin`.
const CACHED: CachedKind = CachedKind { name: "agreement", version: 5 };

/// The share of a photo's compared pixels with as many votes against them as for them from which on that is told: the
/// photos differ as a whole, and nobody can know which of them are right.
const MOSTLY: f64 = 0.5;

/// What agreement is estimated from, beside the photos' pixels.
#[derive(Debug, Clone)]
pub struct AgreementInputs {
    /// The hash of the photos, masks, cameras and model, of the stacks, and of the decisions about gains.
    hash: String,
    /// The tolerance of occlusion.
    tolerance: f32,
    /// The budget in bytes for photos decoded at the same time.
    memory: u64,
}

impl AgreementInputs {
    /// Collects the inputs of a project whose photos have these `stacks`, in the site's order. `memory` is the budget in
    /// bytes for photos decoded at the same time.
    pub fn new(project: &Project, site: &Site, stacks: &[Option<Stack>], memory: u64) -> Self {
        let colour = &project.colour;
        // Masks, photos and the model count as they are now, also where stacks are out of date.
        let undecided = Decisions::default();
        let present = Inputs::new(&site.model, &project.options, &undecided);
        let photos: Vec<Option<String>> = site.photos.iter().map(|photo| present.hash(photo).ok()).collect();
        let all = (VERSION, photos, gains::inputs(site, stacks), gains::decisions(colour));
        let hash = hash_bytes(&serde_json::to_vec(&all).expect("plain data is JSON"));
        Self { hash, tolerance: project.options.tolerance, memory }
    }
}

/// The evidence of a site's photos, and of the same without some of them.
pub struct SiteAgreement {
    site: Site,
    inputs: AgreementInputs,
    options: AgreementOptions,
    whole: Arc<[PhotoEvidence]>,
    /// The photos prepared for comparison, once they were needed, with the gains that they were prepared with.
    reduced: Option<(Gains, Vec<Option<ReducedPhoto>>)>,
    surfaces: FillSurfaces,
    /// The faces that views show as surroundings.
    far: HiddenFaces,
}

impl SiteAgreement {
    /// Returns the evidence of the photos of the project in `folder`: from the cache if it was made from the same `inputs`,
    /// otherwise computed and cached. `gains` and `relief` were estimated from the same photos.
    ///
    /// # Errors
    /// [`Error::Cancelled`]. A photo that cannot be read is noted and has no vote; a cache that cannot be written is
    /// noted, and so is what most photos are undecided about.
    pub fn open(
        folder: &Path,
        site: &Site,
        inputs: AgreementInputs,
        gains: &Gains,
        relief: &Relief,
        task: &Task,
    ) -> Result<Self> {
        let file = folder.join("cache/agreement.bin");
        let options = AgreementOptions::default();
        let hash = hash_bytes(format!("{} {} {options:?}", inputs.hash, inputs.tolerance).as_bytes());
        let surfaces = FillSurfaces::from_model(&site.model);
        let far = FarBackdrops::new(site).faces(site);
        let mut agreement =
            Self { site: site.clone(), inputs, options, whole: Arc::default(), reduced: None, surfaces, far };
        let fits =
            |found: &Vec<PhotoEvidence>| found.len() == site.photos.len() && agreement.has_sizes(found);
        let _lock = match Shared::find(folder, || read_cached(&file, CACHED, &hash).filter(fits), task)? {
            Shared::Known(evidence) => {
                agreement.whole = evidence.into();
                // The same photos are told the same, whether they were compared now or earlier.
                agreement.note_undecided(task);
                return Ok(agreement);
            }
            Shared::Missing(lock) => lock,
        };
        agreement.whole = agreement.compared(&[], relief, gains, task)?.into();
        agreement.note_undecided(task);
        // What was found without some photo must not be cached as that of all photos.
        let is_whole = agreement.reduced.iter().flat_map(|(_, photos)| photos).all(Option::is_some);
        if is_whole && let Err(error) = write_cached(&file, CACHED, &hash, &agreement.whole[..]) {
            task.note(Message::from("the agreement of photos cannot be cached: ").and(&error));
        }
        // Prepared photos are large; few pictures need them again.
        agreement.reduced = None;
        Ok(agreement)
    }

    /// Returns true when the evidence is of photos reduced to their sizes.
    fn has_sizes(&self, evidence: &[PhotoEvidence]) -> bool {
        let reduced = |photo: &Photo| reduced_camera(&photo.camera, &self.options);
        let sizes = self.site.photos.iter().map(reduced).map(|camera| [camera.width, camera.height]);
        sizes.zip(evidence).all(|(size, found)| found.agreement.size == size)
    }

    /// Tells which photos are contradicted nearly everywhere by as many photos as confirm them.
    fn note_undecided(&self, task: &Task) {
        let undecided = self.site.photos.iter().zip(self.whole.iter());
        let undecided = undecided.filter(|(_, evidence)| evidence.undecided >= MOSTLY);
        let photos: Vec<String> = undecided
            .map(|(photo, evidence)| format!("{} ({:.0} %)", photo.name, 100.0 * evidence.undecided))
            .collect();
        if !photos.is_empty() {
            let photos = photos.join(", ");
            task.note(format!(
                "as many photos contradict these as confirm them nearly everywhere, so that none of them counts \
                 less: {photos}; if they were taken in different light or at different times, use the photos of one \
                 time, and check their cameras"
            ));
        }
    }

    /// Returns the evidence of all photos, in the site's order.
    pub fn whole(&self) -> &Arc<[PhotoEvidence]> {
        &self.whole
    }

    /// Returns the evidence when these photos have no vote, with the relief and the gains that were estimated without
    /// them.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn without(
        &mut self,
        photos: &[PhotoId],
        relief: &Relief,
        gains: &Gains,
        task: &Task,
    ) -> Result<Arc<[PhotoEvidence]>> {
        if photos.is_empty() {
            return Ok(self.whole.clone());
        }
        Ok(self.compared(photos, relief, gains, task)?.into())
    }

    /// Compares all photos with each other.
    fn compared(
        &mut self,
        left_out: &[PhotoId],
        relief: &Relief,
        gains: &Gains,
        task: &Task,
    ) -> Result<Vec<PhotoEvidence>> {
        let reduced = match self.reduced.take() {
            Some((of, photos)) => exposed(photos, &of, gains),
            None => self.prepared(gains, task)?,
        };
        let (_, photos) = &*self.reduced.insert((gains.clone(), reduced));
        let all = ReducedPhotos { photos, surfaces: &self.surfaces, groups: &gains.light.groups, relief };
        let count = photos.len() as u64;
        let mut found = Vec::with_capacity(photos.len());
        for ((done, id), photo) in (0..).zip(PhotoId::all(photos.len())).zip(photos) {
            task.step("compare photos", done, count)?;
            let Some(photo) = photo.as_ref().filter(|_| !left_out.contains(&id)) else {
                found.push(PhotoEvidence::default());
                continue;
            };
            let votes = votes(&all, id, left_out, task)?;
            let regions = contradicted_regions(&votes, photo.donor.camera.width as usize, &self.options);
            let full = &self.site.photo(id).camera;
            let reduction = f64::from(full.width) / f64::from(photo.donor.camera.width);
            let agreement = photo_agreement(photo, &votes, &regions, reduction, &self.options);
            let undecided = undecided_share(&votes);
            let things = things(&all, id, left_out, &votes, &self.options);
            let outlines = photo.outlines.clone();
            found.push(PhotoEvidence { agreement, outlines, things, undecided });
        }
        task.step("compare photos", count, count)?;
        Ok(found)
    }

    /// Prepares all photos; `None` where one cannot be read.
    fn prepared(&self, gains: &Gains, task: &Task) -> Result<Vec<Option<ReducedPhoto>>> {
        let budget = Budget::new(self.inputs.memory);
        let ids = PhotoId::all(self.site.photos.len()).collect::<Vec<_>>().into_par_iter();
        ids.map(|id| self.reduced_photo(id, gains, &budget, task)).collect()
    }

    fn reduced_photo(
        &self,
        id: PhotoId,
        gains: &Gains,
        budget: &Budget,
        task: &Task,
    ) -> Result<Option<ReducedPhoto>> {
        task.check_cancelled()?;
        let photo = self.site.photo(id);
        let (width, height) = (u64::from(photo.camera.width), u64::from(photo.camera.height));
        // Memory for the decoded pixels with alpha, their colours, and wider sums while they are reduced.
        match budget.with(width * height * 16, || reduced(photo, &self.options)) {
            Ok((pixels, projector)) => {
                let (model, tolerance) = (&self.site.model, self.inputs.tolerance);
                let content = DonorContent { pixels: &pixels, painted: &[], agreement: None };
                let donor = Donor::new(&projector, &content, model, &self.surfaces, tolerance);
                let outlines = outlines(&donor, &pixels, |face| self.far.contains(face));
                let (gain, optics) = (gains.of_photo[id.index()], &gains.optics[id.index()]);
                Ok(Some(ReducedPhoto::new(donor, outlines, gain, optics)))
            }
            Err(Error::Cancelled) => Err(Error::Cancelled),
            // What reads the photo for its own sake says why it cannot.
            Err(_) => {
                let note = "the photo is not compared with others, because it cannot be read";
                task.with_subject(&photo.name).note(note);
                Ok(None)
            }
        }
    }
}

/// Brings prepared photos from the gains that they were prepared with to others.
fn exposed(photos: Vec<Option<ReducedPhoto>>, from: &Gains, to: &Gains) -> Vec<Option<ReducedPhoto>> {
    let exposure = |gains: &Gains, i: usize| (gains.of_photo[i], gains.optics[i]);
    let one = |(i, mut photo): (usize, Option<ReducedPhoto>)| {
        let (gain, optics) = exposure(to, i);
        if let Some(photo) = photo.as_mut().filter(|_| exposure(from, i) != (gain, optics)) {
            photo.set_exposure(gain, &optics);
        }
        photo
    };
    photos.into_par_iter().enumerate().map(one).collect()
}

/// Returns the camera of a reduced photo. Pixels of small photos are averaged, too, because single ones are noise and the
/// model is wrong by some of them.
fn reduced_camera(camera: &Pinhole, options: &AgreementOptions) -> Pinhole {
    let longest = camera.width.max(camera.height);
    let side = options.longest_side.min(longest / 2).max(1);
    scaled(camera, f64::from(side) / f64::from(longest))
}

/// Reads and reduces a photo, with its camera.
fn reduced(photo: &Photo, options: &AgreementOptions) -> Result<(PhotoPixels, Projector)> {
    let camera = reduced_camera(&photo.camera, options);
    let small = reference(&read_unmasked(photo)?, camera.width, camera.height);
    let rgb = small.rgb.as_chunks::<3>().0.iter().zip(&small.valid);
    let samples = rgb.flat_map(|(&[r, g, b], valid)| [r, g, b, if *valid { u8::MAX } else { 0 }]);
    let samples = Samples::U8(samples.collect());
    let pixels = PhotoPixels { width: camera.width, height: camera.height, channels: 4, samples, icc: None };
    Ok((pixels, Projector { name: photo.name.clone(), camera, pose: photo.pose }))
}
