//! A stroke of brush or lasso while it is drawn.

use std::sync::Arc;

use glam::{DVec2, Vec2};

use super::keeping::MaskWork;
use super::tool::MaskTool;
use quadratura_base::geometry::drawn::{brushed, enclosed};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_document::masks::MaskOrigin;
use quadratura_document::stroke::{Brush, STROKE_VERSION, Stroke, StrokeSample, StrokeView};
use quadratura_sites::masks::MaskEdit;

/// The smallest distance between points of a stroke, in points of the screen; smaller details do not matter.
const NEAR: f32 = 1.5;

/// The hardness of the matte brush: that of the 3D view's brush at first. Where it solves, it is hard all the same.
const MATTE_HARDNESS: f64 = 0.5;

/// The stroke that is being drawn.
#[derive(Debug, Clone)]
pub struct MaskStroke {
    /// The photo in which the stroke began.
    pub photo: PhotoId,
    /// The tool of the stroke.
    pub tool: MaskTool,
    /// Whether the stroke erases.
    pub uncovers: bool,
    /// The path of the pointer, in photo pixels.
    pub line: Vec<DVec2>,
    /// The pixels that the brush has covered; those of the lasso are computed at the end.
    pub pixels: Spans,
    /// The radius of the brush, in photo pixels.
    radius_px: f64,
    /// The position on the screen of the last point, in points.
    last: Vec2,
}

impl MaskStroke {
    /// Makes a stroke without any point.
    pub fn new(photo: PhotoId, tool: MaskTool, uncovers: bool, radius_px: f64) -> Self {
        let (line, pixels, last) = (Vec::new(), Spans::default(), Vec2::ZERO);
        Self { photo, tool, uncovers, line, pixels, radius_px, last }
    }

    /// Continues to a position: `at` on the screen, `position` in the photo, whose pixels are `within`.
    pub fn go_to(&mut self, at: Vec2, position: DVec2, within: PixelRect) {
        if at.distance(self.last) < NEAR && !self.line.is_empty() {
            return;
        }
        if self.tool.is_brush() {
            let from = self.line.last().copied();
            let way: Vec<DVec2> = from.into_iter().chain([position]).collect();
            self.pixels = self.pixels.union(&brushed(&way, self.radius_px, within));
        }
        self.line.push(position);
        self.last = at;
    }

    /// Returns the stroke of the matte brush that it is; `None` for tools that mask, and where it has no pixel. `layer` is the
    /// token of the image layer that is meant, if one is.
    pub fn of_matte(&self, photo: &Photo, layer: Option<String>) -> Option<Stroke> {
        let MaskTool::Matte(mode) = self.tool else { return None };
        if self.pixels.is_empty() {
            return None;
        }
        let (radius, hardness) = (self.radius_px, MATTE_HARDNESS);
        let brush = Brush { mode, radius, hardness, opacity: 1.0, colour: [0; 3] };
        let sample = |at: &DVec2| StrokeSample { at: at.to_array(), pressure: 1.0 };
        Some(Stroke {
            version: STROKE_VERSION,
            view: StrokeView::new(&photo.camera, &photo.pose),
            brush,
            source: None,
            layer,
            samples: self.line.iter().map(sample).collect(),
        })
    }

    /// Returns the step that the stroke makes in its photo, with its name for undo; none where it has no pixel.
    pub fn step(&self, photo: &str, within: PixelRect) -> Option<(String, MaskWork)> {
        let pixels = self.drawn(within);
        if pixels.is_empty() {
            return None;
        }
        let (tool, name) = (self.tool.name(), photo.to_owned());
        let (text, edit) = match self.uncovers {
            true => (format!("mask erasure in {photo} by {tool}"), MaskEdit::Uncover { photo: name, pixels }),
            false => {
                let edit = MaskEdit::Add { photo: name, from: MaskOrigin::Drawn, masked: pixels };
                (format!("mask of {photo} by {tool}"), edit)
            }
        };
        Some((text, MaskWork::Edits(Arc::new(vec![edit]))))
    }

