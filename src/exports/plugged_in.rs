//! An entry in a table, or an implementation of a trait, is enough for everything that uses it: a format of cameras, a
//! layered format, a renderer.

#![cfg(test)]

mod cameras;
mod layered;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::export_record::ExportFormat;
use quadratura_document::{ColourDecisions, Project};
use quadratura_editing::export::{ExportOptions, export};
use quadratura_editing::import::pictures::changed_layers;
use quadratura_editing::import::{ImportOptions, import_once};
use quadratura_editing::watch::{WatchOptions, watch};
use quadratura_foliage::PlacedTrees;
use quadratura_import::cameras::accepted;
use quadratura_io::documents::documents;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_readers::are_read;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::format::{extensions, file_names};
use quadratura_layered_files::read_layered;
use quadratura_layers::device::{PlantedRenderer, SiteDevice};
use quadratura_layers::{Options, SoftwareRasteriser};
use quadratura_projection::agreement::Agreement;
use quadratura_projection::continuation::Continuation;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::Relief;
use quadratura_projection::{
    Gains, LayerTextureId, Renders, SiteContent, SiteRenderer, Sources, Texels, TextureOptions,
};
use quadratura_sites::create::{NewProject, create_project};
use quadratura_sites::discover::{SitePart, SiteParts, find_site, look_at, part_at};
use quadratura_sites::open::Opened;
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_sites::views::{Size, ViewRequest, ViewSource, views};
use quadratura_stacks::build::{BuildOptions, build};
use quadratura_stacks::surroundings::SiteSurroundings;
use quadratura_view::{DisplayMode, Picture, Shot};
use quadratura_views::preview::{self, Preview, PreviewOptions, open_reference};
use quadratura_views::score::{ScoreOptions, held_out, leave_one_out, score};

/// A folder with two photos, their dummy cameras and a model.
fn site() -> tempfile::TempDir {
    quadratura_import::cameras::plug_in(&cameras::Dummy);
    quadratura_layered_files::format::plug_in(layered::FORMAT);
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join("photos")).unwrap();
    for name in ["a.png", "b.png"] {
        image::RgbImage::new(8, 6).save(root.path().join("photos").join(name)).unwrap();
    }
    fs::write(root.path().join("cameras.dummy"), "dummy cameras\nphotos/a.png\nphotos/b.png\n").unwrap();
    fs::write(root.path().join("house.obj"), "o wall\nv -1 -1 5\nv 1 -1 5\nv 1 1 5\nv -1 1 5\nf 1 2 3 4\n")
        .unwrap();
    root
}

fn parts(root: &Path) -> SiteParts {
    let candidates = find_site(root, &Task::silent()).unwrap();
    let first = |part: SitePart| candidates.of(part)[0].clone();
    SiteParts {
        photos: first(SitePart::Photos),
        cameras: first(SitePart::Cameras),
        model: first(SitePart::Model),
    }
}

#[test]
fn the_assistant_finds_and_describes_it() {
    let root = site();
    let parts = parts(root.path());
    assert_eq!(parts.cameras, root.path());
    let look = look_at(&parts, None, &Task::silent()).unwrap();
    assert!(look.is_whole(), "{look:?}");
    let matched = look.matched.unwrap();
    assert_eq!((matched.exactly, matched.of), (2, 2));
    assert_eq!(part_at(&root.path().join("cameras.dummy")), Some(SitePart::Cameras));
    assert!(accepted().contains("a dummy") && SitePart::Cameras.accepted().contains("a dummy"));
}

