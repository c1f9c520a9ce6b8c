//! Sets the site's frame, as one step of the history.

use crate::state::State;
use crate::state::selection::Selection;
use crate::state::site_frame::SiteFrameDialog;
use quadratura_document::Project;
use quadratura_document::frame::FramePart;
use quadratura_views::frame::{FrameChange, changed};

impl State {
    /// Opens the dialog.
    pub fn choose_site_frame(&mut self) {
        self.dialogs.site_frame = self.site_frame_dialog();
    }

    /// Changes the frame as the dialog asks; the dialog goes on with what is known now, or says why it could not be done.
    pub fn set_site_frame(&mut self, dialog: &SiteFrameDialog) {
        match dialog.change() {
            Ok(change) => self.change_site_frame(&change, Some(dialog)),
            Err(problem) => self.dialogs.site_frame = Some(with_problem(dialog, problem)),
        }
    }

    /// Forgets a part of the frame.
    pub fn forget_site_frame(&mut self, part: FramePart) {
        self.change_site_frame(&FrameChange { remove: vec![part], ..FrameChange::default() }, None);
    }

    fn change_site_frame(&mut self, change: &FrameChange, dialog: Option<&SiteFrameDialog>) {
        let Some(session) = &self.session else { return };
        let mut project = Project::clone(session.history.present());
        let opened = session.opened.with_project(&session.folder, project.clone());
        match changed(&opened, change) {
            Ok(frame) => {
                project.frame = frame;
                self.edit("frame of the site", project, None);
                self.dialogs.site_frame = self.site_frame_dialog();
            }
            Err(error) => {
                let shown = dialog.cloned().or_else(|| self.site_frame_dialog());
                self.dialogs.site_frame = shown.map(|dialog| with_problem(&dialog, error.to_string()));
            }
        }
    }

    /// Returns the dialog on the frame as it is.
    fn site_frame_dialog(&self) -> Option<SiteFrameDialog> {
        let session = self.session.as_ref()?;
        let selected = match self.selection.main {
            Selection::Object(object) => Some(session.model().object(object).name.clone()),
            Selection::Face(face) => Some(session.model().face_name(face)),
            _ => None,
        };
        let point = |point: glam::DVec3| format!("{},{},{}", point.x, point.y, point.z);
        let measured = self.space.measure.both().map(|both| both.map(|on_face| point(on_face.position)));
        Some(SiteFrameDialog::new(&session.history.present().frame, selected, measured))
    }
}

fn with_problem(dialog: &SiteFrameDialog, problem: String) -> SiteFrameDialog {
    SiteFrameDialog { problem: Some(problem), ..dialog.clone() }
}
