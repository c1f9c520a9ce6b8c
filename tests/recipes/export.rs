//! Out to the image editor and read back: every pixel, every name, and nobody's work overwritten.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::invented;
use crate::invented::Plan;
use quadratura::task::Task;
use quadratura::testing::document::decisions::LayerNaming;
use quadratura::testing::document::export_record::{ExportFormat, HelperRole};
use quadratura::testing::document::{Decisions, Stack};
use quadratura::testing::editing::export::{ExportOptions, ExportReport, Exported, StackContent, export};
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::import::photo::read_photo;
use quadratura::testing::io::exports::ExportStore;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layered_files::{Depth, EditedLayer, Raster, composite, read_layered};
use quadratura::testing::layers::Faces;
use quadratura::testing::scene::{Photo, Samples};

struct Project {
    folder: tempfile::TempDir,
    photo: Photo,
    stack: Stack,
}

fn project(plan: &Plan) -> Project {
    let folder = tempfile::tempdir().unwrap();
    let (photo, stack) = invented::write(folder.path(), plan);
    Project { folder, photo, stack }
}

impl Project {
    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn export_as(&self, options: &ExportOptions) -> Exported {
        export(self.folder.path(), &[&self.photo], &self.out(), options, &Task::silent()).unwrap()
    }

    fn export(&self) -> ExportReport {
        let mut exported = self.export_as(&ExportOptions::default());
        assert!(exported.failed.is_empty(), "{:?}", exported.failed);
        exported.done.remove(0)
    }

    fn raster(&self) -> Raster {
        let (w, h) = (self.photo.camera.width, self.photo.camera.height);
        Raster::of_photo(read_photo(&self.photo.file, w, h).unwrap())
    }
}

/// Of each pixel of the photo, whether an image layer needs it.
fn covered(project: &Project) -> Vec<bool> {
    let photo = project.raster();
    let mut covered = vec![false; (photo.width() * photo.height()) as usize];
    let folder = StackStore::new(project.folder.path()).folder(&project.photo.name);
    for layer in &project.stack.image_layers {
        let file = folder.join(&layer.needed_file);
        let mask = quadratura::testing::layered_files::png::read_mask(&file, layer.rect).unwrap();
        let whole = PixelRect::of_size(photo.width(), photo.height());
        for (covered, (x, y)) in covered.iter_mut().zip(whole.pixels()) {
            *covered |= mask.holds(x, y);
        }
    }
    covered
}

/// The stacking proof: all image layers over nothing are the photo wherever the model is.
fn assert_stack_is_photo(plan: &Plan) {
    let project = project(plan);
    let photo = Arc::new(project.raster());
    let folder = StackStore::new(project.folder.path()).folder(&project.photo.name);
    let task = Task::silent();
    let content = StackContent::new(&project.stack, folder, photo.clone(), None, &task);
    let document = content.document("key");
    let stacked = composite(&document, |layer| layer.name.ends_with(']')).unwrap();
    let covered = covered(&project);
    assert!(covered.iter().any(|c| *c) && !covered.iter().all(|c| *c));
    for (index, covered) in covered.into_iter().enumerate() {
        let (x, y) = (index as u32 % plan.width, index as u32 / plan.width);
        let expected = if covered && photo.has_colour(x, y) { pixel(&photo, index) } else { [0; 4] };
        assert_eq!(pixel(&stacked, index), expected, "at {x}, {y}");
    }
}

fn pixel(raster: &Raster, index: usize) -> [u16; 4] {
    let at = 4 * index;
    match raster.samples() {
        Samples::U8(s) => [0, 1, 2, 3].map(|i| s[at + i].into()),
        Samples::U16(s) => [0, 1, 2, 3].map(|i| s[at + i]),
    }
}

#[test]
fn all_image_layers_over_nothing_are_the_photo_wherever_the_model_is() {
    for seed in 1..4 {
        assert_stack_is_photo(&Plan { seed, ..Plan::default() });
    }
}

#[test]
fn a_16_bit_photo_with_an_invalid_edge_is_given_back_where_it_is_valid() {
    assert_stack_is_photo(&Plan { depth: Depth::Sixteen, invalid: 40, ..Plan::default() });
}

