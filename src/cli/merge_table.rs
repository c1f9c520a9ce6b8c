//! The table of image layers that can be merged, photo by photo, for `decide --list`.

use serde_json::{Value, json};

use super::table::Table;
use super::words::command_for_project;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_document::{Project, Stack};
use quadratura_stacks::decide::{MergeableLayer, mergeable};

/// Maximum number of partners in a row; JSON has all.
const MOST_PARTNERS: usize = 4;

/// The image layers of photos, with those that each can be merged with.
pub struct MergeTable {
    photos: Vec<(String, Option<Vec<MergeableLayer>>)>,
}

impl MergeTable {
    /// Finds the possible merges in these photos' stacks, which are in the site's order.
    pub fn new(project: &Project, site: &Site, stacks: &[Option<Stack>], photos: &[PhotoId]) -> Self {
        let of_photo = |id: &PhotoId| {
            let name = site.photo(*id).name.clone();
            let decided = project.decisions.of(&name);
            let options = decided.options.applied_to(&project.options);
            let layers =
                stacks[id.index()].as_ref().map(|stack| mergeable(&decided, stack, &site.model, &options));
            (name, layers)
        };
        Self { photos: photos.iter().map(of_photo).collect() }
    }

    /// Returns the tables as text.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (photo, layers) in &self.photos {
            let Some(layers) = layers else {
                let update = command_for_project("update");
                text.push_str(&format!("{photo}: no stack yet; {update} builds it\n\n"));
                continue;
            };
            let mut table = Table::new(&["  token", "layer", "depth", "can be merged with"]);
            for layer in layers {
                let cells = [format!("  {}", layer.token), layer.name.clone(), layer.depth.to_string()];
                table.row(cells.into_iter().chain([partners(layer)]));
            }
            text.push_str(&format!("{photo}:\n{}\n", table.render()));
        }
        let merge = command_for_project("decide --photo PHOTO --merge TOKEN TOKEN");
        format!(
            "{text}depth: 1 is nearest; *: the rectangle around both would be mostly empty\n{merge} merges two layers\n"
        )
    }

    /// Returns the layers by photo as JSON.
    pub fn into_json(self) -> Value {
        let photos = self.photos.into_iter();
        photos.map(|(photo, layers)| json!({ "photo": photo, "layers": layers })).collect::<Vec<_>>().into()
    }
}

/// Returns the partners of a layer that cost least, and the number of the others.
fn partners(layer: &MergeableLayer) -> String {
    let mark = |mostly_empty: bool| if mostly_empty { "*" } else { "" };
    let first = layer.with.iter().take(MOST_PARTNERS);
    let mut named: Vec<String> =
        first.map(|it| format!("{} [{}]{}", it.name, it.token, mark(it.mostly_empty))).collect();
    let more = layer.with.len().saturating_sub(MOST_PARTNERS);
    named.extend((more > 0).then(|| format!("{more} more")));
    if named.is_empty() { "none".into() } else { named.join("; ") }
}
