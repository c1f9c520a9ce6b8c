//! What layered depth images are made from, and how.

use std::collections::BTreeMap;

use quadratura_base::scene::PhotoId;
use quadratura_ldi::merge::Merging;
use quadratura_ldi::{Combining, LdiKind};
use quadratura_sites::views::RequestedView;
use quadratura_views::preview::PreviewOptions;

/// What layered depth images are built from.
#[derive(Debug, Clone, PartialEq)]
pub enum BuildFrom {
    /// The stack of each photo.
    Stack(StackLdiOptions),
    /// Several photos in the camera of each.
    Photos {
        /// How they are combined.
        options: PhotosOptions,
        /// How many they are.
        best: usize,
        /// The others; empty takes those that show most of what the photo shows.
        with: Vec<PhotoId>,
    },
    /// All that the photos together show, in the camera of each photo.
    Site {
        /// How it is made.
        options: SiteLdiOptions,
        /// What the renderer shows.
        preview: PreviewOptions,
        /// Another view, in whose camera one image is made instead.
        at: Option<RequestedView>,
    },
}

/// The options of a layered depth image of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StackLdiOptions {
    /// Whether points are moved to the relief that the photos tell; otherwise they lie on the model's faces.
    pub relief: bool,
    /// Whether fillings of hidden texels are in it.
    pub filled: bool,
    /// Whether what the photo shows where no face is, is in it, infinitely far away.
    pub surroundings: bool,
}

impl StackLdiOptions {
    /// Returns the options by their names on the command line.
    pub(super) fn described(&self, from: LdiKind) -> BTreeMap<String, String> {
        let Self { relief, filled, surroundings } = *self;
        let background = if surroundings { "surroundings" } else { "none" };
        let words = [
            ("from", from.name().to_owned()),
            ("flat", (!relief).to_string()),
            ("unfilled", (!filled).to_string()),
            ("background", background.to_owned()),
        ];
        words.map(|(name, value)| (name.to_owned(), value)).into()
    }
}

impl Default for StackLdiOptions {
    fn default() -> Self {
        Self { relief: true, filled: true, surroundings: true }
    }
}

/// How photos are combined into one layered depth image.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotosOptions {
    /// What is taken from each photo.
    pub stack: StackLdiOptions,
    /// Whether what is hidden in each photo is taken, too: all of its stack instead of its depth image.
    pub hidden: bool,
    /// The share of its sides by which the photo's frame is grown on each side.
    pub guard: f64,
    /// The factor of the reference camera's resolution.
    pub scale: f64,
    /// How samples become layers.
    pub combining: Combining,
}

impl Default for PhotosOptions {
    fn default() -> Self {
        Self {
            stack: StackLdiOptions::default(),
            hidden: false,
            guard: 0.3,
            scale: 1.0,
            combining: Combining::default(),
        }
    }
}

impl PhotosOptions {
    /// The published system: depth images in the order in which they are given, one sample a pixel, no guard band.
    pub fn published() -> Self {
        let combining = Combining { published: true, ..Combining::default() };
        Self { guard: 0.0, combining, ..Self::default() }
    }

    /// Returns the options by their names on the command line.
    pub(super) fn described(&self) -> BTreeMap<String, String> {
        let Self { stack, hidden, guard, scale, combining } = self;
        let Merging { epsilon, layers, .. } = combining.merging;
        let mut words = stack.described(LdiKind::Photos);
        words.extend(
            [
                ("hidden", hidden.to_string()),
                ("guard", guard.to_string()),
                ("scale", scale.to_string()),
                ("epsilon", epsilon.to_string()),
                ("layers", layers.to_string()),
                ("merge", "mean".to_owned()),
                ("published", combining.published.to_string()),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        words
    }
}

/// How the layered depth image of a site is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SiteLdiOptions {
    /// Whether points are moved to the relief that the photos tell; otherwise they lie on the model's faces.
    pub relief: bool,
    /// Whether the renderer shows the filling of occluded areas.
    pub filled: bool,
    /// Whether the surroundings are in it, infinitely far away, and the skirts before them.
    pub surroundings: bool,
    /// The share of its sides by which the reference camera's frame is grown on each side.
    pub guard: f64,
    /// The factor of the reference camera's resolution.
    pub scale: f64,
    /// The largest number of the model's layers at a pixel, at least 1; beyond it the nearest ones and the farthest one stay.
    pub layers: usize,
}

impl Default for SiteLdiOptions {
    fn default() -> Self {
        Self { relief: true, filled: true, surroundings: true, guard: 0.3, scale: 1.0, layers: 10 }
    }
}

impl SiteLdiOptions {
    /// Returns the options by their names on the command line.
    pub(super) fn described(&self) -> BTreeMap<String, String> {
        let Self { relief, filled, surroundings, guard, scale, layers } = *self;
        let background = if surroundings { "surroundings" } else { "none" };
        let words = [
            ("from", LdiKind::Site.name().to_owned()),
            ("flat", (!relief).to_string()),
            ("unfilled", (!filled).to_string()),
            ("background", background.to_owned()),
            ("guard", guard.to_string()),
            ("scale", scale.to_string()),
            ("layers", layers.to_string()),
        ];
        words.map(|(name, value)| (name.to_owned(), value)).into()
    }
}
