//! The contact sheet: every image layer on a chequered ground, nearest first, row by row.

use quadratura::testing::editing::exploded::LayerPicture as Layer;
use quadratura::testing::editing::exploded::premultiplied::{Ink, PremultipliedPicture};

use super::lettering;

const WIDTH: usize = 1800;
const GAP: usize = 22;
const ROW: usize = 190;
const NARROWEST: usize = 120;
const LETTER: f64 = 11.0;
const CAPTION: usize = 26;

const PAPER: Ink = Ink(0xf4_f1_ea, 1.0);
const LIGHT: Ink = Ink(0xff_ff_ff, 1.0);
const DARK: Ink = Ink(0xe2_df_d8, 1.0);
const TEXT: Ink = Ink(0x4a_46_40, 1.0);
const FRAME: Ink = Ink(0xc9_c4_ba, 1.0);

/// A layer's place on the sheet.
struct Cell<'a> {
    layer: &'a Layer,
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

/// Draws all layers.
pub fn draw(layers: &[Layer]) -> PremultipliedPicture {
    let cells = arranged(layers);
    let bottom = cells.iter().map(|cell| cell.y + cell.height).max().unwrap_or(0);
    let mut canvas = PremultipliedPicture::new(WIDTH, bottom + CAPTION + GAP);
    canvas.fill_gradient(PAPER, PAPER);
    for cell in &cells {
        draw_cell(&mut canvas, cell);
    }
    canvas
}

/// Rows of equal height, filled from the left.
fn arranged(layers: &[Layer]) -> Vec<Cell<'_>> {
    let mut cells = Vec::new();
    let mut row: Vec<Cell> = Vec::new();
    let mut y = GAP;
    for layer in layers {
        let (width, height) = cell_size(layer);
        if used(&row) + width + GAP > WIDTH {
            cells.append(&mut row);
            y += ROW + CAPTION + GAP;
        }
        let x = used(&row);
        row.push(Cell { layer, x, y, width, height });
    }
    cells.append(&mut row);
    cells
}

/// Where the next cell of a row would begin.
fn used(row: &[Cell]) -> usize {
    row.last().map_or(GAP, |cell| cell.x + cell.width.max(NARROWEST) + GAP)
}

/// As high as the row, or as large as it is in the photo where that is smaller.
fn cell_size(layer: &Layer) -> (usize, usize) {
    let (w, h) = (layer.pixels.width as f64, layer.pixels.height as f64);
    let scale = (ROW as f64 / h).min((WIDTH - 2 * GAP) as f64 / w).min(1.0);
    (((w * scale).round() as usize).max(1), ((h * scale).round() as usize).max(1))
}

fn draw_cell(canvas: &mut PremultipliedPicture, cell: &Cell) {
    // Layers lower than the row stand on its bottom line, like pictures on a ledge.
    let top = cell.y + ROW - cell.height;
    let mut picture = PremultipliedPicture::new(cell.width, cell.height);
    for y in 0..cell.height {
        for x in 0..cell.width {
            let ink = if (x / 9 + y / 9) % 2 == 0 { LIGHT } else { DARK };
            picture.blend(x as i32, y as i32, ink.linear());
        }
    }
    let pitch = (9 * cell.layer.pixels.width / cell.width).max(2);
    picture.draw(&cell.layer.hatched(pitch).resized(cell.width, cell.height), 0, 0);
    canvas.draw(&picture, cell.x as i32, top as i32);
    frame(canvas, cell, top);
    let room = cell.width.max(NARROWEST) as f64;
    let caption = lettering::fitted(&format!("{} {}", cell.layer.order, cell.layer.name), LETTER, room);
    let at = [cell.x as f64, (cell.y + ROW + 10) as f64];
    lettering::write(canvas, &caption, at, LETTER, TEXT);
}

fn frame(canvas: &mut PremultipliedPicture, cell: &Cell, top: usize) {
    let (left, top) = (cell.x as f64 - 0.5, top as f64 - 0.5);
    let (right, bottom) = (left + cell.width as f64 + 1.0, top + cell.height as f64 + 1.0);
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
    for side in corners.windows(2) {
        canvas.line(side[0], side[1], 1.0, FRAME);
    }
}
