//! The estimate of the light on trees in `cache/tree-light.json`.

use std::path::{Path, PathBuf};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{LightEstimate, LightSupport, TreeRatios};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Site;
use quadratura_document::trees::LightStrength;
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::{read_json, to_json};
use quadratura_foliage::{PlacedTrees, RATIO_CELLS, RatioImage};

/// The version of the file's format and of the method.
pub const VERSION: u32 = 4;
/// The largest size of the file that is read, in bytes: some thousands of ratio images of 8 KB.
const LARGEST: u64 = 1 << 28;
/// The steps of a logarithm in the file: 0.1 % of light.
pub const STEPS: f32 = 1000.0;
/// The largest logarithm of a ratio that can be: light does not differ by more.
const LARGEST_LOG: f32 = 20.0;
/// The largest number of blocks of a photo that can be.
const MOST_BLOCKS: f64 = 1e9;

/// The file.
#[derive(Debug, Serialize, Deserialize)]
struct KeptLight {
    version: u32,
    /// The hash of everything that the estimate was made from.
    inputs: String,
    strength: LightStrength,
    support: LightSupport,
    ratios: Vec<KeptRatios>,
}

/// The ratio images of a tree.
#[derive(Debug, Serialize, Deserialize)]
struct KeptRatios {
    tree: String,
    images: Vec<KeptImage>,
}

/// A ratio image.
#[derive(Debug, Serialize, Deserialize)]
struct KeptImage {
    photo: String,
    /// The part of the photo in pixels: x, y, width, height.
    rect: (i32, i32, u32, u32),
    /// The logarithms in steps of 1/[`STEPS`]: R, G, B of each cell, row by row.
    logs: Vec<i32>,
    /// The logarithm of the ratio of all blocks, R, G, B.
    mean: [f32; 3],
    /// The blocks that show foliage, and their share in all.
    blocks: f64,
    share: f64,
}

fn file(folder: &Path) -> PathBuf {
    folder.join("cache/tree-light.json")
}

/// Returns the estimate that was kept, if it was made from the same inputs.
pub fn kept(folder: &Path, inputs: &str, site: &Site, placed: &PlacedTrees) -> Option<LightEstimate> {
    let kept: KeptLight = read_json(&file(folder), LARGEST, "it is computed again").ok()?;
    if kept.version != VERSION || kept.inputs != inputs {
        return None;
    }
    let image = |KeptImage { photo, rect: (x, y, w, h), logs, mean, blocks, share }: &KeptImage| {
        let (id, photo) = site.numbered_photos().find(|(_, of)| of.name == *photo)?;
        let log = |log: &[i32; 3]| Vec3::from_array(log.map(|log| log as f32 / STEPS));
        let image = RatioImage {
            photo: id,
            camera: photo.camera,
            pose: photo.pose,
            rect: PixelRect { x: *x, y: *y, w: *w, h: *h },
            logs: logs.as_chunks().0.iter().map(log).collect(),
            mean: Vec3::from_array(*mean),
            blocks: *blocks,
            share: *share,
        };
        let is_whole = logs.len() == 3 * RATIO_CELLS * RATIO_CELLS && !image.rect.is_empty();
        let is_ratio = |log: &Vec3| log.abs().max_element() <= LARGEST_LOG;
        let is_sound = *blocks > 0.0 && *blocks <= MOST_BLOCKS && *share > 0.0 && *share <= 1.0;
        let is_sound = is_sound && image.logs.iter().chain([&image.mean]).all(is_ratio);
        (is_whole && is_sound).then_some(image)
    };
    let of_tree = |KeptRatios { tree, images }: &KeptRatios| {
        let placed = placed.trees.iter().find(|of| of.name == *tree)?;
        let images = images.iter().map(image).collect::<Option<_>>()?;
        Some(TreeRatios { tree: tree.clone(), world_from_plant: placed.world_from_plant, images })
    };
    let ratios = kept.ratios.iter().map(of_tree).collect::<Option<_>>()?;
    Some(LightEstimate { strength: kept.strength, support: kept.support, ratios })
}

/// Keeps an estimate.
///
/// # Errors
/// [`Error::Io`].
pub fn keep(folder: &Path, inputs: String, estimate: &LightEstimate, site: &Site) -> Result<()> {
    let file = file(folder);
    let cache = file.parent().expect("it lies in cache/");
    std::fs::create_dir_all(cache).map_err(Error::io(cache, "create the folder"))?;
    let image = |image: &RatioImage| {
        let RatioImage { photo, rect: PixelRect { x, y, w, h }, logs, mean, blocks, share, .. } = image;
        let logs = logs.iter().flat_map(|log| log.to_array());
        KeptImage {
            photo: site.photos[photo.index()].name.clone(),
            rect: (*x, *y, *w, *h),
            logs: logs.map(|log| (log * STEPS).round() as i32).collect(),
            mean: mean.to_array(),
            blocks: *blocks,
            share: *share,
        }
    };
    let of_tree = |TreeRatios { tree, images, .. }: &TreeRatios| KeptRatios {
        tree: tree.clone(),
        images: images.iter().map(image).collect(),
    };
    let LightEstimate { strength, support, ratios } = estimate;
    let ratios = ratios.iter().map(of_tree).collect();
    let kept = KeptLight { version: VERSION, inputs, strength: *strength, support: *support, ratios };
    write_atomically(&file, &to_json(&kept))
}
