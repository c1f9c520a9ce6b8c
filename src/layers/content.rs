//! The content of each image layer: which of its texels some element covers, and which of these the photo
//! shows. Content is stored as spans of pixels, not as images; colours are read from the photo when files are
//! written.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::cluster::Clusters;
use super::nodes::Nodes;
use super::parts::Layers;
use super::projected_model::ProjectedModel;
use super::runs::{Run, Runs, is_visible, item_of};
use crate::ElementIndex;
use quadratura_base::geometry::{PixelRect, Spans};

/// A span of pixels: columns `x0..x1` of row `y` of the photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PixelSpan {
    /// The row.
    pub y: u32,
    /// The first column.
    pub x0: u32,
    /// One past the last column.
    pub x1: u32,
}

/// The content of one image layer, in photo pixels.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Content {
    /// The pixels covered by some element of the layer: disjoint spans, rising.
    pub needed: Vec<PixelSpan>,
    /// The covered pixels that are visible: disjoint spans, rising, within `needed`.
    pub visible: Vec<PixelSpan>,
    /// Per element of the layer, the number of texels that it covers and the number of these that the photo
    /// shows.
    pub texels_of: BTreeMap<ElementIndex, [u64; 2]>,
}

impl Content {
    /// Returns the number of covered texels.
    pub fn texels_used(&self) -> u64 {
        count(&self.needed)
    }

    /// Returns the number of covered texels that are visible.
    pub fn texels_visible(&self) -> u64 {
        count(&self.visible)
    }

    /// Returns the bleed pixels: those of a photo of this width and height that lie one pixel outside the
    /// visible part, or one pixel outside the covered part. They show other surfaces, and serve to extend
    /// colours past outlines. The spans rise; they may overlap, and may include visible pixels.
    pub fn beside(&self, [width, height]: [u32; 2]) -> Vec<PixelSpan> {
        let photo = PixelRect::of_size(width, height);
        let ring = |spans: &[PixelSpan]| {
            let inside = as_set(spans);
            inside.grown(1).minus(&inside)
        };
        let rings = [ring(&self.visible), ring(&self.needed)];
        rings.iter().flat_map(|ring| ring.iter()).filter_map(|(y, run)| span_within(y, run, photo)).collect()
    }

    /// Returns the bounding box of `needed`; empty where nothing is covered.
    pub fn needed_rect(&self) -> PixelRect {
        let boxes = self
            .needed
            .iter()
            .map(|s| PixelRect::from_edges(s.x0 as i32, s.y as i32, s.x1 as i32, s.y as i32 + 1));
        boxes.reduce(|a, b| a.union(&b)).unwrap_or(PixelRect::EMPTY)
    }
}

/// Converts rising spans to a set.
fn as_set(spans: &[PixelSpan]) -> Spans {
    let Some((first, last)) = spans.first().zip(spans.last()) else { return Spans::default() };
    let mut rest = spans.iter().peekable();
    Spans::from_rows(first.y as i32..last.y as i32 + 1, |y, out| {
        while let Some(span) = rest.next_if(|span| span.y as i32 == y) {
            out.push(span.x0 as i32..span.x1 as i32);
        }
    })
}

fn span_within(y: i32, run: &Range<i32>, rect: PixelRect) -> Option<PixelSpan> {
    let (x0, x1) = (run.start.max(rect.x), run.end.min(rect.right()));
    let inside = (rect.y..rect.bottom()).contains(&y) && x0 < x1;
    inside.then_some(PixelSpan { y: y as u32, x0: x0 as u32, x1: x1 as u32 })
}

fn count(spans: &[PixelSpan]) -> u64 {
    spans.iter().map(|s| u64::from(s.x1 - s.x0)).sum()
}

/// Computes the content of every image layer, in the order of the clusters. `left_over` tells for each node whether it
/// is in no image layer.
pub fn contents(
    view: &ProjectedModel,
    runs: &Runs,
    nodes: &Nodes,
    layers: &Layers,
    left_over: &[bool],
    clusters: &Clusters,
) -> Vec<Content> {
    let patches_of = patches_by_element(layers, clusters);
    let sorter = Sorter { view, nodes, layers, left_over, patches_of: &patches_of };
    // Chunks of rows are processed in parallel and joined from the top, so that the result is the same for
    // any number of threads.
    let per_chunk: Vec<Vec<Content>> = runs
        .rows
        .par_chunks(64)
        .enumerate()
        .map(|(chunk, rows)| {
            let mut contents = vec![Content::default(); clusters.list.len()];
            for (i, row) in rows.iter().enumerate() {
                let y = (chunk * 64 + i) as u32;
                row.runs.iter().for_each(|run| sorter.sort(&mut contents, y, run, row.entries(run)));
            }
            contents.iter_mut().for_each(|c| {
                unite(&mut c.needed);
                unite(&mut c.visible);
            });
            contents
        })
        .collect();
    let mut all = vec![Content::default(); clusters.list.len()];
    for chunk in per_chunk {
        for (content, part) in all.iter_mut().zip(chunk) {
            content.needed.extend(part.needed);
            content.visible.extend(part.visible);
            for (element, more) in part.texels_of {
                let texels = content.texels_of.entry(element).or_default();
                *texels = [0, 1].map(|i| texels[i] + more[i]);
            }
        }
    }
    all
}

