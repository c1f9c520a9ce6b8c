//! Connected pixels of a picture: what is one thing.

/// Returns the indices of the pixels at most `reach` columns and rows away from one, itself included, in a picture of this size.
pub(super) fn around([width, height]: [usize; 2], at: usize, reach: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (at % width, at / width);
    let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
    let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
    rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// Returns the connected parts of a set of pixels, in the order of their first pixels; pixels at most `reach` columns and rows
/// apart are connected.
pub(super) fn connected(set: &[bool], size: [usize; 2], reach: usize) -> Vec<Vec<usize>> {
    let mut visited = vec![false; set.len()];
    let mut parts = Vec::new();
    for first in (0..set.len()).filter(|at| set[*at]) {
        if std::mem::replace(&mut visited[first], true) {
            continue;
        }
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&at) = part.get(next) {
            next += 1;
            for beside in around(size, at, reach).filter(|beside| set[*beside]) {
                if !std::mem::replace(&mut visited[beside], true) {
                    part.push(beside);
                }
            }
        }
        parts.push(part);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_one_part_across_corners_and_gaps_within_reach() {
        let set: Vec<bool> = "x...x .x... ....x".bytes().filter(|b| *b != b' ').map(|b| b == b'x').collect();
        assert_eq!(connected(&set, [5, 3], 1), [vec![0, 6], vec![4], vec![14]]);
        assert_eq!(connected(&set, [5, 3], 2), [vec![0, 6], vec![4, 14]]);
        assert_eq!(around([5, 3], 0, 1).collect::<Vec<_>>(), [0, 1, 5, 6]);
        assert_eq!(around([5, 3], 14, 1).collect::<Vec<_>>(), [8, 9, 13, 14]);
    }
}
