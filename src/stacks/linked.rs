//! Linked image layers: parts of one object that a merge asks for in one image layer, although the order of the stack
//! does not allow it. They stay separate, and are named, coloured and selected as one.

use crate::unsatisfied::{holds, of_merge};
use quadratura_document::Element;
use quadratura_layers::together::Obstacle;
use quadratura_layers::{Faces, LayerConstraints, Sorted};

/// The image layers of one object that a merge links.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LinkedLayers {
    /// The unique name of the object.
    pub object: String,
    /// The indices of the image layers, nearest first; two at least.
    pub layers: Vec<usize>,
}

/// Returns true when image layers that a merge cannot put into one are linked: all its faces are of one object.
pub(super) fn is_linkable(merge: &[Faces], why: Obstacle) -> bool {
    merge.iter().all(|faces| faces.object == merge[0].object) && why != Obstacle::Split
}

/// Returns the image layers that merges link. A layer is in one group at most, that of the first merge.
pub(super) fn linked_layers(
    constraints: &LayerConstraints,
    sorted: &Sorted,
    elements: &[Element],
) -> Vec<LinkedLayers> {
    let mut linked: Vec<LinkedLayers> = Vec::new();
    for (number, merge) in (0u32..).zip(&constraints.merge) {
        let left_out = of_merge(merge, number, &sorted.clusters.unsatisfied, elements);
        if left_out.is_empty() || !left_out.iter().all(|u| is_linkable(merge, u.why)) {
            continue;
        }
        let is_asked = |element: &Element| merge.iter().any(|faces| holds(element, faces));
        let taken = |layer: &usize| linked.iter().any(|other| other.layers.contains(layer));
        let clusters = sorted.clusters.list.iter().enumerate();
        let layers: Vec<usize> = clusters
            .filter(|(_, cluster)| cluster.patches.iter().any(|p| is_asked(&elements[p.element.index()])))
            .map(|(layer, _)| layer)
            .filter(|layer| !taken(layer))
            .collect();
        if layers.len() > 1 {
            linked.push(LinkedLayers { object: merge[0].object.clone(), layers });
        }
    }
    linked
}

/// Returns the name of an object in an image layer: with `(front)`, `(middle)` or `(back)` where the layer is one of
/// several that are linked for this object.
pub(super) fn name_in_layer(object: &str, layer: usize, linked: &[LinkedLayers]) -> String {
    let mut of_object = linked.iter().filter(|linked| linked.object == object);
    let place = of_object.find_map(|linked| {
        let at = linked.layers.iter().position(|other| *other == layer)?;
        Some((at, linked.layers.len()))
    });
    match place {
        None => object.to_owned(),
        Some((0, _)) => format!("{object} (front)"),
        Some((at, count)) if at + 1 == count => format!("{object} (back)"),
        Some((_, 3)) => format!("{object} (middle)"),
        Some((at, _)) => format!("{object} (middle {at})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linked_layers_say_where_they_are_and_others_do_not() {
        let linked =
            |count: usize| vec![LinkedLayers { object: "column".into(), layers: (4..4 + count).collect() }];
        let names = |count: usize| {
            (4..4 + count).map(|l| name_in_layer("column", l, &linked(count))).collect::<Vec<_>>()
        };
        assert_eq!(names(2), ["column (front)", "column (back)"]);
        assert_eq!(names(3), ["column (front)", "column (middle)", "column (back)"]);
        assert_eq!(names(4)[1..3], ["column (middle 1)", "column (middle 2)"]);
        assert_eq!(name_in_layer("column", 9, &linked(2)), "column");
        assert_eq!(name_in_layer("wall", 4, &linked(2)), "wall");
    }
}
