//! A site with stacks, and what draws it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use quadratura::render::TextureOptions;
use quadratura::task::Task;
use quadratura::testing::document::{ColourDecisions, Decisions, Stack};
use quadratura::testing::geometry::Pinhole;
use quadratura::testing::gpu::{Gpu, GpuRasteriser, Renderer, TileStore};
use quadratura::testing::import::photo::read_photo;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::Options;
use quadratura::testing::projection::agreement::Agreement;
use quadratura::testing::projection::dome::{CubeMap, Dome};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::twin::ReferenceRenderer;
use quadratura::testing::projection::{Gains, Server, SiteContent, SiteRenderer, Sources, Texels};
use quadratura::testing::scene::PhotoId;
use quadratura::testing::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura::testing::scene::synthetic::Rng;
use quadratura::testing::scene::{FaceId, Object, PhotoPixels, Site};
use quadratura::testing::stacks::build::{BuildOptions, build};
use quadratura::testing::stacks::gains::photo_gains;
use quadratura::testing::stacks::layer_textures::LayerTextureFiles;
use quadratura::testing::stacks::sources::sources;
use quadratura::testing::view::Shot;
use quadratura::testing::view::agreement::{ContradictedPixel, PhotoAgreement};
use tempfile::TempDir;

use crate::common;

/// Some photos of a site, with their stacks.
pub struct Bench {
    /// Holds the stacks, and photos that were made for the test.
    _folder: TempDir,
    pub gpu: Gpu,
    pub site: Site,
    pub sources: Arc<Sources>,
    pub texels: Arc<dyn Texels>,
    files: LayerTextureFiles,
    pub gains: Gains,
    pub agreement: Agreement,
    /// Whether renderers draw skirts.
    pub skirts: bool,
}

