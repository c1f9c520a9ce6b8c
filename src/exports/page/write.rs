//! All files of a page, in the order in which they are computed, so that little is in memory.

use glam::DVec3;

use super::description::{
    DescribedBlend, DescribedExposure, DescribedFar, DescribedPage, DescribedPhoto, DescribedTour,
    DescribedView, PageDescription, VERSION,
};
use super::dome::dome;
use super::geometry::{GeometryInputs, geometry, grids};
use super::labels::ByteLabels;
use super::meter;
use super::options::{LeavingPhoto, PageOptions, PagePart, Published};
use super::photo::composed;
use super::photos::{IN_A_CHUNK, PackedPhoto, PhotoPacking, PhotoToPack};
use super::place_texts::{DescribedText, described_texts};
use super::safe::{PhotoMap, SafeSearch, half_trust};
use super::texts::{PageTexts, index};
use super::tile_chunk::TileKind;
use super::tiles::{TilePage, TilePages};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{PhotoId, up};
use quadratura_base::task::Task;
use quadratura_page::chunk::{Chunk, description};
use quadratura_page::pictures::small_jpeg;
use quadratura_page::place::{PageFile, PageFolder, PagePlace};
use quadratura_page::viewer;
use quadratura_projection::Renders;
use quadratura_sites::open::Opened;
use quadratura_sites::site_parts::SiteParts;
use quadratura_view::{Blend, Shot, Unseen};
use quadratura_views::preview::Preview;

/// The size of pictures of viewpoints, in pixels.
const PICTURE: [u32; 2] = [1280, 800];
/// Their quality.
const PICTURE_QUALITY: u8 = 80;
/// The logarithms of sky factors are stored in steps of this.
const SKY_STEP: f32 = 1.0 / 4096.0;

/// Writes a page.
pub struct PageWriter<'a> {
    opened: &'a Opened,
    ids: &'a [PhotoId],
    leaving: Vec<LeavingPhoto>,
    parts: &'a SiteParts,
    options: &'a PageOptions,
    origin: DVec3,
    up: DVec3,
    start: PageView,
    views: Vec<PageView>,
    texts: Vec<DescribedText>,
    left_out: Vec<String>,
    /// The chunks of the first picture.
    first_chunks: Vec<String>,
}

/// A view with a name.
#[derive(Clone)]
struct PageView {
    name: String,
    pose: Pose,
    /// Half the angle of view from top to bottom, as a tangent.
    tangent: f64,
}

/// What is known once all photos are written.
#[derive(Default)]
struct WrittenPhotos {
    described: Vec<DescribedPhoto>,
    labels: Vec<ByteLabels>,
    maps: Vec<PhotoMap>,
    far: Vec<DescribedFar>,
    hidden: TilePages,
    cut: TilePages,
    hidden_pages: Vec<DescribedPage>,
    cut_pages: Vec<DescribedPage>,
}

impl WrittenPhotos {
    /// Returns the pages of a kind of tiles, and what is listed of those that are written.
    fn tiles(&mut self, kind: TileKind) -> (&mut TilePages, &mut Vec<DescribedPage>) {
        match kind {
            TileKind::Hidden => (&mut self.hidden, &mut self.hidden_pages),
            TileKind::Cut => (&mut self.cut, &mut self.cut_pages),
        }
    }
}

