//! The trees of the open project: questions about them, their edits, and the selection by name.

use std::sync::Arc;

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::error::Result;
use quadratura_document::history::Gesture;
use quadratura_document::trees::{PlacedTree, TreeIndex, Trees};
use quadratura_document::{Masks, Project};
use quadratura_sites::masks::{ClearedMasks, cleared};

/// The gesture of a drag or a slider: each ends its own.
const DRAG: Gesture = Gesture(0x7e_e5);

impl State {
    /// Returns the trees of the open project.
    pub fn trees(&self) -> Option<&Trees> {
        self.session.as_ref().map(Session::trees)
    }

    /// Returns the selected tree.
    pub fn selected_tree(&self) -> Option<&PlacedTree> {
        self.session.as_ref()?.tree_of(self.selection.main)
    }

    /// Selects the tree of a name.
    pub fn select_tree(&mut self, name: &str) {
        if let Some(index) = self.trees().and_then(|trees| trees.index_of(name)) {
            self.select(Selection::Tree(index));
        }
    }

    /// Keeps the name of the selected tree.
    pub fn keep_tree_name(&mut self) {
        self.trees.selected = self.selected_tree().map(|tree| tree.name.clone());
    }

    /// Follows the selected tree where others came or went before it; nothing is selected where it went itself.
    pub fn follow_selected_tree(&mut self) {
        let Selection::Tree(_) = self.selection.main else { return };
        let is_it = self.selected_tree().map(|tree| &tree.name) == self.trees.selected.as_ref();
        if is_it && self.trees.selected.is_some() {
            return;
        }
        let found = self.trees.selected.as_ref().and_then(|name| self.trees()?.index_of(name));
        self.select(found.map_or(Selection::Nothing, Selection::Tree));
    }

    /// Makes other trees a step of the history, or a part of the present gesture; says why where they are impossible.
    pub fn edit_trees(&mut self, step: String, trees: Result<Trees>, goes_on: bool) {
        let Some(session) = &self.session else { return };
        let masks = session.history.present().masks.clone();
        self.edit_trees_and_masks(step, trees.map(|trees| (trees, masks)), goes_on);
    }

    /// Does the same with other masks, too.
    pub fn edit_trees_and_masks(&mut self, step: String, both: Result<(Trees, Masks)>, goes_on: bool) {
        let Some(session) = &self.session else { return };
        match both {
            Ok((trees, masks)) => {
                let project = Project { trees, masks, ..Project::clone(session.history.present()) };
                self.edit(step, project, Some(DRAG));
            }
            Err(error) => self.notify(Note::new(Weight::Problem, error.to_string())),
        }
        if !goes_on {
            self.end_gesture();
        }
    }

    /// Makes the project of before a gesture the present one again, within the gesture.
    pub fn give_gesture_up(&mut self, before: &Arc<Project>) {
        self.edit("nothing", Project::clone(before), Some(DRAG));
        self.end_gesture();
    }

    /// Renames a tree in what is remembered of it.
    pub fn tree_renamed(&mut self, before: &str, after: &str) {
        if self.trees.hidden.remove(before) {
            self.trees.hidden.insert(after.to_owned());
        }
        if self.trees.selected.as_deref() == Some(before) {
            self.trees.selected = Some(after.to_owned());
        }
    }

    /// Opens or closes the eyes of trees, by name.
    pub fn show_trees(&mut self, names: &[String], on: bool) {
        for name in names {
            match on {
                true => self.trees.hidden.remove(name),
                false => self.trees.hidden.insert(name.clone()),
            };
        }
    }

    /// Returns the masks without those of trees; `None` where there are none of them.
    pub fn masks_without_trees(&self) -> Option<Masks> {
        let masks = &self.session.as_ref()?.history.present().masks;
        cleared(masks, &[], &ClearedMasks::Trees).ok()
    }

    /// Returns the ball around a tree: middle and radius, in the world.
    pub fn ball_of_tree(&self, index: TreeIndex) -> Option<(glam::DVec3, f64)> {
        let session = self.session.as_ref()?;
        let tree = session.trees().at(index)?;
        let [height, width] = self.trees.size_of(session.trees(), tree)?;
        let middle = glam::DVec3::from_array(tree.at) + 0.5 * height * session.scene_frame.up;
        Some((middle, 0.5 * height.hypot(width)))
    }
}

impl Session {
    /// Returns the tree that is selected.
    pub fn tree_of(&self, selection: Selection) -> Option<&PlacedTree> {
        match selection {
            Selection::Tree(index) => self.trees().at(index),
            _ => None,
        }
    }

    /// Returns the trees of the project.
    pub fn trees(&self) -> &Trees {
        &self.history.present().trees
    }
}