#[test]
fn new_render_and_score_read_it() {
    let root = site();
    let file = root.path().join("cameras.dummy");
    let parts = SiteParts { cameras: file.clone(), ..parts(root.path()) };
    let project = root.path().join("project");
    let new = NewProject {
        photos: parts.photos.clone(),
        cameras: file.clone(),
        model: parts.model,
        ..NewProject::default()
    };
    let opened = create_project(&project, &new, &Task::silent()).unwrap();
    let names: Vec<&str> = opened.site.photos.iter().map(|photo| photo.name.as_str()).collect();
    assert_eq!(names, ["a.png", "b.png"]);

    let asked = ViewRequest { source: ViewSource::At(file.clone()), size: Size::Own, fps: None };
    let seen = views(&opened.site, &asked, &Task::silent()).unwrap();
    assert_eq!(seen.list.iter().map(|view| view.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);

    let cache: PathBuf = root.path().join("cache");
    let (questions, problems) = held_out(&file, &parts.photos, &cache, &Task::silent()).unwrap();
    assert_eq!((questions.len(), problems.len()), (2, 0));

    let before = SiteStamp::new(&project, &opened.project);
    fs::write(&file, "dummy cameras\nphotos/a.png\n").unwrap();
    assert_eq!(before.changes(&SiteStamp::new(&project, &opened.project)), ["the cameras"]);
}

/// The project of [`site`] with the stacks of its photos.
fn built(root: &Path) -> (PathBuf, Opened) {
    let project = root.join("project");
    let parts = parts(root);
    let new = NewProject {
        photos: parts.photos,
        cameras: parts.cameras,
        model: parts.model,
        ..NewProject::default()
    };
    let opened = create_project(&project, &new, &Task::silent()).unwrap();
    let options = BuildOptions {
        layers: Options::default(),
        decisions: opened.project.decisions.clone(),
        photos: Vec::new(),
        memory: 1 << 30,
        threads: 1,
        force: false,
    };
    let store = StackStore::new(&project);
    let built = build(&opened.site, &store, &SoftwareRasteriser, &options, &Task::silent()).unwrap();
    assert!(built.iter().all(|built| built.stack.is_ok()), "{built:?}");
    (project, opened)
}

/// Paints a pixel of an image layer of a dummy file red; where, in the layer.
fn paint(file: &Path) -> [u32; 2] {
    let document = read_layered(file).unwrap();
    let mut bytes = fs::read(file).unwrap();
    let pixels: u64 = document.layers.iter().map(|layer| 4 * layer.rect.area()).sum();
    let mut at = bytes.len() - pixels as usize;
    for layer in &document.layers {
        let raster = layer.pixels.read().unwrap();
        let all = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| [x, y]));
        let opaque = all.into_iter().find(|[x, y]| raster.rgba16(*x, *y)[3] == 65535);
        if let (true, Some([x, y])) = (layer.name.contains("wall"), opaque) {
            at += 4 * (y * raster.width() + x) as usize;
            bytes[at..at + 4].copy_from_slice(&[255, 0, 0, 255]);
            fs::write(file, bytes).unwrap();
            return [x, y];
        }
        at += 4 * layer.rect.area() as usize;
    }
    panic!("{:?}", document.layers)
}

#[test]
fn a_layered_format_of_the_table_is_exported_imported_and_watched() {
    let root = site();
    let (project, opened) = built(root.path());
    let out = root.path().join("layers");
    let options = ExportOptions { format: ExportFormat::Xcf, ..ExportOptions::default() };
    let photo = &opened.site.photos[0];
    let exported = export(&project, &[photo], &out, &options, &Task::silent()).unwrap();
    assert!(exported.failed.is_empty(), "{:?}", exported.failed);
    let file = exported.done[0].path.clone();
    assert_eq!(file, out.join("a.png.dummy"));
    assert_eq!(documents(&out).unwrap().into_keys().collect::<Vec<_>>(), std::slice::from_ref(&file));
    assert!(extensions().contains(&"dummy") && file_names().contains("dummy"));

    paint(&file);
    let mut message = Vec::new();
    let options = WatchOptions { once: true, ..WatchOptions::default() };
    watch(&project, &out, options, || Ok(()), &Task::silent(), |imported, _| message.push(imported)).unwrap();
    assert!(message.len() == 1 && message[0].failed.is_empty() && message[0].changed == 1, "{message:?}");
}

