//! Tests on images whose missing part is known.

use super::*;
use quadratura_base::scene::synthetic::Rng;

/// Returns a cell of a facade: plaster with a little noise, a window with a dark frame every 24 by 32 cells.
fn facade(x: usize, y: usize, rng: &mut Rng) -> [f32; 3] {
    let (u, v) = (x % 24, y % 32);
    let noise = rng.between(-0.01, 0.01) as f32;
    let in_frame = (6..18).contains(&u) && (8..26).contains(&v);
    let in_glass = (8..16).contains(&u) && (10..24).contains(&v);
    let value = if in_glass {
        0.25
    } else if in_frame {
        0.5
    } else {
        0.8
    };
    [value + noise, value * 0.95 + noise, value * 0.8 + noise]
}

fn canvas(size: [usize; 2], hole: impl Fn(usize, usize) -> bool) -> (ExemplarImage, Vec<[f32; 3]>) {
    let mut rng = Rng::new(3);
    let mut canvas = ExemplarImage::new(size);
    for i in 0..size[0] * size[1] {
        let (x, y) = (i % size[0], i / size[0]);
        canvas.colours[i] = facade(x, y, &mut rng);
        canvas.cells[i] = if hole(x, y) { Cell::Unknown } else { Cell::Known };
    }
    let truth = canvas.colours.clone();
    (canvas, truth)
}

fn error(canvas: &ExemplarImage, colours: &[[f32; 3]], truth: &[[f32; 3]]) -> f32 {
    let holes: Vec<usize> = (0..truth.len()).filter(|i| canvas.cells[*i] == Cell::Unknown).collect();
    let square = |i: &usize| (0..3).map(|c| (colours[*i][c] - truth[*i][c]).powi(2)).sum::<f32>() / 3.0;
    (holes.iter().map(square).sum::<f32>() / holes.len() as f32).sqrt()
}

#[test]
fn a_window_that_is_missing_is_made_like_the_others() {
    let (canvas, truth) = canvas([192, 160], |x, y| (84..124).contains(&x) && (60..104).contains(&y));
    let mut filled = canvas.clone();
    assert!(invent(&mut filled, 7));
    let by_example = error(&canvas, &filled.colours, &truth);
    let smooth = error(&canvas, &canvas.diffused().unwrap(), &truth);
    assert!(by_example < 0.35 * smooth, "by example {by_example}, smooth {smooth}");
    assert!(filled.cells.iter().all(|cell| *cell == Cell::Known));
}

#[test]
fn known_cells_stay_as_they_are_and_threads_make_no_difference() {
    let (canvas, truth) = canvas([130, 90], |x, y| (40..80).contains(&x) && (30..60).contains(&y));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut filled = canvas.clone();
        assert!(pool.install(|| invent(&mut filled, 1)));
        filled
    };
    let filled = with(1);
    assert!(filled == with(3));
    for (i, cell) in canvas.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Known) {
        assert_eq!((filled.colours[i], *cell), (truth[i], Cell::Known));
    }
}

#[test]
fn of_too_little_nothing_is_made_by_example() {
    let (mut canvas, _) = canvas([100, 100], |x, y| x > 8 || y > 8);
    let before = canvas.clone();
    assert!(!invent(&mut canvas, 1));
    assert!(canvas == before);
}
