//! Layered files through this project's own readers, for `tests/editors_round_trip.sh`:
//!
//! `compare_layers list FILE` prints what the file says, and how long it took to say it.
//! `compare_layers name FILE` prints the name of a layer that is fit to be painted on.
//! `compare_layers same BEFORE AFTER [OPTION]...` fails unless every layer of BEFORE is in AFTER at its place,
//! with every sample, mask, opacity, mode and group as it was. AFTER may have 16 bits where BEFORE has 8. Options:
//! `--painted TOKEN`: but for the pixels of this layer, which have to differ; `--cropped`: the editor may have cut
//! off transparent surroundings and dropped colours under transparent pixels, and the document key;
//! `--other-format`: the document key may be gone.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use quadratura::layered::{EditedDocument, EditedLayer, EditedMask, Raster, read_layered};
use quadratura::site::Samples;
use rayon::prelude::*;

type Outcome = Result<String, Box<dyn std::error::Error + Send + Sync>>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match &words[..] {
        ["list", file] => list(Path::new(file)),
        ["name", file] => name(Path::new(file)),
        ["same", before, after, options @ ..] => same(Path::new(before), Path::new(after), options),
        _ => Err("usage: compare_layers list FILE | name FILE | same BEFORE AFTER [OPTION]...".into()),
    };
    match outcome {
        Ok(text) => println!("{text}"),
        Err(error) => {
            eprintln!("wrong: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn list(file: &Path) -> Outcome {
    let began = Instant::now();
    let document = read_layered(file)?;
    let structure = began.elapsed();
    // One layer at a time in memory per thread, as an import reads them.
    let samples: u64 = document
        .layers
        .par_iter()
        .map(|layer| layer.pixels.read().map(|pixels| pixels.samples().len() as u64))
        .collect::<Result<Vec<_>, _>>()?
        .iter()
        .sum();
    let pixels = began.elapsed() - structure;
    let mut text = String::new();
    for layer in &document.layers {
        let groups = layer.groups.join("/");
        let mask = if !layer.masks.is_empty() { ", masked" } else { "" };
        let shown = if layer.visible { "" } else { ", hidden" };
        text += &format!("{:?} in {groups:?}: {:?}{mask}{shown}\n", layer.name, layer.rect);
    }
    document.notes.iter().for_each(|note| text += &format!("note: {note}\n"));
    let EditedDocument { width, height, depth, key, .. } = &document;
    let (bits, layers, megapixels) = (depth.bits(), document.layers.len(), samples as f64 / 4e6);
    let said = format!("{width} x {height}, {bits} bits, key {key:?}, {layers} layers, {megapixels:.1} Mpx");
    Ok(format!("{text}{said}: structure {:.1?}, pixels {:.1?}", structure, pixels))
}

/// Visible, with a token, large enough for a square of paint.
fn name(file: &Path) -> Outcome {
    let document = read_layered(file)?;
    let fit = |layer: &&EditedLayer| {
        layer.visible && layer.name.ends_with(']') && layer.rect.w.min(layer.rect.h) >= 20
    };
    let found = document.layers.iter().find(fit).ok_or("no layer is fit to be painted on")?;
    Ok(found.name.clone())
}

fn same(before: &Path, after: &Path, options: &[&str]) -> Outcome {
    let (before, after) = (read_layered(before)?, read_layered(after)?);
    let cropped = options.contains(&"--cropped");
    let painted = options.iter().position(|o| *o == "--painted").and_then(|at| options.get(at + 1));
    if (before.width, before.height) != (after.width, after.height) {
        return Err(format!("the canvas is {} x {} now", after.width, after.height).into());
    }
    if before.layers.len() != after.layers.len() {
        return Err(format!("{} layers became {}", before.layers.len(), after.layers.len()).into());
    }
    let other_format = options.contains(&"--other-format");
    if !cropped && !other_format && before.key != after.key {
        return Err(format!("the key {:?} became {:?}", before.key, after.key).into());
    }
    let pairs: Vec<_> = before.layers.iter().zip(&after.layers).collect();
    let changed = pairs.par_iter().map(|(before, after)| compare(before, after, cropped));
    let changed = changed.collect::<Result<Vec<u64>, _>>()?;
    let mut text = format!("{} layers, {} bits, 0 offsets changed", changed.len(), after.depth.bits());
    for ((layer, _), pixels) in pairs.iter().zip(&changed) {
        let is_painted = painted.is_some_and(|token| layer.name.contains(&format!("[{token}]")));
        match (pixels, is_painted) {
            (0, true) => return Err(format!("{:?} was painted on, and is as it was", layer.name).into()),
            (0, false) => {}
            (_, true) => text += &format!(", {pixels} pixels painted"),
            (_, false) => return Err(format!("{:?}: {pixels} pixels changed", layer.name).into()),
        }
    }
    let notes = after.notes.iter().map(|note| format!("; note: {note}")).collect::<String>();
    Ok(format!("{text}, 0 other pixels changed{notes}"))
}

/// The number of pixels that differ; everything else has to be the same.
fn compare(before: &EditedLayer, after: &EditedLayer, cropped: bool) -> Result<u64, quadratura::Error> {
    let differs = |what: &str| {
        quadratura::Error::Request(format!("{:?} and {:?} differ in their {what}", before.name, after.name))
    };
    if before.name != after.name {
        return Err(differs("names"));
    }
    if before.groups != after.groups {
        return Err(differs("groups"));
    }
    if before.visible != after.visible {
        return Err(differs("visibility"));
    }
    // A PSD stores opacity in 255 steps.
    if (before.opacity - after.opacity).abs() > 0.5 / 255.0 + 1e-6 || before.blend != after.blend {
        return Err(differs("opacity or mode"));
    }
    if before.hidden_by_group != after.hidden_by_group {
        return Err(differs("groups' visibility"));
    }
    if masked(before)? != masked(after)? {
        return Err(differs("masks"));
    }
    let (old, new) = (before.pixels.read()?, after.pixels.read()?);
    let (old, new) = if old.depth() == new.depth() { (old, new) } else { (sixteen(&old), sixteen(&new)) };
    if cropped {
        let same = old.hash_at(before.rect.x, before.rect.y) == new.hash_at(after.rect.x, after.rect.y);
        return Ok(u64::from(!same));
    }
    if before.rect != after.rect {
        return Err(differs("places"));
    }
    Ok(match (old.samples(), new.samples()) {
        (Samples::U8(a), Samples::U8(b)) => different(a, b),
        (Samples::U16(a), Samples::U16(b)) => different(a, b),
        _ => u64::MAX,
    })
}

/// What each mask says of each pixel of the layer, in 8 bits; whether it is switched on.
fn masked(layer: &EditedLayer) -> Result<Vec<(bool, Vec<u8>)>, quadratura::Error> {
    layer.masks.iter().map(|mask| values_of(mask, layer)).collect()
}

fn values_of(mask: &EditedMask, layer: &EditedLayer) -> Result<(bool, Vec<u8>), quadratura::Error> {
    let pixels = mask.pixels.read()?;
    let at = |x: i32, y: i32| {
        let (x, y) = (x - mask.rect.x, y - mask.rect.y);
        let inside = (0..mask.rect.w as i32).contains(&x) && (0..mask.rect.h as i32).contains(&y);
        let value = if inside { pixels.at(x as u32, y as u32) } else { mask.outside };
        (value * 255.0).round() as u8
    };
    let rows = layer.rect.y..layer.rect.bottom();
    let values = rows.flat_map(|y| (layer.rect.x..layer.rect.right()).map(move |x| (x, y)));
    Ok((mask.enabled, values.map(|(x, y)| at(x, y)).collect()))
}

fn different<T: PartialEq>(a: &[T], b: &[T]) -> u64 {
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| a != b).count() as u64
}

fn sixteen(raster: &Raster) -> Raster {
    match raster.samples() {
        Samples::U8(samples) => {
            let wide = samples.iter().map(|sample| u16::from(*sample) * 257).collect();
            Raster::new(raster.width(), raster.height(), Samples::U16(wide))
        }
        Samples::U16(_) => raster.clone(),
    }
}
