//! Masks, opacities, modes, groups and colour profiles, as PSD files have them: what is understood is applied or told, and
//! nothing is guessed.

use std::collections::BTreeMap;
use std::fs;

use moxcms::ColorProfile;
use quadratura::testing::document::paint::ERASED;
use quadratura::testing::io::colour::Conversion;
use quadratura::testing::scene::Samples;
use serde_json::Value;

use super::paper::{Colour, Paper, Sheet};
use super::psd_file::{Coding, File, Layer};
use super::{RED, Studio, layer};

/// What stands around the wall in the file.
#[derive(Default)]
struct Look {
    /// Of the wall's own layer.
    wall: Dress,
    /// A copy of the wall above it, with a stroke of its own.
    copy: Option<Dress>,
    /// A group around both.
    group: Option<Dress>,
}

#[derive(Clone)]
struct Dress {
    opacity: u8,
    blend: &'static [u8; 4],
    hidden: bool,
    /// A mask of one value inside this rectangle, 255 outside it.
    mask: Option<([i32; 4], u8)>,
}

impl Default for Dress {
    fn default() -> Self {
        Self { opacity: 255, blend: b"norm", hidden: false, mask: None }
    }
}

impl Dress {
    fn put_on(&self, layer: &mut Layer) {
        (layer.opacity, layer.blend) = (self.opacity, self.blend);
        layer.flags = if self.hidden { 2 } else { 0 };
        if let Some((rect, value)) = self.mask {
            layer.mask = Some((rect, 255, 0));
            layer.channels.push((-2, Coding::Rle, vec![value.into(); (rect[2] * rect[3]) as usize]));
        }
    }
}

fn record(sheet: &Sheet, name: &str) -> Layer {
    let Samples::U8(samples) = sheet.pixels.samples() else { panic!("8 bits") };
    let plane = |channel: usize| samples.chunks_exact(4).map(|pixel| u16::from(pixel[channel])).collect();
    let channels = [(0, 0), (1, 1), (2, 2), (-1, 3)].map(|(id, channel)| (id, Coding::Rle, plane(channel)));
    let rect = [sheet.rect.x, sheet.rect.y, sheet.rect.w as i32, sheet.rect.h as i32];
    // Tests are few, and names in them are literals elsewhere.
    Layer::new(Box::leak(name.to_owned().into_boxed_str()), rect, channels.into())
}

/// The file of a studio with that look; `stroke` is painted on the wall, or on the copy where there is one.
fn dressed(paper: &mut Paper, look: &Look, stroke: &[(i32, i32)]) -> Vec<u8> {
    let wall = paper.sheet("wall").clone();
    let mut copy = wall.clone();
    let painted = if look.copy.is_some() { &mut copy } else { paper.sheet("wall") };
    stroke.iter().for_each(|&(x, y)| painted.paint(x, y, RED));
    let wall = paper.sheet("wall").clone();
    let mut layers = Vec::new();
    for sheet in &paper.sheets {
        if sheet.name != wall.name {
            layers.push(record(sheet, &sheet.name));
            continue;
        }
        layers.extend(look.group.is_some().then(|| Layer::section("</Layer group>", 3)));
        let mut own = record(&wall, &wall.name);
        look.wall.put_on(&mut own);
        layers.push(own);
        if let Some(dress) = &look.copy {
            let mut above = record(&copy, &format!("{} copy", wall.name));
            dress.put_on(&mut above);
            layers.push(above);
        }
        if let Some(dress) = &look.group {
            let mut group = Layer::section("group", 1);
            dress.put_on(&mut group);
            layers.push(group);
        }
    }
    let xmp = format!(
        "<x xmlns:dc='http://purl.org/dc/elements/1.1/'><dc:identifier>{}</dc:identifier></x>",
        paper.key
    );
    let resources = vec![(1060, xmp.into_bytes())];
    File { canvas: [paper.width, paper.height], resources, ..File::new(8, layers) }.bytes()
}

type Paint = BTreeMap<(i32, i32), Colour>;

/// Imports that file. Returns the report, the project's paint and the wall as it was exported.
fn worn(look: &Look, stroke: &[(i32, i32)]) -> Option<(Value, Paint, Sheet)> {
    let studio = Studio::new("psd")?;
    let mut paper = Paper::read(&studio.file());
    let wall = paper.sheet("wall").clone();
    fs::write(studio.file(), dressed(&mut paper, look, stroke)).unwrap();
    Some((studio.import(), studio.paint(), wall))
}

const STROKE: [(i32, i32); 3] = [(20, 30), (21, 30), (22, 30)];

fn red() -> Paint {
    STROKE.iter().map(|place| (*place, RED)).collect()
}

fn notes(report: &Value) -> String {
    let of_file = report["files"][0]["notes"].to_string();
    of_file + &layer(report, "wall")["notes"].to_string()
}

#[test]
fn without_any_look_exactly_the_stroke_comes_home() {
    let Some((report, paint, _)) = worn(&Look::default(), &STROKE) else { return };
    assert_eq!(paint, red(), "{report:#}");
    assert_eq!(notes(&report), "[][]");
}

