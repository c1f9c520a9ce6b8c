//! The rows of the lists, from top to bottom, as far as they are open.

use super::Lists;
use crate::app::state::State;
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::document::Stack;
use crate::recipe::layer_table::sorted;
use crate::scene::{FaceId, Model, ObjectId};

/// A row. Objects are counted through the whole model, with those that are switched off: a place stays the same
/// whatever is switched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Row {
    /// The image layers of the selected photo.
    Layers,
    /// The headings of their table.
    Head,
    /// Those of one depth, 0 nearest, and how many they are.
    Depth(u32),
    /// One of them, by its place in the stack.
    Layer(usize),
    /// The objects of the model.
    Objects,
    /// One of them.
    Object(usize),
    /// A face of it, by its index within the object.
    Face(usize, u32),
    /// What is to be said where there is nothing to list.
    Say(&'static str),
}

impl Row {
    /// It shows what is below it, until somebody closes it.
    pub fn is_open_at_first(self) -> bool {
        matches!(self, Self::Layers | Self::Depth(_) | Self::Objects)
    }

    /// Something may be below it.
    pub fn opens(self) -> bool {
        matches!(self, Self::Layers | Self::Depth(_) | Self::Objects | Self::Object(_))
    }

    /// Steps from the left edge.
    pub fn level(self, as_table: bool) -> usize {
        match self {
            Self::Layers | Self::Objects => 0,
            Self::Head | Self::Depth(_) | Self::Object(_) | Self::Say(_) => 1,
            Self::Layer(_) => {
                if as_table {
                    1
                } else {
                    2
                }
            }
            Self::Face(..) => 2,
        }
    }

    /// The keyboard stops at it.
    pub fn is_stop(self) -> bool {
        !matches!(self, Self::Head | Self::Say(_))
    }
}

/// What the lists are about.
pub struct Site<'a> {
    /// The project.
    pub session: &'a Session,
    /// The model with what is switched off.
    pub whole: &'a Model,
    /// By place in the whole model, the object of the model in use; none for one that is off.
    pub used: Vec<Option<ObjectId>>,
    /// The photo whose layers are listed.
    pub photo: Option<usize>,
}

impl<'a> Site<'a> {
    /// Of what is open; none without a project.
    pub fn of(state: &'a State) -> Option<Self> {
        let session = state.session.as_ref()?;
        let whole = &*session.opened.whole;
        Some(Self { session, whole, used: places(whole, session.model()), photo: state.selected_photo() })
    }

    /// The stack of the photo whose layers are listed.
    pub fn stack(&self) -> Option<&'a Stack> {
        self.session.photos.get(self.photo?)?.stack.as_deref()
    }

    /// What a row selects; none for rows that select nothing.
    pub fn selection(&self, row: Row) -> Option<Selection> {
        match row {
            Row::Layer(layer) => Some(Selection::Layer { photo: self.photo?, layer }),
            Row::Object(place) => Some(Selection::Object(self.used[place]?)),
            Row::Face(place, index) => Some(Selection::Face(self.face(place, index)?)),
            Row::Layers | Row::Head | Row::Depth(_) | Row::Objects | Row::Say(_) => None,
        }
    }

    fn face(&self, place: usize, index: u32) -> Option<FaceId> {
        self.session.model().object(self.used[place]?).faces.get(index as usize).copied()
    }

    /// The row of what is selected, and the rows that it lies below, the nearest one last.
    pub fn row_of(&self, selection: Selection, as_table: bool) -> Option<(Row, Vec<Row>)> {
        let model = self.session.model();
        let place = |object: ObjectId| self.used.iter().position(|used| *used == Some(object));
        match selection {
            Selection::Layer { photo, layer } if Some(photo) == self.photo => {
                let depth = Row::Depth(self.stack()?.image_layers.get(layer)?.order);
                let above = if as_table { vec![Row::Layers] } else { vec![Row::Layers, depth] };
                Some((Row::Layer(layer), above))
            }
            Selection::Object(object) => Some((Row::Object(place(object)?), vec![Row::Objects])),
            Selection::Face(face) => {
                let face = model.face(face);
                let place = place(face.object)?;
                Some((Row::Face(place, face.index), vec![Row::Objects, Row::Object(place)]))
            }
            Selection::Layer { .. } | Selection::Photo(_) | Selection::Nothing => None,
        }
    }
}

