//! Groups of a file that is read from the top to the bottom: what they are to the layers within.

use std::sync::Arc;

use super::edited::{Blend, EditedMask};

/// What a file says of a group.
#[derive(Debug, Clone)]
pub struct GroupTraits {
    pub name: String,
    pub visible: bool,
    /// 0..=1
    pub opacity: f32,
    /// What of the group is to be seen.
    pub mask: Option<Arc<EditedMask>>,
    /// Passing through counts as normal.
    pub blend: Blend,
}

/// What the groups around a layer do to it, together.
#[derive(Debug)]
pub struct Around {
    /// Outermost first.
    pub names: Vec<String>,
    /// One of them is not shown.
    pub hidden: bool,
    /// 0..=1
    pub opacity: f32,
    /// Outermost first.
    pub masks: Vec<Arc<EditedMask>>,
    blend: Blend,
}

impl Around {
    /// Of groups, outermost first.
    pub fn of<'a>(groups: impl Iterator<Item = &'a GroupTraits>) -> Self {
        let mut around =
            Self { names: vec![], hidden: false, opacity: 1.0, masks: vec![], blend: Blend::Normal };
        for (group, depth) in groups.zip(0..) {
            around.hidden |= !group.visible;
            around.opacity *= group.opacity;
            if depth < DEEPEST {
                around.names.push(group.name.clone());
                around.masks.extend(group.mask.clone());
            }
            if let Blend::Other(mode) = &group.blend {
                around.blend = Blend::Other(format!("{mode} with its group \"{}\"", group.name));
            }
        }
        around
    }

    /// How a layer is laid over what is below, which by itself would be `own`.
    pub fn blend(&self, own: Blend) -> Blend {
        if own == Blend::Normal { self.blend.clone() } else { own }
    }

    /// All masks of a layer that has `own`.
    pub fn masks(&self, own: Option<EditedMask>) -> Vec<Arc<EditedMask>> {
        own.map(Arc::new).into_iter().chain(self.masks.iter().cloned()).collect()
    }
}

/// Names of groups are told to layers down to this depth: editors end far below it, and a damaged file must
/// not make every layer carry thousands.
const DEEPEST: usize = 100;

/// The groups that are open where the reader stands, outermost first.
#[derive(Debug, Default)]
pub struct OpenGroups {
    open: Vec<GroupTraits>,
}

impl OpenGroups {
    /// Goes into a group.
    pub fn open(&mut self, group: GroupTraits) {
        self.open.push(group);
    }

    /// Leaves the innermost group.
    pub fn close(&mut self, notes: &mut Vec<String>) {
        if self.open.pop().is_none() {
            notes.push("a group ends that has not begun; it is passed over".into());
        }
    }

    /// At the end of the file.
    pub fn finish(self, notes: &mut Vec<String>) {
        let unclosed = self.open.into_iter().map(|group| group.name);
        notes.extend(unclosed.map(|name| format!("group \"{name}\" does not end; it holds all below it")));
    }

    /// What they do to a layer here.
    pub fn around(&self) -> Around {
        Around::of(self.open.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::PixelRect;
    use crate::io::layered::{Grey, Lazy};
    use crate::scene::Samples;

    fn group(name: &str, visible: bool) -> GroupTraits {
        GroupTraits { name: name.into(), visible, opacity: 1.0, mask: None, blend: Blend::Normal }
    }

    fn mask(outside: f32) -> Arc<EditedMask> {
        let pixels = Lazy::new(|| Ok(Grey::new(0, 0, Samples::U8(vec![]))));
        let rect = PixelRect::EMPTY;
        Arc::new(EditedMask { rect, outside, enabled: true, pixels })
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
    fn what_is_unbalanced_is_said() {
        let (mut groups, mut notes) = (OpenGroups::default(), Vec::new());
        groups.close(&mut notes);
        groups.open(group("a", true));
        groups.finish(&mut notes);
        let said = notes.join("; ");
        assert!(said.contains("has not begun") && said.contains("does not end"), "{said}");
    }

    #[test]
    fn opacities_multiply_masks_gather_and_a_mode_reaches_the_layers() {
        let mut groups = OpenGroups::default();
        groups.open(GroupTraits { opacity: 0.5, mask: Some(mask(0.1)), ..group("a", true) });
        let blend = Blend::Other("multiply".into());
        groups.open(GroupTraits { opacity: 0.5, mask: Some(mask(0.2)), blend, ..group("b", true) });
        let around = groups.around();
        let outside: Vec<f32> = around.masks(None).iter().map(|mask| mask.outside).collect();
        assert_eq!((around.opacity, outside), (0.25, vec![0.1, 0.2]));
        assert_eq!(around.blend(Blend::Normal), Blend::Other("multiply with its group \"b\"".into()));
        assert_eq!(around.blend(Blend::Other("screen".into())), Blend::Other("screen".into()));
    }
}