#[test]
fn after_a_save_the_book_of_paint_is_not_read_again() {
    let root = site();
    let (project, opened) = built(root.path());
    let out = root.path().join("layers");
    let options = ExportOptions { format: ExportFormat::Xcf, ..ExportOptions::default() };
    let exported = export(&project, &[&opened.site.photos[0]], &out, &options, &Task::silent()).unwrap();
    let file = exported.done[0].path.clone();
    let mut preview = plain_preview(&project, &opened, &Arc::default());
    paint(&file);
    let imported = import_once(&project, &[file], ImportOptions::default(), &Task::silent()).unwrap();
    assert_eq!(imported.changed, 1, "{imported:?}");
    // Reading it fails from now on: a save shows what the import brought along.
    fs::write(project.join("paint/paint.json"), "no book").unwrap();
    assert!(PaintStore::new(&project).read().is_err());
    let number = imported.number.unwrap();
    let looks = changed_layers(&project, &imported.book, number, 64, &Task::silent()).unwrap();
    assert_eq!((looks.len(), looks[0].pixels), (1, 1));
    assert_eq!(preview.reload_paint(&["a.png".into()], &imported.book, &Task::silent()).unwrap(), 1);
    assert_eq!(imported.book.imports.last().map(|import| import.number), Some(number));
}

/// A renderer as small as one can be: pictures of one shade.
struct Plain {
    surface: Arc<ModelSurface>,
    /// The requests that it has received.
    asked: Arc<Mutex<Vec<&'static str>>>,
}

impl Plain {
    fn note(&self, what: &'static str) {
        self.asked.lock().unwrap().push(what);
    }
}

impl Renders for Plain {
    fn picture(&mut self, shot: &Shot, _: &Task) -> Result<Picture> {
        self.note("picture");
        let (width, height) = (shot.camera.width, shot.camera.height);
        Ok(Picture { width, height, rgba: [9, 9, 9, 255].repeat((width * height) as usize) })
    }

    fn faces(&mut self, shot: &Shot, _: &Task) -> Result<Vec<u32>> {
        Ok(vec![1; (shot.camera.width * shot.camera.height) as usize])
    }
}

