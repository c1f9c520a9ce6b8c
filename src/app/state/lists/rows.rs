//! The rows of the lists, from top to bottom, as far as they are open.

use super::ListsState;
use super::row::ListRow;
use crate::state::State;
use crate::state::lists::layer_list::LayerList;
use crate::state::quality::filling::FillSession;
use crate::state::selection::{Selection, SelectionState};
use crate::state::session::Session;
use quadratura_base::scene::{FaceId, FaceIndex, Model, ObjectId, PhotoId};
use quadratura_document::Stack;
use quadratura_document::trees::{PlacedTree, TreeIndex, Trees};
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_table::sorted;

/// The data that the lists show.
pub struct ListedSite<'a> {
    /// The open project.
    pub session: &'a Session,
    /// The whole model, with excluded objects.
    pub whole: &'a Model,
    /// The object of the model in use, by index in the whole model; none for an excluded one.
    pub used: Vec<Option<ObjectId>>,
    /// The photo whose layers are listed.
    pub photo: Option<PhotoId>,
}

impl<'a> ListedSite<'a> {
    /// Returns the data of the open project; none without one.
    pub fn from_state(state: &'a State) -> Option<Self> {
        let session = state.session.as_ref()?;
        let whole = &*session.opened.whole;
        Some(Self { session, whole, used: places(whole, session.model()), photo: state.selected_photo() })
    }

    /// Returns the stack of the photo whose layers are listed.
    pub fn stack(&self) -> Option<&'a Stack> {
        self.session.stack_of(self.photo?).map(|stack| &**stack)
    }

    /// Returns what a row selects; none for rows that select nothing.
    pub fn selection(&self, row: ListRow) -> Option<Selection> {
        match row {
            ListRow::Layer(layer) => Some(Selection::Layer { photo: self.photo?, layer }),
            ListRow::Object(object) => Some(Selection::Object(self.used[object.index()]?)),
            ListRow::Face(object, index) => Some(Selection::Face(self.face(object, index)?)),
            ListRow::Tree(tree) => Some(Selection::Tree(tree)),
            ListRow::Trees => Some(Selection::Trees),
            ListRow::Layers | ListRow::Head | ListRow::Depth(_) | ListRow::Objects | ListRow::Say(_) => None,
            ListRow::Species(_) => None,
        }
    }

    /// Returns the trees of the project.
    pub fn trees(&self) -> &'a Trees {
        self.session.trees()
    }

    /// Returns the name of a species by its number in the order of names.
    pub fn species(&self, number: u32) -> Option<&'a str> {
        self.trees().species.keys().nth(number as usize).map(String::as_str)
    }

    /// Returns the trees of a species.
    pub fn trees_of(&self, species: &str) -> impl Iterator<Item = &'a PlacedTree> {
        self.trees().placed.iter().filter(move |tree| tree.species == species)
    }

    fn face(&self, object: ObjectId, index: FaceIndex) -> Option<FaceId> {
        self.session.model().object(self.used[object.index()]?).face(index)
    }

    /// Returns whether a row is selected, alone or with others.
    pub fn is_selected(&self, row: ListRow, selected: &SelectionState) -> bool {
        self.selection(row).is_some_and(|this| selected.includes(this))
    }

    /// Returns whether an object is switched off, by name.
    pub fn is_off(&self, object: &str) -> bool {
        self.session.history.present().objects_off.contains(object)
    }

    /// Returns the row of a selection, and the rows above it in the hierarchy, the nearest one last.
    pub fn row_of(&self, selection: Selection, as_table: bool) -> Option<(ListRow, Vec<ListRow>)> {
        let model = self.session.model();
        let in_whole =
            |object: ObjectId| self.used.iter().position(|used| *used == Some(object)).map(ObjectId::new);
        match selection {
            Selection::Layer { photo, layer } if Some(photo) == self.photo => {
                let depth = ListRow::Depth(self.stack()?.image_layers.get(layer.index())?.order);
                let above = if as_table { vec![ListRow::Layers] } else { vec![ListRow::Layers, depth] };
                Some((ListRow::Layer(layer), above))
            }
            Selection::Object(object) => Some((ListRow::Object(in_whole(object)?), vec![ListRow::Objects])),
            Selection::Face(face) => {
                let face = model.face(face);
                let object = in_whole(face.object)?;
                Some((ListRow::Face(object, face.index), vec![ListRow::Objects, ListRow::Object(object)]))
            }
            Selection::Tree(tree) => {
                let species = &self.trees().at(tree)?.species;
                let number = self.trees().species.keys().position(|name| name == species)?;
                Some((ListRow::Tree(tree), vec![ListRow::Trees, ListRow::Species(number as u32)]))
            }
            Selection::Trees => Some((ListRow::Trees, Vec::new())),
            Selection::Layer { .. } | Selection::Photo(_) | Selection::Nothing => None,
        }
    }
}

