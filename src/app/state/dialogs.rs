//! The dialogs and windows over the views that belong to no subject with a state of its own.

use super::orthophoto::OrthophotoDialog;
use super::palette::Palette;
use super::publish::PublishDialog;
use super::save_image::SaveImage;
use super::site_frame::SiteFrameDialog;

/// Which dialogs are shown, and what is typed in them.
#[derive(Default)]
pub struct Dialogs {
    /// The command palette.
    pub palette: Palette,
    /// Whether the help for keys and mouse is shown.
    pub help: bool,
    /// Whether the program's name and version are shown.
    pub about: bool,
    /// Whether the list of the history is shown.
    pub history: bool,
    /// The number of steps of the history that were asked for in its list, until they are done.
    pub history_target: Option<usize>,
    /// Whether the settings are shown.
    pub settings: bool,
    /// Whether the layer options are shown.
    pub layer_options: bool,
    /// The dialog that saves a layered depth image.
    pub save_image: Option<SaveImage>,
    /// The dialog that draws an orthophoto.
    pub orthophoto: Option<OrthophotoDialog>,
    /// The dialog that publishes the site as a web page.
    pub publish: Option<PublishDialog>,
    /// The dialog that sets the site's frame.
    pub site_frame: Option<SiteFrameDialog>,
}

impl Dialogs {
    /// Returns whether one of them is open to which keys belong; the others stay open beside the views.
    pub fn take_keys(&self) -> bool {
        let of_files = self.save_image.is_some() || self.orthophoto.is_some() || self.publish.is_some();
        self.palette.is_open() || self.settings || of_files || self.site_frame.is_some()
    }
}