/// Makes such renderers, which note what is asked of them in one list.
struct PlainDevice(Arc<Mutex<Vec<&'static str>>>);

impl SiteDevice for PlainDevice {
    fn renderer(&self, site: SiteContent<'_>, _: TextureOptions) -> Result<Box<dyn PlantedRenderer>> {
        let surface = Arc::new(ModelSurface::from_model(&site.model));
        Ok(Box::new(Plain { surface, asked: self.0.clone() }))
    }
}

impl PlantedRenderer for Plain {
    fn set_trees(&mut self, _: Option<Arc<PlacedTrees>>) -> Result<()> {
        self.note("trees");
        Ok(())
    }
}

impl SiteRenderer for Plain {
    fn surface(&self) -> Arc<ModelSurface> {
        self.surface.clone()
    }

    fn set_sources(&mut self, _: Arc<Sources>) -> Result<()> {
        self.note("sources");
        Ok(())
    }

    fn set_gains(&mut self, _: Gains) -> Result<()> {
        self.note("gains");
        Ok(())
    }

    fn set_relief(&mut self, _: &Relief) -> Result<()> {
        Ok(())
    }

    fn set_continuation(&mut self, _: Continuation) -> Result<()> {
        self.note("continuation");
        Ok(())
    }

    fn set_agreement(&mut self, _: Agreement) -> Result<()> {
        Ok(())
    }

    fn renew(&mut self, _: Arc<dyn Texels>, changed: &[LayerTextureId], _: &Task) -> Result<usize> {
        self.note("texels");
        Ok(changed.len())
    }

    fn set_origins(&mut self, origins: Option<Arc<dyn Texels>>) -> Result<()> {
        self.note(if origins.is_some() { "origins" } else { "no origins" });
        Ok(())
    }

    fn has_origins(&self) -> bool {
        false
    }

    fn unreadable(&self) -> usize {
        2
    }

    fn statistics(&self) -> String {
        "none".into()
    }
}

fn plain_preview(project: &Path, opened: &Opened, asked: &Arc<Mutex<Vec<&'static str>>>) -> Preview {
    preview_with(project, opened, asked, false)
}

fn preview_with(
    project: &Path,
    opened: &Opened,
    asked: &Arc<Mutex<Vec<&'static str>>>,
    gains: bool,
) -> Preview {
    let options = PreviewOptions { gains, relief: false, agreement: false, ..PreviewOptions::default() };
    let preview = preview::open(
        project,
        &opened.project,
        &opened.site,
        &PlainDevice(asked.clone()),
        &options,
        &Task::silent(),
    )
    .unwrap();
    assert_eq!(std::mem::take(&mut *asked.lock().unwrap()), ["trees"]);
    preview
}

#[test]
fn surroundings_of_other_gains_are_those_with_which_the_project_would_be_opened() {
    let root = site();
    for (name, grey) in [("a.png", 60), ("b.png", 120)] {
        let photo = image::RgbImage::from_pixel(8, 6, image::Rgb([grey; 3]));
        photo.save(root.path().join("photos").join(name)).unwrap();
    }
    let (project, opened) = built(root.path());
    let store = StackStore::new(&project);
    let stacks: Vec<_> = opened.site.photos.iter().map(|photo| store.current(&photo.name).unwrap()).collect();
    let present = |opened: &Opened| {
        SiteSurroundings::present(&project, &opened.project, &opened.site, &stacks, &Task::silent()).unwrap()
    };
    let asked: Arc<Mutex<Vec<&'static str>>> = Arc::default();
    let mut preview = preview_with(&project, &opened, &asked, true);
    preview.set_surroundings(present(&opened), &Task::silent()).unwrap();
    assert!(asked.lock().unwrap().is_empty(), "they are what it shows");
    let colour =
        ColourDecisions { fixed: [("a.png".to_owned(), [1.0; 3])].into(), ..ColourDecisions::default() };
    let brighter = opened.with_project(&project, Project { colour, ..opened.project.clone() });
    // A drag brings them again and again.
    for _ in 0..2 {
        preview.set_surroundings(present(&brighter), &Task::silent()).unwrap();
        assert_eq!(*asked.lock().unwrap(), ["no origins", "texels", "gains"]);
    }
    asked.lock().unwrap().clear();
    let mut opened_again = preview_with(&project, &brighter, &asked, true);
    opened_again.set_surroundings(present(&brighter), &Task::silent()).unwrap();
    assert!(asked.lock().unwrap().is_empty());
}

#[test]
fn stacks_that_a_renderer_shows_stay_on_disk_until_it_is_dropped() {
    let root = site();
    let (project, opened) = built(root.path());
    let plain = PreviewOptions { gains: false, relief: false, ..PreviewOptions::default() };
    let preview = plain_preview(&project, &opened, &Arc::default());
    assert!(are_read(&project));
    drop(preview);
    assert!(!are_read(&project));
    let reference = open_reference(&project, &opened.project, &opened.site, &plain, &Task::silent()).unwrap();
    assert!(are_read(&project));
    drop(reference);
    assert!(!are_read(&project));
}

#[test]
fn a_preview_shows_a_site_with_any_renderer() {
    let root = site();
    let (project, opened) = built(root.path());
    let asked = Arc::default();
    let mut preview = plain_preview(&project, &opened, &asked);
    let photo = &opened.site.photos[0];
    let shot = Shot::new(photo.camera, photo.pose);
    let whole = preview.picture(&shot, &Task::silent()).unwrap();
    // It does not know slices: all comes at once.
    let mut sliced = preview.begin(&shot, &Task::silent()).unwrap();
    assert!(preview.advance(&mut sliced, &Task::silent()).unwrap());
    assert!(sliced.picture() == whole && whole.rgba.len() == 4 * 8 * 6);
    preview.picture(&Shot { display: DisplayMode::Provenance, ..shot.clone() }, &Task::silent()).unwrap();
    preview.redecide(&opened.site, &opened.project.decisions).unwrap();
    preview.set_gains(Gains::none(2)).unwrap();
    assert_eq!(*asked.lock().unwrap(), ["picture", "picture", "origins", "picture", "sources", "gains"]);
    assert!(
        preview.problems()[0].to_string().contains("2 image layers could not be read"),
        "{:?}",
        preview.problems()
    );
    assert_eq!(
        (preview.statistics().as_str(), preview.faces(&shot, &Task::silent()).unwrap().len()),
        ("none", 48)
    );
    let questions = leave_one_out(&opened.site);
    let score_options = ScoreOptions::default();
    let report =
        score(&opened.site.model, &questions, &mut preview, &score_options, &Task::silent()).unwrap();
    assert_eq!((report.views.len(), report.failed.len()), (2, 0), "{:?}", report.failed);
}
