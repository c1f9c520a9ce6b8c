//! Image layers: rectangles of the photo that elements share where this costs no additional texels.

use std::cmp::Reverse;

use super::constraints::ElementConstraints;
use super::occlusion_graph::OcclusionGraph;
use super::options::{BoxShape, Options};
use super::parts::{ElementIndex, Layers, SortedElement};
use super::quotient::Quotient;
use super::together::{MergeResult, Obstacle, Unsatisfied, bring_together};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Model;
use quadratura_base::scene::builder::says_backdrop;

/// The part of an element that lies in one image layer: the whole element, unless it is larger than the
/// largest side allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ElementPatch {
    /// The element.
    pub element: ElementIndex,
    /// Bounds in whole pixels of the photo; patches of one element do not overlap.
    pub bounds: PixelRect,
}

/// The index of an image layer in its photo's stack, which begins with the nearest one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LayerIndex(pub u32);

impl LayerIndex {
    /// Returns the index of the layer at a position in the stack.
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Returns the position in the stack.
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the indices of a stack's `count` layers.
    pub fn all(count: usize) -> impl ExactSizeIterator<Item = Self> + DoubleEndedIterator + Clone {
        (0..count as u32).map(Self)
    }
}

/// An image layer: a rectangle of the photo with the patches that it textures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    /// The position in the stack: the length of the longest path of occlusions that leads to it, 0 nearest.
    pub order: u32,
    /// The rectangle in photo pixels; it may reach outside the photo.
    pub rect: PixelRect,
    /// The patches, by element.
    pub patches: Vec<ElementPatch>,
}

/// The image layers of a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clusters {
    /// The image layers, by order, then by first element.
    pub list: Vec<Cluster>,
    /// The merges that the user requested and that could not be made, between elements.
    pub unsatisfied: Vec<Unsatisfied>,
}

/// Groups elements into image layers by merging their boxes. `bounds` are the bounding boxes of the elements'
/// outlines in whole pixels.
///
/// Merges that the user requested are made first, whatever they cost in texels. Then these groups and all
/// other patches are processed by falling box area (ties: object name, first node). Each joins the cluster
/// whose box holds the union and whose bounding box grows least, provided that no path of occlusions leads
/// between the two in either direction, that they share no forgiven pair, that no split keeps them apart, that one
/// sees through both or neither (the alpha of a layer is the matte of what it shows), and that both consist of backdrops or
/// neither does (a backdrop is hidden by nearly everything, which is counted apart); otherwise it starts a new cluster. With sides that are powers of two this is the rule A12 < A1 + A2 of
/// 2003; the option `published` restricts it to one visibility layer.
pub fn cluster(
    model: &Model,
    layers: &Layers,
    bounds: &[PixelRect],
    photo: PixelRect,
    options: &Options,
    grouping: &ElementConstraints,
) -> Clusters {
    let sees_through = |element: &SortedElement| model.object(element.object).see_through;
    let see_through = layers.elements.iter().map(sees_through).collect();
    let is_backdrop = |element: &SortedElement| says_backdrop(&model.object(element.object).name);
    let backdrops = layers.elements.iter().map(is_backdrop).collect();
    let patches = split_into_patches(bounds, options);
    let rules = Rules::new(layers, [see_through, backdrops], patches, options, grouping);
    let (together, unsatisfied) = rules.bring_together();
    let name = |p: &ElementPatch| &model.object(layers.elements[p.element.index()].object).name;
    let mut units = rules.units(&together.members);
    units.sort_by_key(|unit| {
        let p = &rules.patches[unit.members[0] as usize];
        let area = box_size(unit.bounds, options).area();
        (Reverse(area), name(p), layers.elements[p.element.index()].nodes[0], p.bounds.y, p.bounds.x)
    });
    let mut builder = ClusterBuilder { rules: &rules, quotient: together.quotient, clusters: Vec::new() };
    units.into_iter().for_each(|unit| builder.add(unit));
    Clusters { list: builder.finish(photo), unsatisfied }
}

/// The smallest side of a tile, in pixels; smaller tiles would consist of little but margin.
pub const SMALLEST_TILE: u32 = 64;

/// Returns the longest side that a box may have under these options, in pixels.
pub fn longest_side(options: &Options) -> u32 {
    let most = options.largest_side.max(SMALLEST_TILE);
    match options.boxes {
        BoxShape::Exact => most,
        BoxShape::PowerOfTwo => 1 << most.ilog2(),
    }
}

/// Builds one patch per element, or several for elements whose bounds exceed the longest side: these are
/// tiled.
pub(super) fn split_into_patches(bounds: &[PixelRect], options: &Options) -> Vec<ElementPatch> {
    let most = longest_side(options);
    let side = most.saturating_sub(2 * options.margin).max(SMALLEST_TILE / 2) as usize;
    let mut patches = Vec::with_capacity(bounds.len());
    for (element, b) in bounds.iter().enumerate() {
        for y in (b.y..b.bottom()).step_by(side) {
            for x in (b.x..b.right()).step_by(side) {
                let tile = PixelRect { x, y, w: side as u32, h: side as u32 };
                patches
                    .push(ElementPatch { element: ElementIndex::new(element), bounds: tile.intersection(b) });
            }
        }
    }
    patches
}