/// By place in the whole model the object of the same name in a model that lacks some of them.
fn places(whole: &Model, part: &Model) -> Vec<Option<ObjectId>> {
    let mut rest = (0u32..).zip(&part.objects).peekable();
    let of = |object: &crate::scene::Object| {
        let (id, _) = rest.next_if(|(_, used)| used.name == object.name)?;
        Some(ObjectId(id))
    };
    whole.objects.iter().map(of).collect()
}

/// All rows that are open and pass the filter.
pub fn rows(state: &State, lists: &Lists, site: &Site<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    let wanted = lists.filter.trim().to_lowercase();
    if site.photo.is_some() {
        rows.push(Row::Layers);
        if lists.is_open(Row::Layers) {
            layers(state, lists, site, &wanted, &mut rows);
        }
    }
    rows.push(Row::Objects);
    if lists.is_open(Row::Objects) {
        objects(lists, site.whole, &wanted, &mut rows);
    }
    rows
}

fn passes(name: &str, wanted: &str) -> bool {
    wanted.is_empty() || name.to_lowercase().contains(wanted)
}

fn layers(state: &State, lists: &Lists, site: &Site<'_>, wanted: &str, rows: &mut Vec<Row>) {
    let Some(stack) = site.stack() else {
        rows.push(Row::Say("Not built yet: Layers › Build layers makes them."));
        return;
    };
    let before = rows.len();
    let passing = |place: &usize| passes(&stack.image_layers[*place].name, wanted);
    let list = &state.settings.layer_list;
    if list.as_table {
        rows.push(Row::Head);
        let trust = state.layer_trust();
        let table = sorted(stack, list.column, list.falling, |place| trust.get(place).copied().flatten());
        rows.extend(table.into_iter().filter(passing).map(Row::Layer));
    } else {
        // Orders never decrease through a stack.
        let mut depth = None;
        for place in (0..stack.image_layers.len()).filter(passing) {
            let order = stack.image_layers[place].order;
            if depth != Some(order) {
                rows.push(Row::Depth(order));
            }
            depth = Some(order);
            if lists.is_open(Row::Depth(order)) {
                rows.push(Row::Layer(place));
            }
        }
    }
    if !rows[before..].iter().any(|row| matches!(row, Row::Layer(_) | Row::Depth(_))) {
        rows.push(Row::Say("No layer has these letters in its name."));
    }
}

fn objects(lists: &Lists, whole: &Model, wanted: &str, rows: &mut Vec<Row>) {
    let before = rows.len();
    for (place, object) in whole.objects.iter().enumerate().filter(|(_, o)| passes(&o.name, wanted)) {
        rows.push(Row::Object(place));
        if lists.is_open(Row::Object(place)) {
            rows.extend((0..object.faces.len() as u32).map(|index| Row::Face(place, index)));
        }
    }
    if rows.len() == before {
        rows.push(Row::Say("No object has these letters in its name."));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn an_object_is_found_by_its_name_where_others_are_switched_off() {
        let whole = closed_form::stairs().model;
        let off = whole.objects[1].name.clone();
        let part = whole.without(|object| object.name == off);
        let found = places(&whole, &part);
        assert_eq!(found[..3], [Some(ObjectId(0)), None, Some(ObjectId(1))]);
        assert_eq!(found.iter().flatten().count(), part.objects.len());
    }

    #[test]
    fn only_what_is_open_has_rows_and_the_filter_takes_no_heed_of_capitals() {
        let whole = closed_form::stairs().model;
        let mut lists = Lists::default();
        let listed = |lists: &Lists, wanted: &str| {
            let mut rows = Vec::new();
            objects(lists, &whole, wanted, &mut rows);
            rows
        };
        assert_eq!(listed(&lists, "").len(), whole.objects.len());
        lists.set_open(Row::Object(1), true);
        let faces = whole.objects[1].faces.len();
        assert_eq!(listed(&lists, "").len(), whole.objects.len() + faces);
        let name = whole.objects[1].name.to_lowercase();
        assert_eq!(listed(&lists, &name)[..2], [Row::Object(1), Row::Face(1, 0)]);
        assert!(matches!(listed(&lists, "no such name")[..], [Row::Say(_)]));
    }
}
