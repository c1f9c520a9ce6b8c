//! The three invariants of the visibility sort, checked the slow way: pixel by pixel, from the
//! fragment lists alone, with none of the program's graphs.

use std::collections::BTreeMap;

use quadratura::testing::layers::ElementIndex;
use quadratura::testing::layers::rasteriser::{Presence, TIE, VISIBLE};
use quadratura::testing::layers::{FragmentLists, Sorted, is_behind};
use quadratura::testing::scene::FaceIndex;

use crate::sorted::Case;

/// Pixels of every ordered pair (front, back).
pub type Table = BTreeMap<(u32, u32), u32>;

/// A fragment as the oracle sees it.
#[derive(Debug, Clone, Copy)]
struct Fragment {
    item: u32,
    /// `None` when it belongs to a piece that left the working set.
    node: Option<u32>,
    inverse_depth: f32,
    visible: bool,
}

/// What the fragment lists say about the nodes of a result.
pub struct Oracle<'a> {
    case: &'a Case,
    pixels: Vec<Vec<Fragment>>,
}

impl<'a> Oracle<'a> {
    /// Looks every fragment up.
    pub fn new(case: &'a Case) -> Self {
        let Case { name, sorted, fragments, .. } = case;
        let nodes = &sorted.nodes.list;
        let mut nodes_of = vec![Vec::new(); sorted.view.items.len()];
        for (node, of) in nodes.iter().enumerate() {
            nodes_of[of.item as usize].push(node as u32);
        }
        let inverse = |item: u32, x, y| sorted.view.items[item as usize].inverse_depth.at(x, y);
        let holds = |node: u32, x, y| {
            let node = &nodes[node as usize];
            let near = |plane| inverse(node.item, x, y) >= inverse(plane, x, y);
            node.sides.iter().all(|side| near(side.plane) == side.near)
        };
        let fragment = |entry: u32, x, y| {
            let item = entry & !VISIBLE;
            let mut found = nodes_of[item as usize].iter().copied().filter(|&n| holds(n, x, y));
            let node = found.next();
            assert!(found.next().is_none(), "{name}: pieces of item {item} overlap");
            Fragment { item, node, inverse_depth: inverse(item, x, y), visible: entry & VISIBLE != 0 }
        };
        let pixels = each_pixel(&fragments.lists)
            .map(|(x, y, entries)| entries.iter().map(|&entry| fragment(entry, x, y)).collect())
            .collect();
        Self { case, pixels }
    }

    /// Everything that must hold of a result of the default method.
    pub fn check(&self) {
        self.visible_bits();
        self.partition();
        let table = self.pairs_of_elements();
        self.front(&table);
        self.earliest(&table);
    }

    /// An entry is marked visible exactly where no fragment of its pixel is nearer by more than the
    /// tolerance; an item works exactly when it is nearest somewhere.
    fn visible_bits(&self) {
        let name = &self.case.name;
        let mut working = vec![false; self.case.sorted.view.items.len()];
        for pixel in &self.pixels {
            for fragment in pixel {
                let hidden = pixel.iter().any(|other| self.behind(fragment, other));
                assert_eq!(fragment.visible, !hidden, "{name}: item {}", fragment.item);
                working[fragment.item as usize] |= is_nearest(fragment, pixel);
            }
        }
        assert!(self.case.working() == working, "{name}: the working set is another");
        let counted = |p: &Presence| matches!(p, Presence::Working);
        assert!(self.case.fragments.presence.iter().map(counted).eq(working), "{name}: drawn twice");
    }

    /// *Partition*: every face or piece of the working set is in exactly one element, every element
    /// in exactly one layer; nothing else is in any.
    fn partition(&self) {
        let Case { name, sorted: Sorted { nodes, layers, .. }, .. } = self.case;
        let mut seen = vec![false; nodes.list.len()];
        for pixel in &self.pixels {
            for fragment in pixel.iter().filter(|f| is_nearest(f, pixel)) {
                let node = fragment.node.unwrap_or_else(|| panic!("{name}: {fragment:?} has no node"));
                seen[node as usize] = true;
            }
        }
        assert!(seen.iter().all(|seen| *seen), "{name}: a node is nearest nowhere");
        let mut members: Vec<u32> = layers.elements.iter().flat_map(|e| &e.nodes).map(|n| n.0).collect();
        members.sort_unstable();
        assert!(members.into_iter().eq(0..seen.len() as u32), "{name}: not every node once");
        for (index, element) in layers.elements.iter().enumerate() {
            for node in &element.nodes {
                assert_eq!(layers.element_of[node.0 as usize].index(), index, "{name}");
                assert_eq!(self.case.object_of(node.0), element.object, "{name}");
            }
        }
        let layer_is_used = |layer| layers.elements.iter().any(|e| e.visibility_layer == layer);
        assert!((0..layers.count()).all(layer_is_used), "{name}: an empty layer");
    }

