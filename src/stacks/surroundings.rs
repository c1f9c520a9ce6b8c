//! What is known of a project's surroundings, estimated once and then cached in `cache/`: the dome, and how far
//! photos confirm each other's surroundings.

mod comparison;
mod ground;

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::comparison::PhotosOnShelf;
use self::ground::{GroundOfPhoto, ground_of_photos, mean_ground};
use crate::far_backdrops::FarBackdrops;
use crate::gains;
use crate::inputs::hash_of_model;
use crate::layer_textures::LayerTextureFiles;
use crate::shelf::Shelf;
use crate::sources::sources;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::up;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::{PaintBook, PaintEntry};
use quadratura_document::{Project, Stack};
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_files::hash::hash_bytes;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::agreement::directions::DirectionPhoto;
use quadratura_layers::dome::{DomeContent, dome};
use quadratura_layers::sky_model::Daylight;
use quadratura_projection::dome::Dome;
use quadratura_projection::exposure::SurroundingsGains;
use quadratura_projection::exposure::surroundings::SurroundingsFactors;
use quadratura_projection::{Gains, LayerTextureId, Sources, Texels};
use quadratura_sites::budget::{Budget, default_memory};
use quadratura_sites::dome_picture::{dome_side, picture_dome, picture_stamp};
use quadratura_sites::shared::Shared;
use quadratura_view::agreement::PhotoAgreement;
use quadratura_view::srgb::Srgb;

/// A counter of changes in how the same surroundings are compared and blended.
const VERSION: u32 = 7;

/// The file `cache/surroundings.bin`.
const CACHED: CachedKind = CachedKind { name: "surroundings", version: 4 };

/// The longer side of the reduced photos that are compared and blended.
const LONGEST_PX: u32 = 1024;

/// The least alpha of texels that are compared and blended: that of a photo's own beside outlines.
const LEAST_ALPHA: u8 = 3;

/// What photos tell about their surroundings.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct ComparedSurroundings {
    /// How far others confirm each photo's surroundings, in the site's order.
    agreement: Vec<PhotoAgreement>,
    /// The factors that bring each photo's surroundings to one sky, in the site's order; `None` for photos that show none.
    factors: Vec<Option<SurroundingsFactors>>,
    /// What is seen in every direction; `None` where no photo shows any surroundings.
    dome: Option<Dome>,
}

/// What is kept in the file.
#[derive(Debug, Default, Serialize, Deserialize)]
struct KeptSurroundings {
    /// The hash of everything that `compared` was made from.
    inputs: String,
    compared: ComparedSurroundings,
    /// What each photo shows of the ground, by the hash of the photo.
    ground: BTreeMap<String, GroundOfPhoto>,
}

/// What the photos tell about the surroundings.
#[derive(Debug, Clone, Default)]
pub struct SurroundingsEvidence {
    /// What is seen in every direction; `None` where no photo shows any surroundings.
    pub dome: Option<Arc<Dome>>,
    /// How far others confirm each photo's surroundings, in the site's order; empty where there are none.
    pub agreement: Arc<[PhotoAgreement]>,
    /// The factors that bring each photo's surroundings to one sky.
    pub gains: Arc<SurroundingsGains>,
}

/// The surroundings of a site, and of the site without some of its photos.
pub struct SiteSurroundings {
    site: Site,
    /// The project's folder.
    folder: PathBuf,
    memory: u64,
    /// The photos' layers with the paint that is seen from everywhere, without fillings.
    files: LayerTextureFiles,
    sources: Sources,
    whole: SurroundingsEvidence,
    /// The dome of all photos.
    of_photos: Option<Arc<Dome>>,
    /// The dome of the user's picture, which takes the place of that of the photos.
    picture: Option<Arc<Dome>>,
    /// The daylight of the sky that takes the place of all that photos show.
    daylight: Option<Daylight>,
    /// The hash of everything that it was made from, the user's picture included.
    stamp: String,
    /// What each photo shows of the ground, in the site's order.
    ground: Vec<GroundOfPhoto>,
    /// The photos prepared for comparison, once they were needed; those without surroundings have none.
    reduced: Option<Shelf<DirectionPhoto>>,
}

