//! Image layers: elements share a rectangle of the photo where that costs no texels.

use std::cmp::Reverse;

use super::graph::Graph;
use super::options::{BoxShape, Options};
use super::parts::Layers;
use super::quotient::Quotient;
use super::together::{Obstacle, Together, Unmet, bring_together};
use super::wishes::Grouping;
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
    /// Merges that were asked for and could not be made, between elements.
    pub unmet: Vec<Unmet>,
}

/// Merges the elements' boxes. `bounds` are the elements' outlines in whole pixels.
///
/// What was asked to be together comes first, whatever it costs. Then such groups and all other patches
/// come by falling box area (ties: object name, first node). Each joins the cluster whose
/// box holds the union and whose bounding box grows least, if no path of occlusions leads between
/// the two either way, no forgiven pair is shared and none was asked to be apart; else it starts a
/// cluster. With powers of two that is the rule A12 < A1 + A2 of 2003; `published` restricts it to one
/// visibility layer.
pub fn cluster(
    model: &Model,
    layers: &Layers,
    bounds: &[PixelRect],
    photo: PixelRect,
    options: &Options,
    grouping: &Grouping,
) -> Clusters {
    let rules = Rules::new(layers, split_into_patches(bounds, options), options, grouping);
    let (together, unmet) = rules.bring_together();
    let name = |p: &Patch| &model.object(layers.elements[p.element as usize].object).name;
    let mut units = rules.units(&together.members);
    units.sort_by_key(|unit| {
        let p = &rules.patches[unit.members[0] as usize];
        let area = box_size(unit.bounds, options).area();
        (Reverse(area), name(p), layers.elements[p.element as usize].nodes[0], p.bounds.y, p.bounds.x)
    });
    let mut merging = Merging { rules: &rules, quotient: together.quotient, clusters: Vec::new() };
    units.into_iter().for_each(|unit| merging.place(unit));
    Clusters { list: merging.finish(photo), unmet }
}

/// Smaller tiles would be nothing but margin.
pub const SMALLEST_TILE: u32 = 64;

/// The longest side of a box.
pub fn longest_side(options: &Options) -> u32 {
    let most = options.largest_side.max(SMALLEST_TILE);
    match options.boxes {
        BoxShape::Exact => most,
        BoxShape::PowerOfTwo => 1 << most.ilog2(),
    }
}