#[test]
fn opacity_mode_and_visibility_of_the_layer_and_of_its_group_are_ways_of_looking_at_it_and_told() {
    let dim = Dress { opacity: 128, ..Dress::default() };
    let multiplied = Dress { blend: b"mul ", ..Dress::default() };
    let hidden = Dress { hidden: true, ..Dress::default() };
    for (dress, said) in [(dim, "opacity"), (multiplied, "multiply"), (hidden, "")] {
        for look in [
            Look { wall: dress.clone(), ..Look::default() },
            Look { group: Some(dress.clone()), ..Look::default() },
        ] {
            let Some((report, paint, _)) = worn(&look, &STROKE) else { return };
            assert_eq!(paint, red(), "{said}: {report:#}");
            assert!(notes(&report).contains(said), "{said}: {report:#}");
        }
    }
}

#[test]
fn a_mask_of_the_layer_and_of_its_group_is_work_and_both_count() {
    let masked = |value| Dress { mask: Some(([20, 30, 2, 1], value)), ..Dress::default() };
    for (wall, group, alpha) in [
        (masked(0), None, 0),
        (Dress::default(), Some(masked(0)), 0),
        (Dress::default(), Some(masked(102)), 102),
        (masked(102), Some(masked(51)), 20),
    ] {
        let Some((report, paint, exported)) = worn(&Look { wall, copy: None, group }, &[]) else { return };
        for x in [20, 21] {
            let [r, g, b, _] = exported.at(x, 30);
            let expected = if alpha == 0 { ERASED } else { [r, g, b, alpha * 257] };
            assert_eq!(paint.get(&(x, 30)), Some(&expected), "{report:#}");
        }
        assert_eq!(paint.len(), 2, "nothing else: {report:#}");
    }
}

#[test]
fn a_copy_is_laid_over_with_its_own_opacity_and_that_of_its_group() {
    for (copy, group) in [
        (Dress { opacity: 51, ..Dress::default() }, None),
        (Dress::default(), Some(Dress { opacity: 51, ..Dress::default() })),
    ] {
        let look = Look { copy: Some(copy), group, ..Look::default() };
        let Some((report, paint, exported)) = worn(&look, &STROKE) else { return };
        for (x, y) in STROKE {
            let below = exported.at(x, y);
            let mixed = |i: usize| (f64::from(below[i] / 257) * 0.8 + f64::from(RED[i] / 257) * 0.2).round();
            let expected = [0, 1, 2].map(|i| mixed(i) as u16 * 257);
            assert_eq!(paint.get(&(x, y)).map(|colour| &colour[..3]), Some(&expected[..]), "{report:#}");
        }
        assert_eq!(paint.len(), STROKE.len(), "{report:#}");
    }
}

#[test]
fn a_copy_in_another_mode_and_a_hidden_one_are_left_out_and_named() {
    let copy = Some(Dress { blend: b"mul ", ..Dress::default() });
    let Some((report, paint, _)) = worn(&Look { copy, ..Look::default() }, &STROKE) else { return };
    assert!(paint.is_empty() && notes(&report).contains("multiply"), "{report:#}");
    let copy = Some(Dress { hidden: true, ..Dress::default() });
    let Some((report, paint, _)) = worn(&Look { copy, ..Look::default() }, &STROKE) else { return };
    assert!(paint.is_empty() && notes(&report).contains("is hidden"), "{report:#}");
}

#[test]
fn in_a_hidden_group_a_layer_and_its_copy_count_as_if_the_group_were_shown() {
    let group = Some(Dress { hidden: true, ..Dress::default() });
    let look = Look { copy: Some(Dress::default()), group, ..Look::default() };
    let Some((report, paint, _)) = worn(&look, &STROKE) else { return };
    assert_eq!(paint, red(), "{report:#}");
}

#[test]
fn paint_in_another_profile_comes_home_in_the_photos_own_and_nothing_else_does() {
    let Some(studio) = Studio::new("psd") else { return };
    let adobe = ColorProfile::new_adobe_rgb().encode().unwrap();
    let there = Conversion::between(None, Some(&adobe)).unwrap().unwrap();
    let back = Conversion::between(Some(&adobe), None).unwrap().unwrap();
    let mut paper = Paper::read(&studio.file());
    for sheet in &mut paper.sheets {
        for (x, y) in sheet.pixels_where(true) {
            let colour = there.converted(&[sheet.at(x, y)])[0];
            sheet.paint(x, y, colour);
        }
    }
    paper.icc = Some(adobe);
    // Red of the photo's space lies well within the other one.
    let stroke = there.converted(&[RED])[0];
    STROKE.iter().for_each(|&(x, y)| paper.sheet("wall").paint(x, y, stroke));
    paper.write(&studio.file());
    let report = studio.import();
    let paint = studio.paint();
    assert_eq!(paint.keys().collect::<Vec<_>>(), STROKE.iter().collect::<Vec<_>>(), "{report:#}");
    let expected = back.converted(&[stroke])[0];
    let near = |found: &Colour| (0..4).all(|i| found[i].abs_diff(expected[i]) <= 3 * 257);
    assert!(paint.values().all(near), "{paint:?} is not {expected:?}");
    assert!(report["files"][0]["notes"].to_string().contains("another profile"), "{report:#}");
}