    fn drawn(&self, within: PixelRect) -> Spans {
        match self.tool {
            MaskTool::Brush | MaskTool::Matte(_) => self.pixels.clone(),
            MaskTool::Lasso => enclosed(&self.line, within),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::stroke::BrushMode;

    const PHOTO: PixelRect = PixelRect { x: 0, y: 0, w: 100, h: 80 };

    fn drawn(tool: MaskTool, uncovers: bool, points: &[(f64, f64)]) -> MaskStroke {
        let mut stroke = MaskStroke::new(PhotoId(0), tool, uncovers, 5.0);
        for (x, y) in points {
            let position = DVec2::new(*x, *y);
            stroke.go_to(position.as_vec2(), position, PHOTO);
        }
        stroke
    }

    fn edit(stroke: &MaskStroke) -> (String, MaskEdit) {
        let (name, work) = stroke.step("a.jpg", PHOTO).unwrap();
        match work {
            MaskWork::Edits(edits) => (name, edits[0].clone()),
            MaskWork::Object { .. } | MaskWork::Trees { .. } => panic!("a stroke is no object"),
        }
    }

    #[test]
    fn a_brush_masks_a_band_along_its_path() {
        let (name, edit) = edit(&drawn(MaskTool::Brush, false, &[(20.0, 40.0), (60.0, 40.0)]));
        assert_eq!(name, "mask of a.jpg by brush");
        let MaskEdit::Add { masked, .. } = edit else { panic!("it masks") };
        assert!(masked.holds(40, 40) && masked.holds(40, 43) && !masked.holds(40, 50));
    }

    #[test]
    fn the_matte_brush_makes_a_stroke_in_the_view_of_the_photo_and_no_mask() {
        let scene = quadratura_base::scene::synthetic::closed_form::two_quads();
        let photo = scene.photo();
        let line = [(20.0, 40.0), (60.0, 40.0)];
        let made = drawn(MaskTool::Matte(BrushMode::Solve), false, &line).of_matte(&photo, Some("t1".into()));
        let made = made.unwrap();
        assert_eq!((made.brush.mode, made.brush.radius, made.samples.len()), (BrushMode::Solve, 5.0, 2));
        assert_eq!((made.view.width, made.layer.as_deref()), (photo.camera.width, Some("t1")));
        assert_eq!(made.problem(), None);
        assert!(drawn(MaskTool::Brush, false, &line).of_matte(&photo, None).is_none());
        let beside = [(-50.0, -50.0), (-80.0, -50.0)];
        assert!(drawn(MaskTool::Matte(BrushMode::Solid), false, &beside).of_matte(&photo, None).is_none());
    }

    #[test]
    fn a_lasso_that_erases_uncovers_what_it_encloses() {
        let corners = [(10.0, 10.0), (50.0, 10.0), (50.0, 50.0), (10.0, 50.0)];
        let (name, edit) = edit(&drawn(MaskTool::Lasso, true, &corners));
        assert_eq!(name, "mask erasure in a.jpg by lasso");
        let MaskEdit::Uncover { pixels, .. } = edit else { panic!("it uncovers") };
        assert!(pixels.holds(30, 30) && !pixels.holds(60, 30));
    }

    #[test]
    fn a_stroke_beside_the_photo_makes_no_step() {
        let stroke = drawn(MaskTool::Brush, false, &[(-50.0, -50.0), (-80.0, -50.0)]);
        assert!(stroke.step("a.jpg", PHOTO).is_none());
        assert!(drawn(MaskTool::Lasso, false, &[(30.0, 30.0)]).step("a.jpg", PHOTO).is_none());
    }

    #[test]
    fn trembling_of_the_hand_adds_no_points() {
        let mut stroke = drawn(MaskTool::Lasso, false, &[(30.0, 30.0)]);
        stroke.go_to(Vec2::new(30.5, 30.5), DVec2::new(31.0, 31.0), PHOTO);
        assert_eq!(stroke.line.len(), 1);
        stroke.go_to(Vec2::new(33.0, 30.0), DVec2::new(36.0, 30.0), PHOTO);
        assert_eq!(stroke.line.len(), 2);
    }
}
