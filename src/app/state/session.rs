//! The project that is open: what was read, what is known of its photos, who draws it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;

use crate::app::action::decide::Due;
use crate::document::history::History;
use crate::document::{Project, Stack};
use crate::error::{Error, Result};
use crate::io::atomic::remove_old_leftovers;
use crate::io::lock::ProjectLock;
use crate::io::project::read_project;
use crate::io::recovery::{UnsavedChanges, read_unsaved};
use crate::io::stack_store::StackStore;
use crate::projection::navigation::{Ground, Viewpoint};
use crate::projection::surface::Surface;
use crate::recipe::open::{Opened, open_site};
use crate::recipe::site_stamp::SiteStamp;
use crate::recipe::survey::{StackState, Survey};
use crate::recipe::views::up;
use crate::scene::{Edges, Model};
use crate::task::Task;

/// A film that is being made gets a frame every few seconds: what has had none for so long was killed.
const FILM_RESTS: Duration = Duration::from_secs(60);

/// A project with its lock, which nobody else has until this is dropped.
pub struct Session {
    /// The project's folder.
    pub folder: PathBuf,
    /// What it says, and the site.
    pub opened: Arc<Opened>,
    /// In the site's order.
    pub photos: Vec<PhotoStatus>,
    /// What viewpoints move in.
    pub ground: Ground,
    /// What a ray meets; it knows backs of faces when the painter does.
    pub solid: Arc<Surface>,
    /// Outlines of faces.
    pub edges: Edges,
    /// Versions of stacks may lie about that views showed until others took their place.
    pub has_former: bool,
    /// The site's files as they were when it was read.
    pub seen: SiteStamp,
    /// Something of the site was missing when it was read.
    pub incomplete: bool,
    /// What was decided, and every step that led to it.
    pub history: History,
    /// What is left to do after edits.
    pub due: Due,
    /// Held by jobs that write what must not be left half done, too.
    pub lock: Arc<ProjectLock>,
}

/// The word for a photo whose layers are up to date.
pub const BUILT: &str = "built";

/// The word for a photo of whose stack something is damaged.
const BROKEN: &str = "broken";

/// What is known of one photo.
#[derive(Debug, Clone)]
pub struct PhotoStatus {
    /// `built`, `stale`, `not built` or `broken`.
    pub word: &'static str,
    /// The stack, where there is one.
    pub stack: Option<Arc<Stack>>,
    /// What is wrong with it.
    pub problem: Option<String>,
}

impl PhotoStatus {
    fn of(state: StackState) -> Self {
        // Whatever is up to date is simply built, for who looks at it.
        let word = if matches!(state, StackState::Current(_)) { BUILT } else { state.word() };
        match state {
            StackState::Current(stack) | StackState::Stale(stack) => {
                Self { word, stack: Some(Arc::new(stack)), problem: None }
            }
            StackState::Missing => Self { word, stack: None, problem: None },
            StackState::Broken(error) => Self { word, stack: None, problem: Some(error.to_string()) },
        }
    }

    /// The same; a stack that was known before is that one.
    fn with_known(mut self, known: Option<&Self>) -> Self {
        if let Some(known) = known.filter(|known| known.word != BROKEN && known.stack == self.stack) {
            self.stack = known.stack.clone();
        }
        self
    }

    /// Its stack shows what that of another state of it does: names of layers are drawn nowhere.
    pub fn is_drawn_like(&self, other: &Self) -> bool {
        if (self.word == BROKEN) != (other.word == BROKEN) {
            return false;
        }
        match (&self.stack, &other.stack) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other) || one.differs_in_names_only(other),
            (None, None) => true,
            _ => false,
        }
    }

    /// With what is damaged of its stack's files: the others are shown.
    fn with(self, damage: Option<Error>) -> Self {
        let Some(damage) = damage.filter(|_| self.problem.is_none()) else { return self };
        Self { word: BROKEN, problem: Some(damage.to_string()), ..self }
    }

    /// Built of the project as it is.
    pub fn is_current(&self) -> bool {
        self.word == BUILT
    }

    /// Texels that are needed and that the photo does not show, and those of them that are filled.
    pub fn hidden(&self) -> Option<(u64, u64)> {
        let layers = &self.stack.as_ref()?.image_layers;
        let hidden = layers.iter().map(|layer| layer.texels_used - layer.texels_visible).sum();
        let filled =
            layers.iter().filter_map(|layer| layer.fill.as_ref()).map(|fill| fill.texels_filled).sum();
        Some((hidden, filled))
    }
}

