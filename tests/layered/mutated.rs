//! Damaged files are errors: no panic, no memory beyond measure, and a message that names the file.

use std::path::Path;

use proptest::prelude::*;
use quadratura::testing::layered_files::folder::NewFolder;
use quadratura::testing::layered_files::psd::PsdVariant;
use quadratura::testing::layered_files::{Depth, KEY_FILE, read_layered};

use crate::documents::{Format, LayerPlan, Plan, xcf_of};
use crate::memory::peak_of;
use crate::{psd_variants, xcf_variants};

/// Bytes that reading one of these small files may take. Their code can stand for a thousandfold, pictures
/// in PNG for 32 MB each; a reader that believed a length would ask for gigabytes.
const MOST: usize = 400 << 20;

/// One kind of damage; places are shares of the file.
#[derive(Debug, Clone)]
enum Damage {
    Flip { at: f64, bit: u8 },
    Byte { at: f64, value: u8 },
    Number { at: f64, value: u32 },
    Cut { at: f64 },
    Repeat { at: f64, length: usize },
    Remove { at: f64, length: usize },
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    // Heads, where the lengths stand, more often than pixels.
    let at = || prop_oneof![0.0..1.0f64, 0.0..0.1f64];
    let extreme = prop_oneof![
        Just(0),
        Just(1),
        Just(0x7fff_ffff),
        Just(0x8000_0000),
        Just(u32::MAX),
        Just(0x00ff_ffff),
        0u32..5000,
        any::<u32>()
    ];
    let damage = prop_oneof![
        (at(), 0u8..8).prop_map(|(at, bit)| Damage::Flip { at, bit }),
        (at(), any::<u8>()).prop_map(|(at, value)| Damage::Byte { at, value }),
        (at(), extreme).prop_map(|(at, value)| Damage::Number { at, value }),
        at().prop_map(|at| Damage::Cut { at }),
        (at(), 1usize..300).prop_map(|(at, length)| Damage::Repeat { at, length }),
        (at(), 1usize..300).prop_map(|(at, length)| Damage::Remove { at, length }),
    ];
    proptest::collection::vec(damage, 1..5)
}

fn damaged(mut bytes: Vec<u8>, damages: &[Damage]) -> Vec<u8> {
    for damage in damages {
        let last = bytes.len().saturating_sub(1);
        let place = |at: f64| (at * last as f64) as usize;
        match *damage {
            _ if bytes.is_empty() => {}
            Damage::Flip { at, bit } => bytes[place(at)] ^= 1 << bit,
            Damage::Byte { at, value } => bytes[place(at)] = value,
            Damage::Number { at, value } => {
                let at = place(at);
                bytes[at..].iter_mut().zip(value.to_be_bytes()).for_each(|(to, from)| *to = from);
            }
            Damage::Cut { at } => bytes.truncate(place(at)),
            Damage::Repeat { at, length } => {
                let part = bytes[place(at)..(place(at) + length).min(last)].to_vec();
                let at = place(at);
                bytes.splice(at..at, part);
            }
            Damage::Remove { at, length } => drop(bytes.drain(place(at)..(place(at) + length).min(last))),
        }
    }
    bytes
}

fn plan(depth: Depth) -> Plan {
    let layer = |group, rect: [i64; 4], seed| LayerPlan {
        group,
        rect: rect.into(),
        visible: true,
        locked: seed % 2 == 0,
        seed,
    };
    let layers = vec![
        layer(None, [0, 0, 40, 30], 1),
        layer(Some(0), [-5, 3, 70, 66], 2),
        layer(Some(0), [9, 9, 5, 5], 3),
        layer(Some(1), [30, 20, 20, 10], 4),
    ];
    Plan { size: (40, 30), depth, icc: Some(vec![7; 200]), layers }
}

