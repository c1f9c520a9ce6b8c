//! What every writer writes its reader reads, whatever the document.

use std::path::Path;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::layered_files::psd::PsdVariant;
use quadratura::testing::layered_files::{BlendMode, Depth, EditedDocument, read_layered};

use crate::documents::{Format, KEY, Plan, plans, xcf_of};

fn written_and_read(plan: &Plan, format: Format) -> EditedDocument {
    let folder = tempfile::tempdir().unwrap();
    // The name says nothing: files are known by their content.
    let file = folder.path().join("file.dat");
    plan.write(&file, format);
    let document = read_layered(&file).unwrap();
    // The pixels are read after the folder is gone: the file stays open.
    #[cfg(unix)]
    drop(folder);
    #[cfg(windows)]
    let _kept = folder.keep();
    document
}

fn assert_is(plan: &Plan, found: &EditedDocument) -> Result<(), TestCaseError> {
    prop_assert_eq!((found.width, found.height), plan.size);
    prop_assert_eq!(found.depth, plan.depth);
    prop_assert_eq!(found.key.as_deref(), Some(KEY));
    prop_assert_eq!(&found.notes, &Vec::<String>::new());
    prop_assert_eq!(found.layers.len(), plan.layers.len());
    for (index, (found, expected)) in found.layers.iter().zip(&plan.layers).enumerate() {
        prop_assert_eq!(&found.name, &expected.name(index));
        prop_assert_eq!(&found.groups, &expected.groups());
        prop_assert_eq!(found.rect, expected.rect);
        prop_assert_eq!((found.visible, found.locked), (expected.visible, expected.locked));
        prop_assert_eq!((found.opacity, &found.blend), (1.0, &BlendMode::Normal));
        prop_assert!(found.masks.is_empty() && !found.hidden_by_group);
        prop_assert_eq!(found.pixels.read().unwrap(), expected.pixels(plan.depth));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_psd_comes_back(plan in plans()) {
        let found = written_and_read(&plan, Format::Psd(PsdVariant::Psd));
        prop_assert_eq!((found.format, &found.icc), (ExportFormat::Psd, &plan.icc));
        assert_is(&plan, &found)?;
    }

    #[test]
    fn a_psb_comes_back(plan in plans()) {
        assert_is(&plan, &written_and_read(&plan, Format::Psd(PsdVariant::Psb)))?;
    }

    #[test]
    fn an_xcf_comes_back_with_the_tokens_of_its_layers(plan in plans(), wide in any::<bool>()) {
        let found = written_and_read(&plan, xcf_of(plan.depth, wide));
        prop_assert_eq!((found.format, &found.icc), (ExportFormat::Xcf, &plan.icc));
        for (index, (found, expected)) in found.layers.iter().zip(&plan.layers).enumerate() {
            prop_assert_eq!(found.id.clone(), Some(expected.id(index)));
        }
        assert_is(&plan, &found)?;
    }

    #[test]
    fn an_openraster_file_comes_back(plan in plans()) {
        let found = written_and_read(&plan, Format::Ora);
        prop_assert_eq!((found.format, &found.icc), (ExportFormat::Ora, &plan.icc));
        assert_is(&plan, &found)?;
    }
}

#[test]
fn the_same_document_gives_the_same_xcf_whatever_the_number_of_threads() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let plan = plans().new_tree(&mut runner).unwrap().current();
    let format = xcf_of(plan.depth, false);
    let here = plan.bytes(format);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| plan.bytes(format)), here);
}

/// As Krita's own files are.
fn archive_without_a_stack() -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    archive.start_file("mimetype", zip::write::SimpleFileOptions::default()).unwrap();
    archive.finish().unwrap().into_inner()
}

#[test]
fn a_file_that_is_no_layered_image_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for (content, expected) in [
        (&b""[..], "empty"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"\xff\xd8\xff\xe0", "JPEG"),
        (b"II*\0", "TIFF"),
        (b"hello", "hello"),
        (&archive_without_a_stack(), "not an OpenRaster"),
    ] {
        let file = folder.path().join("file.psd");
        std::fs::write(&file, content).unwrap();
        let error = read_layered(&file).unwrap_err().to_string();
        assert!(error.contains("file.psd") && error.contains(expected), "{error}");
    }
    assert!(read_layered(Path::new("no/such/file")).is_err());
}

#[test]
fn a_file_cut_short_anywhere_is_an_error_or_lacks_pixels_and_never_more() {
    let layer = crate::documents::LayerPlan {
        group: Some(0),
        rect: quadratura::testing::geometry::PixelRect { x: 3, y: 4, w: 20, h: 10 },
        visible: true,
        locked: false,
        seed: 1,
    };
    let plan = Plan { size: (30, 20), depth: Depth::Eight, icc: None, layers: vec![layer] };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cut");
    for format in
        [Format::Psd(PsdVariant::Psd), xcf_of(Depth::Eight, false), xcf_of(Depth::Eight, true), Format::Ora]
    {
        let whole = plan.bytes(format);
        for length in 0..whole.len() {
            std::fs::write(&file, &whole[..length]).unwrap();
            let Ok(document) = read_layered(&file) else { continue };
            for layer in &document.layers {
                if let Ok(pixels) = layer.pixels.read() {
                    assert_eq!(pixels, plan.layers[0].pixels(Depth::Eight), "{format:?} cut at {length}");
                }
            }
        }
    }
}
