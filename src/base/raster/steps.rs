//! How far inside a set each of its pixels lies.

/// Returns the steps to the eight neighbours from each pixel to the nearest one that is not in the set, 0 for those that
/// are not, row by row; the largest value but one where there is none. The edge of the picture is no border. `size` is
/// the number of columns and rows.
pub fn steps_inside(set: &[bool], [columns, rows]: [usize; 2]) -> Vec<u16> {
    const FAR: u16 = u16::MAX - 1;
    let mut steps: Vec<u16> = set.iter().map(|inside| if *inside { FAR } else { 0 }).collect();
    // Two sweeps: each value depends on the neighbours that come before it in one of both orders.
    let mut visit = |x: usize, y: usize, before: [(isize, isize); 4]| {
        let at = y * columns + x;
        for (dx, dy) in before {
            let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            if x < columns && y < rows {
                steps[at] = steps[at].min(steps[y * columns + x] + 1);
            }
        }
    };
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        visit(x, y, [(-1, -1), (0, -1), (1, -1), (-1, 0)]);
    }
    for (y, x) in (0..rows).rev().flat_map(|y| (0..columns).rev().map(move |x| (y, x))) {
        visit(x, y, [(1, 1), (0, 1), (-1, 1), (1, 0)]);
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_count_from_what_is_outside_and_not_from_the_edge_of_the_picture() {
        let set: Vec<bool> = (0..7 * 9).map(|at| at % 7 != 0).collect();
        assert_eq!(steps_inside(&set, [7, 9])[7 * 4..7 * 5], [0, 1, 2, 3, 4, 5, 6]);
        let mut hole = vec![true; 25];
        hole[12] = false;
        assert_eq!(steps_inside(&hole, [5, 5])[..5], [2; 5]);
        assert_eq!(steps_inside(&[true; 4], [2, 2]), [u16::MAX - 1; 4]);
    }
}