impl<'a> PageWriter<'a> {
    /// Prepares a page of these photos.
    ///
    /// # Errors
    /// [`Error::Request`] for a viewpoint that the project does not have, also as that of a text.
    pub fn new(
        opened: &'a Opened,
        ids: &'a [PhotoId],
        leaving: Vec<LeavingPhoto>,
        parts: &'a SiteParts,
        options: &'a PageOptions,
    ) -> Result<Self> {
        let origin = if options.keep_coordinates { DVec3::ZERO } else { middle(opened, ids) };
        let bookmarks = &opened.project.views;
        let views: Vec<PageView> = bookmarks
            .iter()
            .map(|bookmark| {
                let view = bookmark.viewpoint();
                PageView { name: bookmark.name.clone(), pose: view.pose, tangent: 0.5 / view.lens.focal[1] }
            })
            .collect();
        let first = opened.site.photo(ids[0]);
        let start = match &options.viewpoint {
            Some(name) => views.iter().find(|view| view.name == *name).cloned().ok_or_else(|| {
                Error::Request(format!(
                    "the project has no bookmark \"{name}\"; it has {}",
                    match views.as_slice() {
                        [] => "none".to_owned(),
                        some => some
                            .iter()
                            .map(|view| format!("\"{}\"", view.name))
                            .collect::<Vec<_>>()
                            .join(", "),
                    }
                ))
            })?,
            None => views.first().cloned().unwrap_or(PageView {
                name: leaving[0].published.clone(),
                pose: first.pose,
                tangent: f64::from(first.camera.height) / 2.0 / first.camera.fy,
            }),
        };
        let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
        let texts = described_texts(&opened.project.texts, &names, origin)?;
        let up = up(&opened.site.photos);
        let mut left_out = Vec::new();
        if !opened.project.trees.is_empty() {
            left_out.push("planted trees: pages show photos only".to_owned());
        }
        if !parts.gains.light.groups.is_one() {
            left_out.push("the correction of light between rounds of photos, face by face".to_owned());
        }
        let first_chunks = Vec::new();
        Ok(Self {
            opened,
            ids,
            leaving,
            parts,
            options,
            origin,
            up,
            start,
            views,
            texts,
            left_out,
            first_chunks,
        })
    }

    /// Writes all files.
    ///
    /// # Errors
    /// Those of reading layers, of drawing and of writing; [`Error::Cancelled`].
    pub fn write(&mut self, folder: &mut PageFolder, preview: &mut Preview, task: &Task) -> Result<()> {
        for (name, content) in viewer::SITE.files() {
            folder.write(&name, content.as_bytes())?;
        }
        let mut written = self.write_photos(folder, task)?;
        let [hidden, cut] = [&written.hidden.placed[..], &written.cut.placed[..]];
        let inputs = GeometryInputs {
            parts: self.parts,
            photos: self.ids,
            labels: &written.labels,
            tiles: [hidden, cut],
            origin: self.origin,
        };
        chunk(folder, "geometry", &geometry(&inputs))?;
        chunk(folder, "sheets", &self.grids())?;
        if let Some(found) = &self.parts.dome {
            chunk(folder, "dome", &dome(found))?;
        }
        let site = self.describe(&mut written, preview, task);
        let nearest = site.far.first().map(|far| far.chunk.as_str());
        self.first_chunks =
            ["site", "geometry", "sheets"].into_iter().chain(nearest).map(str::to_owned).collect();
        folder.write("data/site.js", &description(&site))?;
        self.write_pictures(folder, preview, &site, task)
    }

    /// Writes the photos one by one, and the pages of tiles whenever one is full.
    fn write_photos(&mut self, folder: &mut PageFolder, task: &Task) -> Result<WrittenPhotos> {
        let sources = &self.parts.skirts.sources;
        let cameras = self.ids.iter().map(|id| sources.photo(*id).camera);
        let upright = cameras.clone().all(|camera| camera.height > camera.width);
        let packing = PhotoPacking::new(self.options, self.ids.len(), upright);
        let mut written = WrittenPhotos::default();
        let mut far = Chunk::default();
        for (number, id) in self.ids.iter().enumerate() {
            task.step("publish photos", number as u64, self.ids.len() as u64)?;
            let photo = composed(*id, &self.parts.skirts, &*self.parts.texels, &self.parts.agreement)?;
            let labels = photo.labels.in_bytes();
            if labels.lost > 0 {
                let name = &self.leaving[number].photo;
                self.left_out.push(format!("{} pixels of {name}, which are shown by the smallest of more than 255 combinations of image layers", labels.lost));
            }
            let projector = sources.photo(*id);
            let name = &self.leaving[number].published;
            let to_pack = PhotoToPack {
                id: *id,
                name,
                camera: &projector.camera,
                pose: &projector.pose,
                origin: self.origin,
            };
            let packed = PackedPhoto::new(&to_pack, &photo, &labels, &self.parts.gains, &packing);
            chunk(folder, &near_name(number), &packed.near)?;
            packed.add_far(&mut far);
            if (number + 1) % IN_A_CHUNK == 0 || number + 1 == self.ids.len() {
                let name = format!("far-{}", written.far.len() + 1);
                chunk(folder, &name, &std::mem::take(&mut far))?;
                let first = number / IN_A_CHUNK * IN_A_CHUNK;
                written.far.push(DescribedFar { chunk: name, first, photos: number + 1 - first });
            }
            for tiled in &photo.tiled {
                let kind = TileKind::of(tiled);
                let (pages, listed) = written.tiles(kind);
                pages.add(tiled, |page| write_page(folder, &page, kind, self.options.quality, listed))?;
            }
            let trust = half_trust(&photo.trust, photo.size);
            written.maps.push(PhotoMap::new(&labels.of_pixel, trust, photo.size));
            // Labels of pixels are written; those of layers are for the geometry.
            written.labels.push(ByteLabels { of_pixel: Vec::new(), ..labels });
            written.described.push(packed.described);
        }
        for kind in [TileKind::Hidden, TileKind::Cut] {
            let (pages, listed) = written.tiles(kind);
            if let Some(page) = pages.last() {
                write_page(folder, &page, kind, self.options.quality, listed)?;
            }
        }
        Ok(written)
    }

