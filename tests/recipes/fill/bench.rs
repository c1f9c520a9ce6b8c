//! Sites whose surfaces have known colours everywhere, photographed by casting rays.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::document::stack::ImageLayer;
use quadratura::testing::document::{Project, Stack};
use quadratura::testing::io::layer_reader::read_grey;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::fill::FillOptions;
use quadratura::testing::layers::{Options, SoftwareRasteriser};
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::scene::synthetic::{Modeller, Scene, Truth, centred, look_at};
use quadratura::testing::scene::{Model, Photo, Site};
use quadratura::testing::sites::open::Opened;
use quadratura::testing::stacks::build::{BuildOptions, build};
use quadratura::testing::stacks::fill::{FillRequest, FilledPhoto, fill};

/// Photos of [`Bench::courtyard`].
pub const PHOTOS: usize = 3;

/// Windows with frames in a wall, the same everywhere: 0 to 1.
pub fn facade(point: DVec3) -> [f64; 3] {
    let (u, v) = (point.x.rem_euclid(1.6), (point.y + point.z).rem_euclid(2.0));
    if (0.5..1.1).contains(&u) && (0.6..1.4).contains(&v) {
        [0.2, 0.25, 0.35]
    } else if (0.35..1.25).contains(&u) && (0.45..1.55).contains(&v) {
        [0.6, 0.55, 0.5]
    } else {
        [0.8, 0.72, 0.55]
    }
}

/// A colour that has nothing to do with its neighbours'.
pub fn noise(point: DVec3) -> [f64; 3] {
    let part = |at: f64| (at.sin() * 43_758.545).rem_euclid(1.0);
    let at = point.dot(DVec3::new(12.9898, 78.233, 37.719));
    [part(at), part(at + 1.7), part(at + 3.1)]
}

/// What a ray meets.
type Paint = fn(DVec3) -> [f64; 3];

pub struct Bench {
    pub folder: tempfile::TempDir,
    site: Site,
    bits: u8,
    paint: Paint,
}

/// A hidden texel that was filled.
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    pub layer: usize,
    pub at: [i32; 2],
    pub rgb: [u16; 3],
    pub confidence: u16,
    pub place: u16,
}

impl Bench {
    /// A wall with windows on a ground, a cube before it, seen from three sides.
    pub fn courtyard() -> Self {
        Self::photographed(facade)
    }

    /// The same with other colours.
    pub fn photographed(paint: Paint) -> Self {
        Self::of(&scenes(&[-5.0, 0.5, 5.5]), 8, false, paint)
    }

    /// The same, with the first photo at a share of the others' resolution.
    pub fn with_first_at(share: f64, paint: Paint) -> Self {
        let mut scenes = scenes(&[-0.5, 0.5, 1.0]);
        let size = |side: f64| (side * share).round() as u32;
        scenes[0].camera = centred(size(320.0), size(240.0), 260.0 * share);
        Self::of(&scenes, 8, false, paint)
    }

    /// The same, seen from these places beside each other.
    pub fn from_places(places: &[f64]) -> Self {
        Self::of(&scenes(places), 8, false, facade)
    }

    /// Gives the pixels of a photo another colour where their rays meet the wall's plane at such points.
    pub fn repaint(&self, photo: usize, colour: [u8; 3], wanted: impl Fn(DVec3) -> bool) {
        let file = &self.site.photos[photo].file;
        let mut pixels = image::open(file).unwrap().to_rgb8();
        for [x, y] in self.pixels_where(photo, wanted) {
            pixels.put_pixel(x as u32, y as u32, image::Rgb(colour));
        }
        pixels.save(file).unwrap();
    }

    /// A backdrop in the place of the wall, seen from one side only, in large photos.
    pub fn before_a_backdrop(paint: Paint) -> Self {
        let mut scenes = scenes_with("trees.backdrop", &[0.5]);
        scenes[0].camera = centred(1000, 750, 812.0);
        Self::of(&scenes, 8, false, paint)
    }

