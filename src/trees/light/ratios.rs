//! Ratio images of trees: what blocks of photos show over what is drawn of the trees there in the estimated light.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use super::blocks::TreeInPhoto;
use super::fit::FoliageRatios;
use super::kept::STEPS;
use quadratura_base::scene::Site;
use quadratura_document::trees::LightStrength;
use quadratura_foliage::{PlacedTrees, RATIO_CELLS, RatioImage, Tree};

/// The ratio images of a tree, from the photos that show most of it.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeRatios {
    /// The name of the tree.
    pub tree: String,
    /// The map from its plant's frame to the world. They are of no use once it stands elsewhere.
    pub world_from_plant: DAffine3,
    /// The ratio images, one for each photo.
    pub images: Arc<[RatioImage]>,
}

/// The number of blocks with the photo's mean ratio that are added to each cell: cells that show little of the tree are like the rest.
const MEAN_BLOCKS: f64 = 1.0;

/// Sums over blocks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct BlockSums {
    blocks: f64,
    /// What the photo shows.
    shown: DVec3,
    /// What is drawn.
    drawn: DVec3,
}

impl BlockSums {
    fn and(self, other: &Self, times: f64) -> Self {
        Self {
            blocks: self.blocks + times * other.blocks,
            shown: self.shown + times * other.shown,
            drawn: self.drawn + times * other.drawn,
        }
    }

    /// Returns the logarithm of what is shown over what is drawn, in the steps in which it is kept.
    fn log(&self) -> Vec3 {
        (self.shown / self.drawn).map(f64::ln).as_vec3().map(|log| (log * STEPS).round() / STEPS)
    }
}

/// Gives trees their ratio images, as far as they stand where they stood when these were made.
pub fn set_ratios(placed: &mut PlacedTrees, ratios: &[TreeRatios]) {
    for tree in &mut placed.trees {
        let is_of_it =
            |of: &&TreeRatios| of.tree == tree.name && of.world_from_plant == tree.world_from_plant;
        tree.ratios = ratios.iter().find(is_of_it).map(|of| of.images.clone()).unwrap_or_default();
    }
}

/// Returns the ratio images of trees in light of this strength, from blocks that show foliage.
pub fn ratios(
    shown: &[TreeInPhoto],
    strength: &LightStrength,
    of_foliage: &FoliageRatios,
    site: &Site,
    placed: &PlacedTrees,
) -> Vec<TreeRatios> {
    let of_tree = |index: usize| {
        let of_photos = shown.iter().filter(|of| of.tree == index);
        let images: Arc<[RatioImage]> =
            of_photos.filter_map(|of| ratio_image(of, strength, of_foliage, site)).collect();
        let Tree { name, world_from_plant, .. } = &placed.trees[index];
        let is_any = !images.is_empty();
        is_any.then(|| TreeRatios { tree: name.clone(), world_from_plant: *world_from_plant, images })
    };
    (0..placed.trees.len()).filter_map(of_tree).collect()
}