/// Elements whose bounds exceed the largest side are tiled.
fn split_into_patches(bounds: &[PixelRect], options: &Options) -> Vec<Patch> {
    let most = longest_side(options);
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
pub fn box_size(bounds: PixelRect, options: &Options) -> PixelRect {
    let grown = bounds.grown(options.margin);
    match options.boxes {
        BoxShape::Exact => PixelRect { x: 0, y: 0, ..grown },
        BoxShape::PowerOfTwo => PixelRect::of_size(grown.w.next_power_of_two(), grown.h.next_power_of_two()),
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

/// Patches that stay together: one, or those that were asked to.
struct Unit {
    /// The patch whose node names it in the quotient.
    root: u32,
    bounds: PixelRect,
    /// Its visibility layer, where it has one only.
    layer: Option<u32>,
    /// Rising.
    members: Vec<u32>,
}

/// A cluster while it grows.
struct Growing {
    of: Unit,
    size: PixelRect,
}

/// What may share an image layer.
struct Rules<'a> {
    layers: &'a Layers,
    options: &'a Options,
    grouping: &'a Grouping,
    patches: Vec<Patch>,
    order: Graph,
    against: Vec<(u32, u32)>,
}

impl<'a> Rules<'a> {
    fn new(layers: &'a Layers, patches: Vec<Patch>, options: &'a Options, grouping: &'a Grouping) -> Self {
        let order = graph_of_patches(layers, &patches);
        let mut against: Vec<(u32, u32)> =
            layers.against.iter().flat_map(|&(f, b, _)| [(f, b), (b, f)]).collect();
        against.sort_unstable();
        Self { layers, options, grouping, patches, order, against }
    }

    /// The merges that were asked for, and which of them were not possible, between elements. An element
    /// of several patches is larger than image layers may be.
    fn bring_together(&self) -> (Together, Vec<Unmet>) {
        let of_element = |element: u32| {
            let begin = self.patches.partition_point(|p| p.element < element);
            begin..self.patches.partition_point(|p| p.element <= element)
        };
        let mut unmet = Vec::new();
        let mut merges = Vec::with_capacity(self.grouping.merges.len());
        for (merge, elements) in (0u32..).zip(&self.grouping.merges) {
            let (small, large): (Vec<u32>, Vec<u32>) =
                elements.iter().partition(|e| of_element(**e).len() == 1);
            let told = |item: u32| Unmet { merge, item, with: elements[0], why: Obstacle::TooLarge };
            unmet.extend(large.into_iter().map(told));
            merges.push(small.into_iter().map(|element| of_element(element).start as u32).collect());
        }
        let together = bring_together(&self.order, &merges, |joining, group| {
            let too_large = || self.too_large(joining, group).then_some((group[0], Obstacle::TooLarge));
            self.obstacle(joining, group).or_else(too_large)
        });
        let element = |patch: u32| self.patches[patch as usize].element;
        let of_patches = together.unmet.iter();
        unmet.extend(of_patches.map(|u| Unmet { item: element(u.item), with: element(u.with), ..*u }));
        unmet.sort_by_key(|unmet| (unmet.merge, unmet.item));
        (together, unmet)
    }

    /// What keeps patches out of a group besides paths of occlusions, and which one of the group.
    fn obstacle(&self, joining: &[u32], group: &[u32]) -> Option<(u32, Obstacle)> {
        let element = |patch: u32| self.patches[patch as usize].element;
        let find = |keeps: &dyn Fn(u32, u32) -> bool, why| {
            let kept = |&&member: &&u32| joining.iter().any(|&j| keeps(element(j), element(member)));
            group.iter().find(kept).map(|&member| (member, why))
        };
        find(&|a, b| self.against.binary_search(&(a, b)).is_ok(), Obstacle::Forgiven)
            .or_else(|| find(&|a, b| self.grouping.apart(a, b), Obstacle::Split))
    }

    fn too_large(&self, a: &[u32], b: &[u32]) -> bool {
        let union = self.bounds(a).union(&self.bounds(b));
        let size = box_size(union, self.options);
        size.w.max(size.h) > longest_side(self.options)
    }

    fn bounds(&self, members: &[u32]) -> PixelRect {
        let bounds = members.iter().map(|&m| self.patches[m as usize].bounds);
        bounds.reduce(|a, b| a.union(&b)).expect("a group has members")
    }

    fn units(&self, members: &[Vec<u32>]) -> Vec<Unit> {
        let layer = |m: &u32| self.layers.elements[self.patches[*m as usize].element as usize].layer;
        let groups = (0u32..).zip(members).filter(|(_, members)| !members.is_empty());
        groups
            .map(|(root, members)| {
                let first = layer(&members[0]);
                let layer = members.iter().all(|m| layer(m) == first).then_some(first);
                Unit { root, bounds: self.bounds(members), layer, members: members.clone() }
            })
            .collect()
    }
}

struct Merging<'a> {
    rules: &'a Rules<'a>,
    quotient: Quotient,
    clusters: Vec<Growing>,
}

impl Merging<'_> {
    fn place(&mut self, unit: Unit) {
        let options = self.rules.options;
        let mut by_growth: Vec<(u64, usize)> = self
            .clusters
            .iter()
            .enumerate()
            .filter(|(_, c)| !options.published || (unit.layer.is_some() && c.of.layer == unit.layer))
            .filter(|(_, c)| self.holds(c, unit.bounds))
            .map(|(i, c)| (c.of.bounds.union(&unit.bounds).area() - c.of.bounds.area(), i))
            .collect();
        by_growth.sort_unstable();
        match by_growth.into_iter().map(|(_, i)| i).find(|&i| self.may_join(&unit, i)) {
            Some(i) => {
                self.quotient.merge(self.clusters[i].of.root, unit.root);
                let cluster = &mut self.clusters[i];
                cluster.of.bounds = cluster.of.bounds.union(&unit.bounds);
                cluster.size = match options.boxes {
                    BoxShape::PowerOfTwo => cluster.size,
                    BoxShape::Exact => box_size(cluster.of.bounds, options),
                };
                cluster.of.members.extend(unit.members);
            }
            None => {
                let size = box_size(unit.bounds, options);
                self.clusters.push(Growing { of: unit, size });
            }
        }
    }

    /// The union costs no more texels than the two apart.
    fn holds(&self, cluster: &Growing, bounds: PixelRect) -> bool {
        let options = self.rules.options;
        let union = box_size(cluster.of.bounds.union(&bounds), options);
        match options.boxes {
            BoxShape::PowerOfTwo => union.w <= cluster.size.w && union.h <= cluster.size.h,
            BoxShape::Exact => {
                union.w.max(union.h) <= options.largest_side
                    && union.area() < cluster.size.area() + box_size(bounds, options).area()
            }
        }
    }

    fn may_join(&self, unit: &Unit, cluster: usize) -> bool {
        let cluster = &self.clusters[cluster].of;
        self.rules.obstacle(&unit.members, &cluster.members).is_none()
            && !self.quotient.connected(cluster.root, unit.root)
    }

    fn finish(self, photo: PixelRect) -> Vec<Cluster> {
        let (patches, order) = (&self.rules.patches, &self.rules.order);
        let count = self.clusters.len() as u32;
        let mut cluster_of = vec![0u32; patches.len()];
        for (i, cluster) in self.clusters.iter().enumerate() {
            cluster.of.members.iter().for_each(|&m| cluster_of[m as usize] = i as u32);
        }
        let edges = order.edges.iter();
        let between = edges.map(|&(f, b, px)| (cluster_of[f as usize], cluster_of[b as usize], px));
        let order = Graph::new(count, between).longest_paths();
        let mut list: Vec<Cluster> = self
            .clusters
            .iter()
            .zip(order)
            .map(|(c, order)| {
                let mut of: Vec<Patch> = c.of.members.iter().map(|&m| patches[m as usize]).collect();
                of.sort_by_key(|p| (p.element, p.bounds.y, p.bounds.x));
                Cluster { order, rect: place_box(c.of.bounds, c.size, photo), patches: of }
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
