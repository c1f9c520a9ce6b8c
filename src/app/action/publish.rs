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
use quadratura_exports::page::{Published, publish};
use quadratura_gpu::start_device;
use quadratura_io::programs::open_with_system;
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::Opened;
use quadratura_views::frame::point_named;

/// Applies a request about the site as a web page.
pub fn apply(state: &mut State, work: &mut Work, request: PublishRequest) {
    match request {
        PublishRequest::Choose => state.choose_publishing(),
        PublishRequest::Keep(dialog) => drop(state.keep_page(&dialog)),
        PublishRequest::Publish(dialog) => {
            if state.keep_page(&dialog) {
                start(state, work, &dialog);
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

/// Writes the page of the project as it is now.
fn start(state: &mut State, work: &mut Work, dialog: &PublishDialog) {
    let Some(session) = &state.session else { return };
    let (folder, lock) = (session.folder.clone(), session.lock.clone());
    let opened = session.opened.with_project(&folder, Project::clone(session.history.present()));
    let (out, options) = (folder.join(dialog.folder.trim()), dialog.options(default_memory()));
    let chosen: Vec<_> = dialog.chosen().map(|photo| photo.id).collect();
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, "Publishing a web page", move |task| {
        // Files of layers that are being updated are read when they are complete.
        let _locks = (lock, stacks.take());
        let photos: Vec<&Photo> = chosen.iter().map(|id| opened.site.photo(*id)).collect();
        let device = start_device()?;
        let published = publish(&folder, &opened, &photos, &out, &options, &*device, task)?;
        Ok(arrival(move |state| state.page_published(&published, options.budget)))
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
        let Some(session) = self.session.as_ref().filter(|session| session.folder == dialog.project) else {
            return false;
        };
        let mut project = Project::clone(session.history.present());
        let opened = session.opened.with_project(&session.folder, project.clone());
        match placed_texts(dialog, &opened) {
            Ok(texts) => {
                (project.texts, project.page) = (texts, dialog.page());
                if project != **session.history.present() {
                    self.edit("what the web page says", project, None);
                }
                self.say_of_page(None);
                true
            }
            Err(error) => {
                self.say_of_page(Some(error.to_string()));
                false
            }
        }
    }

    fn say_of_page(&mut self, problem: Option<String>) {
        if let Some(dialog) = &mut self.dialogs.publish {
            dialog.problem = problem;
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
