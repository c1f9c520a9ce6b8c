//! The light on the trees of a site, estimated from its photos.
//!
//! Photos that show the real trees are compared with the placed ones (`blocks`, `fit`); where no photo shows one, the model
//! beside the trees tells how bright it is (`faces`). The estimate is kept in `cache/`.

mod blocks;
mod faces;
mod fit;
mod kept;
mod ratios;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use self::blocks::blocks;
use self::faces::light_of_faces;
use self::fit::{Fit, PixelBlock, fit};
use self::kept::{keep, kept};
use self::ratios::ratios;
pub use self::ratios::{TreeRatios, set_ratios};
use crate::mask::masks_of;
use crate::shine;
use crate::sunlight::SunBlockers;
use quadratura_base::error::{Message, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::masks::{Mask, MaskOrigin, MaskedTree};
use quadratura_document::trees::{LightStrength, PlacedTree, Strength, TreeLight};
use quadratura_document::{Project, Stack, Trees};
use quadratura_files::hash::hash_bytes;
use quadratura_foliage::files::images::plant_hash;
use quadratura_foliage::{OutdoorLight, PlacedTrees, Tree};
use quadratura_io::stack_store::StackStore;
use quadratura_sites::budget::default_memory;
use quadratura_stacks::gains;
use quadratura_stacks::inputs::hash_of_model;

/// An estimate of the light on trees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightEstimate {
    /// What sun, sky and ground give.
    pub strength: LightStrength,
    /// What it is from.
    pub support: LightSupport,
    /// What photos show of trees over what is drawn of them in this light, without their tint.
    #[serde(skip)]
    pub ratios: Vec<TreeRatios>,
}

impl LightEstimate {
    /// Makes an estimate that is from no photo of a tree.
    pub fn plain(strength: LightStrength, support: LightSupport) -> Self {
        Self { strength, support, ratios: Vec::new() }
    }

    /// Gives trees what is said of their light, or else what was estimated.
    pub fn shine(&self, said: &TreeLight, placed: &mut PlacedTrees) {
        if said.strength == Strength::Estimated {
            shine(&mut placed.light, &self.strength);
        }
        let ratios: &[TreeRatios] = if said.without_photos { &[] } else { &self.ratios };
        set_ratios(placed, ratios);
    }
}

/// What an estimate of the light on trees is from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "from", rename_all = "kebab-case")]
pub enum LightSupport {
    /// Photos that show the real trees.
    Photos {
        /// Their number.
        photos: usize,
        /// The number of blocks of 8 x 8 pixels.
        blocks: usize,
        /// The root mean square of the difference between photos and trees in luminance, relative to the mean.
        residual: f64,
        /// True where sun and sky were told from each other; false where their ratio is the usual one.
        split: bool,
    },
    /// Faces of the model beside the trees: no photo shows a tree.
    Faces {
        /// The number of photo pixels.
        pixels: usize,
    },
    /// Nothing: it is the light of a clear day.
    ClearDay,
}

