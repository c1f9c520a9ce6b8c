//! Merging of items that the user wants in one image layer, as far as the order of the stack allows.

use super::occlusion_graph::OcclusionGraph;
use super::quotient::Quotient;

/// The reason why two items cannot share an image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacle {
    /// A path of occlusions leads from one item to the other: something between them hides one and is hidden
    /// by the other, or they occlude each other directly.
    Occluded,
    /// The occlusion between the items contradicts the order and was forgiven.
    Forgiven,
    /// One sees through one of the items and not through the other.
    SeeThrough,
    /// A split keeps the items apart.
    Split,
    /// The rectangle around both items is larger than image layers may be.
    TooLarge,
}

/// An item that could not be merged as requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unsatisfied {
    /// Index of the merge.
    pub merge: u32,
    /// The item that was left out of the merge.
    pub item: u32,
    /// One of the items that it should have joined.
    pub with: u32,
    /// The reason why it was left out.
    pub why: Obstacle,
}

/// The result of [`bring_together`]: the items after all merges that were possible.
pub struct MergeResult {
    /// The graph of items, in which merged items form one group.
    pub quotient: Quotient,
    /// The members of each group of [`Self::quotient`], rising, at the index of the item that identifies the
    /// group; empty at all other indices.
    pub members: Vec<Vec<u32>>,
    /// The items that could not be merged, by merge.
    pub unsatisfied: Vec<Unsatisfied>,
}

/// Carries out the merges one after the other, each beginning with its first item; items that may not join
/// are left out and reported in [`MergeResult::unsatisfied`]. `order` is acyclic, and the quotient stays so.
/// `obstacle` returns what else keeps the members of a group (first argument) out of another group (second),
/// and the member of the latter that is concerned.
pub fn bring_together(
    order: &OcclusionGraph,
    merges: &[Vec<u32>],
    obstacle: impl Fn(&[u32], &[u32]) -> Option<(u32, Obstacle)>,
) -> MergeResult {
    let mut quotient = Quotient::new(order);
    let mut members: Vec<Vec<u32>> = (0..order.len).map(|item| vec![item]).collect();
    let mut unsatisfied = Vec::new();
    for (merge, items) in (0u32..).zip(merges) {
        let Some(&first) = items.first() else { continue };
        for &item in &items[1..] {
            let (a, b) = (quotient.group(first), quotient.group(item));
            if a == b {
                continue;
            }
            let (group, joining) = (&members[a as usize], &members[b as usize]);
            let occluded = || {
                quotient.connected(a, b).then(|| (connected_member(order, item, group), Obstacle::Occluded))
            };
            if let Some((with, why)) = obstacle(joining, group).or_else(occluded) {
                unsatisfied.push(Unsatisfied { merge, item, with, why });
                continue;
            }
            quotient.merge(a, b);
            let joining = std::mem::take(&mut members[b as usize]);
            members[a as usize].extend(joining);
            members[a as usize].sort_unstable();
        }
    }
    MergeResult { quotient, members, unsatisfied }
}

/// Returns the first member of a group that a path of occlusions connects with `item`, or simply the first
/// member where only earlier merges connect them.
fn connected_member(order: &OcclusionGraph, item: u32, group: &[u32]) -> u32 {
    let leads = |a: u32, b: u32| order.shortest_path(a, b).is_some();
    group.iter().copied().find(|&member| leads(item, member) || leads(member, item)).unwrap_or(group[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(_: &[u32], _: &[u32]) -> Option<(u32, Obstacle)> {
        None
    }

    #[test]
    fn what_does_not_hide_each_other_is_brought_together_and_the_rest_told() {
        // 0 hides 1, which hides 2; 3 is free.
        let order = OcclusionGraph::new(4, [(0, 1, 9), (1, 2, 9)]);
        let together = bring_together(&order, &[vec![0, 2, 3]], free);
        assert_eq!(together.members, [vec![0, 3], vec![1], vec![2], vec![]]);
        assert_eq!(
            together.unsatisfied,
            [Unsatisfied { merge: 0, item: 2, with: 0, why: Obstacle::Occluded }]
        );
    }

    #[test]
    fn a_merge_that_would_close_a_ring_with_an_earlier_one_is_told() {
        // 0 hides 1, 2 hides 3: {0, 3} and {1, 2} hide each other.
        let order = OcclusionGraph::new(4, [(0, 1, 9), (2, 3, 9)]);
        let together = bring_together(&order, &[vec![0, 3], vec![1, 2]], free);
        assert_eq!(together.members[0], [0, 3]);
        assert_eq!(
            together.unsatisfied,
            [Unsatisfied { merge: 1, item: 2, with: 1, why: Obstacle::Occluded }]
        );
    }

    #[test]
    fn merges_that_share_a_thing_become_one() {
        let order = OcclusionGraph::new(4, []);
        let together = bring_together(&order, &[vec![1, 2], vec![0, 2, 3]], free);
        assert!(together.members.contains(&vec![0, 1, 2, 3]) && together.unsatisfied.is_empty());
    }

    #[test]
    fn other_obstacles_are_told_by_what_stays_out_and_what_they_lie_before() {
        // 3 is together with 2, which must not join 1.
        let order = OcclusionGraph::new(4, []);
        let keeps = |joining: &[u32], group: &[u32]| {
            (joining.contains(&2) && group.contains(&1)).then_some((1, Obstacle::Split))
        };
        let together = bring_together(&order, &[vec![2, 3], vec![0, 1, 3]], keeps);
        assert_eq!(together.members[0], [0, 1]);
        assert_eq!(together.unsatisfied, [Unsatisfied { merge: 1, item: 3, with: 1, why: Obstacle::Split }]);
    }
}
