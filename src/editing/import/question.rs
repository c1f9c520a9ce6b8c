//! The question about an import that changes nearly everything at once: a filter on all layers, other colours or
//! another document of the same size look like that, and strokes do not.

use serde::Serialize;

use super::compare::PlacedRaster;
use super::tones::{ChangeKind, Tones};
use quadratura_document::paint::PaintPatch;

/// The share of a layer's exported pixels beyond which the layer counts as changed as a whole, and the share of the
/// layers, and of their area, beyond which an import is questioned: what is meant for a part changes less than half.
const MOST: f64 = 0.5;
/// In documents of fewer layers than this, the share of all pixels together has to be more than [`MOST`], and that of *each*
/// layer more than [`A_GOOD_PART`]: to paint over one of two walls is nothing unusual, and a filter leaves plain areas as they
/// were.
const FEW_LAYERS: usize = 4;
const A_GOOD_PART: f64 = 0.25;
/// The least number of pixels about which to ask: a small layer is easily painted over as a whole.
const LEAST_PIXELS: u64 = 2000;

/// How much of an image layer differs from its export.
#[derive(Debug, Clone, Default)]
pub struct LayerChange {
    /// The number of pixels that the export showed; 0 where the layer is as at the last import, and was not compared.
    pub shown: u64,
    /// The number of these that show something else.
    pub replaced: u64,
    /// How the colours of these pixels have changed.
    pub tones: Tones,
}

impl LayerChange {
    /// Compares a layer with its paint.
    pub fn new(base: PlacedRaster, patch: &PaintPatch) -> Self {
        let shown = base.rect.pixels().filter(|(x, y)| base.at(*x, *y)[3] != 0).count() as u64;
        let (mut replaced, mut tones) = (0, Tones::default());
        for (x, y, colour) in patch.iter() {
            let before = base.at(x, y);
            if before[3] != 0 {
                replaced += 1;
                tones.add(before, colour);
            }
        }
        Self { shown, replaced, tones }
    }

    /// Returns true when most of the exported pixels are as they were: the layer lies where it was.
    pub fn is_in_place(&self) -> bool {
        self.shown > 0 && (self.replaced as f64) < MOST * self.shown as f64
    }

    /// Returns the share of the exported pixels that show something else and are new since the last import.
    fn share(&self, changed: u64) -> f64 {
        self.replaced.min(changed) as f64 / self.shown.max(1) as f64
    }
}

/// A layer in the balance.
#[derive(Debug, Clone)]
pub struct WeighedLayer {
    /// How it differs from its export.
    pub change: LayerChange,
    /// The area of its rectangle.
    pub area: u64,
    /// The number of pixels whose paint is new.
    pub changed: u64,
}

/// What has changed at once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Question {
    /// The number of layers of which most pixels have changed ...
    pub layers: usize,
    /// ... of this number.
    pub of_layers: usize,
    /// The number of pixels.
    pub pixels: u64,
    /// What was done to them, as far as they tell.
    pub kind: ChangeKind,
}

impl Question {
    /// Returns the question about the layers of a file; `None` where there is nothing to ask.
    pub fn of(layers: &[WeighedLayer]) -> Option<Self> {
        let (few, share) = (layers.len() < FEW_LAYERS, |of: &WeighedLayer| of.change.share(of.changed));
        let least = if few { A_GOOD_PART } else { MOST };
        let whole: Vec<_> = layers.iter().filter(|of| share(of) > least).collect();
        let is_most = if few {
            let sum = |value: fn(&WeighedLayer) -> u64| layers.iter().map(value).sum::<u64>() as f64;
            let replaced = sum(|of| of.change.replaced.min(of.changed));
            layers.len() > 1 && whole.len() == layers.len() && replaced > MOST * sum(|of| of.change.shown)
        } else {
            let area = |of: &WeighedLayer| of.area as f64;
            let (changed_area, all_area): (f64, f64) =
                (whole.iter().map(|of| area(of)).sum(), layers.iter().map(area).sum());
            whole.len() as f64 > MOST * layers.len() as f64 && changed_area > MOST * all_area
        };
        let pixels = whole.iter().map(|of| of.changed).sum();
        (is_most && pixels >= LEAST_PIXELS).then(|| {
            let tones = whole.iter().fold(Tones::default(), |sum, of| sum.with(&of.change.tones));
            Self { layers: whole.len(), of_layers: layers.len(), pixels, kind: tones.kind() }
        })
    }

    /// Returns what was found, in a sentence.
    pub fn found(&self) -> String {
        let Self { layers, of_layers, pixels, kind } = self;
        let cause = kind.found();
        format!(
            "most pixels of {layers} of {of_layers} layers have changed at once ({pixels} pixels); {cause}. Nothing of it \
             was imported"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(shown: u64, replaced: u64, changed: u64) -> WeighedLayer {
        let change = LayerChange { shown, replaced, tones: Tones::default() };
        WeighedLayer { change, area: shown.max(5000), changed }
    }

    #[test]
    fn most_pixels_of_most_layers_are_a_question() {
        let mut layers = vec![layer(5000, 4000, 4000); 4];
        layers.extend(vec![layer(5000, 100, 100); 3]);
        let question = Question::of(&layers).unwrap();
        assert_eq!((question.layers, question.of_layers, question.pixels), (4, 7, 16_000));
        layers.extend(vec![layer(0, 0, 0); 2]);
        assert_eq!(Question::of(&layers), None, "five of nine are as they were");
    }

    #[test]
    fn what_was_imported_before_holes_and_what_was_undone_are_no_question() {
        assert_eq!(Question::of(&vec![layer(5000, 5000, 30); 6]), None, "imported with --all before");
        assert_eq!(Question::of(&vec![layer(1000, 0, 9000); 6]), None, "holes are meant to be painted");
        assert_eq!(Question::of(&vec![layer(5000, 0, 5000); 6]), None, "undone in the editor");
    }

    #[test]
    fn small_documents_are_asked_about_only_where_everything_has_changed() {
        assert_eq!(Question::of(&[layer(9000, 9000, 9000)]), None, "one wall may be painted over");
        assert_eq!(Question::of(&[layer(9000, 9000, 9000), layer(9000, 10, 10)]), None);
        assert_eq!(
            Question::of(&[layer(9000, 9000, 9000), layer(9000, 9000, 9000), layer(9000, 10, 10)]),
            None,
            "two of three walls may be painted over"
        );
        assert!(Question::of(&vec![layer(9000, 8500, 8500); 2]).is_some());
        let blurred = [layer(9000, 7000, 7000), layer(6000, 2500, 2500), layer(9000, 8000, 8000)];
        assert_eq!(Question::of(&blurred).unwrap().layers, 3, "a plain wall changes less");
        assert_eq!(Question::of(&blurred[..1]), None);
        assert_eq!(Question::of(&vec![layer(100, 100, 100); 9]), None, "a few pixels");
    }

    #[test]
    fn most_layers_are_no_question_where_they_are_small() {
        let mut layers = vec![layer(5000, 5000, 5000); 6];
        layers.extend(vec![layer(90_000, 0, 0); 2]);
        assert_eq!(Question::of(&layers), None);
    }
}
