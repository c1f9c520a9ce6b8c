//! Decisions about layers, applied to the selection.

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::request::OptionsEdit;
use crate::state::selection::Selection;
use crate::state::session::PhotoStatus;
use quadratura_base::error::Error;
use quadratura_base::scene::PhotoId;
use quadratura_document::Project;
use quadratura_document::history::Gesture;
use quadratura_layers::{Faces, LayerIndex};
use quadratura_stacks::decide::{self, LayerEdit, faces_of_layer};

/// The gesture of sliders and numbers in the options: each drag ends its own.
const OPTIONS: Gesture = Gesture(0x0b_71_05);

/// Returns the reason why the options of the project, or of one photo, are invalid.
pub fn problem_of_options(project: &Project) -> Option<String> {
    project.options.problem().or_else(|| project.decisions.problem(&project.options))
}

impl State {
    /// Adds an image layer to the selection, or removes it.
    pub fn toggle_layer(&mut self, photo: PhotoId, layer: LayerIndex) {
        let (selected, mut layers) = self.selection.layers();
        if selected != photo || layers.is_empty() {
            self.select(Selection::Layer { photo, layer });
            return;
        }
        match layers.iter().position(|other| *other == layer) {
            Some(layer_index) if layers.len() > 1 => {
                layers.remove(layer_index);
            }
            Some(_) => (),
            None => layers.push(layer),
        }
        layers.extend(layers.is_empty().then_some(layer));
        self.select_layers(photo, layers);
    }

    /// Selects image layers of a photo; views and inspector show the last of them.
    pub fn select_layers(&mut self, photo: PhotoId, mut layers: Vec<LayerIndex>) {
        let Some(layer) = layers.pop() else { return };
        self.select(Selection::Layer { photo, layer });
        self.selection.more_layers = layers.into_iter().map(|layer| (photo, layer)).collect();
    }

    /// Keeps image layers selected after their stacks were rebuilt; layers are matched by token.
    pub fn keep_selection(&mut self, before: &[PhotoStatus]) {
        let Some(session) = &self.session else { return };
        let token = |statuses: &[PhotoStatus], photo: PhotoId, layer: LayerIndex| {
            let stack = statuses.get(photo.index())?.stack.as_ref()?;
            Some(stack.image_layers.get(layer.index())?.id.clone())
        };
        let found = |photo: PhotoId, layer: LayerIndex| {
            let id = token(before, photo, layer)?;
            let stack = session.stack_of(photo)?;
            stack.layer_with_token(&id)
        };
        let more = self
            .selection
            .more_layers
            .iter()
            .filter_map(|(photo, layer)| Some((*photo, found(*photo, *layer)?)));
        let more: Vec<(PhotoId, LayerIndex)> = more.collect();
        if let Selection::Layer { photo, layer } = self.selection.main {
            self.selection.main = match found(photo, layer) {
                Some(layer) => Selection::Layer { photo, layer },
                None => Selection::Photo(photo),
            };
        }
        let anchor = self.lists.anchor().and_then(|(photo, layer)| Some((photo, found(photo, layer)?)));
        self.selection.more_layers = more;
        self.lists.set_anchor(anchor);
    }

    /// Edits layer options. `goes_on`: the gesture continues, and all of it is one step.
    pub fn edit_options(&mut self, edit: &OptionsEdit, goes_on: bool) {
        let Some(session) = &self.session else { return };
        let (name, project) = match edit {
            OptionsEdit::Project(options) => {
                let project =
                    Project { options: options.clone(), ..Project::clone(session.history.present()) };
                ("layer options".to_owned(), Ok(project))
            }
            OptionsEdit::Photo(photo, options) => {
                let edit = LayerEdit::Options { photo: photo.clone(), options: *options };
                // Whether a number is valid does not depend on any stack.
                (edit.name(), decide::edited(session.history.present(), &edit, &session.opened.site, &[]))
            }
        };
        // Each photo is checked, too: a wider margin may exceed the smallest side that one of them allows.
        let project = project.and_then(|project| match problem_of_options(&project) {
            Some(problem) => Err(Error::Request(problem)),
            None => Ok(project),
        });
        match project {
            Ok(project) => self.edit(name, project, Some(OPTIONS)),
            Err(error) => self.notify(Note::new(Weight::Problem, error.message())),
        }
        if !goes_on {
            self.end_gesture();
        }
    }