/// The states of all photos of a project. Stacks that are `known` are not held twice.
///
/// # Errors
/// [`crate::Error::Io`] when a photo cannot be read; [`crate::Error::Cancelled`].
pub fn survey(
    folder: &Path,
    opened: &Opened,
    known: &[PhotoStatus],
    task: &Task,
) -> Result<Vec<PhotoStatus>> {
    let store = StackStore::new(folder);
    let survey = Survey::new(opened, &store);
    let photos = &opened.site.photos;
    let status = |(done, photo)| {
        task.step("look at stacks", done, photos.len() as u64)?;
        let status = PhotoStatus::of(survey.state(photo)?).with_known(known.get(done as usize));
        Ok(status.with(store.damage(&photo.name)))
    };
    (0u64..).zip(photos).map(status).collect()
}

impl Session {
    /// Opens the project in `folder` for writing; beside it what was not saved when the program ended last.
    ///
    /// # Errors
    /// Those of [`crate::recipe::open::open`]; [`crate::Error::Request`] when another program writes to it.
    pub fn open(folder: &Path, task: &Task) -> Result<(Self, Option<UnsavedChanges>)> {
        let lock = ProjectLock::take(folder)?;
        let project = read_project(folder)?;
        let pictures = folder.join("pictures");
        if pictures.is_dir()
            && let Err(error) = remove_old_leftovers(&pictures, FILM_RESTS)
        {
            task.note(error.to_string());
        }
        // Before anything of it is read: what is changed meanwhile is noticed.
        let seen = SiteStamp::of(folder, &project);
        let opened = open_site(folder, project, task)?;
        let recovered = read_unsaved(folder, &opened.project).unwrap_or_else(|error| {
            task.note(format!("what was not saved last time cannot be read: {error}"));
            None
        });
        Ok((Self::with(lock, folder, opened, seen, task)?, recovered))
    }

    /// The same for a project that was read already.
    ///
    /// # Errors
    /// [`crate::Error::Request`] when another program writes to it; those of [`survey`].
    pub fn of(folder: &Path, opened: Opened, task: &Task) -> Result<Self> {
        let seen = SiteStamp::of(folder, &opened.project);
        Self::with(ProjectLock::take(folder)?, folder, opened, seen, task)
    }

    fn with(lock: ProjectLock, folder: &Path, opened: Opened, seen: SiteStamp, task: &Task) -> Result<Self> {
        let photos = survey(folder, &opened, &[], task)?;
        let history = History::new(opened.project.clone());
        let model = &opened.site.model;
        let lock = Arc::new(lock);
        Ok(Self {
            folder: folder.to_path_buf(),
            ground: Ground::of(&model.vertices, up(&opened.site.photos)),
            solid: Arc::new(Surface::of(model)),
            edges: Edges::of(model),
            has_former: false,
            seen,
            incomplete: !opened.problems.is_empty(),
            opened: Arc::new(opened),
            photos,
            history,
            due: Due::default(),
            lock,
        })
    }

    /// The site was read again.
    pub fn set_site(&mut self, opened: Opened, photos: Vec<PhotoStatus>) {
        self.ground = Ground::of(&opened.site.model.vertices, up(&opened.site.photos));
        self.solid = Arc::new(Surface::of(&opened.site.model));
        self.edges = Edges::of(&opened.site.model);
        // What was decided while it was read is decided.
        let present = Project::clone(self.history.present());
        self.incomplete = !opened.problems.is_empty();
        self.opened = Arc::new(opened.with_project(&self.folder, present));
        self.photos = photos;
    }

    /// For the title of the window: the folder's own name.
    pub fn name(&self) -> String {
        let folder = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        folder
            .file_name()
            .map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.opened.site.model
    }

    /// Where a photo was taken from.
    pub fn viewpoint_of(&self, photo: usize) -> Viewpoint {
        let photo = &self.opened.site.photos[photo];
        let middle = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height)) / 2.0;
        let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(middle);
        let eye = photo.pose.center_in_world();
        let near = self.solid.nearest(eye, ray).map_or(self.ground.center, |hit| eye + ray * hit.t);
        Viewpoint::of_camera(&photo.camera, &photo.pose, near)
    }
}