    /// *Front*: no element occludes one of its own layer or of a nearer one, but for forgiven pairs,
    /// each of which lies on a cycle and has no more than `min_support` pixels.
    fn front(&self, table: &Table) {
        let Case { name, options, sorted: Sorted { layers, .. }, .. } = self.case;
        let layer = |element: u32| layers.elements[element as usize].visibility_layer;
        let against: Vec<_> = table
            .iter()
            .filter(|((front, back), _)| front != back && layer(*front) >= layer(*back))
            .map(|(&(front, back), &px)| (front, back, px))
            .collect();
        assert_eq!(layers.against, against, "{name}: forgiven pairs");
        for (front, back, px) in against {
            assert!(px <= options.min_support, "{name}: {front} hides {px} px of {back} before it");
            assert!(reaches(table, back, front), "{name}: {front}, {back} forgiven without a cycle");
        }
        // What overlaps within an element is noise as well, or tolerated and recorded.
        let nodes = self.pairs(|fragment| fragment.node);
        for (&(front, back), &px) in &nodes {
            let one = layers.element_of[front as usize] == layers.element_of[back as usize];
            let recorded = layers.tolerated.iter().any(|o| (o.front, o.back, o.px) == (front, back, px));
            assert!(
                !one || px <= options.min_support || recorded,
                "{name}: an element hides {px} px of itself"
            );
        }
        for overlap in &layers.tolerated {
            let [front, back] = [overlap.front, overlap.back].map(|node| layers.element_of[node as usize]);
            assert_eq!(front, back, "{name}: tolerated between elements");
            assert_eq!(nodes.get(&(overlap.front, overlap.back)), Some(&overlap.px), "{name}: tolerated");
        }
    }

    /// [`Oracle::check`] down to *Earliest* alone.
    pub fn earliest_of_all(&self) {
        self.earliest(&self.pairs_of_elements());
    }

    /// *Earliest*: every element of layer k > 0 is occluded by some element of layer k - 1.
    fn earliest(&self, table: &Table) {
        let elements = &self.case.sorted.layers.elements;
        for (index, element) in elements.iter().enumerate().filter(|(_, e)| e.visibility_layer > 0) {
            let is_occluder =
                |front: u32| elements[front as usize].visibility_layer + 1 == element.visibility_layer;
            let occluded = table.keys().any(|&(front, back)| back as usize == index && is_occluder(front));
            assert!(occluded, "{}: element {index} stands too far back", self.case.name);
        }
    }

    /// Every pair of elements, with the sum of their faces' supports.
    pub fn pairs_of_elements(&self) -> Table {
        self.pairs(|fragment| Some(self.case.sorted.layers.element_of[fragment.node? as usize].0))
    }

    /// Pixel by pixel, the elements of the fragments that are in image layers, and whether these are visible.
    pub fn elements_by_pixel(&self) -> impl Iterator<Item = Vec<(ElementIndex, bool)>> {
        let element_of = &self.case.sorted.layers.element_of;
        let left_over = &self.case.sorted.leftovers.nodes;
        let element = |f: &Fragment| {
            let node = f.node.filter(|node| !left_over[*node as usize])?;
            Some((element_of[node as usize], f.visible))
        };
        self.pixels.iter().map(move |pixel| pixel.iter().filter_map(element).collect())
    }

    /// Pixel by pixel, the nodes of the fragments with their inverse depths.
    pub fn nodes_by_pixel(&self) -> impl Iterator<Item = Vec<(u32, f32)>> {
        let node = |f: &Fragment| Some((f.node?, f.inverse_depth));
        self.pixels.iter().map(move |pixel| pixel.iter().filter_map(node).collect())
    }

    /// The number of visible pixels of each node.
    pub fn visible_of_nodes(&self) -> Vec<u32> {
        let mut px = vec![0; self.case.sorted.nodes.list.len()];
        let visible = self.pixels.iter().flatten().filter(|fragment| fragment.visible);
        visible.filter_map(|fragment| fragment.node).for_each(|node| px[node as usize] += 1);
        px
    }

    /// Pixel by pixel, whether leftovers are visible and nothing that is in an image layer.
    pub fn leftovers_by_pixel(&self) -> impl Iterator<Item = bool> {
        let left_over = &self.case.sorted.leftovers.nodes;
        let visible = |f: &&Fragment| f.visible && f.node.is_some();
        let is_left_over = |f: &Fragment| f.node.is_some_and(|node| left_over[node as usize]);
        self.pixels.iter().map(move |pixel| {
            let mut visible = pixel.iter().filter(visible).peekable();
            visible.peek().is_some() && visible.all(is_left_over)
        })
    }

