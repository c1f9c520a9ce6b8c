//! Padding: colours carried outwards, so that filters and mip levels never fetch emptiness or another chart.

/// Gives each texel without a colour that of a nearest one with a colour, by steps to the four neighbours. `width` is that of the rows;
/// `known` tells which texels have a colour, and is true for all afterwards, unless none had one: then nothing changes.
///
/// # Panics
/// When the two have different lengths.
pub fn carry_outwards<T: Copy>(texels: &mut [T], known: &mut [bool], width: usize) {
    assert_eq!(texels.len(), known.len(), "a flag per texel");
    carry_in_place(known, width, |from, to| texels[to] = texels[from]);
}

/// As [`carry_outwards`] for texels that are kept elsewhere: `copy` gives the second of two texels the colour of the first.
pub fn carry_in_place(known: &mut [bool], width: usize, mut copy: impl FnMut(usize, usize)) {
    let neighbours = |at: usize| {
        let column = at % width;
        let left = (column > 0).then(|| at.wrapping_sub(1));
        let right = (column + 1 < width).then_some(at + 1);
        let (above, below) = (at.checked_sub(width), Some(at + width));
        [left, right, above, below].into_iter().flatten()
    };
    let is_unknown = |known: &[bool], at: usize| known.get(at).is_some_and(|known| !known);
    let mut front: Vec<u32> = (0..known.len())
        .filter(|&at| known[at] && neighbours(at).any(|other| is_unknown(known, other)))
        .map(|at| at as u32)
        .collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for at in front {
            for other in neighbours(at as usize) {
                if is_unknown(known, other) {
                    known[other] = true;
                    copy(at as usize, other);
                    next.push(other as u32);
                }
            }
        }
        front = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_carried_outwards_until_they_meet_in_the_middle() {
        let mut texels = vec![7, 0, 0, 0, 0, 9];
        let mut known = vec![true, false, false, false, false, true];
        carry_outwards(&mut texels, &mut known, 6);
        assert_eq!(texels, [7, 7, 7, 9, 9, 9]);
        assert!(known.iter().all(|known| *known));
        // Rows do not run on into each other.
        let mut texels = vec![1, 0, 0, 0, 0, 0, 0, 2];
        let mut known = vec![true, false, false, false, false, false, false, true];
        carry_outwards(&mut texels, &mut known, 2);
        assert_eq!(texels, [1, 1, 1, 1, 1, 2, 2, 2], "where two are equally near, the first counts");
    }

    #[test]
    fn without_any_colour_nothing_changes() {
        let mut texels = vec![3; 4];
        let mut known = vec![false; 4];
        carry_outwards(&mut texels, &mut known, 2);
        assert_eq!((texels, known), (vec![3; 4], vec![false; 4]));
    }
}
