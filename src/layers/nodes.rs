//! Nodes, the units that the sort orders: the items of the working set, and the pieces of those that were
//! cut.

use super::projected_model::ProjectedModel;

/// The index of a node in [`Nodes::list`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

/// One side of a cut by the plane of another item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CutSide {
    /// Index of the item whose plane cuts.
    pub plane: u32,
    /// True for the side nearer to the camera, which is the side of the plane that holds the camera.
    pub near: bool,
}

/// A whole item, or the piece of it that lies on the given sides of other items' planes.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct GraphNode {
    /// Index of the item.
    pub item: u32,
    /// The sides of the cuts that made the piece, first cut first; empty for a whole item.
    pub sides: Vec<CutSide>,
}

/// The tree of cuts of an item, which finds the node that a fragment belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
enum CutTree {
    Leaf(Option<NodeId>),
    Split { plane: u32, near: Box<CutTree>, far: Box<CutTree> },
}

/// The nodes of a photo, and the lookup from a fragment to its node.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Nodes {
    /// The nodes by item, near pieces before far ones.
    pub list: Vec<GraphNode>,
    /// The tree of each item: a leaf for an item that is whole or not in the working set.
    trees: Vec<CutTree>,
}

impl Nodes {
    /// Builds one node for each item flagged in `working`, uncut.
    #[inline]
    pub fn whole(working: &[bool]) -> Self {
        let mut nodes = Self { trees: vec![CutTree::Leaf(None); working.len()], ..Self::default() };
        for (item, _) in working.iter().enumerate().filter(|(_, w)| **w) {
            nodes.trees[item] = CutTree::Leaf(Some(NodeId(nodes.list.len() as u32)));
            nodes.list.push(GraphNode { item: item as u32, sides: Vec::new() });
        }
        nodes
    }

    /// Builds the nodes of the items flagged in `working`; items named in `pieces` are in pieces. Pieces that
    /// left the working set are not listed, and their fragments belong to no node.
    pub fn with_pieces(working: &[bool], pieces: &[GraphNode]) -> Self {
        let mut list: Vec<GraphNode> = pieces.to_vec();
        let is_cut = |item: u32| pieces.iter().any(|p| p.item == item);
        list.extend(
            (0..working.len() as u32)
                .filter(|&i| working[i as usize] && !is_cut(i))
                .map(|item| GraphNode { item, sides: Vec::new() }),
        );
        // Near sorts before far, and whole items have one node only: the result is in model order, near
        // pieces first.
        list.sort_by(|a, b| {
            let key = |n: &GraphNode| n.sides.iter().map(|s| (s.plane, !s.near)).collect::<Vec<_>>();
            (a.item, key(a)).cmp(&(b.item, key(b)))
        });
        let mut nodes = Self { trees: vec![CutTree::Leaf(None); working.len()], ..Self::default() };
        for (i, node) in list.iter().enumerate() {
            nodes.trees[node.item as usize].insert(&node.sides, NodeId(i as u32));
        }
        nodes.list = list;
        nodes
    }

    /// Returns the number of nodes.
    #[inline]
    pub fn len(&self) -> u32 {
        self.list.len() as u32
    }

    /// Returns true when there is no node at all.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns true where the item was cut.
    #[inline]
    pub fn is_cut(&self, item: u32) -> bool {
        matches!(self.trees[item as usize], CutTree::Split { .. })
    }

    /// Returns the node of a whole item; `None` for an item that was cut or is not in the working set.
    #[inline]
    pub fn of_whole(&self, item: u32) -> Option<NodeId> {
        match self.trees[item as usize] {
            CutTree::Leaf(node) => node,
            CutTree::Split { .. } => None,
        }
    }

    /// Returns the node that the item's fragment at the pixel in column `x`, row `y` belongs to; `None` where
    /// its piece left the working set.
    #[inline]
    pub fn at(&self, view: &ProjectedModel, item: u32, x: u32, y: u32) -> Option<NodeId> {
        let mut tree = &self.trees[item as usize];
        loop {
            match tree {
                CutTree::Leaf(node) => return *node,
                CutTree::Split { plane, near, far } => {
                    tree = if is_near(view, item, *plane, x, y) { near } else { far };
                }
            }
        }
    }
}

impl CutTree {
    fn insert(&mut self, sides: &[CutSide], id: NodeId) {
        let Some((side, rest)) = sides.split_first() else {
            *self = CutTree::Leaf(Some(id));
            return;
        };
        if let CutTree::Leaf(_) = self {
            let leaf = || Box::new(CutTree::Leaf(None));
            *self = CutTree::Split { plane: side.plane, near: leaf(), far: leaf() };
        }
        let CutTree::Split { near, far, .. } = self else { unreachable!("made a split just above") };
        if side.near { near.insert(rest, id) } else { far.insert(rest, id) }
    }
}

/// Returns true when the fragment of `item` at this pixel lies on the camera's side of the plane of item
/// `plane`.
#[inline]
pub fn is_near(view: &ProjectedModel, item: u32, plane: u32, x: u32, y: u32) -> bool {
    let depth = |i: u32| view.items[i as usize].inverse_depth.at(x, y);
    depth(item) >= depth(plane)
}
