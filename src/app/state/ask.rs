//! What a panel, a key, a command or a result wants: done by `action`, one enum a subject.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use super::life::Event;
use super::notes::Note;
use super::panes::Pane;
use super::running::JobId;
use super::selection::Selection;
use super::session::Session;
use super::settings::Colours;
use crate::app::action::layers::OptionsEdit;
use crate::app::check::Mend;
use crate::app::flight::Export;
use crate::app::masking::Tool;
use crate::app::masking::keeping::MaskWork;
use crate::app::opening::Wish;
use crate::app::trip::choosing::Wanted;
use crate::document::Project;
use crate::document::history::Gesture;
use crate::document::masks::MaskChange;
use crate::document::paint::PaintBook;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::recovery::UnsavedChanges;
use crate::layers::fill::FillOptions;
use crate::projection::Shown;
use crate::recipe::colour::ColourEdit;
use crate::recipe::decide::LayerEdit;
use crate::recipe::discover::Parts;
use crate::recipe::fill::lookouts::View;
use crate::recipe::layer_table::Column;
use crate::recipe::open::UnusableMask;
use crate::scene::FaceId;

/// One wish, by its subject.
pub enum Ask {
    /// What is selected.
    Select(SelectAsk),
    /// Steps of the history.
    Decide(DecideAsk),
    /// Stacks, the renderer and the jobs.
    Build(BuildAsk),
    /// The 3D view.
    Space(SpaceAsk),
    /// Kept views, the flight, pictures and films.
    Flight(FlightAsk),
    /// The flat views.
    Flat(FlatAsk),
    /// Masks.
    Mask(MaskAsk),
    /// Filling and colour.
    Quality(QualityAsk),
    /// The round trip to the image editor.
    Trip(TripAsk),
    /// The check of the project.
    Check(CheckAsk),
    /// Opening, making, saving and leaving projects.
    Project(ProjectAsk),
    /// The window itself.
    Window(WindowAsk),
}

/// About what is selected, and where it is shown.
pub enum SelectAsk {
    /// This alone is selected from now on.
    Only(Selection),
    /// Adds an image layer of a photo to the selection, or takes it out.
    Toggle(usize, usize),
    /// Selects image layers of a photo, the last one first of all.
    Layers(usize, Vec<usize>),
    /// Shows where a face is in a photo, and marks a place in it, in photo pixels.
    ShowInPhoto(usize, FaceId, Option<[u32; 2]>),
    /// Shows a rectangle of a photo, in its pixels.
    ShowRect(usize, PixelRect),
    /// Selects the photo so many places further in the list.
    StepPhoto(isize),
}

/// Steps of the history.
pub enum DecideAsk {
    /// A step: what is undone, the project after it, and the gesture that it belongs to.
    Edit(String, Box<Project>, Option<Gesture>),
    /// A gesture has ended.
    EndGesture,
    /// Takes the last step back.
    Undo,
    /// Makes a step again that was undone.
    Redo,
    /// Decides something about a photo's layers.
    Layers(Box<LayerEdit>),
    /// Merges the selected image layers.
    Merge,
    /// Splits the selected image layer.
    Split,
    /// The selected surfaces show the selected photo alone.
    Pin,
    /// The selected surfaces never show the selected photo.
    Exclude,
    /// Removes all decisions about the selected photo.
    Reset,
    /// Names an image layer of a photo.
    Rename(usize, usize, String),
    /// Takes one decision about a photo back, by its number.
    Forget(String, usize),
    /// Switches an object on or off, by its name.
    SwitchObject(String, bool),
    /// Switches all objects on.
    AllObjectsOn,
    /// Decides about options of layers.
    Options {
        /// Of all photos, or of one.
        edit: OptionsEdit,
        /// The gesture has not ended.
        goes_on: bool,
    },
}

/// Stacks, the renderer and the jobs.
pub enum BuildAsk {
    /// Builds the stacks of these photos, or of all where none is named.
    Build(Vec<String>),
    /// Fills hidden parts.
    Fill,
    /// Reads the site again, and then builds these photos.
    Reread(Option<Vec<String>>),
    /// Makes the renderer of the 3D view; the one that is there draws until it is made.
    PreparePainter,
    /// Drops the renderer at once, because the model is another one, and makes a new one.
    RestartPainter,
    /// The site was read again: the renderer, the pictures and the watch on its files begin anew.
    SiteRead,
    /// A renderer was made.
    PainterMade,
    /// The renderer of this project could not be made.
    PainterFailed(PathBuf, Error),
    /// Photos serve faces as it is decided by now.
    Redecide,
    /// Asks one job to stop.
    Stop(JobId),
    /// Asks all jobs to stop.
    StopAll,
}

