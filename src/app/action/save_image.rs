//! Actions that save a photo as a layered depth image, or as a page that shows it, with the functions of the command line.

use std::path::{Path, PathBuf};

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::grouped;
use crate::state::request::ImagesRequest;
use crate::state::running::JobKind;
use crate::state::save_image::{ImageFormat, ImageSource, SaveImage};
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_files::writable::check_beside;
use quadratura_gpu::start_device;
use quadratura_images::export::{MeshOptions, export_page};
use quadratura_images::{
    BuildCamera, BuildFrom, BuildRequest, Maker, SiteLdiOptions, StackLdiOptions, build_ldis,
};
use quadratura_ldi::file::Packing;
use quadratura_trees::PlantParts;
use quadratura_views::preview::PreviewOptions;

/// The guard band of pages of the site: enough for all viewpoints that they go to.
const PAGE_GUARD: f64 = 0.1;

/// Applies a request about layered depth images to save.
pub fn apply(state: &mut State, work: &mut Work, request: ImagesRequest) {
    match request {
        ImagesRequest::Choose(format) => state.choose_save_image(format),
        ImagesRequest::Save(dialog) => save(state, work, dialog),
    }
}

/// Starts the job that saves with the options of the dialog.
fn save(state: &mut State, work: &mut Work, dialog: SaveImage) {
    let Some(session) = state.session.as_ref().filter(|session| session.folder == dialog.project) else {
        return;
    };
    let (opened, lock) = (session.opened.clone(), session.lock.clone());
    let stacks = work.live.stacks.clone();
    let name = match dialog.format {
        ImageFormat::Ldi => "Saving a layered depth image",
        ImageFormat::Page => "Saving a page",
    };
    work.jobs.start(&mut state.running, JobKind::Export, name, move |task| {
        // Files of layers that are being updated are read when they are complete.
        let _locks = (lock, stacks.take());
        // Otherwise it would be known after minutes.
        check_beside(&dialog.out())?;
        let saved = match dialog.format {
            ImageFormat::Ldi => save_ldi(&dialog, &opened.project, &opened.site, task)?,
            ImageFormat::Page => save_page(&dialog, &opened.project, &opened.site, task)?,
        };
        Ok(arrival(move |state| state.image_saved(&saved)))
    });
}

/// What was saved.
pub struct SavedImage {
    /// What it is, at the beginning of a sentence.
    what: &'static str,
    path: PathBuf,
    bytes: u64,
    /// Files and folders of the name that were kept.
    spared: Vec<PathBuf>,
}

/// Returns what the image is made from.
fn from(dialog: &SaveImage) -> BuildFrom {
    match dialog.source {
        ImageSource::Stack => BuildFrom::Stack(StackLdiOptions::default()),
        ImageSource::Site => {
            let usual = SiteLdiOptions::default();
            let guard = if dialog.format == ImageFormat::Page { PAGE_GUARD } else { usual.guard };
            let options = SiteLdiOptions { guard, ..usual };
            // The window says which photos have no stack.
            let preview = PreviewOptions {
                without_stack_notes: true,
                tree_parts: PlantParts::Nothing,
                ..PreviewOptions::default()
            };
            BuildFrom::Site { options, preview, at: None }
        }
    }
}

fn save_ldi(dialog: &SaveImage, project: &Project, site: &Site, task: &Task) -> Result<SavedImage> {
    let from = from(dialog);
    let (photos, out) = (vec![dialog.photo], Some(dialog.out()));
    let request = BuildRequest { photos, from, out, packing: Packing::Deflate };
    let (mut built, failed) = build_ldis(&dialog.project, project, site, &request, &start_device, task)?;
    match (built.pop(), Error::of_all(failed)) {
        (Some(built), None) => Ok(SavedImage {
            what: "Layered depth image",
            path: built.file,
            bytes: built.bytes,
            spared: built.spared,
        }),
        (_, Some(error)) => Err(error),
        (None, None) => Err(Error::Cancelled),
    }
}

fn save_page(dialog: &SaveImage, project: &Project, site: &Site, task: &Task) -> Result<SavedImage> {
    let from = from(dialog);
    task.step("layered depth image", 0, 2)?;
    let mut maker = Maker::open(&dialog.project, project, site, &from, &start_device, task)?;
    let ldi = match &from {
        BuildFrom::Stack(stack) => maker.source.cached_or_made(dialog.photo, stack, task)?,
        other => maker.image_of(&BuildCamera::of_photo(site, dialog.photo), other, task)?,
    };
    task.step("page", 1, 2)?;
    let caption = Path::new(&dialog.name).file_stem().unwrap_or_default().to_string_lossy();
    let exported = export_page(&ldi, &dialog.out(), &caption, &MeshOptions::default(), task)?;
    task.step("page", 2, 2)?;
    if exported.seen.as_ref().is_some_and(|(_, safe)| safe.width() <= 0.0) {
        let found = "large holes open in the page as soon as the viewpoint moves aside; fill occluded areas, and save it \
                     again";
        task.note(found);
    }
    let bytes = exported.bytes();
    Ok(SavedImage { what: "Page", path: exported.path, bytes, spared: exported.spared })
}

impl State {
    /// Opens the dialog for the selected photo.
    pub fn choose_save_image(&mut self, format: ImageFormat) {
        let (Some(photo), Some(session)) = (self.selected_photo(), &self.session) else { return };
        let name = session.opened.site.photo(photo).name.clone();
        let stem = Path::new(&name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = match format {
            ImageFormat::Ldi => format!("ldi/{stem}.ldi"),
            ImageFormat::Page => format!("pages/{stem}"),
        };
        let is_unfilled = session.photos[photo.index()].lacks_filling();
        let project = session.folder.clone();
        // A page is leant into, where one photo alone has holes.
        let source = if format == ImageFormat::Page { ImageSource::Site } else { ImageSource::Stack };
        self.dialogs.save_image = Some(SaveImage { format, project, photo, name, source, path, is_unfilled });
    }

    /// Reports what was saved.
    pub fn image_saved(&mut self, saved: &SavedImage) {
        let SavedImage { what, path, bytes, spared } = saved;
        for kept in spared {
            let found = format!(
                "{} was not written by this program, or was changed since, and is kept; the new one is {}",
                kept.display(),
                path.display()
            );
            self.notify(Note::new(Weight::Warning, found));
        }
        let kilobytes = grouped(bytes.div_ceil(1000));
        let text = format!("{what} saved: {}, {kilobytes} kB", path.display());
        self.notify(Note::new(Weight::Info, text));
    }
}
