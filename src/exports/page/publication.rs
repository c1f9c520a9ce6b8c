//! A page that is about to be written: which photos are on it is known, and nothing has left the house.

use std::path::Path;

use glam::DVec3;

use super::choose::{best, shown};
use super::labels::ByteLabels;
use super::options::{LeavingPhoto, PageOptions, Published};
use super::photo::composed;
use super::photos::{PackedPhoto, PhotoPacking, PhotoToPack};
use super::tile_chunk::TileKind;
use super::tiles::TilePages;
use super::write::PageWriter;
use super::{leaving, published_size};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId, up};
use quadratura_base::task::Task;
use quadratura_layers::device::SiteDevice;
use quadratura_page::chunk::Chunk;
use quadratura_page::place::{place_of_page, put};
use quadratura_projection::Renders;
use quadratura_projection::framing::scaled;
use quadratura_sites::open::Opened;
use quadratura_sites::site_parts::SiteParts;
use quadratura_view::metrics::psnr;
use quadratura_view::{Picture, Shot, Unseen};
use quadratura_views::preview::{self, Preview, PreviewOptions};

/// No published pixel takes more bytes than this, of all that a page has: sites whose photos fit by this measure are not measured further.
const MOST_BYTES_PER_PIXEL: f64 = 0.8;
/// The photos of which the size of all is estimated.
const MEASURED: usize = 4;
/// The bytes of a page without photos: the viewer, the dome, pictures for browsers that cannot show more.
const WITHOUT_PHOTOS: f64 = 5e5;
/// The share of the rest that photos may take: geometry and relief take some, and the measured photos may be small ones.
const FOR_PHOTOS: f64 = 0.85;
/// The places of photos that are left out at which the loss is measured, and the longer side of pictures there.
const LOSS_PLACES: usize = 6;
const LOSS_PX: f64 = 320.0;

/// A page that is about to be written.
pub struct Publication<'a> {
    opened: &'a Opened,
    options: &'a PageOptions,
    preview: Preview,
    parts: SiteParts,
    ids: Vec<PhotoId>,
    leaving: Vec<LeavingPhoto>,
    left_out: Vec<String>,
}

impl<'a> Publication<'a> {
    /// Prepares a page of these photos of the project in the folder `project`; of those that together show most of the site well, where
    /// all of them exceed the budget.
    ///
    /// # Errors
    /// Returns the errors of [`preview::open`], [`Error::Request`] for no photos, those of reading layers, or [`Error::Cancelled`].
    pub fn prepare(
        project: &Path,
        opened: &'a Opened,
        photos: &[&Photo],
        options: &'a PageOptions,
        device: &dyn SiteDevice,
        task: &Task,
    ) -> Result<Self> {
        if photos.is_empty() {
            return Err(Error::Request("a page needs one photo at least".into()));
        }
        let site = &opened.site;
        let mut ids: Vec<PhotoId> = photos.iter().filter_map(|photo| site.photo_named(&photo.name)).collect();
        ids.sort_unstable();
        let mut preview =
            preview::open(project, &opened.project, site, device, &PreviewOptions::default(), task)?;
        let parts = preview.parts(&others(opened, &ids), task)?;
        let mut prepared =
            Self { opened, options, preview, parts, ids, leaving: Vec::new(), left_out: Vec::new() };
        prepared.choose(task)?;
        let photos: Vec<&Photo> = prepared.ids.iter().map(|id| site.photo(*id)).collect();
        prepared.leaving = leaving(&photos, options);
        Ok(prepared)
    }

    /// Returns the photos that the page publishes.
    pub fn photos(&self) -> &[LeavingPhoto] {
        &self.leaving
    }

    /// Writes the page in the folder `out`, or beside it where that holds something else.
    ///
    /// # Errors
    /// Returns [`Error::Request`] for a viewpoint that the project does not have, those of reading layers, [`Error::Io`], or
    /// [`Error::Cancelled`].
    pub fn write(mut self, out: &Path, task: &Task) -> Result<Published> {
        let place = place_of_page(out);
        let mut writer = PageWriter::new(self.opened, &self.ids, self.leaving, &self.parts, self.options)?;
        let files = put(&place, |folder| writer.write(folder, &mut self.preview, task))?;
        self.preview.problems().into_iter().for_each(|problem| task.note(problem));
        let mut published = writer.published(place, &files);
        published.left_out.splice(0..0, self.left_out);
        Ok(published)
    }

