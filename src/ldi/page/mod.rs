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
use quadratura_page::chunk::Chunk;
use quadratura_page::html::{escaped, filled};
use quadratura_page::pictures::{jpeg, small_jpeg};
use quadratura_page::place;
use quadratura_page::viewer::PageViewer;
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

/// The version of the description, which the viewer checks.
const VERSION: u32 = 2;
/// The name of the chunk with everything.
const CHUNK: &str = "photo";

/// The viewer of one layered depth image.
const VIEWER: PageViewer = PageViewer {
    index: include_str!("viewer/index.html"),
    style: include_str!("viewer/viewer.css"),
    scripts: &[
        ("segments.js", include_str!("viewer/segments.js")),
        ("frame.js", include_str!("viewer/frame.js")),
        ("painter.js", include_str!("viewer/painter.js")),
        ("lean.js", include_str!("viewer/lean.js")),
        ("lean_input.js", include_str!("viewer/lean_input.js")),
        ("start.js", include_str!("viewer/start.js")),
    ],
    shaders: &[
        ("vertex", include_str!("viewer/vertex.glsl")),
        ("fragment", include_str!("viewer/fragment.glsl")),
    ],
};

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
    let poster = small_jpeg(
        page.poster.over(BACKGROUND),
        [page.poster.width, page.poster.height],
        POSTER,
        POSTER_QUALITY,
    );
    let mut files = vec![
        ("index.html".to_owned(), index(page).into_bytes()),
        ("poster.jpg".to_owned(), poster),
        (format!("data/{CHUNK}.js"), data(page).script(CHUNK)),
    ];
    files.extend(VIEWER.files().into_iter().map(|(name, content)| (name, content.into_bytes())));
    files
}

fn index(page: &Page<'_>) -> String {
    let (width, height) = (page.window.seen.w.to_string(), page.window.seen.h.to_string());
    let values = [
        ("lang", "en"),
        ("version", env!("CARGO_PKG_VERSION")),
        ("caption", &escaped(page.caption)),
        ("width", &width),
        ("height", &height),
        ("scripts", &VIEWER.script_elements()),
    ];
    filled(VIEWER.index, &values)
}

/// Returns the data of the photo.
fn data(page: &Page<'_>) -> Chunk {
    let mut chunk = Chunk::default();
    let description = description(page).to_string();
    chunk.add_packed("photo", description.as_bytes());
    chunk.add_packed("geometry", &geometry::geometry(page.segments));
    for (number, atlas) in page.segments.atlases.iter().enumerate() {
        let quality =
            if atlas.first { page.quality } else { page.quality.saturating_sub(HIDDEN_LOWER).max(1) };
        chunk.add(format!("colours-{number}"), &jpeg(&atlas.rgb, [atlas.width, atlas.height], quality));
        chunk.add(format!("rims-{number}"), &rims(atlas));
    }
    let poster = page.poster;
    let covered = poster.pixels().iter().filter(|pixel| pixel[3] > 127).count() as f64;
    if covered >= WHOLE * poster.pixels().len() as f64 {
        let size = [poster.width, poster.height];
        chunk.add("backdrop", &small_jpeg(poster.over(BACKGROUND), size, BACKDROP, POSTER_QUALITY));
    }
    chunk
}

/// Returns what the viewer has to know of the photo.
fn description(page: &Page<'_>) -> serde_json::Value {
    let (camera, seen) = (page.camera, page.window.seen);
    let atlas = |atlas: &crate::segments::Atlas| json!({ "width": atlas.width, "height": atlas.height });
    json!({
        "version": VERSION,
        "camera": {
            "width": camera.width, "height": camera.height,
            "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy,
        },
        "seen": { "x": seen.x, "y": seen.y, "width": seen.w, "height": seen.h },
        "pivot": page.window.pivot,
        "zoom": page.window.zoom,
        "safe": { "across": page.safe.across, "along": page.safe.along },
        "atlases": page.segments.atlases.iter().map(atlas).collect::<Vec<_>>(),
        "pieces": page.segments.parts.len(),
    })
}

#[cfg(test)]
mod tests;
