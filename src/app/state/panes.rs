//! The views of the centre as commands and actions know them: which are visible, which is in use, which is to come to
//! the front. Their layout belongs to the shell.

use serde::{Deserialize, Serialize};

/// A view of the centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pane {
    /// The 3D view.
    Space,
    /// The photo with its layers.
    Photo,
    /// One image layer.
    Layer,
}

impl Pane {
    /// All views, in order.
    pub const ALL: [Self; 3] = [Self::Space, Self::Photo, Self::Layer];

    /// Returns the name of the view in its tab.
    pub fn name(self) -> &'static str {
        match self {
            Self::Space => "3D",
            Self::Photo => "Photo",
            Self::Layer => "Image layer",
        }
    }
}

/// Whether each of [`Pane::ALL`] is visible.
pub type PaneVisibility = [bool; 3];

/// The visibility of the views of the centre.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Panes {
    seen: PaneVisibility,
    /// The views that would be visible if each of [`Pane::ALL`] came to the front.
    seen_if: [PaneVisibility; 3],
    used: Pane,
    /// The view under the pointer.
    under_pointer: Option<Pane>,
    /// Whether a widget beside the views has the keyboard's focus.
    focus_is_beside: bool,
    to_front: Vec<Pane>,
}

/// The part of the window to which keys without Ctrl belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyOwner {
    /// A view of the centre.
    View(Pane),
    /// A list or control beside the views.
    Beside,
}

impl Default for Panes {
    /// Returns three tabs, the first one in front.
    fn default() -> Self {
        let alone = [[true, false, false], [false, true, false], [false, false, true]];
        Self {
            seen: alone[0],
            seen_if: alone,
            used: Pane::Space,
            under_pointer: None,
            focus_is_beside: false,
            to_front: Vec::new(),
        }
    }
}

impl Panes {
    /// Brings a view to the front; it becomes the view in use.
    pub fn show(&mut self, pane: Pane) {
        self.seen = self.seen_if[pane as usize];
        self.used = pane;
        self.to_front.push(pane);
    }

    /// Returns whether a view is visible.
    pub fn is_shown(&self, pane: Pane) -> bool {
        self.seen[pane as usize]
    }

    /// Returns the view that keys and commands apply to: the one under the pointer, or else the one that the user
    /// worked in last, or a visible one where that is hidden.
    pub fn used(&self) -> Pane {
        if let Some(pane) = self.under_pointer.filter(|pane| self.is_shown(*pane)) {
            return pane;
        }
        let seen = Pane::ALL.into_iter().find(|pane| self.is_shown(*pane));
        if self.is_shown(self.used) { self.used } else { seen.unwrap_or(self.used) }
    }

    /// Records that the user works in this view.
    pub fn use_pane(&mut self, pane: Pane) {
        self.used = pane;
    }

    /// Returns the part of the window to which keys without Ctrl belong: the view under the pointer, or else what has
    /// the keyboard's focus.
    pub fn key_owner(&self) -> KeyOwner {
        if self.under_pointer.is_none() && self.focus_is_beside {
            return KeyOwner::Beside;
        }
        KeyOwner::View(self.used())
    }

    /// Mirrors the pointer and the keyboard's focus: the view under the pointer, and whether a widget beside the views
    /// has the focus.
    pub fn point(&mut self, under_pointer: Option<Pane>, focus_is_beside: bool) {
        (self.under_pointer, self.focus_is_beside) = (under_pointer, focus_is_beside);
    }

    /// Takes the views that were requested to come to the front, in order.
    pub fn take_to_front(&mut self) -> Vec<Pane> {
        std::mem::take(&mut self.to_front)
    }

    /// Mirrors the layout: which views are visible, and which would be if each came to the front.
    pub fn laid_out(&mut self, seen: PaneVisibility, seen_if: [PaneVisibility; 3]) {
        (self.seen, self.seen_if) = (seen, seen_if);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_that_comes_to_the_front_of_its_tabs_hides_the_others_of_them_only() {
        let mut panes = Panes::default();
        panes.show(Pane::Photo);
        assert!(panes.is_shown(Pane::Photo) && !panes.is_shown(Pane::Space));
        // The 3D view is beside the tabs of the other two.
        panes.laid_out([true, true, false], [[true, true, false], [true, true, false], [true, false, true]]);
        panes.show(Pane::Layer);
        assert!(panes.is_shown(Pane::Space) && !panes.is_shown(Pane::Photo));
        assert_eq!(panes.take_to_front(), [Pane::Photo, Pane::Layer]);
        assert_eq!(panes.take_to_front(), []);
    }

    #[test]
    fn the_view_in_use_is_one_that_is_seen() {
        let mut panes = Panes::default();
        panes.use_pane(Pane::Layer);
        assert_eq!(panes.used(), Pane::Space);
        panes.show(Pane::Layer);
        assert_eq!(panes.used(), Pane::Layer);
    }

    #[test]
    fn keys_belong_to_the_view_under_the_pointer_and_otherwise_to_what_has_the_focus() {
        let mut panes = Panes::default();
        assert_eq!(panes.key_owner(), KeyOwner::View(Pane::Space));
        panes.point(None, true);
        assert_eq!(panes.key_owner(), KeyOwner::Beside);
        panes.laid_out([true, true, false], [[true, true, false]; 3]);
        panes.point(Some(Pane::Photo), true);
        assert_eq!((panes.key_owner(), panes.used()), (KeyOwner::View(Pane::Photo), Pane::Photo));
        panes.point(Some(Pane::Layer), false);
        assert_eq!(panes.key_owner(), KeyOwner::View(Pane::Space), "a hidden view has no keys");
    }
}
