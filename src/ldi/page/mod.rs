//! Writes a layered depth image as a page: a folder that opens in a browser, from disk as well, and shows a photo that one
//! can lean into (see `docs/formats.md`).
//!
//! Browsers give pages that are opened from disk no other files to read, so everything but the poster is data within scripts.

mod geometry;
pub mod pictures;

use serde_json::json;

use self::pictures::rims;
use crate::lean::{SafeRegion, Window};
use crate::segments::Segments;
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_files::base64::to_base64;
use quadratura_page::html::{escaped, filled};
use quadratura_page::pictures::{jpeg, small_jpeg};
use quadratura_page::place;
use quadratura_view::Picture;

pub use quadratura_page::place::{PageFile, PagePlace, place_of_page};

/// The longest side of the poster in pixels.
const POSTER: u32 = 1280;
/// The quality of the poster.
const POSTER_QUALITY: u8 = 85;
/// What is behind the picture, as in the viewer.
const BACKGROUND: [u8; 3] = [16, 16, 17];
/// The qualities of hidden parts are lower by this: they are seen in narrow strips.
const HIDDEN_LOWER: u8 = 10;

/// The longer side of the picture behind everything, in pixels: so few that it is out of focus.
const BACKDROP: u32 = 48;
/// The share of the poster that an image covers from which on it has a picture behind it; what is cut out has none.
const WHOLE: f64 = 0.9;

/// The content of a page.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The reference camera.
    pub camera: &'a Pinhole,
    /// The meshes and colours.
    pub segments: &'a Segments,
    /// The window through which it is seen.
    pub window: &'a Window,
    /// The viewpoints that the viewer can go to.
    pub safe: &'a SafeRegion,
    /// The view at the start, for browsers that cannot show more.
    pub poster: &'a Picture,
    /// The text below the picture.
    pub caption: &'a str,
    /// The quality of JPEGs, from 1 to 100.
    pub quality: u8,
}

/// Writes a page to a folder, which appears whole or not at all. Returns its files.
///
/// # Errors
/// [`Error::Io`].
pub fn write_page(place: &PagePlace, page: &Page<'_>) -> Result<Vec<PageFile>> {
    place::put(place, |folder| files_of(page).iter().try_for_each(|(name, bytes)| folder.write(name, bytes)))
}

/// Returns the names and contents of the files.
fn files_of(page: &Page<'_>) -> Vec<(String, Vec<u8>)> {
    let text = |name: &str, content: String| (name.to_owned(), content.into_bytes());
    let poster = small_jpeg(
        page.poster.over(BACKGROUND),
        [page.poster.width, page.poster.height],
        POSTER,
        POSTER_QUALITY,
    );
    vec![
        text("index.html", index(page)),
        text("viewer.css", include_str!("viewer.css").to_owned()),
        text("painter.js", include_str!("painter.js").to_owned()),
        text("viewer.js", include_str!("viewer.js").to_owned()),
        text("start.js", include_str!("start.js").to_owned()),
        text("data.js", data(page)),
        ("poster.jpg".to_owned(), poster),
    ]
}

fn index(page: &Page<'_>) -> String {
    let (width, height) = (page.window.seen.w.to_string(), page.window.seen.h.to_string());
    let values = [
        ("lang", "en"),
        ("version", env!("CARGO_PKG_VERSION")),
        ("caption", &escaped(page.caption)),
        ("width", &width),
        ("height", &height),
        ("vertex", include_str!("vertex.glsl")),
        ("fragment", &with_encoding(include_str!("fragment.glsl"))),
        ("whole", include_str!("whole.glsl")),
        ("reduce", &with_encoding(include_str!("reduce.glsl"))),
    ];
    filled(include_str!("index.html"), &values)
}

/// Returns a shader with the function that it takes from another file.
fn with_encoding(shader: &str) -> String {
    shader.replace("#include encoded\n", include_str!("encoded.glsl"))
}

/// Returns the script with the data of the photo.
fn data(page: &Page<'_>) -> String {
    let uri = |kind: &str, bytes: &[u8]| format!("data:image/{kind};base64,{}", to_base64(bytes));
    let atlas = |atlas: &crate::segments::Atlas| {
        let quality =
            if atlas.first { page.quality } else { page.quality.saturating_sub(HIDDEN_LOWER).max(1) };
        json!({
            "width": atlas.width,
            "height": atlas.height,
            "colours": uri("jpeg", &jpeg(&atlas.rgb, [atlas.width, atlas.height], quality)),
            "rims": uri("png", &rims(atlas)),
        })
    };
    let atlases: Vec<_> = page.segments.atlases.iter().map(atlas).collect();
    let camera = page.camera;
    let poster = page.poster;
    let covered = poster.pixels().iter().filter(|pixel| pixel[3] > 127).count() as f64;
    let backdrop = (covered >= WHOLE * poster.pixels().len() as f64).then(|| {
        let size = [poster.width, poster.height];
        uri("jpeg", &small_jpeg(poster.over(BACKGROUND), size, BACKDROP, POSTER_QUALITY))
    });
    let photo = json!({
        "version": 1,
        "camera": {
            "width": camera.width, "height": camera.height,
            "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy,
        },
        "seen": {
            "x": page.window.seen.x, "y": page.window.seen.y,
            "width": page.window.seen.w, "height": page.window.seen.h,
        },
        "pivot": page.window.pivot,
        "zoom": page.window.zoom,
        "safe": { "across": page.safe.across, "along": page.safe.along },
        "backdrop": backdrop,
        "atlases": atlases,
        "pieces": page.segments.parts.len(),
        "geometry": to_base64(&geometry::geometry(page.segments)),
    });
    format!("window.QuadraturaPhoto = {photo};\n")
}

#[cfg(test)]
mod tests;
