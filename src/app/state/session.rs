//! The open project: its site, the state of its photos, its history.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::pending::PendingUpdates;
use quadratura_base::error::{Error, Result};
use quadratura_base::raster::robust::median;
use quadratura_base::scene::up;
use quadratura_base::scene::{Edges, Model, Object, Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::history::History;
use quadratura_document::{Project, Stack};
use quadratura_files::atomic::remove_old_leftovers;
use quadratura_files::lock::ProjectLock;
use quadratura_io::project::read_project;
use quadratura_io::recovery::{UnsavedChanges, read_unsaved};
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_projection::backdrops::without_backdrops;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::open::{Opened, OpeningProblems, open_site};
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_stacks::layer_table::LayerFigures;
use quadratura_stacks::survey::{StackState, Survey};
use quadratura_view::navigation::{SceneFrame, Viewpoint};

/// The longest time between frames of a video: a video without one for longer was killed.
const FILM_RESTS: Duration = Duration::from_secs(60);

/// An open project with its lock, which no other program holds until this is dropped.
pub struct Session {
    /// The project's folder.
    pub folder: PathBuf,
    /// The project file and the site, as they were read.
    pub opened: Arc<Opened>,
    /// The states of the photos, in the site's order.
    pub photos: Vec<PhotoStatus>,
    /// The scene frame of viewpoints.
    pub scene_frame: SceneFrame,
    /// The height of a camera's picture in space, in world units.
    pub camera_size: f64,
    /// The points of what *Show everything* shows: the model without backdrops and wide ground.
    pub home: Vec<DVec3>,
    /// The surface that rays intersect; back faces are known once the painter knows them.
    pub solid: Arc<ModelSurface>,
    /// The outlines of faces.
    pub edges: Edges,
    /// Whether superseded versions of stacks may be on disk, which views showed until they were replaced.
    pub has_former: bool,
    /// The stamps of the site's files when it was read.
    pub seen: SiteStamp,
    /// Whether parts of the site were missing when it was read.
    pub incomplete: bool,
    /// The photos that have layers and were left out when the site was read, with the reason.
    pub gone: Vec<(String, String)>,
    /// The decisions, with the steps that led to them.
    pub history: History,
    /// The pending updates after edits.
    pub pending: PendingUpdates,
    /// The project's lock, shared with jobs that must not be interrupted while they write.
    pub lock: Arc<ProjectLock>,
    /// The hold on the stacks: what jobs of the window replace stays on disk until nothing names it.
    _reader: StackReader,
}

/// The word for a photo whose layers are up to date.
pub const BUILT: &str = "built";

/// The word for a photo that has layers and whose file is gone since the project was opened.
pub const MISSING: &str = "photo missing";

/// The word for a photo whose stack is damaged.
const BROKEN: &str = "broken";

/// The state of one photo.
#[derive(Debug, Clone)]
pub struct PhotoStatus {
    /// The state: `built`, `stale`, `not built` or `broken`.
    pub word: &'static str,
    /// The stack, where there is one.
    pub stack: Option<Arc<Stack>>,
    /// The problem, where there is one.
    pub problem: Option<String>,
    /// The number of the look at the disk that found this; later looks have higher numbers.
    pub look: u64,
}

/// The number of the next look at a stack on disk.
static NEXT_LOOK: AtomicU64 = AtomicU64::new(1);

impl PhotoStatus {
    fn from_state(state: StackState, look: u64) -> Self {
        // The user sees a stack that is up to date as built.
        let word = if matches!(state, StackState::Current(_)) { BUILT } else { state.word() };
        match state {
            StackState::Current(stack) | StackState::Stale(stack) => {
                Self { word, stack: Some(Arc::new(stack)), problem: None, look }
            }
            StackState::Missing => Self { word, stack: None, problem: None, look },
            StackState::Broken(error) => Self { word, stack: None, problem: Some(error.to_string()), look },
        }
    }

    /// Tells a photo whose file is gone from one whose stack cannot be read: its layers are still shown.
    fn with_file(self, photo: &Photo, store: &StackStore) -> Self {
        if self.word != BROKEN || photo.file.is_file() {
            return self;
        }
        let Ok(Some(stack)) = store.current(&photo.name) else { return self };
        let problem = format!("the photo {} is missing", photo.file.display());
        Self { word: MISSING, stack: Some(Arc::new(stack)), problem: Some(problem), ..self }
    }

    /// Reuses the known stack where it is equal.
    fn with_known(mut self, known: Option<&Self>) -> Self {
        if let Some(known) = known.filter(|known| known.word != BROKEN && known.stack == self.stack) {
            self.stack = known.stack.clone();
        }
        self
    }

    /// Returns whether its stack looks the same as that of another state: names of layers are not drawn.
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

    /// Adds the damage of the stack's files; the others are shown.
    fn with(self, damage: Option<Error>) -> Self {
        let Some(damage) = damage.filter(|_| self.problem.is_none()) else { return self };
        Self { word: BROKEN, problem: Some(damage.to_string()), ..self }
    }

    /// Returns whether the photo has a stack that is up to date and undamaged.
    pub fn is_current(&self) -> bool {
        self.word == BUILT
    }

    /// Returns whether its layers have occluded areas and none of them is filled.
    pub fn lacks_filling(&self) -> bool {
        let Some(stack) = &self.stack else { return false };
        stack.layers_of_faces().any(|layer| layer.texels_used > layer.texels_visible)
            && stack.image_layers.iter().all(|layer| layer.fill.is_none())
    }

    /// Returns the sums over its image layers of faces, without the surroundings.
    pub fn figures(&self) -> Option<LayerFigures> {
        let layers = self.stack.as_ref()?.layers_of_faces();
        Some(LayerFigures::sum(layers.map(LayerFigures::from_layer)))
    }
}

/// Finds the states of all photos of a project. Stacks that are `known` are reused.
///
/// # Errors
/// [`quadratura_base::Error::Io`] when a photo cannot be read; [`quadratura_base::Error::Cancelled`].
pub fn survey(
    folder: &Path,
    project: &Project,
    site: &Site,
    known: &[PhotoStatus],
    task: &Task,
) -> Result<Vec<PhotoStatus>> {
    let store = StackStore::new(folder);
    let survey = Survey::new(project, site, &store);
    let (photos, done) = (&site.photos, AtomicU64::new(0));
    let status = |(at, photo): (usize, &Photo)| {
        task.step("check stacks", done.fetch_add(1, Ordering::Relaxed), photos.len() as u64)?;
        // A look that begins later finds what is there now, or something newer.
        let look = NEXT_LOOK.fetch_add(1, Ordering::Relaxed);
        let status = PhotoStatus::from_state(survey.state(photo)?, look).with_file(photo, &store);
        Ok(status.with_known(known.get(at)).with(store.damage(&photo.name)))
    };
    photos.par_iter().enumerate().map(status).collect()
}

/// Returns the stacks of photos with these states.
pub fn stacks_of(photos: &[PhotoStatus]) -> Vec<Option<Arc<Stack>>> {
    photos.iter().map(|photo| photo.stack.clone()).collect()
}

/// Returns the photos that have layers and are left out of the site, with the reason. (Cameras often name more photos than
/// are used.)
fn gone(folder: &Path, problems: &OpeningProblems) -> Vec<(String, String)> {
    let store = StackStore::new(folder);
    problems.left_out.iter().filter(|(photo, _)| store.stack_file(photo).is_file()).cloned().collect()
}

/// The height of a camera's picture in space, as a share of the site's radius, and at most as a share of the distance from the next camera.
const CAMERA_SHARES: [f64; 2] = [0.035, 0.5];

/// Returns the height of a camera's picture in space: where a site is much larger than the steps between its cameras, they do not hide
/// each other.
fn camera_size(site: &Site, radius: f64) -> f64 {
    let [of_radius, of_step] = CAMERA_SHARES;
    let positions: Vec<DVec3> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    let step = |from: &DVec3| {
        let others = positions.iter().map(|position| position.distance(*from));
        // Photos from one tripod have one place.
        others.filter(|distance| *distance > 1e-3 * radius).fold(f64::INFINITY, f64::min)
    };
    let mut steps: Vec<f64> = positions.par_iter().map(step).collect();
    median(&mut steps).map_or(f64::INFINITY, |step| of_step * step).min(of_radius * radius)
}

/// Returns the points of a site without backdrops and wide ground.
fn home(site: &Site) -> Vec<DVec3> {
    let model = &site.model;
    let points = |object: &Object| -> Vec<DVec3> {
        object.faces.iter().flat_map(|face| model.ring_points(*face)).collect()
    };
    let objects: Vec<Vec<DVec3>> = model.objects.iter().map(points).collect();
    without_backdrops(&objects, up(&site.photos))
}

impl Session {
    /// Returns the newer of the known state and the `seen` one of each photo: jobs that look at the disk at the same time
    /// may end in any order.
    pub fn newest(&self, seen: Vec<PhotoStatus>) -> Vec<PhotoStatus> {
        if seen.len() != self.photos.len() {
            return seen;
        }
        let newer = |(known, seen): (&PhotoStatus, PhotoStatus)| match seen.look < known.look {
            true => known.clone(),
            false => seen,
        };
        self.photos.iter().zip(seen).map(newer).collect()
    }

    /// Returns the names of photos whose files are gone since the site was read.
    pub fn missing_since(&self) -> impl Iterator<Item = &str> {
        let photos = self.opened.site.photos.iter().zip(&self.photos);
        photos.filter(|(_, status)| status.word == MISSING).map(|(photo, _)| photo.name.as_str())
    }

    /// Returns the stack of a photo, where the photo exists and has one.
    pub fn stack_of(&self, photo: PhotoId) -> Option<&Arc<Stack>> {
        self.photos.get(photo.index())?.stack.as_ref()
    }

    /// Opens the project in `folder` for writing; also returns unsaved changes found from an earlier run.
    ///
    /// # Errors
    /// The errors of [`quadratura_sites::open::open`]; [`quadratura_base::Error::Request`] when another program writes to it.
    pub fn open(folder: &Path, task: &Task) -> Result<(Self, Option<UnsavedChanges>)> {
        let lock = ProjectLock::take(folder)?;
        let project = read_project(folder)?;
        let pictures = folder.join("pictures");
        if pictures.is_dir()
            && let Err(error) = remove_old_leftovers(&pictures, FILM_RESTS)
        {
            task.note(error.to_string());
        }
        // The stamp is taken before reading, so that changes during reading are noticed.
        let seen = SiteStamp::new(folder, &project);
        let opened = open_site(folder, project, task)?;
        let recovered = read_unsaved(folder, &opened.project).unwrap_or_else(|error| {
            task.note(format!("the autosaved changes of the last session cannot be read: {error}"));
            None
        });
        Ok((Self::with(lock, folder, opened, seen, task)?, recovered))
    }

    /// Makes the session of a project that was read already.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] when another program writes to it; the errors of [`survey`].
    pub fn new(folder: &Path, opened: Opened, task: &Task) -> Result<Self> {
        let seen = SiteStamp::new(folder, &opened.project);
        Self::with(ProjectLock::take(folder)?, folder, opened, seen, task)
    }

    fn with(lock: ProjectLock, folder: &Path, opened: Opened, seen: SiteStamp, task: &Task) -> Result<Self> {
        let reader = StackReader::begin(folder);
        let photos = survey(folder, &opened.project, &opened.site, &[], task)?;
        let history = History::new(opened.project.clone());
        let model = &opened.site.model;
        let lock = Arc::new(lock);
        let scene_frame = SceneFrame::new(&model.vertices, up(&opened.site.photos));
        Ok(Self {
            folder: folder.to_path_buf(),
            camera_size: camera_size(&opened.site, scene_frame.radius),
            scene_frame,
            home: home(&opened.site),
            solid: Arc::new(ModelSurface::from_model(model)),
            edges: Edges::from_model(model),
            has_former: false,
            seen,
            incomplete: !opened.problems.errors.is_empty(),
            gone: gone(folder, &opened.problems),
            opened: Arc::new(opened),
            photos,
            history,
            pending: PendingUpdates::default(),
            lock,
            _reader: reader,
        })
    }

    /// Replaces the site after it was read again.
    pub fn set_site(&mut self, opened: Opened, photos: Vec<PhotoStatus>) {
        self.scene_frame = SceneFrame::new(&opened.site.model.vertices, up(&opened.site.photos));
        self.camera_size = camera_size(&opened.site, self.scene_frame.radius);
        self.home = home(&opened.site);
        self.solid = Arc::new(ModelSurface::from_model(&opened.site.model));
        self.edges = Edges::from_model(&opened.site.model);
        // Decisions made while the site was read are kept.
        let present = Project::clone(self.history.present());
        self.incomplete = !opened.problems.errors.is_empty();
        self.gone = gone(&self.folder, &opened.problems);
        self.opened = Arc::new(opened.with_project(&self.folder, present));
        self.photos = photos;
    }

    /// Returns the name for the title of the window: that of the project folder.
    pub fn name(&self) -> String {
        let folder = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        folder
            .file_name()
            .map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Returns the model.
    pub fn model(&self) -> &Model {
        &self.opened.site.model
    }

    /// Returns the viewpoint of a photo's camera.
    pub fn viewpoint_of(&self, photo: PhotoId) -> Viewpoint {
        let photo = self.opened.site.photo(photo);
        let middle = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height)) / 2.0;
        let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(middle);
        let eye = photo.pose.center_in_world();
        let near = self.solid.nearest(eye, ray).map_or(self.scene_frame.center, |hit| eye + ray * hit.t);
        Viewpoint::of_camera(&photo.camera, &photo.pose, near)
    }
}