/// Returns the ratio image of a tree in a photo; `None` where no block tells anything.
fn ratio_image(
    of: &TreeInPhoto,
    strength: &LightStrength,
    of_foliage: &FoliageRatios,
    site: &Site,
) -> Option<RatioImage> {
    let [sun, sky] = [strength.sun, strength.sky].map(DVec3::from_array);
    let (mut cells, mut all) = (vec![BlockSums::default(); RATIO_CELLS * RATIO_CELLS], BlockSums::default());
    for (middle, block) in of.blocks.iter().filter(|(_, block)| of_foliage.holds(block)) {
        let one = BlockSums { blocks: 1.0, shown: block.light, drawn: block.sun * sun + block.sky * sky };
        let cell = |at: f64, first: i32, size: u32| {
            let share = (at - f64::from(first)) / f64::from(size);
            ((share * RATIO_CELLS as f64) as usize).min(RATIO_CELLS - 1)
        };
        let (x, y) = (cell(middle.x, of.rect.x, of.rect.w), cell(middle.y, of.rect.y, of.rect.h));
        let cell = &mut cells[y * RATIO_CELLS + x];
        (*cell, all) = (cell.and(&one, 1.0), all.and(&one, 1.0));
    }
    let is_lit = all.shown.min_element() > 0.0 && all.drawn.min_element() > 0.0;
    is_lit.then(|| {
        let photo = &site.photos[of.photo.index()];
        let logs = cells.iter().map(|cell| cell.and(&all, MEAN_BLOCKS / all.blocks).log());
        RatioImage {
            photo: of.photo,
            camera: photo.camera,
            pose: photo.pose,
            rect: of.rect,
            logs: logs.collect(),
            mean: all.log(),
            blocks: all.blocks,
            share: all.blocks / of.blocks.len() as f64,
        }
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::light::clear_day;
    use crate::light::fit::PixelBlock;
    use crate::light::kept::{keep, kept};
    use crate::light::{LightEstimate, LightSupport};
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::PhotoId;
    use quadratura_base::scene::synthetic::{Scene, Truth, centred, look_at};
    use quadratura_foliage::synthetic::plant_of;
    use quadratura_foliage::{Material, OutdoorLight, PlacedSpecies};

    /// A site of a photo, and a tree.
    fn site_and_trees() -> (Site, PlacedTrees) {
        let scene = Scene {
            name: "tree".into(),
            model: Arc::default(),
            camera: centred(256, 256, 200.0),
            pose: look_at(DVec3::new(0.0, -9.0, 0.0), DVec3::ZERO),
            truth: Truth::Unknown,
        };
        let plant = Arc::new(plant_of(Material::default()));
        let tree = Tree {
            number: 0,
            name: "a".into(),
            species: 0,
            world_from_plant: DAffine3::IDENTITY,
            tint: Vec3::ONE,
            casts: false,
            ratios: Arc::default(),
            sunlit: None,
        };
        let species = vec![PlacedSpecies { plant, unpainted: None, images: None, openness: None }];
        let placed = PlacedTrees { species, trees: vec![tree], light: OutdoorLight::day(DVec3::Z) };
        (Site { photos: vec![scene.photo()], model: Arc::default() }, placed)
    }

    /// Blocks all over a rectangle of 256 x 256 pixels, which show a multiple of what is drawn in the light of a clear day.
    fn in_photo(times: impl Fn(DVec2) -> DVec3) -> TreeInPhoto {
        let LightStrength { sun, sky, .. } = clear_day();
        let [sun, sky] = [sun, sky].map(DVec3::from_array);
        let block = |at: usize| {
            let middle = 8.0 * DVec2::new((at % 32) as f64, (at / 32) as f64) + 4.0;
            let parts = [0.3, 0.2].map(|part| DVec3::splat(part * (1.0 + 0.2 * (at as f64).sin())));
            let light = times(middle) * (parts[0] * sun + parts[1] * sky);
            (middle, PixelBlock { photo: 0, sun: parts[0], sky: parts[1], light })
        };
        let rect = PixelRect { x: 0, y: 0, w: 256, h: 256 };
        TreeInPhoto { tree: 0, photo: PhotoId(0), rect, blocks: (0..1024).map(block).collect() }
    }

    fn found(of: TreeInPhoto) -> Option<RatioImage> {
        let (site, placed) = site_and_trees();
        let blocks: Vec<PixelBlock> = of.blocks.iter().map(|(_, block)| *block).collect();
        let of_foliage = FoliageRatios::of(&blocks)?;
        let mut ratios = ratios(&[of], &clear_day(), &of_foliage, &site, &placed);
        Some(ratios.pop()?.images[0].clone())
    }

    #[test]
    fn cells_tell_how_bright_the_photo_is_in_them() {
        let of_half = |middle: DVec2| if middle.x < 128.0 { DVec3::new(2.0, 1.0, 0.5) } else { DVec3::ONE };
        let ratio = found(in_photo(of_half)).unwrap();
        assert_eq!((ratio.blocks, ratio.share), (1024.0, 1.0));
        // A cell has 4 blocks, and another one of the photo's mean ratio, 1.5 in red.
        let red = |cell: usize| ratio.logs[cell].x.exp();
        assert!((red(0) - (4.0 * 2.0 + 1.5) / 5.0).abs() < 0.01, "{}", red(0));
        assert!((red(15) - (4.0 + 1.5) / 5.0).abs() < 0.01, "{}", red(15));
        assert!((ratio.mean - Vec3::new(1.5, 1.0, 0.75).map(f32::ln)).abs().max_element() < 0.01);
    }

    #[test]
    fn what_is_far_too_bright_for_foliage_does_not_count_and_the_rest_is_believed_less() {
        let with_sky = |middle: DVec2| if middle.y < 64.0 { DVec3::splat(9.0) } else { DVec3::splat(0.8) };
        let ratio = found(in_photo(with_sky)).unwrap();
        assert_eq!((ratio.blocks, ratio.share), (768.0, 0.75));
        // Cells of which nothing is known are like the rest.
        assert!(ratio.logs.iter().all(|log| (log.exp() - 0.8).abs().max_element() < 1e-3));
        assert_eq!(found(in_photo(|_| DVec3::ZERO)), None);
    }

    #[test]
    fn a_tree_that_stands_elsewhere_has_no_ratio_images() {
        let (_, mut placed) = site_and_trees();
        let images: Arc<[RatioImage]> = [found(in_photo(|_| DVec3::ONE)).unwrap()].into();
        let of = TreeRatios { tree: "a".into(), world_from_plant: DAffine3::IDENTITY, images };
        set_ratios(&mut placed, std::slice::from_ref(&of));
        assert_eq!(placed.trees[0].ratios.len(), 1);
        placed.trees[0].world_from_plant.translation.x = 0.1;
        set_ratios(&mut placed, &[of]);
        assert_eq!(placed.trees[0].ratios.len(), 0);
    }

    #[test]
    fn an_estimate_that_was_kept_is_the_same_and_one_that_is_damaged_or_of_other_inputs_is_none() {
        let (site, placed) = site_and_trees();
        let images: Arc<[RatioImage]> =
            [found(in_photo(|middle| DVec3::splat(0.5 + middle.x / 200.0))).unwrap()].into();
        let ratios = vec![TreeRatios { tree: "a".into(), world_from_plant: DAffine3::IDENTITY, images }];
        let support = LightSupport::Photos { photos: 1, blocks: 1024, residual: 0.25, split: false };
        let estimate = LightEstimate { strength: clear_day(), support, ratios };
        let folder = tempfile::tempdir().unwrap();
        keep(folder.path(), "inputs".into(), &estimate, &site).unwrap();
        let read = |inputs: &str| kept(folder.path(), inputs, &site, &placed);
        assert_eq!(read("inputs"), Some(estimate));
        assert_eq!(read("others"), None);
        let file = folder.path().join("cache/tree-light.json");
        let text = std::fs::read_to_string(&file).unwrap();
        let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
        let image = &json["ratios"][0]["images"][0];
        assert_eq!(image["logs"].as_array().unwrap().len(), 768);
        let damaged: [(&str, serde_json::Value); 5] = [
            ("photo", "none".into()),
            ("share", 1.5.into()),
            ("blocks", 0.into()),
            ("mean", serde_json::json!([99, 0, 0])),
            ("logs", serde_json::json!([1, 2, 3])),
        ];
        for (field, value) in damaged {
            let before = std::mem::replace(&mut json["ratios"][0]["images"][0][field], value);
            std::fs::write(&file, json.to_string()).unwrap();
            assert_eq!(read("inputs"), None, "{field}");
            json["ratios"][0]["images"][0][field] = before;
        }
    }
}
