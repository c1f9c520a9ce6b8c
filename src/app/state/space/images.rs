//! The 3D view drawn from layered depth images: whether it is, what of them is shown, and what is said about them.

use std::time::Duration;

use super::pace::DrawingPace;
use quadratura_images::live::{LiveOptions, LiveStatus};

/// What a picture is drawn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrawnFrom {
    /// The model, with photos projected onto it.
    Model,
    /// Layered depth images, because the user wants to see them.
    Images(LiveOptions),
    /// Layered depth images, in place of the model while the view moves.
    StandIn(LiveOptions),
}

impl DrawnFrom {
    /// Returns how layered depth images are drawn, where they are.
    pub fn options(&self) -> Option<LiveOptions> {
        match *self {
            Self::Model => None,
            Self::Images(options) | Self::StandIn(options) => Some(options),
        }
    }

    /// Returns whether pictures show the same, maybe in another size: what stands in counts as what it stands in for.
    pub fn shows_the_same(&self, other: &Self) -> bool {
        let peeled = |from: &Self| match from {
            Self::Images(options) => Some(options.peeled),
            Self::Model | Self::StandIn(_) => None,
        };
        peeled(self) == peeled(other)
    }
}

/// The state of layered depth images in the 3D view.
#[derive(Default)]
pub struct SpaceImages {
    /// Whether the view is drawn from them.
    pub on: bool,
    /// Whether they stand in for the model while the view moves.
    pub stands_in: bool,
    /// The layers of depth pixels that are hidden, nearest first.
    pub peeled: u32,
    /// What the newest picture was drawn from, and how long that took.
    pub status: Option<(LiveStatus, Duration)>,
    /// The speed of pictures from them.
    pub(super) pace: DrawingPace,
}