/// Returns the estimate of the light on the trees of a project: the one in `cache/` if it was made from the same photos,
/// masks and trees, else a new one, which is kept there. `placed` is what is drawn of the trees. Their paint has no part in it: the
/// photos do not show it, so that light which makes up for it would take it away.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for masks that cannot be read. A cache that cannot be written is
/// noted.
pub fn estimated_light(
    folder: &Path,
    project: &Project,
    site: &Site,
    placed: &PlacedTrees,
    task: &Task,
) -> Result<LightEstimate> {
    let mut placed = placed.without_paint();
    let store = StackStore::new(folder);
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten();
    let stacks: Vec<Option<Stack>> = site.photos.iter().map(stack).collect();
    let inputs = inputs(project, site, &placed, &gains::inputs(site, &stacks));
    if let Some(kept) = kept(folder, &inputs, site, &placed) {
        return Ok(kept);
    }
    // Planned trees are in no photo, and shade none of the real ones.
    let is_real = |tree: &Tree| is_in_photos(project, tree);
    SunBlockers::new(&site.model).shade_by(&mut placed, &is_real, task)?;
    let placed = &placed;
    let memory = default_memory();
    let gains = gains::photo_gains(site, &stacks, &project.colour, folder, memory, task)?;
    let shown = blocks(folder, project, site, placed, &gains, task)?;
    let of_all: Vec<PixelBlock> =
        shown.iter().flat_map(|of| of.blocks.iter().map(|(_, block)| *block)).collect();
    let estimate = match fit(&of_all) {
        Some(Fit { strength, photos, blocks, residual, is_split: split, of_foliage }) => LightEstimate {
            strength,
            support: LightSupport::Photos { photos, blocks, residual, split },
            ratios: ratios(&shown, &strength, &of_foliage, site, placed),
        },
        None => match light_of_faces(site, placed, &gains, task)? {
            Some((strength, pixels)) => LightEstimate::plain(strength, LightSupport::Faces { pixels }),
            None => LightEstimate::plain(clear_day(), LightSupport::ClearDay),
        },
    };
    if let Err(error) = keep(folder, inputs, &estimate, site) {
        task.note(Message::from("the light on trees cannot be cached: ").and(&error));
    }
    Ok(estimate)
}

/// Returns whether photos show what stands in a tree's place: where it replaces objects of the model, or is masked.
fn is_in_photos(project: &Project, tree: &Tree) -> bool {
    let placed = project.trees.placed.get(tree.number as usize);
    placed.is_some_and(|placed| !placed.replaces.is_empty() || masks_of(project, placed).photos > 0)
}

/// Returns whether the trees of a project need an estimate of their light: where no other light is given, and where photos show trees.
pub fn is_needed(project: &Project) -> bool {
    let Trees { placed, light, .. } = &project.trees;
    let is_placed = |name: &str| placed.iter().any(|tree| tree.name == name);
    let shows_tree = |mask: &Mask| match &mask.from {
        MaskOrigin::Tree(MaskedTree { name, .. }) => mask.pixels > 0 && is_placed(name),
        _ => false,
    };
    let is_estimated = light.strength == Strength::Estimated && !placed.is_empty();
    is_estimated
        || (!light.without_photos && project.masks.photos().flat_map(|(_, masks)| masks).any(shows_tree))
}

/// Returns the light of a clear day, which is the same whatever is up.
pub fn clear_day() -> LightStrength {
    let OutdoorLight { sun, sky, ground, .. } = OutdoorLight::day(DVec3::Z);
    let of_day = |light: glam::Vec3| light.as_dvec3().to_array();
    LightStrength { sun: of_day(sun), sky: of_day(sky), ground: of_day(ground) }
}

/// Returns what an estimate depends on of trees. Tints and light that is given go on top of it, and shadows on faces are no part of it.
pub fn estimated_trees(trees: &Trees) -> Trees {
    let placed = trees.placed.iter().map(|tree| PlacedTree { tint: [0.0; 3], casts: false, ..tree.clone() });
    let light = TreeLight { sun: trees.light.sun, ..TreeLight::default() };
    Trees { species: trees.species.clone(), placed: placed.collect(), light }
}

/// Returns the hash of what an estimate depends on: photos and gains (`of_gains`), the model that is left, trees, the plants of
/// their species, the direction to the sun, and masks, whose files never change.
fn inputs(project: &Project, site: &Site, placed: &PlacedTrees, of_gains: &str) -> String {
    let plants: Vec<String> = placed.species.iter().map(|species| plant_hash(&species.plant)).collect();
    let of_trees = (estimated_trees(&project.trees), plants);
    let gains = gains::decisions(&project.colour);
    let model = hash_of_model(&site.model);
    let all = (env!("CARGO_PKG_VERSION"), kept::VERSION, of_gains, gains, model, of_trees, &project.masks);
    hash_bytes(&serde_json::to_vec(&all).expect("plain data is JSON"))
}