    /// Returns the chunk of grids: relief, colours that continue, factors to one sky, and the points of the meter.
    fn grids(&self) -> Chunk {
        let mut chunk = grids(self.parts, self.origin);
        let of_photo = &self.parts.gains.surroundings.of_photo;
        let of_photos = self.ids.iter().filter_map(|id| of_photo.get(id.index()).and_then(Option::as_ref));
        let steps =
            of_photos.flat_map(|grid| grid.cells.iter().flatten().map(|log| (log / SKY_STEP).round() as i16));
        chunk.add_numbers("sky", steps.map(i16::to_le_bytes));
        let points = meter::numbers(&self.parts.gains.meter, self.ids, self.origin);
        chunk.add_numbers("meter", points.into_iter().map(f32::to_le_bytes));
        chunk
    }

    fn describe(&self, written: &mut WrittenPhotos, preview: &Preview, task: &Task) -> PageDescription {
        let sources = &self.parts.skirts.sources;
        let maps = std::mem::take(&mut written.maps).into_iter().zip(std::mem::take(&mut written.labels));
        let photos: Vec<_> = self
            .ids
            .iter()
            .zip(maps)
            .map(|(id, (map, labels))| (*id, &sources.photo(*id).camera, map, labels))
            .collect();
        let surface = preview.surface();
        let search = SafeSearch {
            parts: self.parts,
            surface: &surface,
            photos: &photos,
            up: self.up,
            origin: self.origin,
        };
        let safe = task.timed("safe region", || search.region());
        let described =
            |view: &PageView| DescribedView::new(view.name.clone(), &view.pose, view.tangent, self.origin);
        let flight = self.opened.project.flight.as_ref();
        let (start, extent) = (described(&self.start), extent(self.opened, self.ids));
        DescribedFar::sort_by_nearness(&mut written.far, &written.described, &start, extent);
        PageDescription {
            version: VERSION,
            title: self.title(),
            up: self.up.to_array(),
            extent,
            blend: DescribedBlend { lambda: Blend::default().lambda },
            exposure: DescribedExposure {
                rule: self.parts.gains.rule.name(),
                keeps_vignetting: self.parts.gains.keeps_vignetting,
                meter: meter::described(&self.parts.gains.meter, self.ids),
            },
            surroundings_scale: sources.surroundings_scale,
            photos: std::mem::take(&mut written.described),
            far: std::mem::take(&mut written.far),
            hidden: std::mem::take(&mut written.hidden_pages),
            cut: std::mem::take(&mut written.cut_pages),
            dome: self.parts.dome.as_ref().map(|dome| f64::from(dome.white)),
            start,
            viewpoints: self.views.iter().map(described).collect(),
            tour: flight.and_then(|path| DescribedTour::of_path(path, self.up, self.origin)),
            texts: self.texts.clone(),
            safe,
        }
    }

    fn title(&self) -> String {
        let title = self.options.title.as_ref().or(self.opened.project.page.title.as_ref());
        title.cloned().unwrap_or_else(|| "A photographed place".to_owned())
    }

