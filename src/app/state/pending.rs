//! The updates that follow from edits: what an edit invalidates, and when it is updated.

use super::life::Autosave;
use quadratura_document::Project;

/// Time without an edit, in seconds, after which the updates that follow from edits are done.
const FOLLOWS_AFTER_S: f64 = 0.3;

/// The parts of the session that an edit invalidates. Later variants include the earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invalidation {
    /// The gains of the photos are out of date.
    Gains,
    /// The state of stacks, and what is shown of them, is out of date.
    Stacks,
    /// The model is out of date: other objects are in use.
    Objects,
    /// Everything is out of date: files or the placement of the model have changed.
    Site,
}

impl Invalidation {
    /// Returns what the change from one project to another invalidates; `None` where nothing is.
    pub fn new(before: &Project, after: &Project) -> Option<Self> {
        let site = |project: &Project| {
            let Project { photos, cameras, model, chunk, rolling_shutter, world_from_model, .. } =
                project.clone();
            (photos, cameras, model, chunk, rolling_shutter, world_from_model)
        };
        let others = has_other_objects(before, after);
        // Bookmarks and flights invalidate nothing; masks and fill options take effect when layers are made again. The 3D view
        // follows trees by itself; layers depend on no more of them than on the objects that they replace.
        let kept = Project {
            masks: after.masks.clone(),
            views: after.views.clone(),
            flight: after.flight.clone(),
            fill: after.fill.clone(),
            trees: after.trees.clone(),
            ..before.clone()
        };
        let multiplied = Project { colour: after.colour.clone(), ..kept.clone() };
        if kept == *after && !others {
            None
        } else if multiplied == *after && !others {
            Some(Self::Gains)
        } else if site(before) != site(after) {
            Some(Self::Site)
        } else if others {
            Some(Self::Objects)
        } else {
            Some(Self::Stacks)
        }
    }
}

/// Returns whether objects were removed or restored, turn or not, or are see-through or not, where they were not before.
fn has_other_objects(before: &Project, after: &Project) -> bool {
    let of = |project: &Project| {
        let off: Vec<String> = project.objects_left_out().into_iter().cloned().collect();
        (off, project.impostors.clone(), project.see_through.clone())
    };
    of(before) != of(after)
}

/// The updates that are pending after edits.
#[derive(Debug, Default)]
pub struct PendingUpdates {
    /// The results that are out of date.
    pub invalidation: Option<Invalidation>,
    /// Whether masks of photos have changed: their stacks stay, and may be out of date.
    pub looks: bool,
    /// Whether an update was stopped or failed. It waits until the next edit, build or reload.
    pub waits: bool,
    /// Whether the site is to be read again as soon as other jobs have ended.
    pub reload: bool,
    /// The time of the last edit, in seconds.
    pub edited_s: f64,
    /// When the autosave is due.
    pub keep: Autosave,
}

impl PendingUpdates {
    /// Returns whether the updates wait: for the next edit, or until there has been none for a moment.
    pub fn rests(&self, now_s: f64) -> bool {
        now_s - self.edited_s < FOLLOWS_AFTER_S || self.waits
    }

    /// Takes the updates to be done now: what is out of date, and whether the states of stacks are looked at.
    pub fn take(&mut self) -> (Option<Invalidation>, bool) {
        (self.invalidation.take(), std::mem::take(&mut self.looks))
    }

    /// Records that an update was stopped or failed: it is pending again, and waits.
    pub fn failed(&mut self, invalidation: Invalidation) {
        self.invalidation = self.invalidation.max(Some(invalidation));
        self.waits = true;
    }

    /// Drops the updates that reading the site again includes.
    pub fn reread(&mut self) {
        (self.invalidation, self.waits, self.reload) = (None, false, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::Similarity;

    fn project() -> Project {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn what_follows_depends_on_what_was_edited() {
        let before = project();
        let mut after = before.clone();
        after.flight = Some(quadratura_document::CameraPath::empty([64, 48]));
        assert_eq!(Invalidation::new(&before, &after), None);
        after.colour.reference = Some("a.jpg".into());
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Gains));
        after.masks =
            serde_json::from_str(r#"{"a.jpg":[{"from":"drawn","file":"a/1.png","pixels":3}]}"#).unwrap();
        assert_eq!(
            Invalidation::new(&before, &after),
            Some(Invalidation::Gains),
            "no stack is another one for a mask"
        );
        after.options.margin += 1;
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Stacks));
        let mut declared = after.clone();
        declared.see_through.insert("fence".into(), true);
        assert_eq!(Invalidation::new(&before, &declared), Some(Invalidation::Objects));
        after.objects_off.insert("tower".into());
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Objects));
        after.world_from_model = Similarity { scale: 2.0, ..Similarity::IDENTITY };
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Site));
    }

    #[test]
    fn updates_begin_when_there_was_no_edit_for_a_moment() {
        let mut pending = PendingUpdates { edited_s: 5.0, ..PendingUpdates::default() };
        assert_eq!([5.0, 5.2, 5.4].map(|now_s| pending.rests(now_s)), [true, true, false]);
        pending.failed(Invalidation::Stacks);
        assert!(pending.rests(9.0), "one that failed waits for the next edit");
        pending.reread();
        assert!(!pending.rests(9.0));
    }

    #[test]
    fn an_update_that_failed_is_pending_again_beside_larger_ones() {
        let mut pending = PendingUpdates::default();
        pending.failed(Invalidation::Objects);
        pending.failed(Invalidation::Gains);
        assert_eq!(pending.take(), (Some(Invalidation::Objects), false));
        assert_eq!(pending.take(), (None, false));
    }
}