    /// Leaves out photos where all of them exceed the budget.
    fn choose(&mut self, task: &Task) -> Result<()> {
        let pixels = |id: &PhotoId| {
            let camera = &self.opened.site.photo(*id).camera;
            let [width, height] = published_size([camera.width, camera.height], self.options.longest);
            f64::from(width) * f64::from(height)
        };
        let budget = FOR_PHOTOS * (self.options.budget as f64 - WITHOUT_PHOTOS).max(0.0);
        if self.ids.iter().map(pixels).sum::<f64>() * MOST_BYTES_PER_PIXEL <= budget {
            return Ok(());
        }
        let each = task.timed("measure photos", || self.mean_bytes(task))?;
        let most = ((budget / each) as usize).max(1);
        if most >= self.ids.len() {
            return Ok(());
        }
        let surface = self.preview.surface();
        let shown = shown(&self.parts, &surface, &self.ids, up(&self.opened.site.photos));
        let chosen = best(&shown, self.ids.len(), most);
        let all = std::mem::take(&mut self.ids);
        self.ids = chosen.iter().map(|number| all[*number]).collect();
        let out: Vec<PhotoId> =
            all.iter().filter(|id| self.ids.binary_search(id).is_err()).copied().collect();
        let loss = self.loss(&all, &out, task)?;
        self.parts = self.preview.parts(&others(self.opened, &self.ids), task)?;
        self.left_out = vec![self.said_of(&out, loss)];
        Ok(())
    }

    /// Returns the mean size of photos on the page in bytes, with their hidden texels, by a few of them.
    fn mean_bytes(&self, task: &Task) -> Result<f64> {
        let packing = PhotoPacking::new(self.options, self.ids.len(), false);
        let (mut bytes, mut pages) = (0, [TilePages::default(), TilePages::default()]);
        let size = |chunk: Chunk| chunk.script("").len();
        let measured: Vec<PhotoId> = spread(&self.ids, MEASURED).collect();
        for id in &measured {
            task.check_cancelled()?;
            let photo = composed(*id, &self.parts.skirts, &*self.parts.texels, &self.parts.agreement)?;
            let labels: ByteLabels = photo.labels.in_bytes();
            let projector = self.parts.skirts.sources.photo(*id);
            let to_pack = PhotoToPack {
                id: *id,
                name: "",
                camera: &projector.camera,
                pose: &projector.pose,
                origin: DVec3::ZERO,
            };
            let packed = PackedPhoto::new(&to_pack, &photo, &labels, &self.parts.gains, &packing);
            let mut far = Chunk::default();
            packed.add_far(&mut far);
            bytes += size(packed.near) + size(far);
            for tiled in &photo.tiled {
                let kind = TileKind::of(tiled);
                let full = |page| {
                    bytes += size(kind.chunk(&page, self.options.quality));
                    Ok::<(), Error>(())
                };
                pages[usize::from(kind == TileKind::Cut)].add(tiled, full)?;
            }
        }
        for (kind, pages) in [TileKind::Hidden, TileKind::Cut].into_iter().zip(&mut pages) {
            bytes += pages.last().map_or(0, |page| size(kind.chunk(&page, self.options.quality)));
        }
        Ok(bytes as f64 / measured.len() as f64)
    }

    /// Returns the likeness in dB of pictures with the chosen photos to those with all, from where photos that are left out were taken,
    /// which is where they are missed most.
    fn loss(&mut self, all: &[PhotoId], out: &[PhotoId], task: &Task) -> Result<f64> {
        let with = [others(self.opened, all), others(self.opened, &self.ids)];
        let places: Vec<PhotoId> = spread(out, LOSS_PLACES).collect();
        let mut pictures: [Vec<Picture>; 2] = [Vec::new(), Vec::new()];
        for (pictures, without) in pictures.iter_mut().zip(&with) {
            for place in &places {
                let photo = self.opened.site.photo(*place);
                let camera = &photo.camera;
                let by = (LOSS_PX / f64::from(camera.width.max(camera.height))).min(1.0);
                let shot = Shot {
                    unseen: Unseen::Continued,
                    without: without.clone(),
                    ..Shot::new(scaled(camera, by), photo.pose)
                };
                pictures.push(self.preview.picture(&shot, task)?);
            }
        }
        let [before, after] = &pictures;
        let (mut squares, mut samples) = (0.0, 0);
        for (before, after) in before.iter().zip(after) {
            let (before, after) = (before.over([0; 3]), after.over([0; 3]));
            squares += before.iter().zip(&after).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
            samples += before.len() as u64;
        }
        Ok(psnr(squares, samples))
    }

    fn said_of(&self, out: &[PhotoId], loss: f64) -> String {
        let names: Vec<&str> = out.iter().map(|id| self.opened.site.photo(*id).name.as_str()).collect();
        format!(
            "{} of {} photos, which the budget of {:.0} MB does not hold: those were chosen that together show most of the site well; from \
             where others were taken, pictures have {loss:.1} dB to those with all photos. Left out: {}",
            out.len(),
            out.len() + self.ids.len(),
            self.options.budget as f64 / 1e6,
            names.join(", ")
        )
    }
}

/// Returns the photos of the site that are not among these, which are ascending.
fn others(opened: &Opened, ids: &[PhotoId]) -> Vec<PhotoId> {
    opened.site.photo_ids().filter(|id| ids.binary_search(id).is_err()).collect()
}

/// Returns at most so many, evenly spread.
fn spread(ids: &[PhotoId], most: usize) -> impl Iterator<Item = PhotoId> {
    let count = ids.len().min(most);
    (0..count).map(move |number| ids[(2 * number + 1) * ids.len() / (2 * count)])
}
