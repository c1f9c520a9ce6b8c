//! Requests about orthophotos, and about the frame that they are in.

use crate::state::orthophoto::OrthophotoDialog;
use crate::state::site_frame::SiteFrameDialog;
use quadratura_document::frame::FramePart;

/// Requests about orthophotos, and about the site's frame.
pub enum OrthoRequest {
    /// Shows the dialog for what is selected.
    Choose,
    /// Draws a preview with the options of the dialog.
    Preview(Box<OrthophotoDialog>),
    /// Draws the orthophoto with the options of the dialog.
    Draw(Box<OrthophotoDialog>),
    /// Shows the dialog for the site's frame.
    ChooseFrame,
    /// Changes the frame as the dialog asks.
    SetFrame(Box<SiteFrameDialog>),
    /// Forgets a part of the frame.
    ForgetFrame(FramePart),
}
