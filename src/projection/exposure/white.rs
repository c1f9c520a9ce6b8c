//! White: a photo's clipped pixels were at least as bright as they are, so that no gain may turn them grey or lilac.

/// The darkest channel of stored linear light, from where on a colour begins to count as clipped: 241 of 255 in sRGB.
const FROM: f64 = 0.88;
/// The same where it is clipped for certain: 252 of 255, as JPEG leaves white.
const CERTAIN: f64 = 0.97;

/// Returns how far stored linear light counts as clipped, 0 to 1.
pub fn clipped(stored: f64) -> f64 {
    let t = ((stored - FROM) / (CERTAIN - FROM)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the light that a view shows of a photo: `exposed`, which gains and optics have made of `stored`, both linear. What is
/// stored as white stays at least as bright. Shader: kept_white of shaders/project.wgsl.
pub fn kept_white(stored: [f64; 3], exposed: [f64; 3]) -> [f64; 3] {
    let darkest = stored.into_iter().fold(f64::INFINITY, f64::min);
    let clipped = clipped(darkest);
    [0, 1, 2].map(|c| exposed[c] + clipped * (stored[c] - exposed[c]).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_under_any_gain_and_other_colours_follow_it() {
        let white = [1.0; 3];
        assert_eq!(kept_white(white, [0.5, 0.6, 0.4]), white);
        assert_eq!(kept_white(white, [0.7, 1.3, 2.0]), [1.0, 1.3, 2.0]);
        for stored in [[0.5; 3], [1.0, 1.0, 0.6]] {
            let exposed = stored.map(|light| 0.5 * light);
            assert_eq!(kept_white(stored, exposed), exposed, "a colour that is known");
        }
        let at = |light: f64| kept_white([light; 3], [0.5 * light; 3])[0];
        let largest = (0..1000).map(|k| f64::from(k) / 1000.0).map(|light| at(light + 1e-3) - at(light));
        assert!(largest.fold(0.0, f64::max) < 0.02, "there is no step");
    }
}
