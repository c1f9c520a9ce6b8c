//! Groups of a file that is read from top to bottom, and their effect on the layers within.

use std::sync::Arc;

use super::edited::{BlendMode, EditedMask};

/// The properties of a group in a file.
#[derive(Debug, Clone)]
pub struct GroupProperties {
    pub name: String,
    pub visible: bool,
    /// Opacity, 0..=1.
    pub opacity: f32,
    /// The mask of the group.
    pub mask: Option<Arc<EditedMask>>,
    /// Blend mode; pass-through counts as normal.
    pub blend: BlendMode,
}

/// The combined effect of all groups that contain a layer.
#[derive(Debug)]
pub struct GroupContext {
    /// The groups' names, outermost first.
    pub names: Vec<String>,
    /// Whether one of the groups is hidden.
    pub hidden: bool,
    /// Product of the groups' opacities, 0..=1.
    pub opacity: f32,
    /// The groups' masks, outermost first.
    pub masks: Vec<Arc<EditedMask>>,
    blend: BlendMode,
}

impl GroupContext {
    /// Combines groups, given outermost first.
    pub fn from_groups<'a>(groups: impl Iterator<Item = &'a GroupProperties>) -> Self {
        let mut around =
            Self { names: vec![], hidden: false, opacity: 1.0, masks: vec![], blend: BlendMode::Normal };
        for (group, depth) in groups.zip(0..) {
            around.hidden |= !group.visible;
            around.opacity *= group.opacity;
            if depth < DEEPEST {
                around.names.push(group.name.clone());
                around.masks.extend(group.mask.clone());
            }
            if let BlendMode::Other(mode) = &group.blend {
                around.blend = BlendMode::Other(format!("{mode} with its group \"{}\"", group.name));
            }
        }
        around
    }

    /// Returns the effective blend mode of a layer whose own mode is `own`.
    pub fn blend(&self, own: BlendMode) -> BlendMode {
        if own == BlendMode::Normal { self.blend.clone() } else { own }
    }

    /// Returns all masks of a layer whose own mask is `own`.
    pub fn masks(&self, own: Option<EditedMask>) -> Vec<Arc<EditedMask>> {
        own.map(Arc::new).into_iter().chain(self.masks.iter().cloned()).collect()
    }
}

/// Names and masks of groups are kept down to this depth. Editors nest far less deeply, and a damaged file
/// must not give every layer thousands of them.
const DEEPEST: usize = 100;

/// The groups that are open at the reader's position, outermost first.
#[derive(Debug, Default)]
pub struct OpenGroups {
    open: Vec<GroupProperties>,
}

impl OpenGroups {
    /// Opens a group.
    pub fn open(&mut self, group: GroupProperties) {
        self.open.push(group);
    }

    /// Closes the innermost group.
    pub fn close(&mut self, notes: &mut Vec<String>) {
        if self.open.pop().is_none() {
            notes.push("a group ends that has not begun; its end is ignored".into());
        }
    }

    /// Reports groups that are still open at the end of the file.
    pub fn finish(self, notes: &mut Vec<String>) {
        let unclosed = self.open.into_iter().map(|group| group.name);
        notes.extend(
            unclosed.map(|name| format!("group \"{name}\" does not end; it contains all layers below it")),
        );
    }

    /// Returns the combined effect of the open groups.
    pub fn around(&self) -> GroupContext {
        GroupContext::from_groups(self.open.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grey, Lazy};
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::Samples;

    fn group(name: &str, visible: bool) -> GroupProperties {
        GroupProperties { name: name.into(), visible, opacity: 1.0, mask: None, blend: BlendMode::Normal }
    }

    fn mask(outside: f32) -> Arc<EditedMask> {
        let pixels = Lazy::new(|| Ok(Grey::new(0, 0, Samples::U8(vec![]))));
        let rect = PixelRect::EMPTY;
        Arc::new(EditedMask { rect, outside, enabled: true, lowest_with: None, pixels })
    }

    #[test]
    fn a_layer_lies_in_all_open_groups_and_is_hidden_by_any() {
        let (mut groups, mut notes) = (OpenGroups::default(), Vec::new());
        groups.open(group("a", false));
        groups.open(group("b", true));
        let around = groups.around();
        assert_eq!((around.names, around.hidden), (vec!["a".into(), "b".into()], true));
        groups.close(&mut notes);
        groups.close(&mut notes);
        let around = groups.around();
        assert!(around.names.is_empty() && !around.hidden && notes.is_empty());
    }

    #[test]
    fn unbalanced_groups_are_reported() {
        let (mut groups, mut notes) = (OpenGroups::default(), Vec::new());
        groups.close(&mut notes);
        groups.open(group("a", true));
        groups.finish(&mut notes);
        let message = notes.join("; ");
        assert!(message.contains("has not begun") && message.contains("does not end"), "{message}");
    }

    #[test]
    fn opacities_multiply_masks_gather_and_a_mode_reaches_the_layers() {
        let mut groups = OpenGroups::default();
        groups.open(GroupProperties { opacity: 0.5, mask: Some(mask(0.1)), ..group("a", true) });
        let blend = BlendMode::Other("multiply".into());
        groups.open(GroupProperties { opacity: 0.5, mask: Some(mask(0.2)), blend, ..group("b", true) });
        let around = groups.around();
        let outside: Vec<f32> = around.masks(None).iter().map(|mask| mask.outside).collect();
        assert_eq!((around.opacity, outside), (0.25, vec![0.1, 0.2]));
        assert_eq!(around.blend(BlendMode::Normal), BlendMode::Other("multiply with its group \"b\"".into()));
        assert_eq!(around.blend(BlendMode::Other("screen".into())), BlendMode::Other("screen".into()));
    }
}