impl Bench {
    /// The piazza, of its photos those whose names begin so. `None` without an adapter.
    pub fn piazza(photos: &[&str]) -> Option<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
        Self::some(common::site(&folder, "photos", "piazza.obj"), photos)
    }

    /// The piazza in which these objects are impostors.
    pub fn turning_piazza(photos: &[&str], turns: impl Fn(&Object) -> bool) -> Option<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
        let mut site = common::site(&folder, "photos", "piazza.obj");
        let (model, refused) = Arc::unwrap_or_clone(site.model).with_impostors(DVec3::Z, turns);
        assert!(refused.is_empty(), "{refused:?}");
        site.model = Arc::new(model);
        Self::some(site, photos)
    }

    /// The castle, in the same way; `None` where it is not beside the project, too.
    pub fn castle(photos: &[&str]) -> Option<Self> {
        let folder = common::castle()?;
        Self::some(common::site(&folder, "images", "castle.obj"), photos)
    }

    fn some(mut site: Site, photos: &[&str]) -> Option<Self> {
        site.photos.retain(|photo| photos.iter().any(|name| photo.name.starts_with(name)));
        assert!(site.photos.len() >= photos.len(), "{} photos", site.photos.len());
        Self::of(site, tempfile::tempdir().unwrap())
    }

    /// A site, all of it; `folder` takes the stacks.
    pub fn of(site: Site, folder: TempDir) -> Option<Self> {
        let gpu = common::gpu()?;
        let rasteriser = GpuRasteriser::new(&gpu).unwrap();
        let stacks = stacks(&site, folder.path(), &rasteriser);
        let store = StackStore::new(folder.path());
        let gains =
            photo_gains(&site, &stacks, &ColourDecisions::default(), folder.path(), 1 << 30, &Task::silent())
                .unwrap();
        let files = LayerTextureFiles::new(&store, &stacks, true);
        Some(Self {
            gpu,
            sources: sources(&site, &stacks, &Decisions::default()).into(),
            texels: Arc::new(files.clone()),
            files,
            _folder: folder,
            gains,
            agreement: Agreement::default(),
            skirts: false,
            site,
        })
    }

    /// Puts a dome around the site, with sides of this many pixels.
    pub fn put_dome(&mut self, side: u32) {
        let light = |direction: DVec3| {
            let d = direction.normalize();
            let waves = (9.0 * d.x).sin() * (7.0 * d.y).cos() * (8.0 * d.z).sin();
            ([0.5 + 0.4 * waves, 0.5 + 0.3 * d.z, 0.4 - 0.2 * d.x].map(|light| light as f32), 1.0)
        };
        let dome = Dome::from_light(&CubeMap::from_directions(side as usize, light));
        self.sources = Arc::new(Sources::clone(&self.sources).with_dome(side));
        self.texels = Arc::new(self.files.clone().with_dome(Some(Arc::new(dome))));
    }

    /// Pins about this share of the faces to one of the photos that serve them.
    pub fn pin(&mut self, share: f64, rng: &mut Rng) {
        let sources = Arc::make_mut(&mut self.sources);
        for range in sources.of_face.clone() {
            let servers = &mut sources.servers[range.start as usize..range.end as usize];
            // Without a share nothing is drawn: other scenes stay what they are.
            if share <= 0.0 || servers.is_empty() || !rng.chance(share) {
                continue;
            }
            let photo = servers[rng.whole(0, servers.len() as u32 - 1) as usize].photo;
            servers.iter_mut().for_each(|server| server.pinned = server.photo == photo);
        }
    }

    /// Lets photos contradict each other in this many discs of each photo: from nearly nothing in the middle of a disc
    /// to full agreement at its rim.
    pub fn contradict(&mut self, discs: u32, rng: &mut Rng) {
        let evidence = self.discs(discs, rng);
        self.agreement = Agreement::new(&evidence.iter().collect::<Vec<_>>(), &self.sources);
    }

    /// Lets photos show the sky, not their faces, in this many discs of each photo, likewise.
    pub fn end_within(&mut self, discs: u32, rng: &mut Rng) {
        let evidence = self.discs(discs, rng);
        let agreement = Agreement::new(&[], &self.sources);
        self.agreement = agreement.with_outlines(&evidence.iter().collect::<Vec<_>>(), &self.sources);
    }

    /// Returns values of each photo's pixels: from nearly nothing in the middle of each of these many discs on a face to 1 at its rim.
    fn discs(&self, discs: u32, rng: &mut Rng) -> Vec<PhotoAgreement> {
        let (mut evidence, sources) = (Vec::new(), &self.sources);
        for (photo, id) in sources.photos.iter().zip((0..).map(PhotoId)) {
            let serves = |face: &FaceId| sources.servers_of(*face).iter().any(|server| server.photo == id);
            let faces: Vec<FaceId> = self.site.model.face_ids().filter(serves).collect();
            let size = [photo.camera.width / 3, photo.camera.height / 3];
            let mut cells: BTreeMap<(u16, u16, FaceId), u8> = BTreeMap::new();
            for _ in 0..if faces.is_empty() { 0 } else { discs } {
                let face = faces[rng.whole(0, faces.len() as u32 - 1) as usize];
                let radius = rng.between(3.0, f64::from(size[1]) / 3.0);
                let middle = DVec2::new(rng.unit() * f64::from(size[0]), rng.unit() * f64::from(size[1]));
                for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                    let away = (DVec2::new(f64::from(x), f64::from(y)) - middle).length() / radius;
                    if away < 1.0 {
                        let agreement = (3.0 + 252.0 * away) as u8;
                        let cell = cells.entry((y as u16, x as u16, face)).or_insert(u8::MAX);
                        *cell = agreement.min(*cell);
                    }
                }
            }
            let pixel = |((y, x, face), agreement)| ContradictedPixel { at: [x, y], face, agreement };
            evidence.push(PhotoAgreement {
                size,
                contradicted: cells.into_iter().map(pixel).collect(),
                ..PhotoAgreement::default()
            });
        }
        evidence
    }

    /// Lets what the photos' surroundings show in this many discs of each photo stand on outlines, and draws skirts.
    pub fn stand(&mut self, discs: u32, rng: &mut Rng) {
        let sources = &self.sources;
        let of_photo = |camera: &Pinhole, rng: &mut Rng| {
            let size = [camera.width / 3, camera.height / 3];
            let mut cells: BTreeMap<[u16; 2], u8> = BTreeMap::new();
            for _ in 0..discs {
                let radius = rng.between(3.0, f64::from(size[1]) / 2.0);
                let middle = DVec2::new(rng.unit() * f64::from(size[0]), rng.unit() * f64::from(size[1]));
                for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                    let away = (DVec2::new(f64::from(x), f64::from(y)) - middle).length() / radius;
                    if away < 1.0 {
                        let cell = cells.entry([x as u16, y as u16]).or_insert(u8::MAX);
                        *cell = ((3.0 + 252.0 * away) as u8).min(*cell);
                    }
                }
            }
            let pixel = |(at, agreement)| ContradictedPixel { at, face: FaceId(0), agreement };
            PhotoAgreement {
                size,
                contradicted: cells.into_iter().map(pixel).collect(),
                ..PhotoAgreement::default()
            }
        };
        let evidence: Vec<PhotoAgreement> =
            sources.photos.iter().map(|photo| of_photo(&photo.camera, rng)).collect();
        self.agreement = Agreement::new(&[], sources).with_surroundings(&evidence, sources);
        self.skirts = true;
    }

    pub fn renderer(&self, relief: &Relief) -> Renderer {
        if self.skirts {
            let site = SiteContent {
                model: self.site.model.clone(),
                sources: self.sources.clone(),
                gains: self.gains.clone(),
                relief,
                agreement: self.agreement.clone(),
                texels: self.texels.clone(),
            };
            return Renderer::of_site(&self.gpu, site, TextureOptions::default()).unwrap();
        }
        let mut renderer =
            renderer_of(&self.gpu, &self.site, &self.sources, &self.gains, relief, &self.texels);
        renderer.set_agreement(self.agreement.clone()).unwrap();
        renderer
    }

    /// A renderer of flat faces with this texture memory.
    pub fn renderer_within(&self, textures: TextureOptions) -> Renderer {
        let tiles = TileStore::new(&self.gpu, &self.sources, self.texels.clone(), textures).unwrap();
        let (model, gains) = (self.site.model.clone(), self.gains.clone());
        Renderer::new(&self.gpu, model, self.sources.clone(), gains, &Relief::default(), tiles).unwrap()
    }

    pub fn twin(&self, relief: &Relief) -> ReferenceRenderer {
        let options = TextureOptions::default().pyramid;
        let (model, sources) = (self.site.model.clone(), self.sources.clone());
        let (gains, texels) = (self.gains.clone(), self.texels.clone());
        let twin = ReferenceRenderer::new(model, sources, gains, relief.clone(), texels, options)
            .with_agreement(self.agreement.clone());
        if self.skirts { twin.with_skirts() } else { twin }
    }

    /// The view of a photo's own camera.
    pub fn own(&self, photo: usize) -> Shot {
        Shot::new(self.site.photos[photo].camera, self.site.photos[photo].pose)
    }

    /// For each pixel of a photo the image layer that shows there what the pixel's face is, plus 1; 0 for
    /// none. `faces` as [`quadratura::testing::projection::Renders::faces`]; `at` is the place in the pixel that they
    /// were looked for at.
    pub fn layers(&self, photo: usize, faces: &[u32], at: DVec2) -> Vec<u32> {
        let width = self.site.photos[photo].camera.width;
        let layer = |(i, face): (u32, &u32)| {
            let px = DVec2::new(f64::from(i % width), f64::from(i / width)) + at;
            let face = FaceId(face.checked_sub(1)?);
            let serves = |s: &&Server| s.photo == PhotoId(photo as u32) && s.domain.holds(px);
            self.sources.servers_of(face).iter().find(serves).map(|server| server.layer_texture.0 + 1)
        };
        (0..).zip(faces).map(|pixel| layer(pixel).unwrap_or(0)).collect()
    }

    pub fn pixels(&self, photo: usize) -> PhotoPixels {
        let photo = &self.site.photos[photo];
        read_photo(&photo.file, photo.camera.width, photo.camera.height).unwrap()
    }
}

