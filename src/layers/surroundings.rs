//! The surroundings: what a photo shows where no face of the model is, such as sky, hills and far houses. They hide
//! nothing, lie behind everything, and cover every pixel of the photo.

use super::cluster::{box_size, place_box, split_into_patches};
use super::constraints::LayerConstraints;
use super::content::{Content, PixelSpan};
use super::options::Options;
use super::runs::{RowRuns, Run, Runs, item_of};
use super::sort::Sorted;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::PhotoPixels;
use quadratura_base::scene::builder::SURROUNDINGS;

/// What a photo shows of the surroundings.
#[derive(Debug, Clone, PartialEq)]
pub enum Surroundings {
    /// Nothing: there is a face at each pixel at which the photo is valid.
    Nothing,
    /// So little that an image layer would be nothing but hidden pixels: these pixels, disjoint spans, rising, belong
    /// to the leftovers.
    LeftOver(Vec<PixelSpan>),
    /// Image layers: one, unless it were longer than image layers may be.
    Layers {
        /// The layers.
        layers: Vec<SurroundingsLayer>,
        /// Whether they are as little visible as leftovers, and are kept because of paint or a decision.
        spared: bool,
    },
}

/// An image layer of the surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct SurroundingsLayer {
    /// The rectangle in photo pixels; it may reach outside the photo.
    pub rect: PixelRect,
    /// Its visible and its needed pixels.
    pub content: Content,
}

impl Surroundings {
    /// Finds the surroundings of a photo with this rectangle. They are visible where no face is and `pixels` are valid,
    /// and needed within `reach` of that and wherever nothing but see-through surfaces is in front of them. Little visible surroundings are kept if a face
    /// to keep in `constraints` has their name.
    pub fn find(
        sorted: &Sorted,
        photo: PixelRect,
        pixels: &PhotoPixels,
        options: &Options,
        constraints: &LayerConstraints,
    ) -> Self {
        let runs = &sorted.runs;
        let visible = valid(&without_face(runs, photo), pixels);
        let behind = behind_see_through(sorted, photo);
        // What is seen through see-through surfaces alone may be visible.
        let open = visible.union(&valid(&behind, pixels));
        if open.is_empty() {
            return Self::Nothing;
        }
        let needed = needed(&visible, photo, options.reach).union(&behind);
        let (least_px, least_share) = options.least_visible(SURROUNDINGS);
        let share = open.count() as f64 / needed.count() as f64;
        let is_little = open.count() < u64::from(least_px) && share < f64::from(least_share);
        let is_kept = constraints.keep.iter().any(|faces| faces.object == SURROUNDINGS);
        if is_little && !is_kept {
            return Self::LeftOver(spans_within(&visible, photo));
        }
        let patches = split_into_patches(&[needed.bounds()], options);
        let layers = patches.into_iter().filter_map(|patch| {
            let content = Content {
                needed: spans_within(&needed, patch.bounds),
                visible: spans_within(&visible, patch.bounds),
                ..Content::default()
            };
            let rect = place_box(patch.bounds, box_size(patch.bounds, options), photo);
            (!content.needed.is_empty()).then_some(SurroundingsLayer { rect, content })
        });
        Self::Layers { layers: layers.collect(), spared: is_little }
    }

    /// Returns the contents of the image layers.
    pub fn contents(&self) -> impl Iterator<Item = &Content> {
        let layers = match self {
            Self::Layers { layers, .. } => &layers[..],
            Self::Nothing | Self::LeftOver(_) => &[],
        };
        layers.iter().map(|layer| &layer.content)
    }
}

/// Returns the pixels of the photo without any fragment.
fn without_face(runs: &Runs, photo: PixelRect) -> Spans {
    let empty = RowRuns::default();
    let covered = Spans::from_rows(photo.y..photo.bottom(), |y, out| {
        let row = runs.rows.get(y as usize).unwrap_or(&empty);
        out.extend(row.runs.iter().map(|run| run.x0 as i32..run.x1 as i32));
    });
    covered.complement(photo)
}

/// Returns the pixels of the photo with see-through items alone.
fn behind_see_through(Sorted { view, runs, .. }: &Sorted, photo: PixelRect) -> Spans {
    let empty = RowRuns::default();
    Spans::from_rows(photo.y..photo.bottom(), |y, out| {
        let row = runs.rows.get(y as usize).unwrap_or(&empty);
        let sees_through = |&entry: &u32| view.items[item_of(entry) as usize].see_through;
        let is_open = |run: &&Run| row.entries(run).iter().all(sees_through);
        out.extend(row.runs.iter().filter(is_open).map(|run| run.x0 as i32..run.x1 as i32));
    })
}

/// Returns the pixels at which the photo is valid.
fn valid(open: &Spans, pixels: &PhotoPixels) -> Spans {
    if !pixels.has_alpha() {
        return open.clone();
    }
    Spans::from_rows(open.rows(), |y, out| {
        for run in open.row(y) {
            let columns = run.clone().filter(|&x| pixels.is_valid(x as u32, y as u32));
            out.extend(columns.map(|x| x..x + 1));
        }
    })
}

/// Returns the pixels of the photo within `reach` of the visible ones, as a share of its longer side.
fn needed(visible: &Spans, photo: PixelRect, reach: f32) -> Spans {
    let whole = Spans::default().complement(photo);
    if reach >= 1.0 {
        return whole;
    }
    let by = (f64::from(reach) * f64::from(photo.w.max(photo.h))).round() as i32;
    visible.grown(by).intersection(&whole)
}

/// Converts the part of a set within a rectangle of the photo.
fn spans_within(set: &Spans, rect: PixelRect) -> Vec<PixelSpan> {
    let inside = set.iter().filter(|(y, _)| (rect.y..rect.bottom()).contains(y));
    let cut = inside.map(|(y, run)| (y, run.start.max(rect.x)..run.end.min(rect.right())));
    cut.filter(|(_, run)| !run.is_empty())
        .map(|(y, run)| PixelSpan { y: y as u32, x0: run.start as u32, x1: run.end as u32 })
        .collect()
}
