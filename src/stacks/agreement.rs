//! How far a project's photos confirm each other, estimated once and then cached in `cache/`: the agreement by which
//! pictures weight photos, and the regions that other photos contradict, which are suggested as masks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::far_backdrops::FarBackdrops;
use crate::gains;
use crate::inputs::{Inputs, hash_of_model};
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{FaceId, Photo, PhotoId, PhotoPixels, Samples, Site};
use quadratura_base::task::Task;
use quadratura_document::{Decisions, Project, Stack};
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_files::hash::{Hashing, hash_bytes};
use quadratura_io::reference::reference;
use quadratura_io::unmasked::read_unmasked;
use quadratura_layers::agreement::{
    AgreementOptions, PhotoEvidence, ReducedPhoto, ReducedPhotos, contradicted_regions, outlines,
    photo_agreement, things, undecided_share, voters, votes,
};
use quadratura_layers::fill::{Donor, DonorContent, FillSurfaces};
use quadratura_projection::framing::scaled;
use quadratura_projection::relief::{FaceRelief, Relief};
use quadratura_projection::{Gains, Projector};
use quadratura_sites::budget::Budget;
use quadratura_sites::shared::Shared;
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::optics::Optics;

/// A counter of changes in how the same photos are compared, or in the relief on which they are.
const VERSION: u32 = 6;

/// The file `cache/agreement.bin`.
const CACHED: CachedKind = CachedKind { name: "agreement", version: 6 };

/// The bytes of a prepared photo for each of its pixels: its surfaces, its colours and their levels.
const PREPARED_BYTES: u64 = 64;

/// The share of a photo's compared pixels with as many votes against them as for them from which on that is told: the
/// photos differ as a whole, and nobody can know which of them are right.
const MOSTLY: f64 = 0.5;

/// What agreement is estimated from, beside the photos' pixels.
#[derive(Debug, Clone)]
pub struct AgreementInputs {
    /// The hash of what all photos have in common: the model and the options.
    common: String,
    /// The hash of each photo with its masks, camera and stack.
    photos: Vec<String>,
    /// The tolerance of occlusion.
    tolerance: f32,
    /// The budget in bytes for photos decoded at the same time.
    memory: u64,
}

impl AgreementInputs {
    /// Collects the inputs of a project whose photos have these `stacks`, in the site's order. `memory` is the budget in
    /// bytes for photos decoded at the same time.
    pub fn new(project: &Project, site: &Site, stacks: &[Option<Stack>], memory: u64) -> Self {
        // Masks, photos and the model count as they are now, also where stacks are out of date.
        let undecided = Decisions::default();
        let present = Inputs::new(&site.model, &project.options, &undecided);
        let tolerance = project.options.tolerance;
        let photos = site.photos.iter().zip(gains::photo_inputs(site, stacks));
        let photos = photos.map(|(photo, stack)| format!("{:?} {stack}", present.hash(photo).ok())).collect();
        let common = (VERSION, hash_of_model(&site.model), tolerance);
        let common = hash_bytes(&serde_json::to_vec(&common).expect("plain data is JSON"));
        Self { common, photos, tolerance, memory }
    }
}

/// The evidence of a site's photos, and of the same without some of them.
pub struct SiteAgreement {
    site: Site,
    inputs: AgreementInputs,
    options: AgreementOptions,
    /// The photos' centres, in world coordinates.
    eyes: Vec<DVec3>,
    whole: Arc<[PhotoEvidence]>,
    /// The evidence that is known, by the hash of everything that it was made from.
    known: BTreeMap<String, PhotoEvidence>,
    prepared: PreparedPhotos,
    surfaces: FillSurfaces,
    /// The faces that views show as surroundings.
    far: HiddenFaces,
}

/// Photos prepared for comparison: as many as the memory allows, those that were used last.
#[derive(Default)]
struct PreparedPhotos {
    /// In the site's order; `None` where a photo is not prepared.
    photos: Vec<Option<ReducedPhoto>>,
    /// The gains that each was prepared with.
    exposures: Vec<([f64; 3], Optics)>,
    /// When each was used last, counted in photos that were compared; 0 for never.
    used: Vec<u64>,
    now: u64,
    /// The photos that cannot be read.
    unread: BTreeSet<PhotoId>,
}