    fn photo_name(&self, photo: PhotoId) -> Option<String> {
        Some(self.session.as_ref()?.opened.site.photos.get(photo.index())?.name.clone())
    }

    fn faces_of(&self, photo: PhotoId, layer: LayerIndex) -> Vec<Faces> {
        let stack = self.session.as_ref().and_then(|session| session.stack_of(photo));
        stack.map(|stack| faces_of_layer(stack, layer)).unwrap_or_default()
    }

    /// Merges the selected image layers into one.
    pub fn merge_layers(&mut self) {
        let (photo, layers) = self.selection.layers();
        let of = layers.iter().flat_map(|layer| self.faces_of(photo, *layer)).collect();
        let Some(name) = self.photo_name(photo) else { return };
        let edit = LayerEdit::Merge { photo: name, of };
        let cost = self
            .session
            .as_ref()
            .and_then(|session| session.merge_cost(photo, &layers))
            .filter(|cost| cost.is_high() || cost.is_too_large());
        match cost {
            // A merge that is not possible is reported at once, without a question.
            Some(cost) if self.decided(&edit).is_ok() => self.request_to_merge(edit, cost),
            _ => self.decide(&edit),
        }
    }

    /// Splits the selected image layer into one for each object.
    pub fn split_layer(&mut self) {
        let Selection::Layer { photo, layer } = self.selection.main else { return };
        let groups: Vec<Vec<Faces>> =
            self.faces_of(photo, layer).into_iter().map(|faces| vec![faces]).collect();
        if let Some(photo) = self.photo_name(photo) {
            self.decide(&LayerEdit::Split { photo, groups });
        }
    }

    /// Renames an image layer; an empty name restores its automatic name.
    pub fn rename_layer(&mut self, photo: PhotoId, layer: LayerIndex, name: &str) {
        let of = self.faces_of(photo, layer);
        let name = (!name.trim().is_empty()).then(|| name.trim().to_owned());
        if let Some(photo) = self.photo_name(photo) {
            self.decide(&LayerEdit::Rename { photo, of, name });
        }
    }

    fn selected_faces(&self) -> Vec<Faces> {
        let Some(session) = &self.session else { return Vec::new() };
        let model = session.model();
        match self.selection.main {
            Selection::Object(object) => vec![Faces::whole(&model.object(object).name)],
            Selection::Face(face) => {
                let it = model.face(face);
                vec![Faces { object: model.object(it.object).name.clone(), faces: vec![it.index] }]
            }
            Selection::Layer { photo, layer } => self.faces_of(photo, layer),
            Selection::Nothing | Selection::Photo(_) | Selection::Tree(_) | Selection::Trees => Vec::new(),
        }
    }

    /// Pins the selection to the photo: no other photo textures it.
    pub fn pin(&mut self) {
        let of = self.selected_faces();
        if let Some(photo) = self.selected_photo_name() {
            self.decide(&LayerEdit::Pin { photo, of });
        }
    }

    /// Excludes the photo from the selection: it never textures it.
    pub fn exclude(&mut self) {
        let of = self.selected_faces();
        if let Some(photo) = self.selected_photo_name() {
            self.decide(&LayerEdit::Exclude { photo, of });
        }
    }

    /// Removes all decisions about the photo.
    pub fn reset_decisions(&mut self) {
        let photo = self.selected_photo_name();
        if photo.is_some() {
            self.decide(&LayerEdit::Reset { photo });
        }
    }

    /// Removes one decision about a photo.
    pub fn forget_decision(&mut self, photo: String, number: usize) {
        self.decide(&LayerEdit::Forget { photo, number });
    }
}
