//! Paints on a layered file, in place of an artist: `paint_mural FILE OBJECT`.
//!
//! A round window in bright colours appears in the middle of the largest layer whose name begins with `OBJECT`, on what the
//! photo shows and on what is hidden alike.

#[path = "../../../tests/round_trip/paper.rs"]
#[allow(dead_code)]
mod paper;

use std::path::PathBuf;

use paper::{Colour, Paper, Sheet, token};

/// From the middle outwards: glass, lead, glass, stone.
const RINGS: [Colour; 5] = [
    [0xffff, 0xd5d5, 0x2020, 0xffff],
    [0x1010, 0x1010, 0x1818, 0xffff],
    [0x1515, 0x5555, 0xd0d0, 0xffff],
    [0xc8c8, 0x1818, 0x2828, 0xffff],
    [0xe8e8, 0xe0e0, 0xd0d0, 0xffff],
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let usage = "usage: paint_mural FILE OBJECT";
    let file = PathBuf::from(arguments.next().ok_or(usage)?);
    let object = arguments.next().ok_or(usage)?.into_string().map_err(|_| usage)?;
    let mut paper = Paper::read(&file);
    let layers = paper.image_layers().filter(|sheet| sheet.name.starts_with(&object));
    let sheet = layers.max_by_key(|sheet| sheet.rect.area());
    let sheet = sheet.ok_or_else(|| format!("no layer's name begins with {object}"))?;
    let painted = paint_window(sheet);
    println!("{painted} pixels painted on \"{}\" [{}]", sheet.name, token(&sheet.name).unwrap_or_default());
    paper.write(&file);
    Ok(())
}

/// As large as fits into half of the layer, in the middle of what it shows.
fn paint_window(sheet: &mut Sheet) -> usize {
    let shown = sheet.pixels_where(true);
    let count = shown.len().max(1) as i64;
    let middle =
        |of: fn(&(i32, i32)) -> i32| shown.iter().map(|place| i64::from(of(place))).sum::<i64>() / count;
    let (x, y) = (middle(|place| place.0) as i32, middle(|place| place.1) as i32);
    let radius = (sheet.rect.w.min(sheet.rect.h) / 4).clamp(4, 120) as i32;
    let mut painted = 0;
    for (dx, dy) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))) {
        let ring = f64::from(dx * dx + dy * dy).sqrt() / f64::from(radius) * RINGS.len() as f64;
        if let Some(colour) = RINGS.get(ring as usize) {
            sheet.paint(x + dx, y + dy, *colour);
            painted += 1;
        }
    }
    painted
}