/// Computes the size of the box for some bounds, placed at the origin: the bounds with their margin, rounded
/// up to powers of two where the options ask for it.
pub fn box_size(bounds: PixelRect, options: &Options) -> PixelRect {
    let grown = bounds.grown(options.margin);
    match options.boxes {
        BoxShape::Exact => PixelRect { x: 0, y: 0, ..grown },
        BoxShape::PowerOfTwo => PixelRect::of_size(grown.w.next_power_of_two(), grown.h.next_power_of_two()),
    }
}

/// Positions a box of the given size around some bounds: centred, but within the photo where it fits.
pub(super) fn place_box(bounds: PixelRect, size: PixelRect, photo: PixelRect) -> PixelRect {
    let position = |low: i32, len: u32, size: u32, end: u32| {
        let centred = low - ((size - len) / 2) as i32;
        if size <= end { centred.clamp(0, (end - size) as i32) } else { centred }
    };
    let x = position(bounds.x, bounds.w, size.w, photo.w);
    let y = position(bounds.y, bounds.h, size.h, photo.h);
    // At the photo's edge, a box that fits into the photo loses its margin there; the bounds always remain
    // inside the box.
    PixelRect { x, y, w: size.w, h: size.h }
}

/// A group of patches that stay together: a single patch, or those that the user merged.
struct Unit {
    /// The patch whose index identifies the unit in the quotient.
    root: u32,
    bounds: PixelRect,
    /// The visibility layer, when all members are in the same one.
    layer: Option<u32>,
    /// Indices of the patches, rising.
    members: Vec<u32>,
}

/// A cluster under construction, with the size of its box.
struct Growing {
    unit: Unit,
    size: PixelRect,
}

/// The rules that decide which patches may share an image layer.
struct Rules<'a> {
    layers: &'a Layers,
    /// Whether one sees through the surfaces of each element.
    see_through: Vec<bool>,
    /// Whether each element is part of a backdrop.
    backdrops: Vec<bool>,
    options: &'a Options,
    grouping: &'a ElementConstraints,
    patches: Vec<ElementPatch>,
    order: OcclusionGraph,
    against: Vec<(u32, u32)>,
}

impl<'a> Rules<'a> {
    fn new(
        layers: &'a Layers,
        [see_through, backdrops]: [Vec<bool>; 2],
        patches: Vec<ElementPatch>,
        options: &'a Options,
        grouping: &'a ElementConstraints,
    ) -> Self {
        let order = graph_of_patches(layers, &patches);
        let mut against: Vec<(u32, u32)> =
            layers.against.iter().flat_map(|&(f, b, _)| [(f, b), (b, f)]).collect();
        against.sort_unstable();
        Self { layers, see_through, backdrops, options, grouping, patches, order, against }
    }

    /// Makes the merges that the user requested; also returns those that were not possible, between elements.
    /// An element of several patches is larger than image layers may be, so it is never merged.
    fn bring_together(&self) -> (MergeResult, Vec<Unsatisfied>) {
        let of_element = |element: u32| {
            let begin = self.patches.partition_point(|p| p.element.0 < element);
            begin..self.patches.partition_point(|p| p.element.0 <= element)
        };
        let mut unsatisfied = Vec::new();
        let mut merges = Vec::with_capacity(self.grouping.merges.len());
        for (merge, elements) in (0u32..).zip(&self.grouping.merges) {
            let (small, large): (Vec<u32>, Vec<u32>) =
                elements.iter().partition(|e| of_element(**e).len() == 1);
            let left_out =
                |item: u32| Unsatisfied { merge, item, with: elements[0], why: Obstacle::TooLarge };
            unsatisfied.extend(large.into_iter().map(left_out));
            merges.push(small.into_iter().map(|element| of_element(element).start as u32).collect());
        }
        let together = bring_together(&self.order, &merges, |joining, group| {
            let too_large = || self.too_large(joining, group).then_some((group[0], Obstacle::TooLarge));
            self.obstacle(joining, group).or_else(too_large)
        });
        let element = |patch: u32| self.patches[patch as usize].element.0;
        let of_patches = together.unsatisfied.iter();
        unsatisfied.extend(of_patches.map(|u| Unsatisfied {
            item: element(u.item),
            with: element(u.with),
            ..*u
        }));
        unsatisfied.sort_by_key(|unsatisfied| (unsatisfied.merge, unsatisfied.item));
        (together, unsatisfied)
    }

