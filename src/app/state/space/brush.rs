//! The brush of the 3D view: its settings, the stroke that is being drawn, and strokes that wait to become paint.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::view_pixel::ViewPixel;
use quadratura_document::stroke::{Brush, BrushMode, STROKE_VERSION, Stroke, StrokeSample, StrokeView};
use quadratura_view::navigation::Viewpoint;

/// The factor by which a key resizes the brush.
pub const STEP: f64 = 1.25;
/// The radii of the brush, in pixels of the view.
pub const RADII_PX: std::ops::RangeInclusive<f64> = 1.0..=500.0;
/// The least distance in pixels between two positions of a stroke: a resting hand adds none.
const LEAST_STEP_PX: f64 = 1.0;

/// The brush of the 3D view.
#[derive(Debug, Clone)]
pub struct SpaceBrush {
    /// Whether it is in use: the left button paints.
    pub on: bool,
    /// Its mode, size in pixels of the view, hardness, opacity and colour.
    pub brush: Brush,
    /// The point of the model from which clone and heal take colours.
    pub source: Option<DVec3>,
    /// The stroke that is being drawn.
    pub stroke: Option<DrawnStroke>,
    /// The strokes that wait to become paint, in their order; the first one may be in work.
    pub waiting: VecDeque<Arc<DrawnStroke>>,
    /// Whether the first waiting stroke is in work.
    pub is_painting: bool,
    /// Whether that stroke is undone already: it is not seen any more.
    pub is_undone: bool,
    /// The strokes that have become paint, which the picture of the view does not contain yet.
    pub unseen: Vec<UnseenStroke>,
    /// The parts of the last stroke that could not become paint, in words.
    pub remark: Option<String>,
}

/// A stroke that has become paint, until a picture contains it.
#[derive(Debug, Clone)]
pub struct UnseenStroke {
    /// The stroke.
    pub drawn: Arc<DrawnStroke>,
    /// The number of its import.
    pub number: u32,
    /// The revision of the first picture that contains it.
    pub revision: u64,
}

/// A stroke and the viewpoint from which it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnStroke {
    /// The viewpoint.
    pub viewpoint: Viewpoint,
    /// The stroke.
    pub stroke: Stroke,
}

impl Default for SpaceBrush {
    fn default() -> Self {
        let brush =
            Brush { mode: BrushMode::Colour, radius: 20.0, hardness: 0.5, opacity: 1.0, colour: [128; 3] };
        Self {
            on: false,
            brush,
            source: None,
            stroke: None,
            waiting: VecDeque::new(),
            is_painting: false,
            is_undone: false,
            unseen: Vec::new(),
            remark: None,
        }
    }
}

impl SpaceBrush {
    /// Resizes the brush by a factor.
    pub fn resize(&mut self, factor: f64) {
        self.brush.radius = (self.brush.radius * factor).clamp(*RADII_PX.start(), *RADII_PX.end());
    }

    /// Returns the position of the source in a view, in pixels; `None` where there is none, or it is behind the view.
    pub fn source_px(&self, view: &Viewpoint, [width, height]: [u32; 2]) -> Option<DVec2> {
        view.camera(width, height).image_from_camera(view.pose.camera_from_world(self.source?))
    }

    /// Starts a stroke at a position of the view; returns false where a source is needed and there is none in the view.
    pub fn begin(&mut self, start: &ViewPixel, pressure: f64) -> bool {
        let ViewPixel { viewpoint, size_px, at_px } = start;
        let source = self.source_px(viewpoint, *size_px);
        if self.brush.mode.has_source() && source.is_none() {
            return false;
        }
        let [width, height] = *size_px;
        let stroke = Stroke {
            version: STROKE_VERSION,
            view: StrokeView::new(&viewpoint.camera(width, height), &viewpoint.pose),
            brush: self.brush.clone(),
            source: source.filter(|_| self.brush.mode.has_source()).map(|px| px.to_array()),
            layer: None,
            samples: vec![StrokeSample { at: at_px.to_array(), pressure }],
        };
        self.stroke = Some(DrawnStroke { viewpoint: *viewpoint, stroke });
        self.remark = None;
        true
    }

    /// Moves the stroke that is being drawn to a position.
    pub fn go_to(&mut self, at_px: DVec2, pressure: f64) {
        let Some(drawn) = &mut self.stroke else { return };
        let last = drawn.stroke.samples.last().map(|sample| DVec2::from(sample.at));
        if last.is_none_or(|last| last.distance(at_px) >= LEAST_STEP_PX) {
            drawn.stroke.samples.push(StrokeSample { at: at_px.to_array(), pressure });
        }
    }

    /// Ends the stroke: it waits to become paint.
    pub fn end(&mut self) {
        self.waiting.extend(self.stroke.take().map(Arc::new));
    }

    /// Returns the strokes that the picture of the view does not contain yet, oldest first.
    pub fn previews(&self) -> impl Iterator<Item = &DrawnStroke> {
        let unseen = self.unseen.iter().map(|stroke| &*stroke.drawn);
        let waiting = self.waiting.iter().skip(usize::from(self.is_undone)).map(|drawn| &**drawn);
        let all = unseen.chain(waiting).chain(&self.stroke);
        // Strokes of the matte brush are in photos.
        all.filter(|drawn| !drawn.stroke.brush.mode.is_of_matte())
    }

