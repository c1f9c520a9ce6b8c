//! Figures of a stack's image layers, and sorting by them.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use quadratura_document::{ImageLayer, Stack};
use quadratura_layers::LayerIndex;

/// Texel counts of an image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LayerFigures {
    /// The number of texels of the rectangle.
    pub texels: u64,
    /// The number of texels that a surface covers.
    pub used: u64,
    /// The number of texels that no surface covers.
    pub waste: u64,
    /// The number of covered texels that are hidden in the photo.
    pub hidden: u64,
    /// The number of hidden texels that are filled.
    pub filled: u64,
}

impl LayerFigures {
    /// Returns the figures of one layer.
    pub fn from_layer(layer: &ImageLayer) -> Self {
        let texels = layer.rect.area();
        Self {
            texels,
            used: layer.texels_used,
            waste: texels.saturating_sub(layer.texels_used),
            hidden: layer.texels_used.saturating_sub(layer.texels_visible),
            filled: layer.fill.as_ref().map_or(0, |fill| fill.texels_filled),
        }
    }

    /// Returns the sums over several layers.
    pub fn sum(layers: impl Iterator<Item = Self>) -> Self {
        layers.fold(Self::default(), |sum, one| Self {
            texels: sum.texels + one.texels,
            used: sum.used + one.used,
            waste: sum.waste + one.waste,
            hidden: sum.hidden + one.hidden,
            filled: sum.filled + one.filled,
        })
    }

    /// Returns the share of the rectangle that surfaces cover, 0..=1.
    pub fn used_share(&self) -> f64 {
        share(self.used, self.texels)
    }

    /// Returns the share of covered texels that are hidden in the photo, 0..=1.
    pub fn hidden_share(&self) -> f64 {
        share(self.hidden, self.used)
    }

    /// Returns the share of hidden texels that are filled, 0..=1; `None` where none are hidden.
    pub fn filled_share(&self) -> Option<f64> {
        (self.hidden > 0).then(|| share(self.filled, self.hidden))
    }
}

/// Returns `part / all`, or 0 for 0 / 0.
fn share(part: u64, all: u64) -> f64 {
    part as f64 / all.max(1) as f64
}

/// A column of the table of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum LayerColumn {
    /// The name: [`ImageLayer::name`].
    Name,
    /// The depth: [`ImageLayer::order`].
    #[default]
    Depth,
    /// The size: [`LayerFigures::texels`].
    Size,
    /// The covered share: [`LayerFigures::used_share`].
    Used,
    /// The number of unused texels: [`LayerFigures::waste`].
    Waste,
    /// The hidden share: [`LayerFigures::hidden_share`].
    Hidden,
    /// The filled share: [`LayerFigures::filled_share`].
    Filled,
    /// The filling's mean confidence, 0..=1.
    Trust,
}

impl LayerColumn {
    /// All columns from left to right.
    pub const ALL: [Self; 8] = [
        Self::Name,
        Self::Depth,
        Self::Size,
        Self::Hidden,
        Self::Used,
        Self::Waste,
        Self::Filled,
        Self::Trust,
    ];

    /// Returns true for columns that sort in descending order at first; names and depths ascend.
    pub fn descends_by_default(self) -> bool {
        !matches!(self, Self::Name | Self::Depth)
    }
}

/// Returns the indices of a stack's layers, sorted by one column. Ties are in index order, and layers without a
/// value come last. `trust` returns the mean confidence of the filling of the layer at an index, where that is
/// known.
pub fn sorted(
    stack: &Stack,
    column: LayerColumn,
    falling: bool,
    trust: impl Fn(LayerIndex) -> Option<f64>,
) -> Vec<LayerIndex> {
    let value = |(index, layer): (LayerIndex, &ImageLayer)| {
        let figures = LayerFigures::from_layer(layer);
        let value = match column {
            LayerColumn::Name => None,
            LayerColumn::Depth => Some(f64::from(layer.order)),
            LayerColumn::Size => Some(figures.texels as f64),
            LayerColumn::Used => Some(figures.used_share()),
            LayerColumn::Waste => Some(figures.waste as f64),
            LayerColumn::Hidden => Some(figures.hidden_share()),
            LayerColumn::Filled => figures.filled_share(),
            LayerColumn::Trust => trust(index),
        };
        (value, index)
    };
    let mut indexed: Vec<(Option<f64>, LayerIndex)> = stack.numbered_layers().map(value).collect();
    let name = |index: &LayerIndex| &stack.layer(*index).name;
    let turned = |order: Ordering| if falling { order.reverse() } else { order };
    indexed.sort_by(|(a, at), (b, bt)| {
        let by_value = match (a, b) {
            (Some(a), Some(b)) => turned(a.total_cmp(b)),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) if column == LayerColumn::Name => turned(by_name(name(at), name(bt))),
            (None, None) => Ordering::Equal,
        };
        by_value.then(at.cmp(bt))
    });
    indexed.into_iter().map(|(_, index)| index).collect()
}