    /// The same, seen from one side only.
    pub fn alone() -> Self {
        Self::of(&scenes(&[0.5]), 8, false, facade)
    }

    /// Two courtyards a hundred units apart, each seen in two photos, of which none shows anything of the other.
    pub fn two_courtyards() -> Self {
        let mut m = Modeller::new();
        for (name, x) in [("near", 0.0), ("far", 100.0)] {
            courtyard(
                &mut m,
                [&format!("{name} wall"), &format!("{name} ground"), &format!("{name} cube")],
                x,
            );
        }
        let model: Arc<Model> = m.finish();
        let scenes = [0.0, 5.5, 100.0, 105.5].map(|x| scene(&model, x, if x < 50.0 { 0.0 } else { 100.0 }));
        Self::of(&scenes, 8, false, facade)
    }

    /// Scenes of one model. With `alpha`, a corner of the photos is not valid.
    pub fn of(scenes: &[Scene], bits: u8, alpha: bool, paint: Paint) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let model = scenes[0].model.clone();
        let photo = |(i, scene): (usize, &Scene)| {
            let name = format!("{i}.png");
            let photo = Photo { name: name.clone(), file: folder.path().join(name), ..scene.photo() };
            save(&photo, &model, bits, alpha, paint);
            photo
        };
        let photos = scenes.iter().enumerate().map(photo).collect();
        Self { site: Site { photos, model }, folder, bits, paint }
    }

    /// Builds all stacks; returns the photos' names.
    pub fn build(&self, layers: Options) -> Vec<String> {
        let options = BuildOptions {
            layers,
            decisions: Default::default(),
            photos: Vec::new(),
            memory: 1 << 30,
            threads: 1,
            force: false,
        };
        let store = StackStore::new(self.folder.path());
        let built = build(&self.site, &store, &SoftwareRasteriser, &options, &Task::silent()).unwrap();
        built.into_iter().map(|built| built.stack.map(|stack| stack.photo.name).unwrap()).collect()
    }

    pub fn opened(&self) -> Opened {
        // Whatever the last build was asked for: stacks say so themselves.
        let project =
            Project { photos: ".".into(), cameras: ".".into(), model: ".".into(), ..Project::default() };
        Opened {
            project,
            site: self.site.clone(),
            whole: self.site.model.clone(),
            reprojection: None,
            points: Default::default(),
            problems: std::sync::Arc::default(),
        }
    }

    pub fn fill(&self, options: &FillOptions) -> Vec<FilledPhoto> {
        self.try_fill(options).unwrap()
    }

    pub fn try_fill(&self, options: &FillOptions) -> quadratura::Result<Vec<FilledPhoto>> {
        self.fill_photos(options, &[])
    }

    pub fn fill_photos(
        &self,
        options: &FillOptions,
        photos: &[String],
    ) -> quadratura::Result<Vec<FilledPhoto>> {
        let request = FillRequest {
            options: options.clone(),
            photos: photos.to_vec(),
            memory: 1 << 30,
            force: false,
            keep_former: false,
        };
        let opened = self.opened();
        let filled = fill(self.folder.path(), &opened.project, &opened.site, &request, &Task::silent())?;
        assert!(filled.iter().all(|filled| filled.stack.is_ok()), "{filled:?}");
        Ok(filled)
    }

    /// All filled texels of a stack.
    pub fn texels(&self, photo: usize, stack: &Stack) -> Vec<Filled> {
        let folder = StackStore::new(self.folder.path()).folder(&self.site.photos[photo].name);
        let mut texels = Vec::new();
        for (index, layer) in stack.image_layers.iter().enumerate() {
            let Some(fill) = &layer.fill else { continue };
            let (width, _, rgba) = decode(&folder.join(&fill.filled_file));
            let confidence = read_grey(&folder.join(&fill.confidence_file), layer.rect, layer.rect).unwrap();
            let places = read_grey(&folder.join(&fill.provenance_file), layer.rect, layer.rect).unwrap();
            let before = texels.len();
            for (i, texel) in rgba.chunks_exact(4).enumerate().filter(|(_, texel)| texel[3] > 0) {
                let at = [layer.rect.x + (i as u32 % width) as i32, layer.rect.y + (i as u32 / width) as i32];
                let rgb = [texel[0], texel[1], texel[2]];
                texels.push(Filled { layer: index, at, rgb, confidence: confidence[i], place: places[i] });
            }
            assert_eq!((texels.len() - before) as u64, fill.texels_filled);
        }
        texels
    }

    /// How far the colours of filled texels are from the truth, of 255: those that `chosen` wants, by where they
    /// come from and their image layer.
    pub fn differences(
        &self,
        photo: usize,
        stack: &Stack,
        chosen: impl Fn(u16, &ImageLayer) -> bool,
    ) -> Vec<f64> {
        let texels = self.texels(photo, stack);
        let chosen = texels.iter().filter(|texel| chosen(texel.place, &stack.image_layers[texel.layer]));
        let difference = |texel: &Filled| difference(texel.rgb, (self.paint)(self.on_wall(photo, texel.at)));
        chosen.map(difference).collect()
    }

    /// Where a pixel's ray meets the wall's plane.
    pub fn on_wall(&self, photo: usize, [x, y]: [i32; 2]) -> DVec3 {
        let shot = &self.site.photos[photo];
        let wall = self.site.model.face_ids().next().expect("the wall comes first");
        let (plane, eye) = (self.site.model.face(wall).plane, shot.pose.center_in_world());
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
        eye - ray * (plane.signed_distance(eye) / plane.normal.dot(ray))
    }

    /// The pixels of a photo whose rays meet the wall's plane at such a point.
    pub fn pixels_where(&self, photo: usize, wanted: impl Fn(DVec3) -> bool) -> Vec<[i32; 2]> {
        let camera = &self.site.photos[photo].camera;
        let all = (0..camera.height as i32).flat_map(|y| (0..camera.width as i32).map(move |x| [x, y]));
        all.filter(|at| wanted(self.on_wall(photo, *at))).collect()
    }

    /// Pixels where the stack, with its filling, does not give the photo back although it is valid there and some
    /// surface covers it.
    pub fn wrong_pixels(&self, photo: usize, stack: &Stack) -> usize {
        let shot = &self.site.photos[photo];
        let (width, _, photo) = decode(&shot.file);
        let folder = StackStore::new(self.folder.path()).folder(&shot.name);
        let mut picture = vec![[0u16; 4]; (width * shot.camera.height) as usize];
        for layer in stack.image_layers.iter().rev() {
            let filled = layer.fill.as_ref().map(|fill| &fill.filled_file);
            for file in filled.into_iter().chain([&layer.file]) {
                let (w, _, rgba) = decode(&folder.join(file));
                for (i, texel) in rgba.chunks_exact(4).enumerate().filter(|(_, texel)| texel[3] > 0) {
                    let x = layer.rect.x + (i as u32 % w) as i32;
                    let y = layer.rect.y + (i as u32 / w) as i32;
                    picture[(y as u32 * width + x as u32) as usize] = texel.try_into().unwrap();
                }
            }
        }
        let channels = photo.len() / picture.len();
        for [y, x0, x1] in &stack.leftovers {
            let row = (y * width) as usize;
            for at in row + *x0 as usize..row + *x1 as usize {
                picture[at][..3].copy_from_slice(&photo[at * channels..at * channels + 3]);
            }
        }
        let full = if self.bits == 16 { 65535 } else { 255 };
        let pixels = photo.chunks_exact(channels).zip(&picture);
        let valid = pixels.filter(|(photo, _)| channels == 3 || photo[3] == full);
        valid.filter(|(photo, found)| found[3] > 0 && found[..3] != photo[..3]).count()
    }

    /// The files of all stacks, by name.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        fn walk(folder: &Path, root: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    walk(&path, root, found);
                } else {
                    let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
                    found.insert(name, fs::read(&path).unwrap());
                }
            }
        }
        let (root, mut found) = (self.folder.path().join("stacks"), BTreeMap::new());
        walk(&root, &root, &mut found);
        // Where the project lies is in the hashes of photos' files, not in what was made of them.
        found.retain(|name, _| name.ends_with(".png"));
        found
    }
}

