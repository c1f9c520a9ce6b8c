//! Structural similarity (Wang, Bovik, Sheikh & Simoncelli, "Image quality assessment: from error visibility
//! to structural similarity", 2004), in the form that scikit-image uses by default.

use rayon::prelude::*;

use super::ImagePair;

/// Side of a window in pixels.
const SIDE: usize = 7;
const PIXELS: f64 = (SIDE * SIDE) as f64;
/// `(K1 L)^2` and `(K2 L)^2` with K1 = 0.01, K2 = 0.03, L = 255.
const C1: f64 = 2.55 * 2.55;
const C2: f64 = 7.65 * 7.65;

/// Computes the mean structural similarity over all windows of 7 x 7 pixels that are completely `counted`,
/// and over R, G and B. Windows are uniform, K1 = 0.01, K2 = 0.03, and variances are sample variances
/// (division by 48), as in `skimage.metrics.structural_similarity` with its defaults. Returns `None` without
/// such a window.
pub fn structural_similarity(compared: &ImagePair, counted: &[bool]) -> Option<f64> {
    let (width, height) = (compared.width as usize, compared.height as usize);
    if width < SIDE || height < SIDE {
        return None;
    }
    let rows = (0..=height - SIDE).into_par_iter().map(|top| row(compared, counted, top));
    // The sums are added in the order of the rows, so that the same input gives the same bytes.
    let rows: Vec<(f64, u64)> = rows.collect();
    let (sum, windows) = rows.iter().fold((0.0, 0), |(sum, count), row| (sum + row.0, count + row.1));
    (windows > 0).then(|| sum / (3 * windows) as f64)
}

/// Sums over pixels of one channel: first over the seven pixels of a column, then over seven columns.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    x: u32,
    y: u32,
    xx: u32,
    yy: u32,
    xy: u32,
}

/// Sums the similarities of the windows whose first row is `top`, over all channels; also returns their
/// number.
fn row(compared: &ImagePair, counted: &[bool], top: usize) -> (f64, u64) {
    let width = compared.width as usize;
    let whole: Vec<bool> =
        (0..width).map(|column| (top..top + SIDE).all(|row| counted[row * width + column])).collect();
    let starts: Vec<usize> =
        (0..=width - SIDE).filter(|&start| whole[start..start + SIDE].iter().all(|w| *w)).collect();
    let mut sum = 0.0;
    if !starts.is_empty() {
        for channel in 0..3 {
            let columns: Vec<Moments> =
                (0..width).map(|column| column_moments(compared, column, top, channel)).collect();
            sum += starts.iter().map(|&start| similarity(&columns[start..start + SIDE])).sum::<f64>();
        }
    }
    (sum, starts.len() as u64)
}

fn column_moments(compared: &ImagePair, column: usize, top: usize, channel: usize) -> Moments {
    let mut moments = Moments::default();
    for row in top..top + SIDE {
        let at = 3 * (row * compared.width as usize + column) + channel;
        let (x, y) = (u32::from(compared.truth[at]), u32::from(compared.predicted[at]));
        moments.x += x;
        moments.y += y;
        moments.xx += x * x;
        moments.yy += y * y;
        moments.xy += x * y;
    }
    moments
}

