//! Parts of views: the rows of a picture that are needed, drawn with the exposure of the whole view.

use std::ops::Range;

use crate::exposed_shot::ExposedShot;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::{Renders, Sliced};
use quadratura_view::Picture;

/// Returns the rows of a picture of some width and height from the first to the last one that is needed, of which the indices of its
/// pixels tell that; none where no row is.
pub fn rows_of(is_needed: impl Fn(Range<usize>) -> bool, [width, height]: [u32; 2]) -> Range<u32> {
    let is_needed = |row: &u32| {
        let start = *row as usize * width as usize;
        is_needed(start..start + width as usize)
    };
    match (0..height).find(is_needed) {
        None => 0..0,
        Some(first) => first..(first..height).rev().find(is_needed).unwrap_or(first) + 1,
    }
}

/// Draws some rows of a view; all others are empty.
///
/// # Errors
/// Those of [`Renders::picture`].
pub fn drawn_rows(
    renderer: &mut impl Renders,
    view: ExposedShot,
    rows: Range<u32>,
    task: &Task,
) -> Result<Picture> {
    let mut sliced = Sliced::of_rows(view.shot, view.exposure.clone(), rows.clone());
    while !rows.is_empty() && !renderer.advance(&mut sliced, task)? {}
    Ok(sliced.picture())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_reach_from_the_first_to_the_last_one_that_is_needed() {
        let rows = |needed: &[usize]| rows_of(|mut row| row.any(|at| needed.contains(&at)), [4, 6]);
        assert_eq!((rows(&[6, 13]), rows(&[23]), rows(&[0, 23])), (1..4, 5..6, 0..6));
        assert!(rows(&[]).is_empty());
    }
}