fn scenes(from: &[f64]) -> Vec<Scene> {
    scenes_with("wall", from)
}

/// The scenes, with another name for the wall.
fn scenes_with(wall: &str, from: &[f64]) -> Vec<Scene> {
    let mut m = Modeller::new();
    courtyard(&mut m, [wall, "ground", "cube"], 0.0);
    let model: Arc<Model> = m.finish();
    from.iter().map(|x| scene(&model, *x, 0.0)).collect()
}

/// Models a wall, a ground and a cube of these names, with their middle at `x`.
fn courtyard(m: &mut Modeller, [wall, ground, cube]: [&str; 3], x: f64) {
    let at = |y: f64, z: f64| DVec3::new(x - 9.0, y, z);
    m.object(wall).quad_facing(DVec3::NEG_Y, at(6.0, 0.0), DVec3::X * 18.0, DVec3::Z * 8.0);
    m.object(ground).quad(at(-9.0, 0.0), DVec3::X * 18.0, DVec3::Y * 15.0);
    m.object(cube).cuboid(DVec3::new(x + 0.5, 2.0, 1.2), DVec3::splat(1.2), glam::DMat3::IDENTITY);
}

/// The courtyard whose middle is at `middle`, seen from a place.
fn scene(model: &Arc<Model>, x: f64, middle: f64) -> Scene {
    Scene {
        name: "courtyard".into(),
        model: model.clone(),
        camera: centred(320, 240, 260.0),
        pose: look_at(DVec3::new(x, -7.0, 2.2), DVec3::new(middle + 0.5, 6.0, 2.6)),
        truth: Truth::Unknown,
    }
}

