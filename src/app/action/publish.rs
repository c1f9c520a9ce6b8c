//! Actions that publish the site as a web page, with the function of the command line.

use std::path::{Path, PathBuf};

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::publish::{OfferedPhoto, PublishDialog, TypedText};
use crate::state::request::PublishRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_document::{PlaceText, Project};
use quadratura_exports::page::{PageOptions, Published, publish};
use quadratura_gpu::start_device;
use quadratura_io::programs::open_with_system;
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::Opened;
use quadratura_views::frame::point_named;

/// The folder of previews in the project folder, and the longest side of photos there, in pixels.
const PREVIEW: &str = "cache/page";
const PREVIEW_SIDE: u32 = 1024;

/// Applies a request about the site as a web page.
pub fn apply(state: &mut State, work: &mut Work, request: PublishRequest) {
    match request {
        PublishRequest::Choose => state.choose_publishing(),
        PublishRequest::Keep(dialog) => drop(state.keep_page(&dialog)),
        PublishRequest::Publish(dialog) => {
            if state.keep_page(&dialog) {
                publish_page(state, work, &dialog);
            }
        }
        PublishRequest::Preview(dialog) => {
            if let Some(project) = state.project_with_page(&dialog) {
                preview_page(state, work, &dialog, project);
            }
        }
        PublishRequest::Open(folder) => open_page(state, &folder),
    }
}

/// Opens a page in the user's browser.
fn open_page(state: &mut State, folder: &Path) {
    let page = folder.join("index.html");
    if let Err(error) = open_with_system(&page) {
        let text = format!("{} could not be opened: {error}", page.display());
        state.notify(Note::new(Weight::Warning, text));
    }
}

/// Publishes the page of the project as it is now.
fn publish_page(state: &mut State, work: &mut Work, dialog: &PublishDialog) {
    let Some(session) = &state.session else { return };
    let project = Project::clone(session.history.present());
    let (out, options) = (session.folder.join(dialog.folder.trim()), dialog.options(default_memory()));
    let budget = options.budget;
    write_page(
        state,
        work,
        (dialog, project),
        (out, options),
        "Publishing a web page",
        move |state, done| {
            state.page_published(&done, budget);
        },
    );
}

/// Shows the page as it would be, with small photos.
fn preview_page(state: &mut State, work: &mut Work, dialog: &PublishDialog, project: Project) {
    let Some(session) = &state.session else { return };
    let out = session.folder.join(PREVIEW);
    let longest = dialog.longest.min(PREVIEW_SIDE);
    let options = PageOptions { longest, ..dialog.options(default_memory()) };
    write_page(
        state,
        work,
        (dialog, project),
        (out, options),
        "Making a preview of the web page",
        |state, done| {
            state.page_previewed(done.folder);
        },
    );
}

/// Writes a page of a project in the background, and hands it to `arrived`.
fn write_page(
    state: &mut State,
    work: &mut Work,
    (dialog, project): (&PublishDialog, Project),
    (out, options): (PathBuf, PageOptions),
    title: &str,
    arrived: impl FnOnce(&mut State, Published) + Send + 'static,
) {
    let Some(session) = &state.session else { return };
    let (folder, lock) = (session.folder.clone(), session.lock.clone());
    let opened = session.opened.with_project(&folder, project);
    let chosen: Vec<_> = dialog.chosen().map(|photo| photo.id).collect();
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, title, move |task| {
        // Files of layers that are being updated are read when they are complete.
        let _locks = (lock, stacks.take());
        let photos: Vec<&Photo> = chosen.iter().map(|id| opened.site.photo(*id)).collect();
        let device = start_device()?;
        let published = publish(&folder, &opened, &photos, &out, &options, &*device, task)?;
        Ok(arrival(move |state| arrived(state, published)))
    });
}

impl State {
    /// Opens the dialog, on what the project keeps.
    pub fn choose_publishing(&mut self) {
        let Some(session) = &self.session else { return };
        let site = &session.opened.site;
        let offered = |id| {
            let photo = site.photo(id);
            let size = [photo.camera.width, photo.camera.height];
            OfferedPhoto { id, name: photo.name.clone(), size }
        };
        let photos = site.photo_ids().filter(|id| session.stack_of(*id).is_some()).map(offered).collect();
        let place = |point: glam::DVec3| format!("{:.4},{:.4},{:.4}", point.x, point.y, point.z);
        let measured = self.space.measure.points.last().map(|point| place(point.position));
        let present = session.history.present();
        self.dialogs.publish = Some(PublishDialog::new(session.folder.clone(), present, photos, measured));
    }

