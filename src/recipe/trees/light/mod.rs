//! The light on the trees of a site, estimated from its photos.
//!
//! Photos that show the real trees are compared with the placed ones (`blocks`, `fit`); where no photo shows one, the model
//! beside the trees tells how bright it is (`faces`). The estimate is kept in `cache/`.

mod blocks;
mod faces;
mod fit;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use self::blocks::blocks;
use self::faces::light_of_faces;
use self::fit::{Fit, fit};
use crate::document::trees::LightStrength;
use crate::document::{Project, Stack};
use crate::error::{Error, Message, Result};
use crate::foliage::{Light, Wood};
use crate::io::atomic::write_atomically;
use crate::io::hash::hash_bytes;
use crate::io::json::{read_json, to_json};
use crate::io::plant_images::plant_hash;
use crate::io::stack_store::StackStore;
use crate::recipe::budget::default_memory;
use crate::recipe::gains;
use crate::recipe::inputs::hash_of_model;
use crate::recipe::open::Opened;
use crate::scene::{Photo, Site};
use crate::task::Task;

/// An estimate of the light on trees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LightEstimate {
    /// What sun, sky and ground give.
    pub strength: LightStrength,
    /// What it is from.
    pub support: LightSupport,
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

/// The cached estimate in `cache/tree-light.json`.
#[derive(Debug, Serialize, Deserialize)]
struct CachedLight {
    version: u32,
    /// The hash of everything that the estimate was made from.
    inputs: String,
    estimate: LightEstimate,
}

/// The version of the cache file's format and of the method.
const VERSION: u32 = 2;
/// The largest size of the cache file that is read, in bytes.
const LARGEST: u64 = 1 << 20;

/// Returns the estimate of the light on the trees of an opened project: the one in `cache/` if it was made from the same photos,
/// masks and trees, else a new one, which is kept there. `wood` is what is drawn of the trees.
///
/// # Errors
/// [`Error::Cancelled`], and [`Error::Input`] and [`Error::Io`] for masks that cannot be read. A cache that cannot be written is
/// noted.
pub fn estimated_light(folder: &Path, opened: &Opened, wood: &Wood, task: &Task) -> Result<LightEstimate> {
    let store = StackStore::new(folder);
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten();
    let stacks: Vec<Option<Stack>> = opened.site.photos.iter().map(stack).collect();
    let file = folder.join("cache/tree-light.json");
    let inputs = inputs(&opened.project, &opened.site, wood, &gains::inputs(&opened.site, &stacks));
    if let Some(kept) = kept(&file, &inputs) {
        return Ok(kept);
    }
    let memory = default_memory();
    let gains = gains::photo_gains(&opened.site, &stacks, &opened.project.colour, folder, memory, task)?;
    let estimate = match fit(&blocks(folder, opened, wood, &gains, task)?) {
        Some(Fit { strength, photos, blocks, residual, is_split: split }) => {
            LightEstimate { strength, support: LightSupport::Photos { photos, blocks, residual, split } }
        }
        None => match light_of_faces(&opened.site, wood, &gains, task)? {
            Some((strength, pixels)) => LightEstimate { strength, support: LightSupport::Faces { pixels } },
            None => LightEstimate { strength: clear_day(), support: LightSupport::ClearDay },
        },
    };
    if let Err(error) = keep(&file, inputs, &estimate) {
        task.note(Message::from("the light on trees cannot be cached: ").and(&error));
    }
    Ok(estimate)
}

/// Returns the light of a clear day, which is the same whatever is up.
pub fn clear_day() -> LightStrength {
    let Light { sun, sky, ground, .. } = Light::day(DVec3::Z);
    let of_day = |light: glam::Vec3| light.as_dvec3().to_array();
    LightStrength { sun: of_day(sun), sky: of_day(sky), ground: of_day(ground) }
}

/// Returns the hash of what an estimate depends on: photos and gains (`of_gains`), the model that is left, trees, the plants of
/// their species, the direction to the sun, and masks, whose files never change.
fn inputs(project: &Project, site: &Site, wood: &Wood, of_gains: &str) -> String {
    let plants: Vec<String> = wood.species.iter().map(|species| plant_hash(&species.plant)).collect();
    let trees = &project.trees;
    let of_trees = (&trees.species, &trees.placed, trees.light.sun, plants);
    let gains = gains::decisions(&project.colour);
    let model = hash_of_model(&site.model);
    let all = (env!("CARGO_PKG_VERSION"), VERSION, of_gains, gains, model, of_trees, &project.masks);
    hash_bytes(&serde_json::to_vec(&all).expect("plain data is JSON"))
}

fn kept(file: &Path, inputs: &str) -> Option<LightEstimate> {
    let kept: CachedLight = read_json(file, LARGEST, "it is computed again").ok()?;
    (kept.version == VERSION && kept.inputs == inputs).then_some(kept.estimate)
}

fn keep(file: &Path, inputs: String, estimate: &LightEstimate) -> Result<()> {
    let folder = file.parent().expect("it lies in cache/");
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let kept = CachedLight { version: VERSION, inputs, estimate: estimate.clone() };
    write_atomically(file, &to_json(&kept))
}