/// Returns, by index in the whole model, the object of the same name in a partial model.
fn places(whole: &Model, part: &Model) -> Vec<Option<ObjectId>> {
    let mut rest = (0u32..).zip(&part.objects).peekable();
    let of = |object: &quadratura_base::scene::Object| {
        let (id, _) = rest.next_if(|(_, used)| used.name == object.name)?;
        Some(ObjectId(id))
    };
    whole.objects.iter().map(of).collect()
}

/// Returns all rows that are open and match the filter.
pub fn rows(list: LayerList, fill: &FillSession, lists: &ListsState, site: &ListedSite<'_>) -> Vec<ListRow> {
    let mut rows = Vec::new();
    let wanted = lists.filter.trim().to_lowercase();
    if site.photo.is_some() {
        rows.push(ListRow::Layers);
        if lists.is_open(ListRow::Layers) {
            layers(list, fill, lists, site, &wanted, &mut rows);
        }
    }
    if !site.trees().is_empty() {
        rows.push(ListRow::Trees);
        if lists.is_open(ListRow::Trees) {
            trees(lists, site.trees(), &wanted, &mut rows);
        }
    }
    rows.push(ListRow::Objects);
    if lists.is_open(ListRow::Objects) {
        objects(lists, site.whole, &wanted, &mut rows);
    }
    rows
}

fn passes(name: &str, wanted: &str) -> bool {
    wanted.is_empty() || name.to_lowercase().contains(wanted)
}

fn layers(
    list: LayerList,
    fill: &FillSession,
    lists: &ListsState,
    site: &ListedSite<'_>,
    wanted: &str,
    rows: &mut Vec<ListRow>,
) {
    let Some(stack) = site.stack() else {
        rows.push(ListRow::Say("Not built yet: use Layers › Build layers."));
        return;
    };
    let before = rows.len();
    let passing = |layer: &LayerIndex| passes(&stack.layer(*layer).name, wanted);
    if list.as_table {
        rows.push(ListRow::Head);
        let trust = site.photo.map(|photo| fill.layer_trust(photo)).unwrap_or_default();
        let table =
            sorted(stack, list.column, list.falling, |layer| trust.get(layer.index()).copied().flatten());
        rows.extend(table.into_iter().filter(passing).map(ListRow::Layer));
    } else {
        // Orders never decrease through a stack.
        let mut depth = None;
        for layer in stack.layer_indices().filter(passing) {
            let order = stack.layer(layer).order;
            if depth != Some(order) {
                rows.push(ListRow::Depth(order));
            }
            depth = Some(order);
            if lists.is_open(ListRow::Depth(order)) {
                rows.push(ListRow::Layer(layer));
            }
        }
    }
    if !rows[before..].iter().any(|row| matches!(row, ListRow::Layer(_) | ListRow::Depth(_))) {
        rows.push(ListRow::Say("No layer's name contains these letters."));
    }
}