/// Lists the patches of every element: their bounds and the index of their cluster.
fn patches_by_element(layers: &Layers, clusters: &Clusters) -> Vec<Vec<(PixelRect, u32)>> {
    let mut patches_of = vec![Vec::new(); layers.elements.len()];
    for (c, cluster) in clusters.list.iter().enumerate() {
        for patch in &cluster.patches {
            patches_of[patch.element.index()].push((patch.bounds, c as u32));
        }
    }
    patches_of
}

struct Sorter<'a> {
    view: &'a ProjectedModel,
    nodes: &'a Nodes,
    layers: &'a Layers,
    left_over: &'a [bool],
    patches_of: &'a [Vec<(PixelRect, u32)>],
}

impl Sorter<'_> {
    fn sort(&self, contents: &mut [Content], y: u32, run: &Run, entries: &[u32]) {
        for &entry in entries {
            let item = item_of(entry);
            if self.nodes.is_cut(item) {
                self.sort_cut(contents, y, run, entry);
            } else if let Some(node) = self.nodes.of_whole(item) {
                let span = PixelSpan { y, x0: run.x0, x1: run.x1 };
                self.put(contents, node.0, span, is_visible(entry));
            }
        }
    }

    /// Sorts a run of a cut item: it is divided where the node changes.
    fn sort_cut(&self, contents: &mut [Content], y: u32, run: &Run, entry: u32) {
        let node_at = |x: u32| self.nodes.at(self.view, item_of(entry), x, y);
        let mut x0 = run.x0;
        while x0 < run.x1 {
            let node = node_at(x0);
            let x1 = (x0 + 1..run.x1).find(|&x| node_at(x) != node).unwrap_or(run.x1);
            if let Some(node) = node {
                self.put(contents, node.0, PixelSpan { y, x0, x1 }, is_visible(entry));
            }
            x0 = x1;
        }
    }

    fn put(&self, contents: &mut [Content], node: u32, span: PixelSpan, visible: bool) {
        if self.left_over[node as usize] {
            return;
        }
        let element = self.layers.element_of[node as usize];
        let patches = &self.patches_of[element.index()];
        if let [(_, cluster)] = patches[..] {
            return push(&mut contents[cluster as usize], element, span, visible);
        }
        for (bounds, cluster) in patches {
            let x0 = span.x0.max(bounds.x as u32);
            let x1 = span.x1.min(bounds.right() as u32);
            let inside = (bounds.y..bounds.bottom()).contains(&(span.y as i32));
            if inside && x0 < x1 {
                push(&mut contents[*cluster as usize], element, PixelSpan { x0, x1, ..span }, visible);
            }
        }
    }
}

fn push(content: &mut Content, element: ElementIndex, span: PixelSpan, visible: bool) {
    let length = u64::from(span.x1 - span.x0);
    let [covered, visible_texels] = content.texels_of.entry(element).or_default();
    *covered += length;
    *visible_texels += if visible { length } else { 0 };
    content.needed.push(span);
    if visible {
        content.visible.push(span);
    }
}

/// Sorts spans and joins overlapping and adjacent ones, so that they are disjoint and rising.
fn unite(spans: &mut Vec<PixelSpan>) {
    spans.sort_unstable();
    let mut united: Vec<PixelSpan> = Vec::with_capacity(spans.len());
    for span in spans.drain(..) {
        match united.last_mut() {
            Some(last) if last.y == span.y && last.x1 >= span.x0 => last.x1 = last.x1.max(span.x1),
            _ => united.push(span),
        }
    }
    *spans = united;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_and_touching_spans_become_one() {
        let span = |y, x0, x1| PixelSpan { y, x0, x1 };
        let mut spans = vec![span(1, 0, 2), span(0, 4, 9), span(0, 0, 5), span(0, 9, 10), span(1, 3, 4)];
        unite(&mut spans);
        assert_eq!(spans, [span(0, 0, 10), span(1, 0, 2), span(1, 3, 4)]);
    }

    #[test]
    fn beside_an_outline_lie_the_photos_own_pixels_one_away() {
        let span = |y, x0, x1| PixelSpan { y, x0, x1 };
        // Two rows at the photo's left edge; of the second row one pixel is hidden.
        let content = Content {
            needed: vec![span(1, 0, 3), span(2, 0, 3)],
            visible: vec![span(1, 0, 3), span(2, 0, 2)],
            ..Content::default()
        };
        let mut beside = content.beside([10, 3]);
        unite(&mut beside);
        assert_eq!(beside, [span(0, 0, 4), span(1, 3, 4), span(2, 2, 4)]);
        assert!(Content::default().beside([10, 3]).is_empty());
    }
}
