//! Image layers: elements share a rectangle of the photo where that costs no texels.

use std::cmp::Reverse;

use super::graph::Graph;
use super::options::{BoxShape, Options};
use super::parts::Layers;
use super::quotient::Quotient;
use crate::geometry::PixelRect;
use crate::scene::Model;

/// The part of an element that lies in one image layer: all of it, unless the element is larger
/// than the largest side allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// The element, in reading order of the visibility layers.
    pub element: u32,
    /// Whole pixels of the photo; patches of one element do not overlap.
    pub bounds: PixelRect,
}

/// A rectangle of the photo with the patches it textures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    /// Its place in the stack: the longest path of occlusions that leads to it, 0 nearest.
    pub order: u32,
    /// May reach outside the photo.
    pub rect: PixelRect,
    /// By element.
    pub patches: Vec<Patch>,
}

/// The image layers of a photo, by order, then by first element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clusters {
    /// By order, then by first element.
    pub list: Vec<Cluster>,
}

/// Merges the elements' boxes. `bounds` are the elements' outlines in whole pixels.
///
/// Patches come by falling box area (ties: object name, first node). Each joins the cluster whose
/// box holds the union and whose bounding box grows least, if no path of occlusions leads between
/// the two either way and no forgiven pair is shared; else it starts a cluster. With powers of two
/// that is the rule A12 < A1 + A2 of 2003; `published` restricts it to one visibility layer.
pub fn cluster(
    model: &Model,
    layers: &Layers,
    bounds: &[PixelRect],
    photo: PixelRect,
    options: &Options,
) -> Clusters {
    let mut patches = split_into_patches(bounds, options);
    let name = |p: &Patch| &model.object(layers.elements[p.element as usize].object).name;
    patches.sort_by_key(|p| {
        let area = box_size(p.bounds, options).area();
        (Reverse(area), name(p), layers.elements[p.element as usize].nodes[0], p.bounds.y, p.bounds.x)
    });
    let mut merging = Merging::new(layers, patches, options);
    (0..merging.patches.len() as u32).for_each(|p| merging.place(p));
    Clusters { list: merging.finish(photo) }
}

/// Smaller tiles would be nothing but margin.
pub const SMALLEST_TILE: u32 = 64;

/// Elements whose bounds exceed the largest side are tiled.
fn split_into_patches(bounds: &[PixelRect], options: &Options) -> Vec<Patch> {
    let most = options.largest_side.max(SMALLEST_TILE);
    let most = match options.boxes {
        BoxShape::Exact => most,
        BoxShape::PowerOfTwo => 1 << most.ilog2(),
    };
    let side = most.saturating_sub(2 * options.margin).max(SMALLEST_TILE / 2) as usize;
    let mut patches = Vec::with_capacity(bounds.len());
    for (element, b) in bounds.iter().enumerate() {
        for y in (b.y..b.bottom()).step_by(side) {
            for x in (b.x..b.right()).step_by(side) {
                let tile = PixelRect { x, y, w: side as u32, h: side as u32 };
                patches.push(Patch { element: element as u32, bounds: tile.intersection(b) });
            }
        }
    }
    patches
}

/// The box of some bounds, at the origin: with the margin, and powers of two if so wished.
pub(super) fn box_size(bounds: PixelRect, options: &Options) -> PixelRect {
    let grown = bounds.grown(options.margin);
    match options.boxes {
        BoxShape::Exact => PixelRect { x: 0, y: 0, ..grown },
        BoxShape::PowerOfTwo => {
            PixelRect { x: 0, y: 0, w: grown.w.next_power_of_two(), h: grown.h.next_power_of_two() }
        }
    }
}

/// Puts the box of some bounds around them: centred, but within the photo where it fits.
fn place_box(bounds: PixelRect, size: PixelRect, photo: PixelRect) -> PixelRect {
    let place = |low: i32, len: u32, size: u32, end: u32| {
        let centred = low - ((size - len) / 2) as i32;
        if size <= end { centred.clamp(0, (end - size) as i32) } else { centred }
    };
    let x = place(bounds.x, bounds.w, size.w, photo.w);
    let y = place(bounds.y, bounds.h, size.h, photo.h);
    // At the photo's edge there is no margin where the box fits into the photo; the bounds never leave
    // the box.
    PixelRect { x, y, w: size.w, h: size.h }
}

/// A cluster while it grows.
struct Growing {
    /// The patch whose node names the cluster in the quotient.
    first: u32,
    bounds: PixelRect,
    size: PixelRect,
    layer: u32,
    members: Vec<u32>,
}

struct Merging<'a> {
    layers: &'a Layers,
    options: &'a Options,
    patches: Vec<Patch>,
    order: Graph,
    quotient: Quotient,
    against: Vec<(u32, u32)>,
    clusters: Vec<Growing>,
}

