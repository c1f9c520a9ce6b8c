//! The question about a file in which nearly everything has changed at once, with a picture before and after.

use std::sync::{Arc, Weak};

use eframe::egui::{Context, Frame, RichText, TextureHandle, TextureOptions, Ui};

use super::fill::question::side_by_side;
use super::paint::PaintView;
use crate::panel::pictures::image;
use crate::state::request::{Request, RoundTripRequest};
use crate::state::round_trip::report::ImportQuestion;
use crate::state::round_trip::shown_path;
use crate::widget::spinner::Spinner;
use quadratura_view::Picture;

/// The pictures of the question on the device.
#[derive(Default)]
pub struct ImportQuestionTextures {
    /// The pictures that the textures show.
    of: Weak<[Picture; 2]>,
    /// Before and after.
    textures: Option<[TextureHandle; 2]>,
}

impl ImportQuestionTextures {
    /// Uploads new pictures, and drops those of the question before.
    fn follow(&mut self, pictures: Option<&Arc<[Picture; 2]>>, context: &Context) {
        let Some(pictures) = pictures else { return *self = Self::default() };
        if self.of.ptr_eq(&Arc::downgrade(pictures)) {
            return;
        }
        let load = |name: &str, picture| context.load_texture(name, image(picture), TextureOptions::LINEAR);
        let [before, after] = pictures.as_ref();
        self.textures = Some([load("file as exported", before), load("file as saved", after)]);
        self.of = Arc::downgrade(pictures);
    }
}

/// Draws the first question about a file, if there is one.
pub fn import_question_ui(
    ui: &mut Ui,
    view: &PaintView<'_>,
    textures: &mut ImportQuestionTextures,
    requests: &mut Vec<Request>,
) {
    let Some(question) = view.round_trip.questions.first() else { return textures.follow(None, ui.ctx()) };
    textures.follow(question.pictures.as_ref(), ui.ctx());
    let ImportQuestion { file, found, .. } = question;
    let folder = view.session.map(|session| session.folder.clone()).unwrap_or_default();
    let name = shown_path(&folder, file);
    Frame::group(ui.style()).show(ui, |ui| {
        ui.label(RichText::new("Import everything?").heading());
        ui.strong(&name);
        let mut sentence = found.clone();
        sentence[..1].make_ascii_uppercase();
        ui.label(format!("{sentence}."));
        match &textures.textures {
            Some(textures) => side_by_side(ui, textures, ["As exported", "As saved"], &name),
            None => drop(ui.add(Spinner::new())),
        }
        ui.horizontal_wrapped(|ui| {
            let all = "All of it becomes paint. Undo import takes it back.";
            if ui.button("Import everything").on_hover_text(all).clicked() {
                requests.push(RoundTripRequest::ImportAll(file.clone()).into());
            }
            let leave = "Nothing is imported. Undo the change in the image editor and save again.";
            if ui.button("Leave it").on_hover_text(leave).clicked() {
                requests.push(RoundTripRequest::LeaveFile(file.clone()).into());
            }
        });
    });
    ui.separator();
}
