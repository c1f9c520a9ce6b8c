//! Requests of panels, keys, commands and results, which `action` applies; one enum for each subject.

mod flag;
mod images;
mod model;
mod options;
mod ortho;
mod publish;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

pub use self::flag::Flag;
pub use self::images::ImagesRequest;
pub use self::model::ModelRequest;
pub use self::options::OptionsEdit;
pub use self::ortho::OrthoRequest;
pub use self::publish::PublishRequest;
pub use super::quality::request::QualityRequest;
pub use super::trees::request::TreeRequest;

use super::checks::Mend;
use super::flight::export::Export;
use super::guide::Document;
use super::life::LifeEvent;
use super::masking::keeping::MaskWork;
use super::masking::tool::MaskTool;
use super::notes::Note;
use super::opening::DialogRequest;
use super::panels::Tab;
use super::panes::Pane;
use super::round_trip::{Projected, dialogs::DialogPurpose, image_editor::EditorChoice};
use super::running::JobId;
use super::selection::Selection;
use super::session::Session;
use super::settings::{Colours, Navigation};
use super::space::FrameFacts;
use super::space::visibility::Uncovered;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_document::Project;
use quadratura_document::bookmark::BookmarkIndex;
use quadratura_document::camera_path::KeyframeIndex;
use quadratura_document::history::Gesture;
use quadratura_document::masks::MaskChange;
use quadratura_document::paint::PaintBook;
use quadratura_document::stroke::Stroke;
use quadratura_io::recovery::UnsavedChanges;
use quadratura_layers::LayerIndex;
use quadratura_sites::discover::SiteParts;
use quadratura_sites::open::UnusableMask;
use quadratura_stacks::decide::LayerEdit;
use quadratura_stacks::fill::viewpoints::RankedViewpoint;
use quadratura_stacks::layer_table::LayerColumn;
use quadratura_view::DisplayMode;

/// A request for a change, by subject.
pub enum Request {
    /// The selection.
    Select(SelectRequest),
    /// Decisions and the history.
    Decide(DecideRequest),
    /// Stacks, the renderer and the jobs.
    Build(JobRequest),
    /// The 3D view.
    Space(SpaceRequest),
    /// Bookmarks, the flight, pictures and videos.
    Flight(FlightRequest),
    /// The flat views.
    Flat(FlatRequest),
    /// Masks.
    Mask(MaskRequest),
    /// Filling and exposures.
    Quality(QualityRequest),
    /// The round trip to the image editor.
    RoundTrip(RoundTripRequest),
    /// The check of the project.
    Check(CheckRequest),
    /// What is suggested to complete the model.
    Model(ModelRequest),
    /// Opening, creating, saving and leaving projects.
    Project(ProjectRequest),
    /// Trees.
    Trees(TreeRequest),
    /// Layered depth images to save.
    Images(ImagesRequest),
    /// Orthophotos.
    Ortho(OrthoRequest),
    /// The site as a web page.
    Publish(PublishRequest),
    /// The window itself.
    Window(WindowRequest),
}

/// Requests about the selection, and about where it is shown.
pub enum SelectRequest {
    /// Selects this alone.
    Only(Selection),
    /// Adds an image layer of a photo to the selection, or removes it.
    Toggle(PhotoId, LayerIndex),
    /// Selects image layers of a photo; the last one is the main selection.
    Layers(PhotoId, Vec<LayerIndex>),
    /// Frames a face in a photo, and marks a position in it, in photo pixels.
    ShowInPhoto(PhotoId, FaceId, Option<[u32; 2]>),
    /// Frames a rectangle of a photo, in its pixels.
    ShowRect(PhotoId, PixelRect),
    /// Selects the photo this many positions further in the list.
    StepPhoto(isize),
}