fn read(file: &Path) -> ag_psd::psd::Psd {
    let options =
        ag_psd::psd::ReadOptions { use_image_data: Some(true), ..ag_psd::psd::ReadOptions::default() };
    ag_psd::reader::read_psd(&fs::read(file).unwrap(), &options).unwrap()
}

#[test]
fn a_psd_has_a_group_per_order_with_the_nearest_on_top_and_the_photo_at_the_bottom() {
    let project = project(&Plan::default());
    let report = project.export();
    assert_eq!(report.path, project.out().join("nord%2Ft%C3%BCr%201.png.psd"));
    assert_eq!((report.layers, report.groups), (9, 4));
    let psd = read(&report.path);
    let name = |layer: &ag_psd::psd::Layer| layer.additional_info.name.clone().unwrap();
    let nodes = psd.children.unwrap();
    let names: Vec<_> = nodes.iter().map(name).collect();
    let photo = "photo - reference, do not paint here";
    assert_eq!(names, [photo, "order 3 - farthest", "order 2", "order 1", "order 0 - nearest"]);
    for (node, order) in nodes[1..].iter().zip([3, 2, 1, 0]) {
        let found: Vec<_> = node.children.as_ref().unwrap().iter().map(name).collect();
        let layers = project.stack.image_layers.iter().rev().filter(|layer| layer.order == order);
        let tokens: Vec<_> = layers.map(|layer| format!("[{}]", layer.id)).collect();
        assert!(found.iter().zip(&tokens).all(|(name, token)| name.ends_with(token)), "{found:?}");
        assert!(found.len() == tokens.len() || found.last().unwrap().starts_with("guide"), "{found:?}");
    }
}

#[test]
fn layers_are_cropped_to_what_is_needed_and_eight_pixels_inside_their_rectangle() {
    let project = project(&Plan::default());
    project.export();
    let (records, _) = ExportStore::new(project.folder.path().join("exports")).read_all().unwrap();
    for (exported, layer) in records[0].layers.iter().zip(&project.stack.image_layers) {
        assert_eq!(exported.exported_rect, layer.needed_rect.grown(8).intersection(&layer.rect));
    }
}

#[test]
fn the_record_says_whose_pixels_lie_where() {
    let project = project(&Plan::default());
    let report = project.export();
    let (records, problems) = ExportStore::new(project.folder.path().join("exports")).read_all().unwrap();
    assert!(problems.is_empty());
    let record = &records[0];
    assert_eq!((&record.key, record.format, record.depth), (&report.key, ExportFormat::Psd, 8));
    assert_eq!(record.layers.len(), 9);
    assert_eq!(record.layers[3].elements[0].object, "object 3");
    assert_eq!(record.helpers.last().unwrap().role, HelperRole::Reference);
    let psd = read(&report.path);
    let xmp = psd.image_resources.unwrap().xmp_metadata.unwrap();
    assert!(xmp.contains(&format!("<dc:identifier>{}</dc:identifier>", record.key)));
}

#[test]
fn the_same_export_again_gives_the_same_bytes_in_the_same_place() {
    let project = project(&Plan::default());
    let first = project.export();
    let bytes = fs::read(&first.path).unwrap();
    let again = project.export();
    assert_eq!(again, first);
    assert_eq!(fs::read(&again.path).unwrap(), bytes);
}

#[test]
fn a_file_that_was_painted_on_stays_and_the_export_goes_beside_it() {
    let project = project(&Plan::default());
    let first = project.export().path;
    fs::write(&first, "painted").unwrap();
    let second = project.export();
    assert_eq!(second.path, project.out().join("nord%2Ft%C3%BCr%201.png-2.psd"));
    assert_eq!(second.spared, std::slice::from_ref(&first));
    assert_eq!(fs::read(&first).unwrap(), b"painted");
    assert_eq!(project.export().path, second.path, "the second is ours and may be replaced");
}