/// A renderer of any sources.
pub fn renderer_of(
    gpu: &Gpu,
    site: &Site,
    sources: &Arc<Sources>,
    gains: &Gains,
    relief: &Relief,
    texels: &Arc<dyn Texels>,
) -> Renderer {
    let tiles = TileStore::new(gpu, sources, texels.clone(), TextureOptions::default()).unwrap();
    Renderer::new(gpu, site.model.clone(), sources.clone(), gains.clone(), relief, tiles).unwrap()
}

fn stacks(site: &Site, folder: &Path, rasteriser: &GpuRasteriser) -> Vec<Option<Stack>> {
    let options = BuildOptions {
        layers: Options::default(),
        decisions: Default::default(),
        photos: Vec::new(),
        memory: 1 << 30,
        threads: 2,
        force: false,
    };
    let store = StackStore::new(folder);
    let built = build(site, &store, rasteriser, &options, &Task::silent()).unwrap();
    built.into_iter().map(|built| Some(built.stack.unwrap())).collect()
}

/// The largest difference of two pixels in R, G, B.
pub fn apart(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).take(3).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// The steps of 8 bits by which two pixels differ, laid over the grey of what is not textured: what is nearly transparent has
/// no colour to speak of.
pub fn apart_over_grey(a: &[u8], b: &[u8]) -> f64 {
    let over = |pixel: &[u8], c: usize| {
        let (alpha, grey) = (f64::from(pixel[3]) / 255.0, linear_of_srgb(128.0 / 255.0));
        let light = alpha * linear_of_srgb(f64::from(pixel[c]) / 255.0) + (1.0 - alpha) * grey;
        255.0 * srgb_from_linear(light)
    };
    let colour = (0..3).map(|c| (over(a, c) - over(b, c)).abs()).fold(0.0, f64::max);
    colour.max(f64::from(a[3].abs_diff(b[3])))
}