    /// Returns how many strokes have not become paint yet, with the one that is being drawn.
    pub fn unpainted(&self) -> usize {
        self.waiting.len() + usize::from(self.stroke.is_some())
    }

    /// Drops the strokes that have not become paint yet; returns how many there were.
    pub fn drop_unpainted(&mut self) -> usize {
        let count = self.unpainted();
        self.waiting.clear();
        (self.stroke, self.is_painting, self.is_undone) = (None, false, false);
        count
    }

    /// Takes the first waiting stroke, where it is this one: it has ended.
    pub fn take_ended(&mut self, drawn: &Arc<DrawnStroke>) -> Option<Arc<DrawnStroke>> {
        self.waiting.front().filter(|first| Arc::ptr_eq(first, drawn))?;
        (self.is_painting, self.is_undone) = (false, false);
        self.waiting.pop_front()
    }

    /// Takes the previews of strokes that a picture of this revision contains.
    pub fn seen(&mut self, revision: u64) -> Vec<UnseenStroke> {
        self.unseen.extract_if(.., |stroke| stroke.revision <= revision).collect()
    }

    /// Drops the preview of a stroke whose import was undone.
    pub fn undone(&mut self, number: u32) {
        self.unseen.retain(|stroke| stroke.number != number);
    }

    /// Cancels the stroke that is being drawn; returns whether there was one.
    pub fn give_up(&mut self) -> bool {
        self.stroke.take().is_some()
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    fn begin(brush: &mut SpaceBrush) -> bool {
        let pose = look_at(DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO);
        let view = Viewpoint::of_camera(&centred(64, 48, 50.0), &pose, DVec3::ZERO);
        let at_px = DVec2::new(10.0, 24.0);
        brush.begin(&ViewPixel { viewpoint: view, size_px: [64, 48], at_px }, 1.0)
    }

    /// Returns a stroke of colour.
    pub fn a_stroke() -> Stroke {
        let mut brush = SpaceBrush::default();
        begin(&mut brush);
        brush.stroke.unwrap().stroke
    }

    #[test]
    fn cloning_needs_a_source_and_painting_a_colour_does_not() {
        let mut brush = SpaceBrush::default();
        assert_eq!(brush.brush.mode, BrushMode::Colour, "the first stroke needs nothing else");
        brush.brush.mode = BrushMode::Clone;
        assert!(!begin(&mut brush) && brush.stroke.is_none());
        brush.source = Some(DVec3::ZERO);
        assert!(begin(&mut brush));
        let source = brush.stroke.as_ref().unwrap().stroke.source.unwrap();
        assert!(DVec2::from(source).distance(DVec2::new(32.0, 24.0)) < 1e-9);
        brush.brush.mode = BrushMode::Colour;
        brush.source = None;
        assert!(begin(&mut brush));
        assert_eq!(brush.stroke.as_ref().unwrap().stroke.problem(), None);
    }

    #[test]
    fn a_stroke_waits_when_it_ends_and_a_resting_hand_adds_nothing() {
        let mut brush = SpaceBrush::default();
        brush.brush.mode = BrushMode::Erase;
        begin(&mut brush);
        [10.2, 10.4, 20.0].into_iter().for_each(|x| brush.go_to(DVec2::new(x, 24.0), 0.5));
        brush.end();
        assert_eq!((brush.waiting.len(), brush.waiting[0].stroke.samples.len()), (1, 2));
        assert!(!brush.give_up());
    }

    #[test]
    fn a_stroke_is_previewed_until_a_picture_contains_it_or_it_is_undone() {
        let mut brush = SpaceBrush::default();
        for number in 1..=3 {
            begin(&mut brush);
            brush.end();
            let first = brush.waiting[0].clone();
            let drawn = brush.take_ended(&first).unwrap();
            brush.unseen.push(UnseenStroke { drawn, number, revision: u64::from(number) + 10 });
        }
        begin(&mut brush);
        assert_eq!((brush.previews().count(), brush.unpainted()), (4, 1));
        assert!(brush.seen(10).is_empty(), "this picture is older");
        assert_eq!(brush.previews().count(), 4);
        assert_eq!(brush.seen(11).len(), 1);
        brush.undone(3);
        assert_eq!(brush.unseen.iter().map(|stroke| stroke.number).collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn a_stroke_that_is_undone_while_it_is_in_work_is_not_seen_any_more() {
        let mut brush = SpaceBrush::default();
        for _ in 0..2 {
            begin(&mut brush);
            brush.end();
        }
        (brush.is_painting, brush.is_undone) = (true, true);
        assert_eq!(brush.previews().count(), 1);
        let first = brush.waiting[0].clone();
        brush.take_ended(&first).unwrap();
        assert_eq!((brush.previews().count(), brush.is_undone), (1, false), "the next one is seen");
    }

    #[test]
    fn the_brush_stays_within_its_sizes() {
        let mut brush = SpaceBrush::default();
        brush.resize(1e9);
        assert_eq!(brush.brush.radius, *RADII_PX.end());
        brush.resize(1e-9);
        assert_eq!(brush.brush.radius, *RADII_PX.start());
    }
}