impl<'a> Merging<'a> {
    fn new(layers: &'a Layers, patches: Vec<Patch>, options: &'a Options) -> Self {
        let order = graph_of_patches(layers, &patches);
        let mut against: Vec<(u32, u32)> =
            layers.against.iter().flat_map(|&(f, b, _)| [(f, b), (b, f)]).collect();
        against.sort_unstable();
        let quotient = Quotient::new(&order);
        Self { layers, options, patches, order, quotient, against, clusters: Vec::new() }
    }

    fn place(&mut self, patch: u32) {
        let p = self.patches[patch as usize];
        let layer = self.layers.elements[p.element as usize].layer;
        let mut by_growth: Vec<(u64, usize)> = self
            .clusters
            .iter()
            .enumerate()
            .filter(|(_, c)| !self.options.published || c.layer == layer)
            .filter(|(_, c)| self.holds(c, p.bounds))
            .map(|(i, c)| (c.bounds.union(&p.bounds).area() - c.bounds.area(), i))
            .collect();
        by_growth.sort_unstable();
        match by_growth.into_iter().map(|(_, i)| i).find(|&i| self.may_join(patch, i)) {
            Some(i) => {
                self.quotient.merge(self.clusters[i].first, patch);
                let cluster = &mut self.clusters[i];
                cluster.bounds = cluster.bounds.union(&p.bounds);
                cluster.size = match self.options.boxes {
                    BoxShape::PowerOfTwo => cluster.size,
                    BoxShape::Exact => box_size(cluster.bounds, self.options),
                };
                cluster.members.push(patch);
            }
            None => self.clusters.push(Growing {
                first: patch,
                bounds: p.bounds,
                size: box_size(p.bounds, self.options),
                layer,
                members: vec![patch],
            }),
        }
    }

    /// The union costs no more texels than the two apart.
    fn holds(&self, cluster: &Growing, bounds: PixelRect) -> bool {
        let union = box_size(cluster.bounds.union(&bounds), self.options);
        match self.options.boxes {
            BoxShape::PowerOfTwo => union.w <= cluster.size.w && union.h <= cluster.size.h,
            BoxShape::Exact => {
                union.w.max(union.h) <= self.options.largest_side
                    && union.area() < cluster.size.area() + box_size(bounds, self.options).area()
            }
        }
    }

    fn may_join(&self, patch: u32, cluster: usize) -> bool {
        let element = self.patches[patch as usize].element;
        let shares_forgiven = self.clusters[cluster].members.iter().any(|&m| {
            let other = self.patches[m as usize].element;
            self.against.binary_search(&(element, other)).is_ok()
        });
        !shares_forgiven && !self.quotient.connected(self.clusters[cluster].first, patch)
    }

    fn finish(self, photo: PixelRect) -> Vec<Cluster> {
        let count = self.clusters.len() as u32;
        let mut cluster_of = vec![0u32; self.patches.len()];
        for (i, cluster) in self.clusters.iter().enumerate() {
            cluster.members.iter().for_each(|&m| cluster_of[m as usize] = i as u32);
        }
        let edges = self.order.edges.iter();
        let between = edges.map(|&(f, b, px)| (cluster_of[f as usize], cluster_of[b as usize], px));
        let order = Graph::new(count, between).longest_paths();
        let mut list: Vec<Cluster> = self
            .clusters
            .iter()
            .zip(order)
            .map(|(c, order)| {
                let mut patches: Vec<Patch> = c.members.iter().map(|&m| self.patches[m as usize]).collect();
                patches.sort_by_key(|p| (p.element, p.bounds.y, p.bounds.x));
                Cluster { order, rect: place_box(c.bounds, c.size, photo), patches }
            })
            .collect();
        list.sort_by_key(|c| {
            let first = c.patches[0];
            (c.order, first.element, first.bounds.y, first.bounds.x)
        });
        list
    }
}

/// Occlusions between patches: those of their elements, wherever both reach.
fn graph_of_patches(layers: &Layers, patches: &[Patch]) -> Graph {
    let mut patches_of: Vec<Vec<u32>> = vec![Vec::new(); layers.elements.len()];
    for (i, patch) in patches.iter().enumerate() {
        patches_of[patch.element as usize].push(i as u32);
    }
    let patches_of = &patches_of;
    let edges = layers.occlusions.edges.iter().flat_map(move |&(front, back, px)| {
        patches_of[front as usize].iter().flat_map(move |&f| {
            let meets = move |b: &&u32| {
                !patches[f as usize].bounds.intersection(&patches[**b as usize].bounds).is_empty()
            };
            patches_of[back as usize].iter().filter(meets).map(move |&b| (f, b, px))
        })
    });
    Graph::new(patches.len() as u32, edges)
}
