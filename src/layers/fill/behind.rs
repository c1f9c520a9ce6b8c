//! What other photos show behind things that a photo sees through: the colours that filling would put there, without
//! any that are invented.

use glam::DVec2;
use rayon::prelude::*;

use super::cells::RegionCells;
use super::donor::Donor;
use super::photo::{FillContext, nearest_donors};
use super::queries::{Asking, Query, centre};
use super::ranked_donors::DonatedColour;
use super::region::Region;
use super::seam::seam;
use quadratura_base::error::Result;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;

/// The colour that is expected behind a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedColour {
    /// Linear light in the photo's own exposure, full range 1.
    pub light: [f32; 3],
    /// The confidence, 0 to [`super::MOST_CONFIDENCE`].
    pub confidence: f32,
}

/// Returns what other photos show at the pixels of regions of a photo, `own`, one value per pixel in the order of the
/// region's spans; `None` where no photo shows the surface. Paint gives nothing.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn predicted_colours(
    context: &FillContext,
    photo: PhotoId,
    own: &Donor,
    regions: &[Region],
    task: &Task,
) -> Result<Vec<Vec<Option<PredictedColour>>>> {
    let donors = context.donors(&nearest_donors(context, photo, regions))?;
    let asking = Asking { context, photo, own, donors: &donors };
    let given = |query: &Query, px: DVec2| query.given(px, 0).filter(|given| !given.painted);
    let given = asking.ask(regions, &given, task)?;
    let exposed = |(region, given): (&Region, Vec<Option<DonatedColour>>)| {
        task.check_cancelled()?;
        Ok(asking.in_own_exposure(region, &given))
    };
    regions.par_iter().zip(given).map(exposed).collect()
}

impl Asking<'_> {
    /// Brings the colours of a region to the level that the photo itself shows of the surface beside it.
    fn in_own_exposure(
        &self,
        region: &Region,
        given: &[Option<DonatedColour>],
    ) -> Vec<Option<PredictedColour>> {
        let cells = RegionCells::around(region, self.frame());
        let item = self.own.item(region.surface);
        let differences =
            item.map(|item| self.all_differences(region, item, &cells, None, &|_| false)).unwrap_or_default();
        let seam = seam(&cells, &differences);
        let exposed = |((x, y), given): ((u32, u32), &Option<DonatedColour>)| {
            let DonatedColour { colour, confidence, .. } = (*given)?;
            let factor = seam.as_ref().map_or([0.0; 3], |seam| seam.at(x, y)).map(f32::exp);
            let gain = self.factor(centre(x, y));
            let light = [0, 1, 2].map(|c| colour[c] * factor[c] * gain[c]);
            Some(PredictedColour { light, confidence })
        };
        region.pixels().zip(given).map(exposed).collect()
    }
}
