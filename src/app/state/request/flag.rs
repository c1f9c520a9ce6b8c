//! Settings that one command toggles.

/// A setting that one command toggles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flag {
    /// Whether the settings are shown.
    Settings,
    /// Whether stacks that are out of date are built and filled in the background.
    KeepUpToDate,
    /// Whether the panel of messages is shown.
    Notes,
    /// Whether the left side is shown.
    Lists,
    /// Whether the right side is shown.
    Side,
    /// Whether the help for keys and mouse is shown.
    Help,
    /// Whether the program's name and version are shown.
    About,
    /// Whether the list of the history is shown.
    History,
    /// Whether the layer options are shown.
    LayerOptions,
    /// Whether layers are listed as a table.
    LayerTable,
    /// Whether the result of the check is shown.
    Check,
    /// Whether the dialog for the image editor is shown.
    ImageEditor,
    /// Whether the panel of bookmarks and flight is shown.
    Flight,
    /// Whether the legend is shown.
    Legend,
    /// Whether outlines of faces are drawn.
    Wireframe,
    /// Whether cameras are drawn.
    Cameras,
    /// Whether back faces are drawn.
    Backs,
    /// Whether the photos' surroundings are drawn where no surface is.
    Surroundings,
    /// Whether photos count less where others contradict them.
    Agreement,
    /// Whether views show what the other photos show where they contradict a photo, also through its own camera.
    WithoutTransients,
    /// Whether the view is drawn from layered depth images.
    Images,
    /// Whether the photo is drawn over the view.
    PhotoOver,
    /// Whether outlines of elements are drawn over the photo.
    Outlines,
    /// Whether hidden areas are hatched.
    Hatching,
    /// Whether rectangles of image layers are drawn.
    Rectangles,
    /// Whether the filling of occluded areas is shown.
    Filling,
    /// Whether paint is shown.
    Paint,
    /// Whether the photo is shown with matched exposure.
    Even,
    /// Whether suggestions are drawn.
    Suggestions,
}
