//! The memory of the photo view.

use glam::DVec2;

use super::placement::{PlacedView, ScreenRect};
use super::version::LayersVersion;
use crate::state::model_suggestions::EdgeGrip;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_document::stack::UntexturedReason;
use quadratura_editing::peel::{PeelHit, PeelShape, PhotoLayers};

/// State of the photo view that lasts from frame to frame.
#[derive(Clone, Default)]
pub struct PhotoPane {
    /// The number of hidden visibility layers.
    pub hidden_layers: u32,
    /// Whether the list of untextured faces is shown.
    pub reasons_shown: bool,
    /// The reason for which faces are listed; none for all.
    pub reason: Option<UntexturedReason>,
    /// The placement of the photo.
    pub view: PlacedView,
    /// The photo that is shown.
    photo: Option<PhotoId>,
    /// The layer, surface and colour under the pointer.
    pub pointed: Option<Pointed>,
    /// The part to frame once the size of the view is known, as corners in photo pixels.
    sought: Option<[DVec2; 2]>,
    /// The position where a face is occluded, in photo pixels: marked as long as the face is selected.
    pub mark: Option<(FaceId, DVec2)>,
    /// The rectangle of the clickable line over the photo, as it was drawn last: no stroke starts there.
    pub line: Option<ScreenRect>,
    /// The edge of a suggestion under the pointer.
    pub grip: EdgeGrip,
}

/// The pixel under the pointer, with its shapes.
#[derive(Clone)]
pub struct Pointed {
    /// The pixel.
    pub pixel: (i32, i32),
    /// The colour of the pixel: R, G, B.
    pub colour: Option<[u8; 3]>,
    /// The shapes at the pixel from front to back, without hidden layers.
    pub hits: Vec<PeelHit>,
    /// The version of the layers that the shapes are of.
    pub version: Option<LayersVersion>,
}

impl Pointed {
    /// Returns the front shape.
    pub fn shape<'a>(&self, layers: &'a PhotoLayers) -> Option<&'a PeelShape> {
        layers.shapes.get(self.hits.first()?.shape)
    }
}

impl PhotoPane {
    /// Shows another photo: fitted to the view, with all layers.
    pub fn turn_to(&mut self, photo: PhotoId) {
        if self.photo != Some(photo) {
            self.photo = Some(photo);
            self.view.fit();
            (self.hidden_layers, self.pointed, self.mark) = (0, None, None);
        }
    }

    /// Frames a part of a photo, as corners in photo pixels, or all of it. Marks the position where a face is occluded.
    pub fn look_at(&mut self, photo: PhotoId, part: Option<[DVec2; 2]>, mark: Option<(FaceId, DVec2)>) {
        self.turn_to(photo);
        (self.mark, self.sought) = (mark, part);
        self.view.fit();
    }

    /// Frames the requested part, now that the size of the view is known.
    pub fn show_sought(&mut self, rect: ScreenRect) {
        self.view.rect = Some(rect);
        if let Some([low, high]) = self.sought.take() {
            self.view.placement.show(rect, low, high);
        }
    }

    /// Pans to the position where a face is occluded and marks it; `None` removes the mark.
    pub fn go_to(&mut self, face: FaceId, position: Option<DVec2>) {
        self.mark = position.map(|position| (face, position));
        if let Some(position) = position {
            self.view.placement.center_on(position);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    const VIEW: ScreenRect = ScreenRect { min: Vec2::ZERO, max: Vec2::new(424.0, 324.0) };

    #[test]
    fn another_photo_is_shown_whole_and_the_same_one_as_it_was() {
        let mut pane = PhotoPane::default();
        pane.turn_to(PhotoId(1));
        pane.hidden_layers = 3;
        pane.view.placement.pan(Vec2::X);
        pane.turn_to(PhotoId(1));
        assert!(pane.hidden_layers == 3 && !pane.view.placement.is_fitted());
        pane.turn_to(PhotoId(2));
        assert!(pane.hidden_layers == 0 && pane.view.placement.is_fitted());
    }

    #[test]
    fn a_part_is_framed_once_when_the_size_of_the_view_is_known() {
        let mut pane = PhotoPane::default();
        let (low, high) = (DVec2::new(100.0, 100.0), DVec2::new(140.0, 130.0));
        pane.look_at(PhotoId(0), Some([low, high]), None);
        assert!(pane.view.placement.is_fitted());
        pane.show_sought(VIEW);
        assert_eq!((pane.view.placement.middle(), pane.view.placement.scale()), ((low + high) / 2.0, 10.0));
        pane.view.fit();
        pane.show_sought(VIEW);
        assert!(pane.view.placement.is_fitted(), "it is not framed again");
    }

    #[test]
    fn a_face_without_a_position_takes_the_mark_away_and_moves_nothing() {
        let mut pane = PhotoPane::default();
        pane.go_to(FaceId(3), Some(DVec2::ONE));
        assert!(pane.mark == Some((FaceId(3), DVec2::ONE)) && pane.view.placement.middle() == DVec2::ONE);
        pane.go_to(FaceId(4), None);
        assert!(pane.mark.is_none() && pane.view.placement.middle() == DVec2::ONE);
    }
}