impl SiteSurroundings {
    /// Returns what is cached in the project's folder if it was made from the same stacks, decisions and paint;
    /// otherwise compares and blends the photos' surroundings and caches the result. `gains` are the photos' in the
    /// site's order, `memory` is the budget in bytes for photos decoded at the same time.
    ///
    /// # Errors
    /// [`Error::Cancelled`], and the errors of reading paint. A layer that cannot be read is noted and not used; a
    /// cache that cannot be written is noted.
    pub fn open(
        folder: &Path,
        project: &Project,
        site: &Site,
        stacks: &[Option<impl Borrow<Stack>>],
        gains: &Gains,
        memory: u64,
        task: &Task,
    ) -> Result<Self> {
        let sources = sources(site, stacks, &project.decisions);
        let store = StackStore::new(folder);
        let mut book = PaintStore::new(folder).read()?;
        let far = Arc::new(FarBackdrops::new(site));
        book.entries.retain(|entry| seen_from_everywhere(project, entry, &far));
        let owned: Vec<Option<Stack>> =
            stacks.iter().map(|stack| stack.as_ref().map(|stack| stack.borrow().clone())).collect();
        let files = LayerTextureFiles::new(&store, &owned, false)
            .with_far(&owned, far)
            .with_paint_of(&store, &owned, &book);
        let file = folder.join("cache/surroundings.bin");
        let mut kept: KeptSurroundings = read_cached(&file, CACHED, "").unwrap_or_default();
        let of_photos = gains::photo_inputs(site, stacks);
        let known = of_photos.iter().map(|photo| kept.ground.get(photo).copied());
        let ground = ground_of_photos(folder, site, known.collect(), task)?;
        let inputs = inputs(&files, &sources, site, gains, (mean_ground(&ground, &[], gains), &book));
        let mut found = Self {
            site: site.clone(),
            folder: folder.to_owned(),
            memory,
            files,
            sources,
            whole: SurroundingsEvidence::default(),
            of_photos: None,
            picture: None,
            daylight: None,
            stamp: format!("{inputs} {}", picture_stamp(folder, project)),
            ground,
            reduced: None,
        };
        let pictured = picture_dome(folder, project, site, task).unwrap_or_else(|error| {
            task.note(Message::from("the picture of the surroundings is not used: ").and(&error));
            None
        });
        found.picture = pictured.map(Arc::new);
        if found.sources.surroundings.is_empty() {
            found.take_whole(ComparedSurroundings::default());
            return Ok(found);
        }
        let ground: BTreeMap<String, GroundOfPhoto> =
            of_photos.into_iter().zip(found.ground.iter().copied()).collect();
        let is_same = |kept: &KeptSurroundings| kept.inputs == inputs && kept.ground == ground;
        let mut _lock = None;
        if !is_same(&kept) {
            // Another program may have made them meanwhile.
            match Shared::find(folder, || read_cached(&file, CACHED, "").filter(is_same), task)? {
                Shared::Known(made) => kept = made,
                Shared::Missing(lock) => _lock = lock,
            }
        }
        if is_same(&kept) {
            found.take_whole(kept.compared);
            return Ok(found);
        }
        if kept.inputs != inputs {
            kept.compared = found.compared(&[], gains, task)?;
        }
        kept = KeptSurroundings { inputs, ground, ..kept };
        if let Err(error) = write_cached(&file, CACHED, "", &kept) {
            task.note(Message::from("the surroundings cannot be cached: ").and(&error));
        }
        found.take_whole(kept.compared);
        // Prepared photos are large; few pictures need them again.
        found.reduced = None;
        Ok(found)
    }