/// Reads all that is to be read of a file, and judges the errors.
fn read_all(path: &Path) {
    let judge = |error: quadratura::Error| {
        let text = error.to_string();
        assert!(text.contains("damaged"), "the file is not named: {text}");
    };
    let document = match read_layered(path) {
        Ok(document) => document,
        Err(error) => return judge(error),
    };
    for layer in &document.layers {
        match layer.pixels.read() {
            Ok(pixels) => {
                let size = (pixels.width(), pixels.height(), pixels.depth());
                assert_eq!(size, (layer.rect.w, layer.rect.h, document.depth));
            }
            Err(error) => judge(error),
        }
        let others = layer.masks.iter().filter_map(|mask| mask.lowest_with.as_ref());
        for (mask, pixels) in layer.masks.iter().chain(others).map(|mask| (mask, mask.pixels.read())) {
            match pixels {
                Ok(pixels) => {
                    let size = (pixels.width(), pixels.height(), pixels.depth());
                    assert_eq!(size, (mask.rect.w, mask.rect.h, document.depth));
                }
                Err(error) => judge(error),
            }
        }
    }
}

fn assert_survives(whole: &[u8], damages: &[Damage]) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("damaged");
    let bytes = damaged(whole.to_vec(), damages);
    std::fs::write(&file, &bytes).unwrap();
    let peak = peak_of(|| read_all(&file));
    prop_assert!(peak < MOST, "{} bytes of a file took {peak}", bytes.len());
    Ok(())
}

/// The number of mutations of each file: `usual`, or as many as the variable `MUTATIONS` says.
fn cases(usual: u32) -> u32 {
    std::env::var("MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// A test on each of these files.
macro_rules! survives {
    ($($name:ident: $whole:expr;)*) => {
        proptest! {
            #![proptest_config(ProptestConfig::with_cases(cases(300)))]
            $(
                #[test]
                fn $name(damages in damages()) {
                    static WHOLE: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| $whole);
                    assert_survives(&WHOLE, &damages)?;
                }
            )*
        }
    };
}

survives! {
    a_damaged_psd_of_8_bits: plan(Depth::Eight).bytes(Format::Psd(PsdVariant::Psd));
    a_damaged_psd_of_16_bits: plan(Depth::Sixteen).bytes(Format::Psd(PsdVariant::Psd));
    a_damaged_psb: plan(Depth::Eight).bytes(Format::Psd(PsdVariant::Psb));
    a_damaged_psd_with_everything_that_is_not_written_here: psd_variants::everything().bytes();
    a_damaged_xcf_of_version_3: plan(Depth::Eight).bytes(xcf_of(Depth::Eight, false));
    a_damaged_xcf_of_version_11: plan(Depth::Eight).bytes(xcf_of(Depth::Eight, true));
    a_damaged_xcf_of_16_bits: plan(Depth::Sixteen).bytes(xcf_of(Depth::Sixteen, true));
    a_damaged_xcf_with_everything_that_is_not_written_here: xcf_variants::everything().bytes();
    a_damaged_openraster_file: plan(Depth::Eight).bytes(Format::Ora);
}

const STACK: &str = r#"{"photo": {"width": 40, "height": 30}, "image_layers": [
    {"id": "a", "rect": [0, 0, 40, 30], "file": "order-00 x [a].png"}]}"#;

fn folder(around: &Path, stack: &[u8], png: &[u8]) -> std::path::PathBuf {
    let target = around.join("damaged");
    let mut folder = NewFolder::create(&target).unwrap();
    folder.add("stack.json", stack).unwrap();
    folder.add("order-00 x [a].png", png).unwrap();
    folder.add(KEY_FILE, b"key").unwrap();
    folder.commit().unwrap();
    target
}

fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let raster = plan(Depth::Eight).layers[0].pixels(Depth::Eight);
    quadratura::testing::layered_files::png::write_rgba(&mut bytes, &raster, Some(&[7; 200])).unwrap();
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(100)))]

    #[test]
    fn a_damaged_folder(damages in damages(), in_png in any::<bool>()) {
        let around = tempfile::tempdir().unwrap();
        let (mut stack, mut png) = (STACK.as_bytes().to_vec(), png());
        let harmed = if in_png { &mut png } else { &mut stack };
        *harmed = damaged(harmed.clone(), &damages);
        let target = folder(around.path(), &stack, &png);
        let peak = peak_of(|| read_all(&target));
        prop_assert!(peak < MOST, "it took {peak} bytes");
    }
}