/// The 3D view.
pub enum SpaceAsk {
    /// Flies into the camera of a photo.
    FlyToPhoto(usize),
    /// Flies to where a view looks from.
    LookFrom(Box<View>),
    /// Frames the selection in the view in use.
    Frame,
    /// Shows everything in the view in use.
    ShowAll,
    /// Flies into the selected photo, or back.
    Snap,
    /// Flies into the selected photo, never back.
    FlyInto,
    /// Levels the horizon.
    Level,
    /// What the picture shows.
    Display(Shown),
    /// Pulls the selected photo's layers apart, or puts them together.
    PullApart,
}

/// Kept views, the flight, pictures and films.
pub enum FlightAsk {
    /// Flies to a kept view.
    FlyToView(usize),
    /// Shows the flight at a time, in seconds.
    GoTo(f64),
    /// Keeps the view.
    KeepView,
    /// Adds a keyframe of the view.
    AddKeyframe,
    /// Removes the selected keyframe.
    RemoveKeyframe,
    /// Plays the flight, or pauses it.
    Play,
    /// Shows the dialog for a picture.
    ChooseStill,
    /// Shows the dialog for a film.
    ChooseFilm,
    /// Renders as it was chosen.
    Render(Export),
}

/// The flat views.
pub enum FlatAsk {
    /// Fits the picture into the view in use.
    Fit,
    /// Shows pixel for pixel.
    ShowPixels,
    /// Shows the picture larger by a factor.
    Zoom(f64),
    /// Takes so many more visibility layers off the photo.
    Peel(i32),
    /// Shows or hides the faces without texture.
    ListUntextured,
}

