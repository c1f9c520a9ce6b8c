//! The filling of a stack's hidden texels, as in `stack.json`.

use serde::{Deserialize, Serialize};

use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceIndex;

/// The filling of an image layer, as files of its rectangle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerFill {
    /// An RGBA PNG, opaque where a hidden texel was filled, else transparent. It never covers a texel of `file`.
    pub filled_file: String,
    /// An 8-bit PNG of the filling's confidence in 255ths; 0 where nothing was filled.
    pub confidence_file: String,
    /// An 8- or 16-bit PNG: for each filled texel, the index in [`StackFill::origins`] of its source; 0 elsewhere.
    pub provenance_file: String,
    /// An RGBA PNG, opaque where paint was propagated from another photo over what `file` shows, else transparent.
    /// It covers texels of `file` only. The confidence and provenance files describe these texels, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(rename = "spread_file")]
    pub propagation_file: Option<String>,
    /// An 8-bit PNG of the matte, in 255ths: how much of each texel the surface covers, in linear light. Texels that are
    /// not known have none of it. `None` for layers of solid surfaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matte_file: Option<String>,
    /// An RGBA PNG, opaque where the photo shows the surface mixed with what is behind it, with the surface's own colour,
    /// which replaces that of `file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreground_file: Option<String>,
    /// The number of filled texels.
    pub texels_filled: u64,
}

impl LayerFill {
    /// Returns all file names for modification.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let always = [&mut self.filled_file, &mut self.confidence_file, &mut self.provenance_file];
        let optional = [&mut self.propagation_file, &mut self.matte_file, &mut self.foreground_file];
        always.into_iter().chain(optional.into_iter().flatten())
    }
}

/// A summary of the filling of a stack's hidden texels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StackFill {
    /// The hash of everything that the filling was made from; while it matches, the stack is not filled again.
    pub inputs: String,
    /// The meanings of the numbers in provenance files; the first one stands for no filling.
    pub origins: Vec<String>,
    /// The number of hidden texels.
    pub texels_hidden: u64,
    /// The number of hidden texels that were filled from other photos.
    pub texels_from_photos: u64,
    /// The number of hidden texels that were filled from paint of other photos.
    #[serde(default)]
    pub texels_from_paint: u64,
    /// The number of hidden texels that were inpainted by patches (by example).
    pub texels_by_example: u64,
    /// The number of hidden texels that were inpainted by diffusion.
    pub texels_diffused: u64,
    /// The number of pixels at which the photo shows see-through surfaces, those that have mattes.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub matte_pixels: u64,
    /// Those of which nobody knows how much is the surface: it is solid there.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub matte_unknown: u64,
    /// Paint that was propagated from other photos over visible texels, or met the photo's own paint there: by face
    /// and photo.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(rename = "spread")]
    pub propagated: Vec<PropagationEntry>,
    /// The size of the filling's files in bytes.
    pub bytes: u64,
    /// What the filling was made from, in parts, so that later paint changes only what it concerns; `None` in fillings
    /// of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basis: Option<FillBasis>,
}

/// What a filling was made from, in parts.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FillBasis {
    /// The hash of everything except the paint.
    pub common: String,
    /// The paint of all photos, without that on the surroundings.
    pub paint: Vec<FilledPaint>,
    /// The hash of what the surroundings are filled from beside that: paint on them; empty where there are none,
    /// and in fillings of before.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub around: String,
    /// The photos from which the filling takes something or could, in the site's order, with the photo itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub donors: Vec<String>,
    /// The hash of what these photos, the faces of the photo and its paint are: while it matches, the filling is as it would be
    /// made, whatever changed elsewhere; empty in fillings of before.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub parts: String,
}

/// An entry of the paint book that a filling was made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilledPaint {
    /// The photo that was painted on.
    pub photo: String,
    /// The surfaces in the photo's stack that the paint lies on.
    pub surfaces: Vec<SurfaceName>,
    /// The rectangle of the painted pixels, in pixels of the present photo.
    pub rect: PixelRect,
    /// The hash of the entry.
    pub entry: String,
    /// Whether no other photo sees it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_here: bool,
}

/// The name of a surface of the model.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SurfaceName {
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object.
    pub face: FaceIndex,
    /// The triangle's index within the face, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
}

/// Paint of another photo that was propagated to a face that this photo shows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PropagationEntry {
    /// The face, as `object[index]`.
    pub face: String,
    /// The photo in which it was painted.
    pub from: String,
    /// The number of texels that the paint replaced.
    pub texels: u64,
    /// The number of texels that kept the photo's own paint.
    pub own: u64,
    /// The number of texels of `own` whose paint clearly differs.
    pub conflicts: u64,
    /// The number of texels of `texels` where the paint of a third photo clearly differs.
    pub dissents: u64,
    /// The number of texels that kept the photo's pixels, because the paint is less than half as fine.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub coarse: u64,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Names in [`StackFill::origins`] that are not names of photos. No photo's name has brackets at both ends.
pub mod origins {
    use quadratura_view::legend::Origin;

    /// No filling.
    pub const NONE: &str = "[none]";
    /// Paint in the photo itself.
    pub const PAINTED: &str = "[painted]";
    /// The beginning of names for paint in another photo: `[painted in NAME]`.
    const PAINTED_IN: &str = "[painted in ";
    /// Inpainting by patches (by example).
    pub const EXEMPLAR: &str = "[exemplar]";
    /// Inpainting by diffusion.
    pub const DIFFUSED: &str = "[diffused]";

    /// Returns the name for paint in the photo of this name.
    pub fn painted_in(photo: &str) -> String {
        format!("{PAINTED_IN}{photo}]")
    }

    /// Returns the photo that a name for paint in another photo refers to; `None` for other names.
    pub fn painter(origin: &str) -> Option<&str> {
        origin.strip_prefix(PAINTED_IN)?.strip_suffix(']')
    }

    /// Returns the kind of source that a name stands for.
    pub fn origin_of(name: &str) -> Origin {
        match name {
            NONE => Origin::Photo,
            PAINTED => Origin::Paint,
            EXEMPLAR => Origin::Example,
            DIFFUSED => Origin::Diffused,
            name if painter(name).is_some() => Origin::Propagated,
            _ => Origin::OtherPhoto,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::origins::origin_of;
    use quadratura_view::legend::Origin;

    #[test]
    fn names_of_origins_are_told_apart() {
        let names = ["[none]", "[painted]", "[painted in a.jpg]", "b.jpg", "[exemplar]", "[diffused]"];
        assert_eq!(names.map(origin_of), Origin::ALL);
    }
}
