//! Groups of a file that is read from the top to the bottom: what they are to the layers within.

use super::edited::Blend;

/// What a file says of a group.
#[derive(Debug, Clone)]
pub struct GroupTraits {
    pub name: String,
    pub visible: bool,
    /// 0..=1
    pub opacity: f32,
    /// With a mask that is switched on.
    pub masked: bool,
    /// Passing through counts as normal.
    pub blend: Blend,
}

impl GroupTraits {
    /// Says what of the group does not reach its layers.
    pub fn note(&self, notes: &mut Vec<String>) {
        let mut not_applied = |what: String| {
            notes.push(format!("group \"{}\": {what} is not applied to its layers", self.name));
        };
        if self.opacity < 1.0 {
            not_applied(format!("its opacity of {:.0} %", 100.0 * self.opacity));
        }
        if self.masked {
            not_applied("its mask".into());
        }
        if let Blend::Other(mode) = &self.blend {
            not_applied(format!("its mode \"{mode}\""));
        }
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
    pub fn open(&mut self, group: GroupTraits, notes: &mut Vec<String>) {
        group.note(notes);
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

    /// Their names, outermost first.
    pub fn names(&self) -> Vec<String> {
        self.open.iter().take(DEEPEST).map(|group| group.name.clone()).collect()
    }

    /// True when one of them is not shown.
    pub fn hide(&self) -> bool {
        self.open.iter().any(|group| !group.visible)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(name: &str, visible: bool) -> GroupTraits {
        GroupTraits { name: name.into(), visible, opacity: 1.0, masked: false, blend: Blend::Normal }
    }

    #[test]
    fn a_layer_lies_in_all_open_groups_and_is_hidden_by_any() {
        let (mut groups, mut notes) = (OpenGroups::default(), Vec::new());
        groups.open(group("a", false), &mut notes);
        groups.open(group("b", true), &mut notes);
        assert_eq!((groups.names(), groups.hide()), (vec!["a".into(), "b".into()], true));
        groups.close(&mut notes);
        groups.close(&mut notes);
        assert!(groups.names().is_empty() && !groups.hide() && notes.is_empty());
    }

    #[test]
    fn what_a_group_does_to_its_layers_and_what_is_unbalanced_is_said() {
        let (mut groups, mut notes) = (OpenGroups::default(), Vec::new());
        groups.close(&mut notes);
        let blend = Blend::Other("multiply".into());
        groups.open(GroupTraits { opacity: 0.5, masked: true, blend, ..group("a", true) }, &mut notes);
        groups.finish(&mut notes);
        let said = notes.join("; ");
        for part in ["has not begun", "50 %", "its mask", "multiply", "does not end"] {
            assert!(said.contains(part), "{said}");
        }
    }
}