fn trees(lists: &ListsState, trees: &Trees, wanted: &str, rows: &mut Vec<ListRow>) {
    let before = rows.len();
    for (name, number) in trees.species.keys().zip(0..) {
        let of_it = |(_, tree): &(TreeIndex, &PlacedTree)| {
            tree.species == *name && (passes(name, wanted) || passes(&tree.name, wanted))
        };
        let all = trees.placed.iter().enumerate().map(|(index, tree)| (TreeIndex::new(index), tree));
        let found: Vec<ListRow> = all.filter(of_it).map(|(index, _)| ListRow::Tree(index)).collect();
        if found.is_empty() && !passes(name, wanted) {
            continue;
        }
        rows.push(ListRow::Species(number));
        if lists.is_open(ListRow::Species(number)) {
            rows.extend(found);
        }
    }
    if rows.len() == before {
        rows.push(ListRow::Say("No tree's name contains these letters."));
    }
}

fn objects(lists: &ListsState, whole: &Model, wanted: &str, rows: &mut Vec<ListRow>) {
    let before = rows.len();
    let objects = whole.objects.iter().enumerate().map(|(index, object)| (ObjectId::new(index), object));
    for (id, object) in objects.filter(|(_, object)| passes(&object.name, wanted)) {
        rows.push(ListRow::Object(id));
        if lists.is_open(ListRow::Object(id)) {
            rows.extend(FaceIndex::all(object.faces.len()).map(|index| ListRow::Face(id, index)));
        }
    }
    if rows.len() == before {
        rows.push(ListRow::Say("No object's name contains these letters."));
    }
}

impl ListsState {
    /// Follows a selection made elsewhere: opens the rows above its row and moves the cursor to it; returns whether the
    /// selection changed.
    pub fn follow(&mut self, selection: Selection, site: &ListedSite<'_>, as_table: bool) -> bool {
        if std::mem::replace(&mut self.known, selection) == selection {
            return false;
        }
        let Some((row, above)) = site.row_of(selection, as_table) else { return false };
        above.into_iter().for_each(|row| self.set_open(row, true));
        self.cursor = Some(row);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_trees::edit::{TreeChange, placed};

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
    fn trees_are_below_their_species_and_are_found_by_either_name() {
        let change = TreeChange { at: Some([0.0; 3]), ..TreeChange::default() };
        let place =
            |trees: &Trees, species: &str, name: &str| placed(trees, species, Some(name), &change).unwrap().0;
        let all = place(&place(&place(&Trees::default(), "oak", "gate"), "maple", "court"), "oak", "well");
        let mut lists = ListsState::default();
        let listed = |lists: &ListsState, wanted: &str| {
            let mut rows = Vec::new();
            trees(lists, &all, wanted, &mut rows);
            rows
        };
        let (maple, oak) = (ListRow::Species(0), ListRow::Species(1));
        let tree = |index| ListRow::Tree(TreeIndex(index));
        assert_eq!(listed(&lists, ""), [maple, tree(1), oak, tree(0), tree(2)]);
        assert_eq!(listed(&lists, "gate"), [oak, tree(0)]);
        assert_eq!(listed(&lists, "maple"), [maple, tree(1)]);
        assert!(matches!(listed(&lists, "elm")[..], [ListRow::Say(_)]));
        lists.set_open(oak, false);
        assert_eq!(listed(&lists, ""), [maple, tree(1), oak]);
    }

    #[test]
    fn only_what_is_open_has_rows_and_the_filter_takes_no_heed_of_capitals() {
        let whole = closed_form::stairs().model;
        let mut lists = ListsState::default();
        let listed = |lists: &ListsState, wanted: &str| {
            let mut rows = Vec::new();
            objects(lists, &whole, wanted, &mut rows);
            rows
        };
        assert_eq!(listed(&lists, "").len(), whole.objects.len());
        lists.set_open(ListRow::Object(ObjectId(1)), true);
        let faces = whole.objects[1].faces.len();
        assert_eq!(listed(&lists, "").len(), whole.objects.len() + faces);
        let name = whole.objects[1].name.to_lowercase();
        assert_eq!(
            listed(&lists, &name)[..2],
            [ListRow::Object(ObjectId(1)), ListRow::Face(ObjectId(1), FaceIndex(0))]
        );
        assert!(matches!(listed(&lists, "no such name")[..], [ListRow::Say(_)]));
    }
}
