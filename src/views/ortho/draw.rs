//! The pixels of an orthophoto, row by row, and where they come from.

use crate::known::origin_of_colour;
use crate::preview::Preview;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_io::ortho::picture::IndexedPicture;
use quadratura_io::ortho::rows::RowsFile;
use quadratura_projection::Renders;
use quadratura_view::legend::{CONTINUED, CONTINUED_NAME, Origin};
use quadratura_view::{DisplayMode, Quality, Shot};

use super::SourceShares;
use super::cut::CutLines;

/// Pixels of the picture per pixel of the picture of sources, along a side.
pub(super) const SOURCES_STEP: u32 = 4;

/// The rows of the picture of sources that are drawn at a time.
const SOURCES_ROWS: usize = 512;

/// The colours of the picture of sources behind those of [`Origin::ALL`]: what continues, and what is empty.
const EMPTY: [u8; 3] = [255; 3];

/// Draws a view with the lines of a section and appends its rows to a file. Returns whether some pixels are coarser than photos are, because
/// memory does not hold these.
///
/// # Errors
/// As [`Renders::picture`]; [`quadratura_base::error::Error::Io`] on a full disk.
pub(super) fn draw(
    preview: &mut Preview,
    shot: &Shot,
    cut: &CutLines,
    rows: &mut RowsFile,
    task: &Task,
) -> Result<bool> {
    let height = u64::from(shot.camera.height);
    let mut sliced = preview.begin_faces(shot, task)?;
    let mut is_done = false;
    while !is_done {
        task.step("draw rows", u64::from(rows.size_px()[1]), height)?;
        is_done = preview.advance(&mut sliced, task)?;
        let mut drawn = sliced.take_rows();
        blacken(&mut drawn);
        let [width, top] = rows.size_px();
        cut.lay_over(&mut drawn, width, top);
        rows.append(&drawn)?;
    }
    Ok(sliced.is_coarser())
}

/// Makes pixels that are fully transparent black, as in other pictures.
fn blacken(rgba: &mut [u8]) {
    let transparent = rgba.as_chunks_mut::<4>().0.iter_mut().filter(|pixel| pixel[3] == 0);
    transparent.for_each(|pixel| *pixel = [0; 4]);
}

/// Draws where the pixels of a view come from, [`SOURCES_STEP`] times as coarse, and counts them.
///
/// # Errors
/// As [`Renders::picture`].
pub(super) fn draw_sources(
    preview: &mut Preview,
    shot: &Shot,
    task: &Task,
) -> Result<(IndexedPicture, SourceShares)> {
    let coarse = Shot {
        display: DisplayMode::Provenance,
        quality: Quality::Finer,
        supersampled: false,
        ..reduced(shot, SOURCES_STEP)
    };
    let mut shares = SourceShares::default();
    let mut index = |(pixel, face): (&[u8; 4], &u32)| -> u8 {
        let origin = origin_of_colour(*pixel);
        if *face == 0 {
            return Origin::ALL.len() as u8 + 1;
        }
        shares.add(origin);
        let at = origin.and_then(|origin| Origin::ALL.iter().position(|other| *other == origin));
        at.unwrap_or(Origin::ALL.len()) as u8
    };
    let (width, height) = (coarse.camera.width, coarse.camera.height);
    let mut indices = Vec::with_capacity(width as usize * height as usize);
    // In bands: a picture of 30,000 pixels has sources of 7,500, whose colours and faces need not be in memory at once.
    for top in (0..height).step_by(SOURCES_ROWS) {
        let mut band = coarse.clone();
        band.camera.height = (height - top).min(SOURCES_ROWS as u32);
        band.camera.cy -= f64::from(top);
        let picture = preview.picture_of_faces(&band, task)?;
        let faces = preview.faces(&band, task)?;
        indices.extend(picture.pixels().iter().zip(&faces).map(&mut index));
    }
    let colours = Origin::ALL.map(Origin::colour).into_iter().chain([CONTINUED, EMPTY]).collect();
    Ok((IndexedPicture { width, indices, colours }, shares.of_one()))
}

/// Returns the names of the colours of pictures of sources.
pub(super) fn legend() -> String {
    let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    let entries = Origin::ALL.map(|origin| format!("{} {}", hex(origin.colour()), origin.name()));
    format!("{}, {} {CONTINUED_NAME}", entries.join(", "), hex(CONTINUED))
}

/// Returns the same view with fewer pixels, which begin at the same corner and are `step` times as large.
fn reduced(shot: &Shot, step: u32) -> Shot {
    let mut coarse = shot.clone();
    let by = f64::from(step);
    let camera = &mut coarse.camera;
    (camera.width, camera.height) = (camera.width.div_ceil(step), camera.height.div_ceil(step));
    (camera.fx, camera.fy) = (camera.fx / by, camera.fy / by);
    (camera.cx, camera.cy) = (camera.cx / by, camera.cy / by);
    coarse
}
