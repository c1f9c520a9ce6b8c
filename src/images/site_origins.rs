//! Where the colours of the layered depth image of a site are from: paint, inpainting, or photos. Its layers are drawn once
//! more with the colours that stand for sources, of the photo with the largest weight at each point.

use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_ldi::DepthPixelOrigin;
use quadratura_projection::peeling::{Peeled, PeeledLayer, Peels};
use quadratura_view::legend::Origin;
use quadratura_view::{Blend, DisplayMode, Mode, Shot};

use super::cover::FoundPixel;

/// Returns the view that shows sources in place of colours.
pub fn of_origins(shot: &Shot) -> Shot {
    let blend = Blend { mode: Mode::Best, ..shot.blend };
    Shot { display: DisplayMode::Provenance, blend, ..shot.clone() }
}

/// Sets the origins of the depth pixels of each row, which come layer after layer and in a layer by column, and those of the
/// surroundings behind them, whose plane is given.
///
/// # Errors
/// Those of [`Peels::peel`] and [`Peels::surroundings`].
pub fn find_origins(
    rows: &mut [Vec<FoundPixel>],
    surroundings: Option<u32>,
    peels: &mut dyn Peels,
    shot: &Shot,
    task: &Task,
) -> Result<()> {
    let width = shot.camera.width as usize;
    let mut next = vec![0; rows.len()];
    let mut each = |layer: PeeledLayer| {
        let parts = layer.parts.chunks_exact(width).zip(layer.colours.chunks_exact(width));
        for ((row, next), (parts, colours)) in rows.iter_mut().zip(&mut next).zip(parts) {
            for (x, (part, colour)) in parts.iter().zip(colours).enumerate() {
                // What has no colour has no depth pixel.
                let is_next =
                    |found: &&mut FoundPixel| usize::from(found.column) == x && found.plane + 1 == *part;
                let Some(found) = row.get_mut(*next).filter(is_next) else { continue };
                found.origin = origin_of(*colour).unwrap_or(found.origin);
                *next += 1;
            }
        }
        task.check_cancelled()?;
        Ok(true)
    };
    peels.peel(shot, Peeled::Faces, &mut each, task)?;
    let Some(surroundings) = surroundings else { return Ok(()) };
    let picture = peels.surroundings(shot, task)?;
    for (row, colours) in rows.iter_mut().zip(picture.pixels().chunks_exact(width)) {
        for found in row.iter_mut().filter(|found| found.plane == surroundings) {
            found.origin = origin_of(colours[usize::from(found.column)]).unwrap_or(found.origin);
        }
    }
    Ok(())
}

/// Returns what a colour of the picture of sources stands for; `None` for photos, of which there are two kinds, and where
/// nothing is shown.
fn origin_of([r, g, b, alpha]: [u8; 4]) -> Option<DepthPixelOrigin> {
    // Between texels of two sources colours are mixed.
    let distance = |origin: &Origin| -> u32 {
        origin.colour().into_iter().zip([r, g, b]).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    };
    match Origin::ALL.into_iter().min_by_key(distance).filter(|_| alpha > 0)? {
        Origin::Photo => None,
        Origin::Paint | Origin::Propagated => Some(DepthPixelOrigin::Paint),
        Origin::OtherPhoto => Some(DepthPixelOrigin::OtherPhotos),
        Origin::Example | Origin::Diffused => Some(DepthPixelOrigin::Invented),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_sources_are_told_apart_also_when_filtering_changed_them_a_little() {
        for origin in Origin::ALL {
            for step in [-9, 0, 9] {
                let [r, g, b] = origin.colour().map(|byte| byte.saturating_add_signed(step));
                let expected = match origin {
                    Origin::Photo => None,
                    Origin::Paint | Origin::Propagated => Some(DepthPixelOrigin::Paint),
                    Origin::OtherPhoto => Some(DepthPixelOrigin::OtherPhotos),
                    Origin::Example | Origin::Diffused => Some(DepthPixelOrigin::Invented),
                };
                assert_eq!(origin_of([r, g, b, 255]), expected, "{origin:?}");
            }
        }
        assert_eq!(origin_of([0; 4]), None);
    }
}