    /// Keeps in the project what the page says, as one step that can be undone; returns false, and says why in the dialog, where that is
    /// not possible.
    pub fn keep_page(&mut self, dialog: &PublishDialog) -> bool {
        let Some(project) = self.project_with_page(dialog) else { return false };
        let is_new = self.session.as_ref().is_some_and(|session| project != **session.history.present());
        if is_new {
            self.edit("what the web page says", project, None);
        }
        true
    }

    /// Returns the project with what the page says; without one, the dialog says why.
    fn project_with_page(&mut self, dialog: &PublishDialog) -> Option<Project> {
        let session = self.session.as_ref().filter(|session| session.folder == dialog.project)?;
        let mut project = Project::clone(session.history.present());
        let opened = session.opened.with_project(&session.folder, project.clone());
        let texts = placed_texts(dialog, &opened);
        self.say_of_page(texts.as_ref().err().map(ToString::to_string));
        (project.texts, project.page) = (texts.ok()?, dialog.page());
        Some(project)
    }

    fn say_of_page(&mut self, problem: Option<String>) {
        if let Some(dialog) = &mut self.dialogs.publish {
            dialog.problem = problem;
        }
    }

    /// Takes in a preview that was written.
    pub fn page_previewed(&mut self, folder: PathBuf) {
        let text = format!(
            "The preview is ready, with photos of {PREVIEW_SIDE} pixels at most. Nothing is published yet."
        );
        self.notify(Note::new(Weight::Info, text.clone()));
        if let Some(dialog) = &mut self.dialogs.publish {
            (dialog.report, dialog.done) = (vec![text], Some(folder));
        }
    }

    /// Takes in a page that was written.
    pub fn page_published(&mut self, published: &Published, budget: u64) {
        let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
        let spared = published.spared.iter();
        let spared = spared
            .map(|folder| format!("{} was changed, or holds other files, and is kept", folder.display()));
        let text = format!(
            "Published {} photos in {}: {}, of which {} are needed for the first picture",
            published.photos.len(),
            published.folder.display(),
            megabytes(published.bytes),
            megabytes(published.first)
        );
        let large = (published.bytes > budget).then(|| {
            format!("That is more than {}: smaller or fewer photos make it less", megabytes(budget))
        });
        let left_out = published.left_out.iter().map(|what| format!("Not on the page: {what}"));
        let report = std::iter::once(text.clone()).chain(large).chain(spared).chain(left_out).collect();
        self.notify(Note::new(Weight::Info, text));
        let folder: PathBuf = published.folder.clone();
        if let Some(dialog) = &mut self.dialogs.publish {
            (dialog.report, dialog.done) = (report, Some(folder));
        }
    }
}

/// Returns the texts of the dialog at their places.
fn placed_texts(dialog: &PublishDialog, opened: &Opened) -> Result<Vec<PlaceText>> {
    (1..).zip(&dialog.texts).map(|(number, typed)| placed(number, typed, opened)).collect()
}

fn placed(number: usize, typed: &TypedText, opened: &Opened) -> Result<PlaceText> {
    let (title, place) = (typed.title.trim(), typed.at.trim());
    let fault = |why: String| Error::Request(format!("Text {number}: {why}"));
    if title.is_empty() {
        return Err(fault("it has no title, by which visitors choose it".into()));
    }
    if place.is_empty() {
        return Err(fault(format!(
            "{title:?} has no place; click it with the measuring tool before this dialog is opened, or type a pixel of a photo, such as \
             {}:100,200",
            first_photo(opened)
        )));
    }
    let at = point_named(opened, place).map_err(|error| fault(error.to_string()))?;
    let text = typed.placed(at.to_array());
    text.problem().map_or(Ok(text), |problem| Err(fault(problem)))
}

/// Returns the name of a photo, for examples.
fn first_photo(opened: &Opened) -> &str {
    opened.site.photos.first().map_or("PHOTO", |photo| &photo.name)
}
