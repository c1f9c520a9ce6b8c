//! The list of layers and groups in an XCF, from top to bottom.

use crate::{Group, LayerNode, LayeredDocument, PixelLayer};

/// An entry of the list.
pub enum XcfItem<'d, 'a> {
    /// A group, which precedes its layers.
    Group(&'d Group<'a>),
    /// A layer, with its path where it is in a group: the group's number from the top, and its own within the
    /// group.
    Layer(&'d PixelLayer<'a>, Option<[u32; 2]>),
}

/// Returns all entries.
pub fn items<'d, 'a>(document: &'d LayeredDocument<'a>) -> Vec<XcfItem<'d, 'a>> {
    let mut list = Vec::new();
    for (outer, node) in (0..).zip(document.nodes.iter().rev()) {
        match node {
            LayerNode::Layer(layer) => list.push(XcfItem::Layer(layer, None)),
            LayerNode::Group(group) => {
                list.push(XcfItem::Group(group));
                let layers = (0..).zip(group.layers.iter().rev());
                list.extend(layers.map(|(inner, layer)| XcfItem::Layer(layer, Some([outer, inner]))));
            }
        }
    }
    list
}

impl<'d, 'a> XcfItem<'d, 'a> {
    /// Returns the name of the layer or group.
    pub fn name(&self) -> &'d str {
        match self {
            Self::Group(group) => &group.name,
            Self::Layer(layer, _) => &layer.name,
        }
    }

    /// Returns the layer, if it is one.
    pub fn layer(&self) -> Option<&'d PixelLayer<'a>> {
        match self {
            Self::Group(_) => None,
            Self::Layer(layer, _) => Some(layer),
        }
    }
}