/// Requests about decisions and the history.
pub enum DecideRequest {
    /// Adds a step: its name for undo, the project after it, and its gesture.
    Edit(String, Box<Project>, Option<Gesture>),
    /// Ends a gesture.
    EndGesture,
    /// Undoes the last step.
    Undo,
    /// Redoes the step that was undone last.
    Redo,
    /// Undoes or redoes steps until this many are done.
    GoToStep(usize),
    /// Applies a decision about a photo's layers.
    Layers(Box<LayerEdit>),
    /// Merges the selected image layers.
    Merge,
    /// Confirms the merge that waits for it (`true`), or gives it up.
    ConfirmMerge(bool),
    /// Splits the selected image layer.
    Split,
    /// Pins the selection to the selected photo.
    Pin,
    /// Excludes the selected photo from the selection.
    Exclude,
    /// Removes all decisions about the selected photo.
    Reset,
    /// Renames an image layer of a photo.
    Rename(PhotoId, LayerIndex, String),
    /// Removes one decision about a photo, by its number.
    Forget(String, usize),
    /// Asks whether to remove an object from the model, by name.
    AskToRemove(String),
    /// Removes the object that was asked about (`true`), or keeps it.
    ConfirmRemoval(bool),
    /// Removes an object from the model or restores it, by name.
    SwitchObject(String, bool),
    /// Makes an object turn towards cameras, or stay as it is modelled, by name.
    TurnObject(String, bool),
    /// Declares an object see-through in places, or solid, by name.
    SeeThroughObject(String, bool),
    /// Removes what was decided about an object.
    FreeObject(String),
    /// Restores all removed objects.
    AllObjectsOn,
    /// Edits layer options.
    Options {
        /// The edit, of the project's options or of one photo's.
        edit: OptionsEdit,
        /// Whether the gesture continues.
        goes_on: bool,
    },
}

/// Requests about stacks, the renderer and the jobs.
pub enum JobRequest {
    /// Builds the stacks of these photos, or of all where the list is empty.
    Build(Vec<String>),
    /// Fills occluded areas.
    Fill,
    /// Reads the site again, and then builds these photos.
    Reread(Option<Vec<String>>),
    /// Makes the renderer of the 3D view; the current one keeps drawing until it is made.
    PreparePainter,
    /// Drops the renderer at once, because the model has changed, and makes a new one.
    RestartPainter,
    /// Restarts the renderer, the pictures and the watch on files, because the site was read again.
    SiteRead {
        /// Whether photos and model are the same ones as before.
        is_same: bool,
    },
    /// Installs a renderer that was made.
    PainterMade,
    /// Reports that the renderer of this project could not be made.
    PainterFailed(PathBuf, Error),
    /// Applies the current decisions to the renderer.
    Redecide,
    /// Stops a job.
    Stop(JobId),
    /// Stops all jobs.
    StopAll,
}

/// Requests about the 3D view.
pub enum SpaceRequest {
    /// Flies into the camera of a photo.
    FlyToPhoto(PhotoId),
    /// Flies to the viewpoint of a view.
    LookFrom(Box<RankedViewpoint>),
    /// Frames the selection in the view in use.
    Frame,
    /// Frames everything in the view in use.
    ShowAll,
    /// Flies into the selected photo, or back.
    Snap,
    /// Flies into the selected photo, never back.
    FlyInto,
    /// Levels the horizon.
    Level,
    /// Sets the display mode.
    Display(DisplayMode),
    /// Switches the exploded view of the selected photo's layers on or off.
    PullApart,
    /// Pulls the selected photo's layers apart in place of another one's.
    FollowSelection,
    /// Requests the picture that is due, of a view that was drawn.
    Draw(FrameFacts),
    /// Makes the pictures of the layers that are pulled apart.
    WantLayerPictures,
    /// Shows an object or hides it, by name; the model stays as it is.
    ShowObject(String, bool),
    /// Shows only one object, by name, or all again where it is the only one.
    Isolate(String),
    /// Shows all objects.
    ShowAllObjects,
    /// Sets how surfaces that no photo covers are shown.
    ShowUncovered(Uncovered),
    /// Takes up the brush, or puts it away.
    Brush,
    /// Takes up the measuring tool, or puts it away.
    Measure,
    /// Sets the site's scale by the length that was typed for the measured distance.
    SetScale,
    /// Resizes the brush by a factor.
    ResizeBrush(f64),
}

