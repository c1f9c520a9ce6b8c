//! Bytes of a picture as they are packed: rows less the row before, which leaves zeros where nothing changes.

/// Returns rows of bytes, each less the one before, modulo 256.
pub fn differences(bytes: &[u8], width: usize) -> Vec<u8> {
    let above = std::iter::repeat_n(0, width).chain(bytes.iter().copied());
    bytes.iter().zip(above).map(|(byte, above)| byte.wrapping_sub(above)).collect()
}

/// Halves a plane: each value is the mean of those of four that `counts` allows, 0 where there are none. An odd side is rounded up.
pub fn halved(values: &[u8], [width, height]: [usize; 2], counts: impl Fn(usize) -> bool) -> Vec<u8> {
    let mut half = Vec::with_capacity(width.div_ceil(2) * height.div_ceil(2));
    for y in (0..height).step_by(2) {
        for x in (0..width).step_by(2) {
            let (mut sum, mut count) = (0u32, 0u32);
            for at in [(0, 0), (1, 0), (0, 1), (1, 1)]
                .into_iter()
                .filter(|(dx, dy)| x + dx < width && y + dy < height)
                .map(|(dx, dy)| (y + dy) * width + x + dx)
                .filter(|at| counts(*at))
            {
                sum += u32::from(values[at]);
                count += 1;
            }
            half.push((sum + count / 2).checked_div(count).unwrap_or(0) as u8);
        }
    }
    half
}

/// Rounds to one of 16 values, of which all but 0 stay above 0.
pub fn in_16_steps(value: u8) -> u8 {
    let step = (u32::from(value) + 8) / 17;
    if value > 0 { (step.max(1) * 17) as u8 } else { 0 }
}

/// Rounds to one of 8 values, likewise: what was filled is known so well.
pub fn in_8_steps(value: u8) -> u8 {
    let step = (u32::from(value) + 17) / 36;
    if value > 0 { (step.max(1) * 36).min(255) as u8 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_repeat_leave_zeros() {
        assert_eq!(differences(&[5, 250, 5, 250, 1, 251], 2), [5, 250, 0, 0, 252, 1]);
    }

    #[test]
    fn halves_count_only_what_they_may() {
        let values = [10, 20, 30, 40, 50, 60];
        assert_eq!(halved(&values, [3, 2], |_| true), [30, 45]);
        assert_eq!(halved(&values, [3, 2], |at| at == 4), [50, 0]);
        assert_eq!([0, 1, 9, 128, 255].map(in_16_steps), [0, 17, 17, 136, 255]);
    }
}
