//! How hidden parts are filled: where it would be seen most, what shows there, and the options.

use std::collections::BTreeMap;

use super::lookup::Lookup;
use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::document::{Project, Stack};
use crate::layers::fill::FillOptions;
use crate::recipe::fill::shares::{LayerShares, layer_shares};
use crate::recipe::fill::worst::{HiddenLayer, views_of_photos, worst_first};

/// What is known of fillings.
#[derive(Default)]
pub struct FillDesk {
    /// Layers by how much of their hidden parts is seen.
    pub worst: Lookup<Vec<HiddenLayer>>,
    /// What shows at hidden texels of a photo's layers, by the photo's place.
    pub shares: BTreeMap<usize, Lookup<Vec<LayerShares>>>,
    /// Objects that are left out, as they are being typed.
    pub without: Option<String>,
}

impl Editor {
    /// Sees to it that layers are ranked by how much of their hidden parts is seen.
    pub fn want_worst(&mut self) {
        let Some(session) = self.session.as_ref().filter(|_| self.quality.fill.worst.is_due()) else {
            return;
        };
        let opened = session.opened.clone();
        let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.clone()).collect();
        let job = self.jobs.start(Kind::Look, "Looking for hidden parts", move |task| {
            let stacks: Vec<Option<&Stack>> = stacks.iter().map(Option::as_deref).collect();
            let worst = worst_first(&opened.site, &stacks, &views_of_photos(&opened.site), task)?;
            Ok(Box::new(move |editor| editor.quality.fill.worst.find(worst)))
        });
        self.quality.fill.worst.is_sought_by(job);
    }

    /// Sees to it that one knows what fills the layers of a photo.
    pub fn want_shares(&mut self, photo: usize) {
        let Some(session) = &self.session else { return };
        let lookup = self.quality.fill.shares.entry(photo).or_default();
        if !lookup.is_due() {
            return;
        }
        let (folder, name) = (session.folder.clone(), session.opened.site.photos[photo].name.clone());
        let job = self.jobs.start(Kind::Look, format!("Looking at fillings of {name}"), move |task| {
            let shares = layer_shares(&folder, &name, task)?;
            Ok(Box::new(move |editor| editor.quality.fill.shares.entry(photo).or_default().find(shares)))
        });
        lookup.is_sought_by(job);
    }

    /// Decides how to fill; the next filling is made so.
    pub fn edit_fill(&mut self, options: FillOptions) {
        let Some(session) = &self.session else { return };
        let project = Project { fill: options, ..Project::clone(session.history.present()) };
        self.edit("options of filling", project, None);
    }
}