/// Requests about bookmarks, the flight, pictures and videos.
pub enum FlightRequest {
    /// Flies to a bookmark.
    FlyToView(BookmarkIndex),
    /// Shows the flight at a time, in seconds.
    GoTo(f64),
    /// Pauses the flight.
    Pause,
    /// Selects a keyframe.
    SelectKeyframe(KeyframeIndex),
    /// Adds a bookmark of the view.
    KeepView,
    /// Adds a keyframe of the view.
    AddKeyframe,
    /// Removes the selected keyframe.
    RemoveKeyframe,
    /// Plays the flight, or pauses it.
    Play,
    /// Shows the dialog for a picture.
    ChooseStill,
    /// Shows the dialog for a video.
    ChooseFilm,
    /// Renders with the options of the dialog.
    Render(Export),
}

/// Requests about the flat views.
pub enum FlatRequest {
    /// Fits the picture into the view in use.
    Fit,
    /// Shows one screen pixel for each pixel.
    ShowPixels,
    /// Zooms by a factor.
    Zoom(f64),
    /// Hides this many more visibility layers of the photo.
    Peel(i32),
    /// Shows or hides the faces without texture.
    ListUntextured,
    /// Opens or closes the eye of an image layer.
    ShowLayer(PhotoId, LayerIndex, bool),
    /// Shows only one image layer in the photo, or all again where it is the only one.
    Solo(PhotoId, LayerIndex),
    /// Sets the opacity of an image layer, 0 to 255.
    Opacity(PhotoId, LayerIndex, u8),
    /// Shows all image layers of a photo, opaque.
    ShowAllLayers(PhotoId),
    /// Loads a photo and its layers, and takes layers off, as far as that is not done.
    WantPhoto(PhotoId),
    /// Loads the image layer that is shown, unless it is loaded.
    WantImageLayer,
    /// Makes the large picture of a photo, unless it is made.
    WantLargePicture(PhotoId),
}

