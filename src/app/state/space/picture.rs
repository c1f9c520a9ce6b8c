//! Pictures of the 3D view: what is requested of the painter, and what it has drawn.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use super::images::DrawnFrom;
use quadratura_images::live::LiveStatus;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_view::flight::FrameLens;
use quadratura_view::{DisplayMode, Picture, Shot};

/// A request for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureRequest {
    /// The view to draw.
    pub shot: Shot,
    /// The lens of the view; the shot has it rounded to the pixels of the picture.
    pub lens: FrameLens,
    /// What it is drawn from.
    pub from: DrawnFrom,
    /// Whether the picture may be dropped for a newer one, as pictures of a view at rest may. Those of a moving view
    /// are finished; otherwise nothing would be visible during the movement.
    pub yields: bool,
    /// The background colour, sRGB.
    pub background: [u8; 3],
    /// The number of changes of the project's content that the picture shows.
    pub revision: u64,
}

impl PictureRequest {
    /// Returns whether two requests are for the same view of the same content, maybe in another size or quality.
    pub fn shows_the_same(&self, other: &Self) -> bool {
        let Shot { pose, blend, display, exposure, relief, backs, .. } = &self.shot;
        let shot = &other.shot;
        self.revision == other.revision
            && self.from.shows_the_same(&other.from)
            && (pose, blend, display) == (&shot.pose, &shot.blend, &shot.display)
            && (exposure, relief, backs) == (&shot.exposure, &shot.relief, &shot.backs)
            && (&self.shot.without, &self.shot.hidden) == (&shot.without, &shot.hidden)
    }
}

/// A picture that was drawn.
pub struct PaintedPicture {
    /// The request.
    pub request: PictureRequest,
    /// The picture, opaque: with untextured faces shaded, over the background.
    pub image: Picture,
    /// The nearest face at each pixel: 1 + its id, 0 for none; empty where the picture was drawn from layered depth images.
    pub faces: Vec<u32>,
    /// The surface that rays intersect, as it was drawn.
    pub surface: Arc<ModelSurface>,
    /// The time of drawing.
    pub spent: Duration,
    /// What is drawn from layered depth images, where these were asked for.
    pub images: Option<LiveStatus>,
}

/// The newest picture, which is shown until the next one is drawn.
pub struct NewestPicture {
    /// The picture, opaque.
    pub image: Arc<Picture>,
    /// The picture that was requested.
    pub request: PictureRequest,
    /// The nearest face at each pixel: 1 + its id, 0 for none; empty where it is not known, or the model has changed
    /// since.
    pub faces: Vec<u32>,
    /// The colours in the picture, sRGB, where they stand for photos.
    colours: HashSet<[u8; 3]>,
}

impl NewestPicture {
    /// Makes the newest picture of one that was drawn.
    pub fn new(request: PictureRequest, image: Picture, faces: Vec<u32>) -> Self {
        let display = request.shot.display;
        let colours = match display {
            DisplayMode::Weights | DisplayMode::BestPhoto => {
                image.rgba.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
            }
            _ => HashSet::new(),
        };
        Self { image: Arc::new(image), request, faces, colours }
    }

    /// Returns whether a picture whose colours stand for photos contains a colour, sRGB. Devices round otherwise.
    pub fn contains(&self, [r, g, b]: [u8; 3]) -> bool {
        let near = |sample: u8| sample.saturating_sub(1)..=sample.saturating_add(1);
        near(r).any(|r| near(g).any(|g| near(b).any(|b| self.colours.contains(&[r, g, b]))))
    }
}