    /// Returns the surroundings of the project as it is now, with the gains that are decided now.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn present(
        folder: &Path,
        project: &Project,
        site: &Site,
        stacks: &[Option<impl Borrow<Stack>>],
        task: &Task,
    ) -> Result<Self> {
        let (colour, memory) = (&project.colour, default_memory());
        let gains = gains::photo_gains(site, stacks, colour, folder, memory, task)?;
        Self::open(folder, project, site, stacks, &gains, memory, task)
    }

    /// Returns the same with a plain sky in the place of all that photos show around the model: its sun and its air are those that
    /// explain best what they show.
    pub fn with_modelled_sky(mut self, gains: &Gains) -> Self {
        let looks = self.site.photos.iter().map(|photo| photo.pose.rotation.transpose() * DVec3::Z);
        let forwards = looks.sum::<DVec3>().normalize_or_zero();
        let ground = mean_ground(&self.ground, &[], gains);
        let daylight = Daylight::estimated(self.of_photos.as_deref(), up(&self.site.photos), forwards);
        let dome = Arc::new(daylight.dome(ground, self.side() as usize));
        let gains =
            SurroundingsGains { dome_white: dome.white, ..SurroundingsGains::clone(&self.whole.gains) };
        self.whole = SurroundingsEvidence { dome: Some(dome.clone()), gains: gains.into(), ..self.whole };
        self.stamp += " sky";
        (self.picture, self.daylight) = (Some(dome), Some(daylight));
        self
    }

    /// Returns the daylight of the sky that takes the place of all that photos show; `None` where they show it.
    pub fn daylight(&self) -> Option<&Daylight> {
        self.daylight.as_ref()
    }

    /// Returns what all photos tell.
    pub fn whole(&self) -> &SurroundingsEvidence {
        &self.whole
    }

    /// Returns the hash of everything that it was made from.
    pub fn stamp(&self) -> &str {
        &self.stamp
    }

    /// Returns the photos' layers with the paint that is seen from everywhere, without fillings.
    pub(super) fn files(&self) -> &LayerTextureFiles {
        &self.files
    }

    /// Returns the sources that number the layers, without the dome.
    pub(super) fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Returns the photos that show surroundings.
    pub fn photos(&self) -> impl Iterator<Item = PhotoId> {
        let of_servers = self.sources.servers_of_surroundings().iter().map(|server| server.photo);
        of_servers.collect::<BTreeSet<PhotoId>>().into_iter()
    }

    /// Returns true when the user's picture is the dome; false without one, and where it cannot be read.
    pub fn uses_picture(&self) -> bool {
        self.picture.is_some()
    }

    /// Returns the side of the dome, which is the same with and without any photos.
    pub fn side(&self) -> u32 {
        dome_side(&self.site)
    }

    /// Returns what the other photos tell when these have no say, with the gains that were estimated without them.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn without(
        &mut self,
        photos: &[PhotoId],
        gains: &Gains,
        task: &Task,
    ) -> Result<SurroundingsEvidence> {
        match photos.is_empty() || self.sources.surroundings.is_empty() {
            true => Ok(self.whole.clone()),
            false => {
                let compared = self.compared(photos, gains, task)?;
                Ok(self.evidence(compared))
            }
        }
    }

    /// Takes what was compared of all photos.
    fn take_whole(&mut self, compared: ComparedSurroundings) {
        self.of_photos = compared.dome.clone().map(Arc::new);
        self.whole = self.evidence(compared);
    }

    /// Returns what was compared as evidence, with the user's picture in the place of the dome.
    fn evidence(&self, compared: ComparedSurroundings) -> SurroundingsEvidence {
        let ComparedSurroundings { agreement, factors, dome } = compared;
        let dome = self.picture.clone().or(dome.map(Arc::new));
        let gains = SurroundingsGains {
            of_photo: factors,
            dome_white: dome.as_ref().map_or(1.0, |dome| dome.white),
            scale: self.sources.surroundings_scale,
        };
        SurroundingsEvidence { dome, agreement: agreement.into(), gains: gains.into() }
    }

    /// Compares and blends the photos that are not left out. Each is read a few times, one after the other.
    fn compared(&mut self, left_out: &[PhotoId], gains: &Gains, task: &Task) -> Result<ComparedSurroundings> {
        let shelf = match self.reduced.take() {
            Some(shelf) => shelf,
            None => self.prepared(task)?,
        };
        let taking_part = self.photos().filter(|id| !left_out.contains(id));
        let photos = PhotosOnShelf { shelf: &shelf, ids: taking_part.collect() };
        photos.change_all(|id, photo| {
            photo.set_exposure(gains.of_photo[id.index()], &gains.optics[id.index()]);
            photo.set_agreement(&[]);
        })?;
        let mut factors = vec![None; self.site.photos.len()];
        // Photos are compared under one sky, and what they then confirm of each other tells more of it.
        photos.unite(&mut factors, task)?;
        let scale = self.sources.surroundings_scale;
        let agreement = photos.compare(&self.site, &gains.light.groups, scale, task)?;
        photos.unite(&mut factors, task)?;
        let ground = mean_ground(&self.ground, left_out, gains);
        let content = DomeContent { photos: &photos, ground, up: up(&self.site.photos) };
        let dome = task.timed("blend surroundings", || dome(&content, self.side() as usize, task))?;
        drop(photos);
        self.reduced = Some(shelf);
        Ok(ComparedSurroundings { agreement, factors, dome })
    }

    /// Reads and reduces the surroundings of all photos.
    fn prepared(&self, task: &Task) -> Result<Shelf<DirectionPhoto>> {
        let budget = Budget::new(self.memory);
        let shelf = Shelf::new(self.site.photos.len(), self.memory / 2, &self.folder.join("cache"));
        let prepare = |id: PhotoId| {
            task.check_cancelled()?;
            let camera = &self.site.photo(id).camera;
            // The decoded layer, which may be twice as large as the photo along both sides.
            let bytes = u64::from(camera.width) * u64::from(camera.height) * 8;
            let reduced = budget.with(bytes, || self.reduced_photo(id, task))?;
            reduced.map_or(Ok(()), |photo| shelf.put(id.index(), photo))
        };
        self.site.photo_ids().collect::<Vec<_>>().into_par_iter().try_for_each(prepare)?;
        Ok(shelf)
    }

    fn reduced_photo(&self, id: PhotoId, task: &Task) -> Result<Option<DirectionPhoto>> {
        let photo = self.site.photo(id);
        let servers = self.sources.servers_of_surroundings().iter().filter(|server| server.photo == id);
        let layers: Vec<LayerTextureId> = servers.map(|server| server.layer_texture).collect();
        if layers.is_empty() {
            return Ok(None);
        }
        let (camera, step) = reduced_camera(&photo.camera);
        let mut sums = vec![([0.0f32; 3], 0u32); camera.width as usize * camera.height as usize];
        for layer in layers {
            match self.files.layer_texture(layer) {
                Ok(pixels) => {
                    let texels = pixels.rect.pixels().zip(pixels.rgba.as_chunks::<4>().0);
                    for ((x, y), texel) in texels.filter(|(_, texel)| texel[3] >= LEAST_ALPHA) {
                        let (x, y) = (x.div_euclid(step as i32), y.div_euclid(step as i32));
                        if let Some(at) = camera.rect().index(x, y) {
                            let srgb = Srgb::tables();
                            (0..3).for_each(|c| sums[at].0[c] += srgb.linear(texel[c]));
                            sums[at].1 += 1;
                        }
                    }
                }
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => {
                    let note = Message::from("its surroundings are not used: ").and(&error);
                    task.with_subject(&photo.name).note(note);
                }
            }
        }
        // A pixel that an outline crosses shows both sides of it.
        let whole = step * step;
        let light = |(sum, count): ([f32; 3], u32)| {
            (4 * count >= 3 * whole).then(|| sum.map(|sum| sum / count as f32))
        };
        Ok(Some(DirectionPhoto::new(camera, photo.pose, sums.into_iter().map(light).collect())))
    }
}

