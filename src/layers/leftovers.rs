//! Leftovers: faces of the working set that a photo shows so little of that an image layer of their own would be
//! nothing but hidden pixels. They stay in the working set, in their elements and visibility layers; only image layers
//! leave them out.

use rayon::prelude::*;

use super::constraints::ResolvedConstraints;
use super::content::PixelSpan;
use super::nodes::Nodes;
use super::options::Options;
use super::projected_model::ProjectedModel;
use super::runs::{Run, Runs, is_visible, item_of};
use quadratura_base::scene::{FaceId, Model};

/// A face of which a photo shows little.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BarelyVisible {
    /// The face.
    pub face: FaceId,
    /// The number of pixels at which the photo shows it.
    pub visible_px: u64,
    /// The number of pixels that it covers.
    pub covered_px: u64,
    /// The first pixel, by rows, at which the photo shows it.
    pub first_px: [u32; 2],
}

/// The faces that get no image layer because the photo barely shows them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Leftovers {
    /// The faces without an image layer, in the model's order.
    pub faces: Vec<BarelyVisible>,
    /// The faces that are as little visible and keep their image layers, because a decision or paint concerns
    /// them; in the model's order.
    pub spared: Vec<FaceId>,
    /// True for each node that is in no image layer.
    pub nodes: Vec<bool>,
    /// The pixels at which the photo shows leftovers and nothing that is in an image layer: disjoint spans, rising.
    pub spans: Vec<PixelSpan>,
}

/// The pixels of an item. What is seen through see-through items alone counts as visible: where these are empty, it is.
#[derive(Clone, Copy, Default)]
struct PixelCounts {
    visible_px: u64,
    covered_px: u64,
    /// The first visible one, row by row.
    first_px: Option<[u32; 2]>,
}

impl Leftovers {
    /// Finds the faces that are visible at fewer than `min_visible` pixels and at less than `min_share` of the
    /// pixels that they cover. All pieces and triangles of a face count together.
    pub fn find(
        model: &Model,
        view: &ProjectedModel,
        runs: &Runs,
        nodes: &Nodes,
        options: &Options,
        wanted: &ResolvedConstraints,
    ) -> Self {
        let pixels = pixels_of_items(view, runs);
        let mut leftovers = Self { nodes: vec![false; nodes.list.len()], ..Self::default() };
        let mut is_left_over = vec![false; view.items.len()];
        let mut first = 0;
        for group in view.items.chunk_by(|a, b| a.face == b.face) {
            let items = first..first + group.len();
            first = items.end;
            let PixelCounts { visible_px, covered_px, first_px } =
                pixels[items.clone()].iter().fold(PixelCounts::default(), sum);
            let Some(first_px) = first_px else { continue };
            let face = group[0].face;
            let object = &model.object(model.face(face).object).name;
            let (least_px, least_share) = options.least_visible(object);
            let share = visible_px as f64 / covered_px as f64;
            if visible_px >= u64::from(least_px) || share >= f64::from(least_share) {
                continue;
            }
            if wanted.keeps(face) {
                leftovers.spared.push(face);
            } else {
                leftovers.faces.push(BarelyVisible { face, visible_px, covered_px, first_px });
                is_left_over[items].fill(true);
            }
        }
        for (left_over, node) in leftovers.nodes.iter_mut().zip(&nodes.list) {
            *left_over = is_left_over[node.item as usize];
        }
        if !leftovers.faces.is_empty() {
            leftovers.spans = spans(view, runs, nodes, &is_left_over);
        }
        leftovers
    }
}

/// Adds the pixels of two items.
fn sum(a: PixelCounts, b: &PixelCounts) -> PixelCounts {
    let by_rows = |[x, y]: [u32; 2]| (y, x);
    PixelCounts {
        visible_px: a.visible_px + b.visible_px,
        covered_px: a.covered_px + b.covered_px,
        first_px: [a.first_px, b.first_px].into_iter().flatten().min_by_key(|at| by_rows(*at)),
    }
}

/// Counts the pixels of every item.
fn pixels_of_items(view: &ProjectedModel, runs: &Runs) -> Vec<PixelCounts> {
    let none = || vec![PixelCounts::default(); view.items.len()];
    let count = |mut pixels: Vec<PixelCounts>, (y, row): (usize, &super::runs::RowRuns)| {
        for run in &row.runs {
            let entries = row.entries(run);
            let seen_through = seen_through(view, [run.x0, y as u32], entries);
            for &entry in entries {
                let visible = is_visible(entry) || seen_through == Some(item_of(entry));
                let px = u64::from(run.len());
                let of_run = PixelCounts {
                    visible_px: if visible { px } else { 0 },
                    covered_px: px,
                    first_px: visible.then_some([run.x0, y as u32]),
                };
                let pixels = &mut pixels[item_of(entry) as usize];
                *pixels = sum(*pixels, &of_run);
            }
        }
        pixels
    };
    let unite = |mut a: Vec<PixelCounts>, b: Vec<PixelCounts>| {
        a.iter_mut().zip(&b).for_each(|(a, b)| *a = sum(*a, b));
        a
    };
    runs.rows.par_iter().enumerate().fold(none, count).reduce(none, unite)
}

/// Returns the item that is the nearest solid one at the first pixel of a run that shows nothing but see-through items.
fn seen_through(view: &ProjectedModel, [x, y]: [u32; 2], entries: &[u32]) -> Option<u32> {
    let sees_through = |entry: &u32| view.items[item_of(*entry) as usize].see_through;
    if !entries.iter().filter(|entry| is_visible(**entry)).all(sees_through) {
        return None;
    }
    let solid = entries.iter().filter(|entry| !sees_through(entry)).map(|entry| item_of(*entry));
    let depth = |item: &u32| view.items[*item as usize].inverse_depth.at(x, y);
    solid.max_by(|a, b| depth(a).total_cmp(&depth(b)))
}

/// Returns the pixels at which a leftover is visible and no node that is in an image layer.
fn spans(view: &ProjectedModel, runs: &Runs, nodes: &Nodes, is_left_over: &[bool]) -> Vec<PixelSpan> {
    let mut spans: Vec<PixelSpan> = Vec::new();
    for (y, run, entries) in runs.iter() {
        let visible = || entries.iter().filter(|&&entry| is_visible(entry)).map(|&entry| item_of(entry));
        if !visible().any(|item| is_left_over[item as usize]) {
            continue;
        }
        let in_layer = |x: u32| {
            visible().any(|item| !is_left_over[item as usize] && nodes.at(view, item, x, y).is_some())
        };
        for x in columns(&run).filter(|&x| !in_layer(x)) {
            match spans.last_mut() {
                Some(last) if last.y == y && last.x1 == x => last.x1 += 1,
                _ => spans.push(PixelSpan { y, x0: x, x1: x + 1 }),
            }
        }
    }
    spans
}

fn columns(run: &Run) -> std::ops::Range<u32> {
    run.x0..run.x1
}