#[test]
fn a_photo_without_a_stack_fails_alone() {
    let project = project(&Plan::default());
    let foreign = Photo { name: "stranger.png".into(), ..project.photo.clone() };
    let photos = [&foreign, &project.photo];
    let exported =
        export(project.folder.path(), &photos, &project.out(), &ExportOptions::default(), &Task::silent())
            .unwrap();
    assert_eq!(exported.done.len(), 1);
    assert_eq!(exported.failed[0].0, "stranger.png");
    let problem = exported.failed[0].1.to_string();
    assert!(problem.contains("run “build” first"), "{problem}");
}

#[test]
fn a_damaged_layer_fails_the_export_and_leaves_nothing_behind() {
    let project = project(&Plan::default());
    let folder = StackStore::new(project.folder.path()).folder(&project.photo.name);
    fs::write(folder.join(&project.stack.image_layers[2].file), "no picture").unwrap();
    let exported = project.export_as(&ExportOptions::default());
    assert!(exported.failed[0].1.to_string().contains("2.png"));
    assert_eq!(fs::read_dir(project.out()).unwrap().count(), 0);
}

#[test]
fn a_stop_stops() {
    let project = project(&Plan::default());
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let options = ExportOptions::default();
    assert!(export(project.folder.path(), &[&project.photo], &project.out(), &options, &task).is_err());
    assert_eq!(fs::read_dir(project.out()).unwrap().count(), 0);
}

#[test]
fn a_folder_holds_whole_layers_and_a_stack_that_is_true_of_them() {
    let project = project(&Plan::default());
    let options = ExportOptions { format: ExportFormat::Folder, ..ExportOptions::default() };
    let report = project.export_as(&options).done.remove(0);
    assert_eq!(report.path, project.out().join("nord%2Ft%C3%BCr%201.png.layers"));
    let stack: Stack = serde_json::from_slice(&fs::read(report.path.join("stack.json")).unwrap()).unwrap();
    let folder = StackStore::new(project.folder.path()).folder(&project.photo.name);
    for (exported, layer) in stack.image_layers.iter().zip(&project.stack.image_layers) {
        let (w, h) = (layer.rect.w, layer.rect.h);
        let read = |file: PathBuf| quadratura::testing::layered_files::png::read_rgba(&file, w, h).unwrap();
        assert_eq!(read(report.path.join(&exported.file)), read(folder.join(&layer.file)));
        assert!(report.path.join(&exported.needed_file).is_file());
    }
    assert_eq!(fs::read(report.path.join("photo.png")).unwrap(), fs::read(&project.photo.file).unwrap());
    assert_eq!(fs::read_to_string(report.path.join("quadratura-key.txt")).unwrap(), report.key);

    assert_eq!(project.export_as(&options).done[0].path, report.path, "ours and unchanged");
    fs::write(report.path.join(&stack.image_layers[0].file), "painted").unwrap();
    let beside = project.export_as(&options).done.remove(0);
    assert_eq!(beside.path, project.out().join("nord%2Ft%C3%BCr%201.png-2.layers"));
}

#[test]
fn an_openraster_file_lists_every_layer_with_its_place_and_its_pixels() {
    let project = project(&Plan { depth: Depth::Sixteen, ..Plan::default() });
    let plain = ExportOptions { format: ExportFormat::Ora, ..ExportOptions::default() };
    project.export_as(&plain);
    let records = || ExportStore::new(project.folder.path().join("exports")).read_all().unwrap().0;
    let selected = records()[0].layers.last().map(|layer| layer.id.clone());
    let options = ExportOptions { format: ExportFormat::Ora, selected, ..ExportOptions::default() };
    let report = project.export_as(&options).done.remove(0);
    let bytes = fs::read(&report.path).unwrap();
    assert_eq!(&bytes[30..54], b"mimetypeimage/openraster", "first, and not compressed");
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let mut member = |name: &str| {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name(name).unwrap(), &mut bytes).unwrap();
        bytes
    };
    let xml = String::from_utf8(member("stack.xml")).unwrap();
    let xml = roxmltree::Document::parse(&xml).unwrap();
    for layer in &records()[0].layers {
        let found = xml.descendants().find(|node| node.attribute("name") == Some(&layer.name)).unwrap();
        let number = |name: &str| found.attribute(name).unwrap().parse::<i32>().unwrap();
        assert_eq!((number("x"), number("y")), (layer.exported_rect.x, layer.exported_rect.y));
        let file = project.folder.path().join("layer.png");
        fs::write(&file, member(found.attribute("src").unwrap())).unwrap();
        let is_selected = found.attribute("selected") == Some("true");
        assert_eq!(is_selected, options.selected.as_ref() == Some(&layer.id), "{}", layer.name);
        let rect = layer.exported_rect;
        let pixels = quadratura::testing::layered_files::png::read_rgba(&file, rect.w, rect.h).unwrap();
        assert_eq!(pixels.hash_at(rect.x, rect.y), layer.pixels, "{}", layer.name);
    }
    assert_eq!(member("quadratura-key.txt"), report.key.as_bytes());
    assert!(!member("mergedimage.png").is_empty() && !member("Thumbnails/thumbnail.png").is_empty());
    let again = project.export_as(&options).done.remove(0);
    assert_eq!(fs::read(again.path).unwrap(), bytes);
}

