//! What a pixel shows, from pictures of the sources of texels.

use quadratura_view::legend::{CONTINUED, Origin};

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// What a photo shows, or paint.
    Photographed,
    /// What another photo shows, as filling brought it there.
    Filled,
    /// What was invented.
    Inpainted,
    /// What no photo shows.
    Nothing,
}

impl Known {
    fn of_origin(origin: Origin) -> Self {
        match origin {
            Origin::Photo | Origin::Paint | Origin::Propagated => Self::Photographed,
            Origin::OtherPhoto => Self::Filled,
            Origin::Example | Origin::Diffused => Self::Inpainted,
        }
    }

    /// Returns what the colour of a view of sources stands for: the nearest one, where photos of several sources share a pixel.
    pub fn of_colour(pixel: [u8; 4]) -> Self {
        origin_of_colour(pixel).map_or(Self::Nothing, Self::of_origin)
    }
}

/// Returns the source that the colour of a view of sources stands for: the nearest one; `None` where no photo shows anything.
pub(crate) fn origin_of_colour([r, g, b, alpha]: [u8; 4]) -> Option<Origin> {
    if alpha < 128 {
        return None;
    }
    let colours = Origin::ALL.map(|origin| (origin.colour(), Some(origin)));
    let distance = |colour: &[u8; 3]| -> u32 {
        colour.iter().zip([r, g, b]).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    };
    let all = colours.into_iter().chain([(CONTINUED, None)]);
    all.min_by_key(|(colour, _)| distance(colour)).and_then(|(_, origin)| origin)
}