    /// *Leftovers*: exactly the faces that are visible at too few pixels and at too small a share, and are not kept,
    /// are in no image layer.
    pub fn leftovers(&self, keeps: impl Fn(&str, FaceIndex) -> bool) {
        let Case { name, model, options, sorted, .. } = self.case;
        let mut pixels: BTreeMap<_, [u64; 2]> = BTreeMap::new();
        for fragment in self.pixels.iter().flatten() {
            let count = pixels.entry(sorted.view.items[fragment.item as usize].face).or_default();
            *count = [count[0] + u64::from(fragment.visible), count[1] + 1];
        }
        let barely = |[visible, covered]: [u64; 2]| {
            let share = visible as f64 / covered as f64;
            visible > 0 && visible < options.min_visible.into() && share < options.min_share.into()
        };
        let face_name = |face| (&model.object(model.face(face).object).name, model.face(face).index);
        let expected: Vec<_> = pixels.into_iter().filter(|(_, counts)| barely(*counts)).collect();
        let (kept, left_over): (Vec<_>, Vec<_>) =
            expected.into_iter().partition(|(face, _)| keeps(face_name(*face).0, face_name(*face).1));
        let found = sorted.leftovers.faces.iter().map(|f| (f.face, [f.visible_px, f.covered_px]));
        assert_eq!(found.collect::<Vec<_>>(), left_over, "{name}: leftovers");
        let kept: Vec<_> = kept.into_iter().map(|(face, _)| face).collect();
        assert_eq!(sorted.leftovers.spared, kept, "{name}: spared");
    }

    /// The layer of every element by exact peeling: what no element that is left hides is a layer.
    pub fn peeled(&self) -> Vec<u32> {
        let layers = &self.case.sorted.layers;
        let forgiven = |front, back| layers.against.iter().any(|&(f, b, _)| (f, b) == (front, back));
        let mut pairs: Vec<(u32, u32)> = self.pairs_of_elements().into_keys().collect();
        pairs.retain(|&(front, back)| front != back && !forgiven(front, back));
        let mut peeled = vec![None; layers.elements.len()];
        for layer in 0.. {
            let alive = |element: u32| peeled[element as usize].is_none();
            let hidden = |back| pairs.iter().any(|&(f, b)| b == back && alive(f));
            let free: Vec<u32> = (0..peeled.len() as u32).filter(|&e| alive(e) && !hidden(e)).collect();
            if free.is_empty() {
                break;
            }
            free.into_iter().for_each(|element| peeled[element as usize] = Some(layer));
        }
        peeled.into_iter().map(|layer| layer.expect("no cycle is left")).collect()
    }

    /// Every ordered pair of different names that fragments have, with the number of fragment pairs
    /// of which the first is nearer by more than the tolerance.
    fn pairs(&self, name_of: impl Fn(&Fragment) -> Option<u32>) -> Table {
        let mut table = Table::new();
        for pixel in &self.pixels {
            for back in pixel {
                for front in pixel.iter().filter(|front| self.behind(back, front)) {
                    if let (Some(front), Some(back)) = (name_of(front), name_of(back)) {
                        *table.entry((front, back)).or_default() += 1;
                    }
                }
            }
        }
        table
    }

    fn behind(&self, fragment: &Fragment, other: &Fragment) -> bool {
        is_behind(fragment.inverse_depth, other.inverse_depth, self.case.options.tolerance)
    }
}

/// Nothing at this pixel is nearer, rounding apart.
fn is_nearest(fragment: &Fragment, pixel: &[Fragment]) -> bool {
    !pixel.iter().any(|other| is_behind(fragment.inverse_depth, other.inverse_depth, TIE))
}

/// Every pixel of some lists: column, row, entries.
pub fn each_pixel(lists: &FragmentLists) -> impl Iterator<Item = (u32, u32, &[u32])> {
    lists.bands.iter().flat_map(move |band| {
        (band.y0..band.y1).flat_map(move |y| (0..lists.width).map(move |x| (x, y, lists.pixel(band, x, y))))
    })
}

/// True when occlusions lead from one element to another.
fn reaches(table: &Table, from: u32, to: u32) -> bool {
    let (mut reached, mut next) = (vec![from], 0);
    while next < reached.len() {
        for &(front, back) in table.keys() {
            if front == reached[next] && !reached.contains(&back) {
                reached.push(back);
            }
        }
        next += 1;
    }
    reached.contains(&to)
}
