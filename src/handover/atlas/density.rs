//! Texels per unit of charts: as many as photos show, within what an atlas may hold.

use glam::DVec2;

use super::{CELL, cells_of};
use quadratura_base::raster::robust::{median, quantile};

/// The share of a chart's places whose photos are not finer than its texels.
const QUANTILE: f64 = 0.9;

/// The largest density of a chart, as a multiple of the median of its object: a photo taken at arm's length must not fill the atlas.
const OVER_MEDIAN: f64 = 2.0;

/// What is known of a chart before its density is settled.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Width and height in units of the world.
    pub size: DVec2,
    /// The pixels per unit of the best photo at places spread over the chart; empty where no photo shows it.
    pub of_photos: Vec<f64>,
    /// The number of the object.
    pub object: usize,
}

/// What an atlas may hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The largest density, in texels per unit.
    pub density: f64,
    /// The largest number of texels of all cells together.
    pub texels: f64,
    /// The side of a page in texels.
    pub page: u32,
}

/// The densities of all charts.
#[derive(Debug, Clone, PartialEq)]
pub struct Densities {
    /// Texels per unit of each chart.
    pub of_charts: Vec<f64>,
    /// The largest density that the limit on texels left; infinite where it took no effect.
    pub cap: f64,
    /// The charts that are coarser because they would be larger than a page.
    pub larger_than_page: Vec<usize>,
    /// The share of the charts' places that photos show with fewer pixels than there are texels, 0 to 1.
    pub upsampled: f64,
}

/// Settles the densities of charts. A chart that no photo shows gets the median of its object, or of all.
pub fn densities(charts: &[Wanted], limits: &Limits) -> Densities {
    let wanted: Vec<Option<f64>> =
        charts.iter().map(|chart| quantile(&mut chart.of_photos.clone(), QUANTILE)).collect();
    let of_all = median(&mut wanted.iter().flatten().copied().collect::<Vec<_>>()).unwrap_or(1.0);
    let objects = charts.iter().map(|chart| chart.object + 1).max().unwrap_or(0);
    let mut of_objects = vec![Vec::new(); objects];
    charts.iter().zip(&wanted).for_each(|(chart, wanted)| of_objects[chart.object].extend(*wanted));
    let medians: Vec<f64> =
        of_objects.iter_mut().map(|densities| median(densities).unwrap_or(of_all)).collect();
    let free: Vec<f64> = charts
        .iter()
        .zip(&wanted)
        .map(|(chart, wanted)| {
            let usual = medians[chart.object];
            wanted.unwrap_or(usual).min(OVER_MEDIAN * usual).min(limits.density)
        })
        .collect();
    let cap = cap(charts, &free, limits.texels);
    let most = f64::from(limits.page - 2 * CELL);
    let mut larger_than_page = Vec::new();
    let of_charts: Vec<f64> = (0..)
        .zip(charts.iter().zip(&free))
        .map(|(index, (chart, &free))| {
            let fits = most / chart.size.max_element().max(f64::MIN_POSITIVE);
            if fits < free.min(cap) {
                larger_than_page.push(index);
            }
            free.min(cap).min(fits)
        })
        .collect();
    let upsampled = upsampled(charts, &of_charts);
    Densities { of_charts, cap, larger_than_page, upsampled }
}

/// Returns the largest density with which all cells together have no more than `most` texels; infinite where they have no
/// more in any case.
fn cap(charts: &[Wanted], free: &[f64], most: f64) -> f64 {
    let texels = |cap: f64| -> f64 {
        let of_chart = |(chart, free): (&Wanted, &f64)| {
            let size = chart.size * free.min(cap);
            f64::from(cells_of(size.x)) * f64::from(cells_of(size.y)) * f64::from(CELL * CELL)
        };
        charts.iter().zip(free).map(of_chart).sum()
    };
    if texels(f64::INFINITY) <= most {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, free.iter().copied().fold(0.0, f64::max));
    // 40 halvings leave a difference that no texel shows.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if texels(middle) <= most { low = middle } else { high = middle }
    }
    low
}

/// Returns the share of places, weighted by the charts' texels, where the best photo is coarser than the chart.
fn upsampled(charts: &[Wanted], densities: &[f64]) -> f64 {
    let (mut coarse, mut all) = (0.0, 0.0);
    for (chart, density) in charts.iter().zip(densities) {
        let texels = chart.size.x * chart.size.y * density * density;
        let of_chart = chart.of_photos.iter().filter(|of_photo| *of_photo < density).count();
        let share = of_chart as f64 / chart.of_photos.len().max(1) as f64;
        coarse += texels * if chart.of_photos.is_empty() { 1.0 } else { share };
        all += texels;
    }
    if all > 0.0 { coarse / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { density: f64::INFINITY, texels: 1e9, page: 4096 };

    fn chart(size: f64, of_photos: &[f64]) -> Wanted {
        Wanted { size: DVec2::splat(size), of_photos: of_photos.to_vec(), object: 0 }
    }

    #[test]
    fn one_photo_at_arms_length_does_not_fill_the_atlas() {
        let charts = [chart(1.0, &[50.0]), chart(1.0, &[60.0]), chart(1.0, &[900.0])];
        assert_eq!(densities(&charts, &LIMITS).of_charts, [50.0, 60.0, 120.0]);
        let capped = densities(&charts, &Limits { density: 55.0, ..LIMITS });
        assert_eq!(capped.of_charts, [50.0, 55.0, 55.0]);
    }

    #[test]
    fn what_no_photo_shows_is_as_fine_as_the_rest_of_its_object_and_counts_as_upsampled() {
        let charts = [chart(1.0, &[40.0; 10]), chart(1.0, &[])];
        let found = densities(&charts, &LIMITS);
        assert_eq!(found.of_charts, [40.0, 40.0]);
        assert_eq!(found.upsampled, 0.5);
        assert_eq!(densities(&[chart(1.0, &[])], &LIMITS).of_charts, [1.0]);
    }

    #[test]
    fn a_budget_lowers_the_finest_charts_and_a_page_the_largest() {
        let charts = [chart(10.0, &[100.0]), chart(10.0, &[60.0])];
        let found = densities(&charts, &Limits { texels: 1.2e6, ..LIMITS });
        assert!(found.of_charts[1] == 60.0 && found.of_charts[0] > 80.0 && found.of_charts[0] < 100.0);
        let found = densities(&charts, &Limits { page: 512, ..LIMITS });
        assert_eq!((found.of_charts, found.larger_than_page), (vec![48.0, 48.0], vec![0, 1]));
    }
}