    /// Writes the poster, the pictures of viewpoints for browsers that cannot draw more, and the page that shows them.
    fn write_pictures(
        &self,
        folder: &mut PageFolder,
        preview: &mut Preview,
        site: &PageDescription,
        task: &Task,
    ) -> Result<()> {
        let mut draw = |view: &PageView| -> Result<Vec<u8>> {
            let [width, height] = PICTURE;
            let focal = f64::from(height) / 2.0 / view.tangent;
            let camera = Pinhole {
                width,
                height,
                fx: focal,
                fy: focal,
                cx: f64::from(width) / 2.0,
                cy: f64::from(height) / 2.0,
            };
            let without = self.opened.site.photo_ids().filter(|id| !self.ids.contains(id)).collect();
            let shot = Shot { unseen: Unseen::Continued, without, ..Shot::new(camera, view.pose) };
            let picture = preview.picture(&shot, task)?;
            Ok(small_jpeg(picture.over([0; 3]), PICTURE, PICTURE[0], PICTURE_QUALITY))
        };
        folder.write("poster.jpg", &draw(&self.start)?)?;
        for (number, view) in self.views.iter().enumerate() {
            folder.write(&format!("views/{}.jpg", number + 1), &draw(view)?)?;
        }
        let names: Vec<&str> = self.views.iter().map(|view| view.name.as_str()).collect();
        let said = &self.opened.project.page;
        let credits = if self.options.credits.is_empty() { &said.credits } else { &self.options.credits };
        let licence = self.options.licence.as_deref().or(said.licence.as_deref());
        let texts = PageTexts {
            title: &site.title,
            views: &names,
            texts: &site.texts,
            credits,
            licence,
            first_chunks: &self.first_chunks,
        };
        folder.write("index.html", index(&texts).as_bytes())
    }

    /// Returns what was published.
    pub fn published(self, place: PagePlace, files: &[PageFile]) -> Published {
        let sum = |is_meant: &dyn Fn(&str) -> bool| {
            files.iter().filter(|file| is_meant(&file.name)).map(|file| file.bytes).sum::<u64>()
        };
        let data = |start: &'static str| {
            move |name: &str| name.strip_prefix("data/").is_some_and(|name| name.starts_with(start))
        };
        let part = |what: &'static str, start: &'static str| PagePart { what, bytes: sum(&data(start)) };
        let is_first = |name: &str| self.first_chunks.iter().any(|chunk| name == format!("data/{chunk}.js"));
        let viewer =
            sum(&|name: &str| name.starts_with("code/") || name == "viewer.css" || name == "index.html");
        Published {
            folder: place.folder,
            spared: place.spared,
            photos: self.leaving,
            bytes: sum(&|_| true),
            first: sum(&is_first) + sum(&data("dome")) + viewer,
            viewer,
            parts: vec![
                part("photos, with labels and confidence", "near"),
                part("coarse photos, with coarse labels and confidence", "far"),
                part("hidden texels", "hidden"),
                part("layers that one sees through", "cut"),
                part("geometry", "geometry"),
                part("relief and colours of what no photo shows", "sheets"),
                part("dome", "dome"),
            ],
            left_out: self.left_out,
        }
    }
}

/// Returns the name of the chunk of a photo, which does not tell the photo's own.
fn near_name(number: usize) -> String {
    format!("near-{}", number + 1)
}

fn chunk(folder: &mut PageFolder, name: &str, content: &Chunk) -> Result<()> {
    folder.write(&format!("data/{name}.js"), &content.script(name))
}

/// Writes a page of tiles, which has these names, and lists it.
fn write_page(
    folder: &mut PageFolder,
    page: &TilePage,
    kind: TileKind,
    quality: u8,
    listed: &mut Vec<DescribedPage>,
) -> Result<()> {
    let name = format!("{}-{}", kind.name(), listed.len() + 1);
    chunk(folder, &name, &kind.chunk(page, quality))?;
    listed.push(DescribedPage { chunk: name, rows: page.rows() });
    Ok(())
}

/// Returns the mean of the cameras, rounded so that numbers are short.
fn middle(opened: &Opened, ids: &[PhotoId]) -> DVec3 {
    let sum: DVec3 = ids.iter().map(|id| opened.site.photo(*id).pose.center_in_world()).sum();
    (sum / ids.len() as f64).round()
}

/// Returns half of the diagonal of the box around the cameras.
fn extent(opened: &Opened, ids: &[PhotoId]) -> f64 {
    let centres = || ids.iter().map(|id| opened.site.photo(*id).pose.center_in_world());
    let low = centres().reduce(DVec3::min).unwrap_or_default();
    let high = centres().reduce(DVec3::max).unwrap_or_default();
    low.distance(high) / 2.0
}