#[test]
fn even_colour_is_for_looking_at_and_leaves_the_plain_export_as_it_was() {
    let project = project(&Plan::default());
    let plain = project.export();
    let before = fs::read(&plain.path).unwrap();
    let evened = [(project.photo.name.clone(), [2.0, 1.0, 0.5])].into();
    let options = ExportOptions { format: ExportFormat::Ora, evened, ..ExportOptions::default() };
    let even = project.export_as(&options).done.remove(0);
    assert_ne!(even.key, plain.key);

    let records = ExportStore::new(project.folder.path().join("exports")).read_all().unwrap().0;
    let record = records.iter().find(|record| record.key == even.key).unwrap();
    assert_eq!(record.evened, Some([2.0, 1.0, 0.5]));
    assert!(record.layers.is_empty() && record.pieces.is_empty() && record.helpers.len() > 1);

    let document = read_layered(&even.path).unwrap();
    let token = |layer: &EditedLayer| project.stack.image_layers.iter().any(|l| layer.name.contains(&l.id));
    assert!(!document.layers.iter().any(|layer| token(layer) || layer.id.is_some()), "cannot be imported");
    let photo = document.layers.iter().find(|layer| layer.name.starts_with("photo")).unwrap();
    let mut expected = project.raster();
    expected.multiply_light([2.0, 1.0, 0.5]);
    assert_eq!(photo.pixels.read().unwrap(), expected);
    assert_ne!(expected, project.raster());

    let folder = ExportOptions { format: ExportFormat::Folder, ..options };
    let message = export(project.folder.path(), &[&project.photo], &project.out(), &folder, &Task::silent());
    assert!(message.unwrap_err().to_string().contains("psd, xcf or ora"));
    assert_eq!(fs::read(&project.export().path).unwrap(), before);
}

#[test]
fn a_layer_is_exported_by_the_name_that_was_decided_whatever_it_was_called_when_it_was_built() {
    let project = project(&Plan::default());
    let own = ExportOptions { decisions: Some(Decisions::default()), ..ExportOptions::default() };
    let plain = project.export_as(&own).done.remove(0);
    let layer = &project.stack.image_layers[0];
    let elements: Vec<_> = project.stack.visibility_layers.iter().flatten().collect();
    let held = layer.elements.iter().map(|element| elements[element.index()]);
    let of =
        held.map(|element| Faces { object: element.object.clone(), faces: element.all_faces() }).collect();
    let mut decisions = Decisions::default();
    let named = decisions.photos.entry(project.photo.name.clone()).or_default();
    named.names.push(LayerNaming { name: "the palazzo".into(), of });
    let options = ExportOptions { decisions: Some(decisions), ..ExportOptions::default() };
    let report = project.export_as(&options).done.remove(0);
    assert_ne!(report.key, plain.key, "it is another document");
    let document = read_layered(&report.path).unwrap();
    let expected = format!("the palazzo [{}]", layer.id);
    assert!(document.layers.iter().any(|layer| layer.name == expected), "{expected}");
    // Taken back, it has its own name again.
    assert_eq!(project.export_as(&own).done[0].key, plain.key);
}