/// Compares names without regard to case; equal ones by their bytes.
fn by_name(a: &str, b: &str) -> Ordering {
    let lower = |name: &str| name.chars().flat_map(char::to_lowercase).collect::<Vec<_>>();
    lower(a).cmp(&lower(b)).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::assemble;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_base::task::Task;
    use quadratura_document::stack::LayerFill;
    use quadratura_layers::{LayerConstraints, Options, SoftwareRasteriser, sort_photo};

    /// Makes the stack of five steps, each half hidden by the next.
    fn stack() -> Stack {
        let scene = closed_form::stairs();
        let (site, photo) = (scene.site(), scene.photo());
        let options = Options::default();
        let constraints = LayerConstraints::default();
        let task = Task::silent();
        let sorted = sort_photo(
            &site.model,
            &photo.camera,
            &photo.pose,
            &SoftwareRasteriser,
            &options,
            &constraints,
            &task,
        );
        assemble(&site.model, &photo, &sorted.unwrap(), &options, &constraints, "")
    }

    #[test]
    fn figures_add_up() {
        let stack = stack();
        let sum = LayerFigures::sum(stack.image_layers.iter().map(LayerFigures::from_layer));
        assert_eq!((sum.texels, sum.used), (stack.texels, stack.texels_used));
        assert_eq!(sum.used + sum.waste, sum.texels);
        assert!(sum.hidden > 0 && sum.hidden_share() < 1.0 && sum.filled_share() == Some(0.0));
        assert_eq!(LayerFigures::default().filled_share(), None, "nothing is hidden");
    }

    #[test]
    fn layers_come_by_any_column_and_the_other_way_round() {
        let mut stack = stack();
        let count = stack.image_layers.len();
        assert!(count >= 3, "{count}");
        let names = ["Window", "arch", "tower", "Wall", "box"];
        stack.image_layers.iter_mut().zip(names).for_each(|(layer, name)| layer.name = name.into());
        let sorted = |column, falling| sorted(&stack, column, falling, |_| None);
        let by_name: Vec<&str> = sorted(LayerColumn::Name, false)
            .into_iter()
            .map(|index| stack.layer(index).name.as_str())
            .collect();
        let mut expected: Vec<&str> = names[..count].to_vec();
        expected.sort_by_key(|name| name.to_lowercase());
        assert_eq!(by_name, expected);
        let waste = |index: LayerIndex| LayerFigures::from_layer(stack.layer(index)).waste;
        assert!(sorted(LayerColumn::Waste, true).windows(2).all(|pair| waste(pair[0]) >= waste(pair[1])));
        assert!(sorted(LayerColumn::Waste, false).windows(2).all(|pair| waste(pair[0]) <= waste(pair[1])));
        assert_eq!(
            sorted(LayerColumn::Depth, false),
            stack.layer_indices().collect::<Vec<_>>(),
            "as they lie in the stack"
        );
    }

    #[test]
    fn what_has_no_value_comes_last_either_way() {
        let mut stack = stack();
        let whole = stack.numbered_layers().find(|(_, layer)| layer.texels_used == layer.texels_visible);
        let (whole, _) = whole.expect("nothing lies before the nearest step");
        for layer in &mut stack.image_layers {
            let file = || "x.png".to_owned();
            layer.fill = Some(LayerFill {
                filled_file: file(),
                confidence_file: file(),
                provenance_file: file(),
                propagation_file: None,
                matte_file: None,
                foreground_file: None,
                texels_filled: 1,
            });
        }
        for falling in [false, true] {
            let by_filled = sorted(&stack, LayerColumn::Filled, falling, |_| None);
            assert_eq!(by_filled.last(), Some(&whole));
            let by_trust =
                sorted(&stack, LayerColumn::Trust, falling, |place| (place != LayerIndex(1)).then_some(0.5));
            assert_eq!(by_trust.last(), Some(&LayerIndex(1)));
        }
    }
}