    /// Returns what keeps patches out of a group, other than paths of occlusions, and the member of the group
    /// concerned.
    fn obstacle(&self, joining: &[u32], group: &[u32]) -> Option<(u32, Obstacle)> {
        let element = |patch: u32| self.patches[patch as usize].element.0;
        let find = |keeps: &dyn Fn(u32, u32) -> bool, why| {
            let kept = |&&member: &&u32| joining.iter().any(|&j| keeps(element(j), element(member)));
            group.iter().find(kept).map(|&member| (member, why))
        };
        let differs = |a: u32, b: u32| self.see_through[a as usize] != self.see_through[b as usize];
        find(&|a, b| self.against.binary_search(&(a, b)).is_ok(), Obstacle::Forgiven)
            .or_else(|| find(&differs, Obstacle::SeeThrough))
            .or_else(|| find(&|a, b| self.grouping.apart(a, b), Obstacle::Split))
    }

    /// Returns true for patches of backdrops alone. Those that the user merged with something else are not.
    fn is_backdrop(&self, members: &[u32]) -> bool {
        members.iter().all(|&member| self.backdrops[self.patches[member as usize].element.index()])
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
        let layer =
            |m: &u32| self.layers.elements[self.patches[*m as usize].element.index()].visibility_layer;
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

/// The image layers that are grown from units, one unit after the other.
struct ClusterBuilder<'a> {
    rules: &'a Rules<'a>,
    quotient: Quotient,
    clusters: Vec<Growing>,
}

impl ClusterBuilder<'_> {
    fn add(&mut self, unit: Unit) {
        let options = self.rules.options;
        let mut by_growth: Vec<(u64, usize)> = self
            .clusters
            .iter()
            .enumerate()
            .filter(|(_, c)| !options.published || (unit.layer.is_some() && c.unit.layer == unit.layer))
            .filter(|(_, c)| self.holds(c, unit.bounds))
            .map(|(i, c)| (c.unit.bounds.union(&unit.bounds).area() - c.unit.bounds.area(), i))
            .collect();
        by_growth.sort_unstable();
        match by_growth.into_iter().map(|(_, i)| i).find(|&i| self.may_join(&unit, i)) {
            Some(i) => {
                self.quotient.merge(self.clusters[i].unit.root, unit.root);
                let cluster = &mut self.clusters[i];
                cluster.unit.bounds = cluster.unit.bounds.union(&unit.bounds);
                cluster.size = match options.boxes {
                    BoxShape::PowerOfTwo => cluster.size,
                    BoxShape::Exact => box_size(cluster.unit.bounds, options),
                };
                cluster.unit.members.extend(unit.members);
            }
            None => {
                let size = box_size(unit.bounds, options);
                self.clusters.push(Growing { unit, size });
            }
        }
    }

    /// Returns true when the union costs no more texels than the two separately.
    fn holds(&self, cluster: &Growing, bounds: PixelRect) -> bool {
        let options = self.rules.options;
        let union = box_size(cluster.unit.bounds.union(&bounds), options);
        match options.boxes {
            BoxShape::PowerOfTwo => union.w <= cluster.size.w && union.h <= cluster.size.h,
            BoxShape::Exact => {
                union.w.max(union.h) <= options.largest_side
                    && union.area() < cluster.size.area() + box_size(bounds, options).area()
            }
        }
    }

    fn may_join(&self, unit: &Unit, cluster: usize) -> bool {
        let cluster = &self.clusters[cluster].unit;
        self.rules.obstacle(&unit.members, &cluster.members).is_none()
            && self.rules.is_backdrop(&unit.members) == self.rules.is_backdrop(&cluster.members)
            && !self.quotient.connected(cluster.root, unit.root)
    }

    fn finish(self, photo: PixelRect) -> Vec<Cluster> {
        let (patches, order) = (&self.rules.patches, &self.rules.order);
        let count = self.clusters.len() as u32;
        let mut cluster_of = vec![0u32; patches.len()];
        for (i, cluster) in self.clusters.iter().enumerate() {
            cluster.unit.members.iter().for_each(|&m| cluster_of[m as usize] = i as u32);
        }
        let edges = order.edges.iter();
        let between = edges.map(|&(f, b, px)| (cluster_of[f as usize], cluster_of[b as usize], px));
        let order = OcclusionGraph::new(count, between).longest_paths();
        let mut list: Vec<Cluster> = self
            .clusters
            .iter()
            .zip(order)
            .map(|(c, order)| {
                let mut members: Vec<ElementPatch> =
                    c.unit.members.iter().map(|&m| patches[m as usize]).collect();
                members.sort_by_key(|p| (p.element, p.bounds.y, p.bounds.x));
                Cluster { order, rect: place_box(c.unit.bounds, c.size, photo), patches: members }
            })
            .collect();
        list.sort_by_key(|c| {
            let first = c.patches[0];
            (c.order, first.element, first.bounds.y, first.bounds.x)
        });
        list
    }
}

/// Builds the graph of occlusions between patches: those of their elements, for patches whose bounds
/// intersect.
fn graph_of_patches(layers: &Layers, patches: &[ElementPatch]) -> OcclusionGraph {
    let mut patches_of: Vec<Vec<u32>> = vec![Vec::new(); layers.elements.len()];
    for (i, patch) in patches.iter().enumerate() {
        patches_of[patch.element.index()].push(i as u32);
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
    OcclusionGraph::new(patches.len() as u32, edges)
}
