//! Brings together what shall share an image layer, as far as the order of the stack allows.

use super::graph::Graph;
use super::quotient::Quotient;

/// Why two things share no image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacle {
    /// A path of occlusions leads from one to the other: what lies between them hides the one, and is
    /// hidden by the other, or they hide each other themselves.
    Occluded,
    /// Their occlusion contradicts the order and was forgiven.
    Forgiven,
    /// A split keeps them apart.
    Split,
    /// The rectangle around both is larger than image layers may be.
    TooLarge,
}

/// A wish that was not met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unmet {
    /// Its place among the merges.
    pub merge: u32,
    /// The thing that stayed out of it.
    pub item: u32,
    /// One of those that it should have joined.
    pub with: u32,
    /// Why.
    pub why: Obstacle,
}

/// Things after the merges that were possible.
pub struct Together {
    /// Things with those brought together merged.
    pub quotient: Quotient,
    /// By thing that names a group of [`Self::quotient`] its members, rising; empty for all others.
    pub members: Vec<Vec<u32>>,
    /// What was not possible, by merge.
    pub unmet: Vec<Unmet>,
}

/// Merges one list after the other, of each from its first thing on: what may not join is left out and
/// told. `order` is acyclic and stays so. `obstacle` says what else keeps the members of a group out of
/// another one, and which of the latter it lies before.
pub fn bring_together(
    order: &Graph,
    merges: &[Vec<u32>],
    obstacle: impl Fn(&[u32], &[u32]) -> Option<(u32, Obstacle)>,
) -> Together {
    let mut quotient = Quotient::new(order);
    let mut members: Vec<Vec<u32>> = (0..order.len).map(|item| vec![item]).collect();
    let mut unmet = Vec::new();
    for (merge, items) in (0u32..).zip(merges) {
        let Some(&first) = items.first() else { continue };
        for &item in &items[1..] {
            let (a, b) = (quotient.group(first), quotient.group(item));
            if a == b {
                continue;
            }
            let (group, joining) = (&members[a as usize], &members[b as usize]);
            let occluded =
                || quotient.connected(a, b).then(|| (tied(order, item, group), Obstacle::Occluded));
            if let Some((with, why)) = obstacle(joining, group).or_else(occluded) {
                unmet.push(Unmet { merge, item, with, why });
                continue;
            }
            quotient.merge(a, b);
            let joining = std::mem::take(&mut members[b as usize]);
            members[a as usize].extend(joining);
            members[a as usize].sort_unstable();
        }
    }
    Together { quotient, members, unmet }
}

/// One of a group that a path of occlusions ties to `item`; the first where merges of others tie them.
fn tied(order: &Graph, item: u32, group: &[u32]) -> u32 {
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
        let order = Graph::new(4, [(0, 1, 9), (1, 2, 9)]);
        let together = bring_together(&order, &[vec![0, 2, 3]], free);
        assert_eq!(together.members, [vec![0, 3], vec![1], vec![2], vec![]]);
        assert_eq!(together.unmet, [Unmet { merge: 0, item: 2, with: 0, why: Obstacle::Occluded }]);
    }

    #[test]
    fn a_merge_that_would_close_a_ring_with_an_earlier_one_is_told() {
        // 0 hides 1, 2 hides 3: {0, 3} and {1, 2} hide each other.
        let order = Graph::new(4, [(0, 1, 9), (2, 3, 9)]);
        let together = bring_together(&order, &[vec![0, 3], vec![1, 2]], free);
        assert_eq!(together.members[0], [0, 3]);
        assert_eq!(together.unmet, [Unmet { merge: 1, item: 2, with: 1, why: Obstacle::Occluded }]);
    }

    #[test]
    fn merges_that_share_a_thing_become_one() {
        let order = Graph::new(4, []);
        let together = bring_together(&order, &[vec![1, 2], vec![0, 2, 3]], free);
        assert!(together.members.contains(&vec![0, 1, 2, 3]) && together.unmet.is_empty());
    }

    #[test]
    fn other_obstacles_are_told_by_what_stays_out_and_what_they_lie_before() {
        // 3 is together with 2, which must not join 1.
        let order = Graph::new(4, []);
        let keeps = |joining: &[u32], group: &[u32]| {
            (joining.contains(&2) && group.contains(&1)).then_some((1, Obstacle::Split))
        };
        let together = bring_together(&order, &[vec![2, 3], vec![0, 1, 3]], keeps);
        assert_eq!(together.members[0], [0, 1]);
        assert_eq!(together.unmet, [Unmet { merge: 1, item: 3, with: 1, why: Obstacle::Split }]);
    }
}