/// Computes the similarity of one window from its columns.
fn similarity(columns: &[Moments]) -> f64 {
    let sum = |of: fn(&Moments) -> u32| f64::from(columns.iter().map(of).sum::<u32>());
    let (mean_x, mean_y) = (sum(|m| m.x) / PIXELS, sum(|m| m.y) / PIXELS);
    let centred = |sum: f64, product: f64| (sum / PIXELS - product) * (PIXELS / (PIXELS - 1.0));
    let var_x = centred(sum(|m| m.xx), mean_x * mean_x);
    let var_y = centred(sum(|m| m.yy), mean_y * mean_y);
    let cov = centred(sum(|m| m.xy), mean_x * mean_y);
    let luminance = (2.0 * mean_x * mean_y + C1) / (mean_x * mean_x + mean_y * mean_y + C1);
    luminance * ((2.0 * cov + C2) / (var_x + var_y + C2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn noise(seed: u64, width: u32, height: u32) -> Vec<u8> {
        let mut rng = Rng::new(seed);
        (0..3 * width * height).map(|_| rng.whole(0, 255) as u8).collect()
    }

    /// Computes the mean window by window, with means first and deviations from them after.
    fn by_definition(compared: &ImagePair, counted: &[bool]) -> f64 {
        let (width, height) = (compared.width as usize, compared.height as usize);
        let mut values = Vec::new();
        for (top, left) in (0..=height - 7).flat_map(|t| (0..=width - 7).map(move |l| (t, l))) {
            let at: Vec<usize> = (0..49).map(|i| (top + i / 7) * width + left + i % 7).collect();
            if !at.iter().all(|&i| counted[i]) {
                continue;
            }
            for channel in 0..3 {
                let x: Vec<f64> = at.iter().map(|i| compared.truth[3 * i + channel].into()).collect();
                let y: Vec<f64> = at.iter().map(|i| compared.predicted[3 * i + channel].into()).collect();
                let mean = |v: &[f64]| v.iter().sum::<f64>() / 49.0;
                let (mx, my) = (mean(&x), mean(&y));
                let cov = |a: &[f64], b: &[f64], ma: f64, mb: f64| {
                    a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>() / 48.0
                };
                let (c1, c2) = ((0.01f64 * 255.0).powi(2), (0.03f64 * 255.0).powi(2));
                values.push(
                    (2.0 * mx * my + c1) * (2.0 * cov(&x, &y, mx, my) + c2)
                        / ((mx * mx + my * my + c1) * (cov(&x, &x, mx, mx) + cov(&y, &y, my, my) + c2)),
                );
            }
        }
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn it_is_what_the_definition_says_with_and_without_left_out_pixels() {
        let (width, height) = (23, 17);
        let (truth, predicted) = (noise(1, width, height), noise(2, width, height));
        let compared = ImagePair { width, height, truth: &truth, predicted: &predicted };
        let all = vec![true; 23 * 17];
        let mut some = all.clone();
        (some[5], some[200]) = (false, false);
        for counted in [all, some] {
            let found = structural_similarity(&compared, &counted).unwrap();
            assert!((found - by_definition(&compared, &counted)).abs() < 1e-9);
        }
    }

    /// Returns a slope with noise, and a darker copy with noise of its own.
    fn slope_with_noise(seed: u64, width: u32, height: u32) -> (Vec<u8>, Vec<u8>) {
        let mut rng = Rng::new(seed);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let samples = pixels.flat_map(|(x, y)| (0..3).map(move |c| 5 * x + 3 * y + 40 * c));
        samples
            .map(|slope| {
                let truth = slope % 200 + rng.whole(0, 40);
                (truth as u8, (truth * 3 / 4 + rng.whole(0, 50)) as u8)
            })
            .unzip()
    }

    /// The expected values are from scikit-image 0.26.0 (numpy 2.4.6) on the same images, whose samples it
    /// got from a copy of [`Rng`] in Python: `skimage.metrics.structural_similarity(truth, predicted,
    /// win_size=7, channel_axis=2, data_range=255)`, which leaves out a border of three pixels from the mean.
    #[test]
    fn it_is_what_scikit_image_says() {
        let said = [
            (71, 40, 30, 0.7220631566709595),
            (72, 7, 7, 0.6503538966141718),
            (73, 64, 9, 0.7078609290968728),
        ];
        for (seed, width, height, expected) in said {
            let (truth, predicted) = slope_with_noise(seed, width, height);
            let compared = ImagePair { width, height, truth: &truth, predicted: &predicted };
            let found = structural_similarity(&compared, &vec![true; (width * height) as usize]).unwrap();
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
    }

    #[test]
    fn a_picture_is_like_itself_and_two_flat_ones_are_compared_by_their_means() {
        let picture = noise(3, 9, 8);
        let all = [true; 72];
        let itself = ImagePair { width: 9, height: 8, truth: &picture, predicted: &picture };
        assert!((structural_similarity(&itself, &all).unwrap() - 1.0).abs() < 1e-12);
        let (dark, bright) = ([50u8; 216], [100u8; 216]);
        let flat = ImagePair { width: 9, height: 8, truth: &dark, predicted: &bright };
        let expected = (2.0 * 50.0 * 100.0 + C1) / (50.0 * 50.0 + 100.0 * 100.0 + C1);
        assert!((structural_similarity(&flat, &all).unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn without_a_whole_window_there_is_none() {
        let picture = noise(4, 9, 8);
        let compared = ImagePair { width: 9, height: 8, truth: &picture, predicted: &picture };
        let mut counted = [true; 72];
        (counted[3 * 9 + 2], counted[3 * 9 + 6]) = (false, false);
        assert_eq!(structural_similarity(&compared, &counted), None);
        let narrow = ImagePair { width: 6, height: 12, ..compared };
        assert_eq!(structural_similarity(&narrow, &[true; 72]), None);
    }
}