impl SiteAgreement {
    /// Returns the evidence of the photos of the project in `folder`, of which that is computed anew that was not made from the
    /// same `inputs` before. `gains` and `relief` were estimated from the same photos.
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
        let basis = hash_bytes(format!("{} {options:?}", inputs.common).as_bytes());
        let surfaces = FillSurfaces::from_model(&site.model);
        let far = FarBackdrops::new(site).faces(site);
        let eyes = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
        let (whole, known, prepared) = (Arc::default(), BTreeMap::new(), PreparedPhotos::default());
        let mut agreement =
            Self { site: site.clone(), inputs, options, eyes, whole, known, prepared, surfaces, far };
        let keys = agreement.keys(&[], relief, gains);
        let holds = |known: &BTreeMap<String, PhotoEvidence>| keys.iter().all(|key| known.contains_key(key));
        let kept = || read_cached(&file, CACHED, &basis);
        let lock = match Shared::find(folder, || kept().filter(holds), task)? {
            Shared::Known(known) => {
                agreement.known = known;
                None
            }
            Shared::Missing(lock) => {
                agreement.known = kept().unwrap_or_default();
                Some(lock)
            }
        };
        agreement.whole = agreement.compared(&keys, &[], relief, gains, task)?.into();
        agreement.note_undecided(task);
        // Of all that is known, what the present photos have is kept; nothing that was found without some photo.
        let whole = keys.into_iter().zip(agreement.whole.iter().cloned()).collect();
        agreement.known = whole;
        if lock.is_some()
            && agreement.prepared.unread.is_empty()
            && let Err(error) = write_cached(&file, CACHED, &basis, &agreement.known)
        {
            task.note(Message::from("the agreement of photos cannot be cached: ").and(&error));
        }
        // Prepared photos are large; few pictures need them again.
        agreement.prepared = PreparedPhotos::default();
        Ok(agreement)
    }

    /// Returns for each photo the hash of everything that its evidence is made from: the photo and those that are asked about it,
    /// their exposures, and the relief of the faces that it may show.
    fn keys(&self, left_out: &[PhotoId], relief: &Relief, gains: &Gains) -> Vec<String> {
        let of_face = |face: FaceId| {
            (face, self.face_ball(face), relief.of(face).map(hash_of_relief).unwrap_or_default())
        };
        let faces: Vec<(FaceId, (DVec3, f64), String)> =
            self.site.model.face_ids().collect::<Vec<_>>().into_par_iter().map(of_face).collect();
        let groups = &gains.light.groups;
        let own = |id: PhotoId| {
            let optics = &gains.optics[id.index()];
            let text = (&self.inputs.photos[id.index()], gains.of_photo[id.index()], optics, groups.of(id));
            serde_json::to_vec(&text).expect("plain data is JSON")
        };
        let key = |id: PhotoId| {
            if left_out.contains(&id) {
                return String::new();
            }
            let mut hash = Hashing::default();
            hash.add(&own(id));
            voters(&self.eyes, id, left_out, groups).into_iter().for_each(|voter| hash.add(&own(voter)));
            let photo = self.site.photo(id);
            let seen = faces.iter().filter(|(_, ball, _)| may_show(&photo.camera, &photo.pose, *ball));
            seen.for_each(|(face, _, relief)| {
                hash.add(&face.0.to_le_bytes());
                hash.add(relief.as_bytes());
            });
            hash.hash()
        };
        self.site.photo_ids().collect::<Vec<_>>().into_par_iter().map(key).collect()
    }

    /// Returns the middle and the radius of a ball around a face.
    fn face_ball(&self, face: FaceId) -> (DVec3, f64) {
        let corners = || self.site.model.ring_points(face);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let middle = (low + corners().fold(DVec3::NEG_INFINITY, DVec3::max)) / 2.0;
        (middle, corners().map(|corner| corner.distance(middle)).fold(0.0, f64::max))
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
        let keys = self.keys(photos, relief, gains);
        Ok(self.compared(&keys, photos, relief, gains, task)?.into())
    }

    /// Compares the photos with each other whose evidence is not known by its key.
    fn compared(
        &mut self,
        keys: &[String],
        left_out: &[PhotoId],
        relief: &Relief,
        gains: &Gains,
        task: &Task,
    ) -> Result<Vec<PhotoEvidence>> {
        let again = keys.iter().filter(|key| !self.known.contains_key(*key)).count() as u64;
        let (mut done, groups) = (0, &gains.light.groups);
        let mut found = Vec::with_capacity(keys.len());
        for (id, key) in self.site.photo_ids().zip(keys) {
            if let Some(evidence) = self.known.get(key) {
                found.push(evidence.clone());
                continue;
            }
            if left_out.contains(&id) {
                found.push(PhotoEvidence::default());
                continue;
            }
            task.step("compare photos", done, again)?;
            done += 1;
            let voters = voters(&self.eyes, id, left_out, groups);
            self.prepare(id, &voters, gains, task)?;
            let photos = &self.prepared.photos[..];
            let Some(photo) = &photos[id.index()] else {
                found.push(PhotoEvidence::default());
                continue;
            };
            let all = ReducedPhotos { photos, surfaces: &self.surfaces, groups, relief };
            let votes = votes(&all, id, &voters, task)?;
            let regions = contradicted_regions(&votes, photo.donor.camera.width as usize, &self.options);
            let full = &self.site.photo(id).camera;
            let reduction = f64::from(full.width) / f64::from(photo.donor.camera.width);
            let agreement = photo_agreement(photo, &votes, &regions, reduction, &self.options);
            let undecided = undecided_share(&votes);
            let things = things(&all, id, &voters, &votes, &self.options);
            let outlines = photo.outlines.clone();
            found.push(PhotoEvidence { agreement, outlines, things, undecided });
        }
        task.step("compare photos", again, again)?;
        Ok(found)
    }

    /// Prepares a photo and those that are asked about it, as far as they can be read, and forgets those that were not used for the
    /// longest time where there is no memory for more.
    fn prepare(&mut self, id: PhotoId, voters: &[PhotoId], gains: &Gains, task: &Task) -> Result<()> {
        let count = self.site.photos.len();
        if self.prepared.photos.is_empty() {
            self.prepared.photos.resize_with(count, || None);
            self.prepared.exposures = vec![Default::default(); count];
            self.prepared.used = vec![0; count];
        }
        self.prepared.now += 1;
        let needed: Vec<PhotoId> = voters.iter().copied().chain([id]).collect();
        needed.iter().for_each(|id| self.prepared.used[id.index()] = self.prepared.now);
        self.make_room(&needed);
        let exposure = |id: PhotoId| (gains.of_photo[id.index()], gains.optics[id.index()]);
        let missing: Vec<PhotoId> = needed
            .iter()
            .copied()
            .filter(|id| self.prepared.photos[id.index()].is_none() && !self.prepared.unread.contains(id))
            .collect();
        let budget = Budget::new(self.inputs.memory);
        let made = missing.into_par_iter().map(|id| Ok((id, self.reduced_photo(id, gains, &budget, task)?)));
        for (id, photo) in made.collect::<Result<Vec<_>>>()? {
            self.prepared.exposures[id.index()] = exposure(id);
            if photo.is_none() {
                self.prepared.unread.insert(id);
            }
            self.prepared.photos[id.index()] = photo;
        }
        for id in needed {
            let (gain, optics) = exposure(id);
            let of_photo = &mut self.prepared.exposures[id.index()];
            if let Some(photo) =
                self.prepared.photos[id.index()].as_mut().filter(|_| *of_photo != (gain, optics))
            {
                photo.set_exposure(gain, &optics);
                *of_photo = (gain, optics);
            }
        }
        Ok(())
    }

    /// Forgets prepared photos until there is memory for those that are `needed`.
    fn make_room(&mut self, needed: &[PhotoId]) {
        let bytes = |id: PhotoId| {
            let camera = reduced_camera(&self.site.photo(id).camera, &self.options);
            u64::from(camera.width) * u64::from(camera.height) * PREPARED_BYTES
        };
        let prepared = self.site.photo_ids().filter(|id| self.prepared.photos[id.index()].is_some());
        let mut idle: Vec<PhotoId> = prepared.filter(|id| !needed.contains(id)).collect();
        idle.sort_by_key(|id| (self.prepared.used[id.index()], *id));
        let sum = |photos: &[PhotoId]| photos.iter().map(|id| bytes(*id)).sum::<u64>();
        let (mut held, mut idle) = (sum(needed) + sum(&idle), idle.into_iter());
        while held > self.inputs.memory
            && let Some(id) = idle.next()
        {
            held -= bytes(id);
            self.prepared.photos[id.index()] = None;
        }
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

pub(super) fn hash_of_relief(relief: &FaceRelief) -> String {
    let FaceRelief { frame, low, cell, size, heights } = relief;
    let mut hash = Hashing::default();
    hash.add(format!("{frame:?} {low:?} {cell:?} {size:?}").as_bytes());
    hash.add(heights.iter().map(|height| height.to_le_bytes()).collect::<Vec<_>>().as_flattened());
    hash.hash()
}

/// Returns whether a camera may show something of a ball, given by its middle and radius in world coordinates: true where it does.
fn may_show(camera: &Pinhole, pose: &Pose, (middle, radius): (DVec3, f64)) -> bool {
    let middle = pose.camera_from_world(middle);
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let sides = [
        DVec3::new(1.0, 0.0, camera.cx / camera.fx),
        DVec3::new(-1.0, 0.0, (width - camera.cx) / camera.fx),
        DVec3::new(0.0, 1.0, camera.cy / camera.fy),
        DVec3::new(0.0, -1.0, (height - camera.cy) / camera.fy),
    ];
    middle.z > -radius && sides.iter().all(|side| side.dot(middle) > -radius * side.length())
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