/// Returns the camera of a reduced photo, and how many pixels along both sides one of its pixels stands for.
fn reduced_camera(camera: &Pinhole) -> (Pinhole, u32) {
    let step = camera.width.max(camera.height).div_ceil(LONGEST_PX).max(1);
    let by = f64::from(step);
    let reduced = Pinhole {
        width: (camera.width / step).max(1),
        height: (camera.height / step).max(1),
        fx: camera.fx / by,
        fy: camera.fy / by,
        cx: camera.cx / by,
        cy: camera.cy / by,
    };
    (reduced, step)
}

/// Returns true for paint on the surroundings that other photos see.
fn seen_from_everywhere(project: &Project, entry: &PaintEntry, far: &FarBackdrops) -> bool {
    (entry.object == SURROUNDINGS || far.contains(&entry.object)) && !project.fill.stays(&entry.place())
}

/// Returns the hash of everything that the evidence is made from: what the photos' layers of the surroundings show, whatever else
/// changed in their stacks, their exposures, the ground, and paint.
fn inputs(
    files: &LayerTextureFiles,
    sources: &Sources,
    site: &Site,
    gains: &Gains,
    (ground, paint): (Option<[f32; 3]>, &PaintBook),
) -> String {
    let servers = sources.servers_of_surroundings().iter();
    let layers: Vec<_> =
        servers.map(|server| (server.photo.0, files.content(server.layer_texture))).collect();
    let cameras = site.photos.iter().map(|photo| {
        let pose = (photo.pose.rotation_rows(), photo.pose.translation);
        (&photo.name, photo.camera.width, photo.camera.height, photo.camera.matrix_rows(), pose)
    });
    let cameras: Vec<_> = cameras.collect();
    let all = (
        (env!("CARGO_PKG_VERSION"), VERSION, dome_side(site), hash_of_model(&site.model)),
        (layers, cameras),
        (&gains.of_photo, &gains.optics, &gains.light.groups),
        ground,
        serde_json::to_string(&paint.entries).expect("plain data is JSON"),
    );
    hash_bytes(&serde_json::to_vec(&all).expect("plain data is JSON"))
}