/// How far a colour of 8 bits is from a true one of 0 to 1, of 255.
pub fn difference(rgb: [u16; 3], truth: [f64; 3]) -> f64 {
    let off = |c: usize| (f64::from(rgb[c]) - 255.0 * truth[c]).abs();
    (off(0) + off(1) + off(2)) / 3.0
}

/// Photographs the model: the colour of what each pixel's middle meets.
fn save(photo: &Photo, model: &Model, bits: u8, alpha: bool, paint: Paint) {
    let surface = ModelSurface::from_model(model);
    let (width, height) = (photo.camera.width, photo.camera.height);
    let eye = photo.pose.center_in_world();
    let mut bytes = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(px);
        let colour = surface.nearest(eye, ray).map_or([0.1; 3], |hit| paint(eye + ray * hit.t));
        let valid = !alpha || x + y > width / 3;
        let samples = colour.into_iter().chain(alpha.then_some(if valid { 1.0 } else { 0.0 }));
        for sample in samples {
            match bits {
                8 => bytes.push((sample * 255.0).round() as u8),
                _ => bytes.extend(((sample * 65535.0).round() as u16).to_be_bytes()),
            }
        }
    }
    let mut encoder = png::Encoder::new(fs::File::create(&photo.file).unwrap(), width, height);
    encoder.set_color(if alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(if bits == 8 { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

/// A decoded PNG: width, height, samples.
pub fn decode(path: &Path) -> (u32, u32, Vec<u16>) {
    let mut decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let samples = match info.bit_depth {
        png::BitDepth::Sixteen => bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect(),
        _ => bytes.iter().map(|&b| b.into()).collect(),
    };
    (info.width, info.height, samples)
}