/// Requests about masks.
pub enum MaskRequest {
    /// Changes masks, as a step with this name for undo.
    Mask(String, MaskWork),
    /// Accepts suggestions, by number.
    Accept(Vec<u32>),
    /// Dismisses suggestions, by number.
    Dismiss(Vec<u32>),
    /// Sets the margin of masked objects, in pixels.
    Margin(u32),
    /// Paints a stroke of the matte brush.
    Matte(Box<Stroke>),
    /// Selects a tool, or deselects it.
    TakeUp(MaskTool),
    /// Deselects the tool.
    PutAway,
    /// Switches brush and lasso between erasing and masking.
    Uncover,
    /// Resizes the brush by a factor.
    ResizeBrush(f64),
    /// Shows or hides masks.
    Show,
    /// Reads the masks of a photo, unless they are read.
    WantMasks(PhotoId),
    /// Reads the suggestions of earlier runs, once.
    WantSuggestions,
    /// Offers suggestions that are hardly objects, or leaves them out.
    OfferUnlikely(bool),
    /// Marks the suggestion under the pointer, by number.
    PointAt(Option<u32>),
    /// Marks the outcome of the last search as seen.
    ForgetOutcome,
    /// Finds transient objects in these photos, or in all where the list is empty.
    Look(Vec<String>),
    /// Masks the selected object in the selected photo.
    Object,
    /// Cancels the current stroke.
    GiveUpStroke,
    /// Writes the next change of masks in the queue.
    WriteNext,
    /// Reports masks that cannot be used, and the consequence.
    Report(Vec<UnusableMask>, &'static str),
    /// Reports the parts of the site that could not be read.
    ReportProblems,
    /// Replaces a mask by another one, or removes it.
    Set(MaskChange),
    /// Chooses a file for a mask that cannot be used.
    Choose(Box<UnusableMask>),
}

/// Requests about the round trip to the image editor.
pub enum RoundTripRequest {
    /// Shows the dialog for imports.
    ChooseImports,
    /// Imports the files chosen in the dialog.
    Import,
    /// Imports these files.
    ImportFiles(Vec<PathBuf>),
    /// Imports a file in which nearly everything has changed at once.
    ImportAll(PathBuf),
    /// Does not import a file about which there is a question, until it is saved again.
    LeaveFile(PathBuf),
    /// Makes the pictures for the question about a file.
    LookAtQuestion(PathBuf),
    /// Shows the dialog for exports.
    ChooseExport,
    /// Exports with the options of the dialog.
    Export,
    /// Opens the selected photo in the image editor.
    EditPhoto {
        /// Whether a new export is made, in place of the existing file.
        fresh: bool,
    },
    /// Sets the image editor that opens photos.
    UseEditor(EditorChoice),
    /// Looks up which image editors are installed.
    LookForEditors,
    /// Undoes the last import.
    TakeBackLast,
    /// Shows a folder in the system's file manager.
    ShowFolder(PathBuf),
    /// Opens a system dialog for a file or folder.
    ChoosePath(DialogPurpose),
    /// Shows the paint of these photos, which has changed on disk to that of the book.
    PaintChanged(BTreeSet<String>, Arc<PaintBook>),
    /// Shows paint on other photos that their files do not contain yet.
    ShowProjected(Box<Projected>),
    /// Shows the present files of fillings.
    ShowFillings,
    /// Makes the pictures before and after an import, by its number in the project's paint.
    LookAtImport(u32, Arc<PaintBook>),
    /// Starts watching the folder of documents, where there is one.
    WatchForSaves,
}

/// Requests about the check of the project.
pub enum CheckRequest {
    /// Compares cameras, photos and model.
    Check,
    /// Fixes the placement of the model, or undoes that.
    Mend(Mend),
    /// Shows the overlay of a photo, by its index in the report.
    ShowPhoto(PhotoId),
    /// Loads the overlay of a photo, with the model's edges.
    Overlay(PathBuf),
}

/// Requests about opening, creating, saving and leaving projects.
pub enum ProjectRequest {
    /// Opens a project; asks first about unsaved changes.
    Open(PathBuf),
    /// Opens a project after all questions were answered.
    OpenNow(PathBuf),
    /// Handles a project that was opened, with unsaved changes found from an earlier run.
    Opened(Box<(Session, Option<UnsavedChanges>)>),
    /// Handles the result of creating a project.
    Created(SiteParts, Box<Result<Session>>),
    /// Saves the project.
    Save,
    /// Handles an event of the life cycle.
    Life(LifeEvent),
    /// Restores (`true`) or discards the unsaved changes of the last run.
    Recover(bool),
    /// Removes a project from the list of recent ones.
    Forget(PathBuf),
    /// Shows which files are missing.
    ShowMissing,
    /// Handles a request of a dialog for projects.
    Dialog(DialogRequest),
}

/// Requests about the window itself.
pub enum WindowRequest {
    /// Toggles a flag of the window.
    Flip(Flag),
    /// Clears a flag of the window.
    Hide(Flag),
    /// Shows or hides the palette.
    Palette,
    /// Sorts the table of layers by a column.
    SortLayers(LayerColumn),
    /// Sets the colours of the window.
    Theme(Colours),
    /// Scales text and buttons by this many steps of a tenth.
    Resize(f32),
    /// Sets the scale of text and buttons.
    Scale(f32),
    /// Resets text and buttons to the system's size.
    UsualSize,
    /// Sets what the mouse does in the 3D view.
    Navigate(Navigation),
    /// Shows or hides the hints for first steps.
    ShowHints(bool),
    /// Lets layered depth images stand in for the model while the 3D view moves, or not.
    ImagesWhileMoving(bool),
    /// Resets the layout.
    ResetLayout,
    /// Shows a tab of the right side.
    ShowTab(Tab),
    /// Brings a view to the front.
    ShowPane(Pane),
    /// Shows a note.
    Say(Note),
    /// Removes all notes.
    ClearNotes,
    /// Marks all notes as seen.
    SeeNotes,
    /// Opens a document with the system's program.
    Read(Document),
    /// Copies facts for a report of a fault to the clipboard.
    CopyDiagnostics,
}

macro_rules! subjects {
    ($($subject:ident($request:ident)),*) => {
        $(impl From<$request> for Request {
            fn from(request: $request) -> Self {
                Self::$subject(request)
            }
        })*
    };
}

subjects!(
    Select(SelectRequest),
    Decide(DecideRequest),
    Build(JobRequest),
    Space(SpaceRequest),
    Flight(FlightRequest),
    Flat(FlatRequest),
    Mask(MaskRequest),
    Quality(QualityRequest),
    RoundTrip(RoundTripRequest),
    Check(CheckRequest),
    Model(ModelRequest),
    Project(ProjectRequest),
    Trees(TreeRequest),
    Images(ImagesRequest),
    Ortho(OrthoRequest),
    Publish(PublishRequest),
    Window(WindowRequest)
);
