//! A photo as it is shown and as it would be with paint of other photos: pictures for the question whether paint is
//! seen from everywhere.

use std::path::Path;

use super::propagation::with_all;
use super::{FillRequest, FilledPhoto, tell};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_io::unmasked::read_unmasked;
use quadratura_layered_files::Raster;
use quadratura_layers::fill::FilledRegion;
use quadratura_view::Picture;

/// The part of a photo where paint of other photos would change most.
#[derive(Debug, Clone, PartialEq)]
pub struct BothWays {
    /// The photo that would show paint of others.
    pub photo: String,
    /// The photos that were painted on, of which the part shows most first.
    pub from: Vec<String>,
    /// The part, in photo pixels.
    pub rect: PixelRect,
    /// The part while paint is seen only in its photo.
    pub only_here: Picture,
    /// The part with paint that is seen from everywhere.
    pub everywhere: Picture,
}

/// The margin around the paint, as a share of its longer side, so that the place can be recognised.
const AROUND: f64 = 0.5;
/// The least margin in pixels.
const LEAST_AROUND: f64 = 24.0;

/// Returns pictures, at most `longest` pixels in width and height, of the photo that paint of others would change most
/// if all paint were seen from everywhere; `None` when it would change none. Nothing is written.
///
/// # Errors
/// Returns the errors of [`tell`], and those of reading the photo.
pub fn both_ways(
    folder: &Path,
    project: &Project,
    site: &Site,
    longest: u32,
    task: &Task,
) -> Result<Option<BothWays>> {
    let options = with_all(&project.fill, true);
    let reports = tell(folder, project, site, &FillRequest { options, ..FillRequest::default() }, task)?;
    let texels = |photo: &FilledPhoto| photo.propagated.iter().map(|paint| paint.texels).sum::<u64>();
    let most = reports.iter().rev().max_by_key(|photo| texels(photo)).filter(|photo| texels(photo) > 0);
    let Some((photo, found)) = most.and_then(|found| Some((site.photo_named(&found.photo)?, found))) else {
        return Ok(None);
    };
    let photo = site.photo(photo);
    let rects = found.laid.iter().map(|laid| laid.region.rect());
    let Some(painted) = rects.reduce(|a, b| a.hull(&b)) else { return Ok(None) };
    let margin = (AROUND * f64::from(painted.w.max(painted.h))).max(LEAST_AROUND) as u32;
    let rect = painted.grown(margin).intersection(&photo.camera.rect());
    let shown = Raster::of_photo(read_unmasked(photo)?).cropped(rect);
    let mut from = found.propagated.clone();
    from.sort_by(|a, b| b.texels.cmp(&a.texels).then_with(|| a.from.cmp(&b.from)));
    let mut names: Vec<String> = Vec::new();
    from.into_iter().for_each(|paint| {
        if !names.contains(&paint.from) {
            names.push(paint.from)
        }
    });
    Ok(Some(BothWays {
        photo: found.photo.clone(),
        from: names,
        rect,
        only_here: picture(&shown, longest),
        everywhere: picture(&painted_over(shown, rect, &found.laid), longest),
    }))
}

/// Returns a part of a photo with paint of others.
fn painted_over(mut shown: Raster, rect: PixelRect, laid: &[FilledRegion]) -> Raster {
    for laid in laid {
        for ((x, y), texel) in laid.region.pixels().zip(&laid.texels) {
            let (x, y) = (x as i32 - rect.x, y as i32 - rect.y);
            let [r, g, b] = texel.rgb;
            shown.set_rgba16(x as u32, y as u32, [r, g, b, u16::MAX]);
        }
    }
    shown
}

fn picture(raster: &Raster, longest: u32) -> Picture {
    let small = raster.thumbnail(longest);
    Picture { width: small.width(), height: small.height(), rgba: small.samples().big_endian().into_owned() }
}