/// Masks.
pub enum MaskAsk {
    /// Changes masks: what is undone, and what is done.
    Mask(String, MaskWork),
    /// Masks what is suggested, by numbers.
    Accept(Vec<u32>),
    /// Forgets what is suggested, by numbers.
    Dismiss(Vec<u32>),
    /// Masks of objects have this margin from now on, in pixels.
    Margin(u32),
    /// Takes a tool up, or puts it away.
    TakeUp(Tool),
    /// Brush and lasso uncover, or mask.
    Uncover,
    /// Makes the brush larger by a factor.
    ResizeBrush(f64),
    /// Shows or hides masks.
    Show,
    /// Looks for transient objects in these photos, or in all where none is named.
    Look(Vec<String>),
    /// Masks the selected object in the selected photo.
    Object,
    /// Gives the stroke up that goes on.
    GiveUpStroke,
    /// The next change of masks that waits is written.
    WriteNext,
    /// Reports masks that cannot be used, and what follows.
    Report(Vec<UnusableMask>, &'static str),
    /// Reports what of the site could not be read.
    ReportProblems,
    /// Puts another mask in the place of one, or none.
    Set(MaskChange),
    /// Chooses a file for a mask that cannot be used.
    Choose(Box<UnusableMask>),
}

/// Filling and colour.
pub enum QualityAsk {
    /// Decides how hidden parts are filled.
    Fill(FillOptions),
    /// Decides about the photos' exposures.
    Colour {
        /// One after the other.
        edits: Vec<ColourEdit>,
        /// The gesture has not ended.
        goes_on: bool,
    },
    /// Looks what paint would be laid over which photos.
    LookAtPropagation,
    /// Lays paint over other photos.
    Propagate,
    /// Takes paint off other photos.
    TakePropagatedOff,
    /// The 3D view has other gains.
    ShowGains,
}

/// The round trip to the image editor.
pub enum TripAsk {
    /// Shows the dialog for imports.
    ChooseImports,
    /// Imports what was chosen in the dialog.
    Import,
    /// Imports these files.
    ImportFiles(Vec<PathBuf>),
    /// Shows the dialog for exports.
    ChooseExport,
    /// Exports as it was chosen in the dialog.
    Export,
    /// Opens the selected photo in the image editor.
    EditPhoto {
        /// A new export, instead of the file begun before.
        fresh: bool,
    },
    /// Takes the last import back.
    TakeBackLast,
    /// Shows a folder in the system's file manager.
    ShowFolder(PathBuf),
    /// A dialog of the system for a file or folder.
    ChoosePath(Wanted),
    /// Paint of these photos has changed on disk; the project's paint is this now.
    PaintChanged(BTreeSet<String>, Arc<PaintBook>),
    /// Makes the pictures before and after an import, by its number in the project's paint.
    LookAtImport(u32, Arc<PaintBook>),
    /// Watches the folder of documents from now on, where there is one.
    WatchForSaves,
}

/// The check of the project.
pub enum CheckAsk {
    /// Compares cameras, photos and model.
    Check,
    /// Moves the model to where it should stand, or back.
    Mend(Mend),
    /// Reads the picture of a photo with the model's edges.
    Overlay(PathBuf),
}

/// Opening, making, saving and leaving projects.
pub enum ProjectAsk {
    /// Opens a project; asks first where something is not saved.
    Open(PathBuf),
    /// Opens a project: all that had to be asked was asked.
    OpenNow(PathBuf),
    /// A project was opened, and what was not saved last time was found.
    Opened(Box<(Session, Option<UnsavedChanges>)>),
    /// A project was made, or why it was not.
    Created(Parts, Box<Result<Session>>),
    /// Saves the project.
    Save,
    /// Something happens to a project that may be left.
    Life(Event),
    /// What was not saved last time is restored, or discarded.
    Recover(bool),
    /// Removes a project from the list of recent ones.
    Forget(PathBuf),
    /// Shows which files are missing.
    ShowMissing,
    /// What a dialog around opening, making and leaving projects wants.
    Dialog(Wish),
}

/// The window itself.
pub enum WindowAsk {
    /// Switches a flag of the window.
    Flip(Flag),
    /// Shows or hides the palette.
    Palette,
    /// Sorts the table of layers by a column.
    SortLayers(Column),
    /// The colours of the window.
    Theme(Colours),
    /// Text and buttons larger or smaller by so many steps of a tenth.
    Resize(f32),
    /// Text and buttons as large as the system has them.
    UsualSize,
    /// Everything where it was at first.
    ResetLayout,
    /// Brings a view to the front.
    ShowPane(Pane),
    /// Says something.
    Say(Note),
}

/// What is on or off by one command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flag {
    /// The settings are shown.
    Settings,
    /// The panel of messages is shown.
    Notes,
    /// The left side is shown.
    Lists,
    /// The right side is shown.
    Side,
    /// What keys and mouse do is shown.
    Help,
    /// The options of layers are shown.
    LayerOptions,
    /// Layers are listed as a table.
    LayerTable,
    /// The result of the check is shown.
    Check,
    /// The dialog for the image editor is shown.
    ImageEditor,
    /// The panel of views and flight is shown.
    Flight,
    /// The legend is shown.
    Legend,
    /// Outlines of faces are drawn.
    Wireframe,
    /// Cameras are drawn.
    Cameras,
    /// Backs of faces are drawn.
    Backs,
    /// The photo lies over the view.
    PhotoOver,
    /// Outlines of elements are drawn over the photo.
    Outlines,
    /// What is hidden is hatched.
    Hatching,
    /// Rectangles of image layers are drawn.
    Rectangles,
    /// Fillings are shown.
    Filling,
    /// Paint is shown.
    Paint,
    /// The photo is shown in the exposure that it is blended with.
    Even,
    /// Suggestions are drawn.
    Suggestions,
}

macro_rules! subjects {
    ($($subject:ident($ask:ident)),*) => {
        $(impl From<$ask> for Ask {
            fn from(ask: $ask) -> Self {
                Self::$subject(ask)
            }
        })*
    };
}

subjects!(
    Select(SelectAsk),
    Decide(DecideAsk),
    Build(BuildAsk),
    Space(SpaceAsk),
    Flight(FlightAsk),
    Flat(FlatAsk),
    Mask(MaskAsk),
    Quality(QualityAsk),
    Trip(TripAsk),
    Check(CheckAsk),
    Project(ProjectAsk),
    Window(WindowAsk)
);
