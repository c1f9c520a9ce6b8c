//! Measures how long it takes from a save in an image editor until other photos show the paint.
//!
//! `save_to_view PROJECT PHOTO LAYER X Y FROM [SAVES]` exports PHOTO of a project whose photos are filled, paints a
//! stroke of 160 x 120 pixels on the image layer whose name contains LAYER, the first one at X, Y (photo pixels), saves,
//! and does what the window does: import, the coarse picture from the side of the photo FROM, the other photos, and
//! their files. It repeats this (10 times) with another stroke each and prints seconds in percentiles. It fails where a
//! stroke does not show. Paint stays in the project: use a copy.
//!
//! On Linux it prints processor seconds, too (of all threads together): on an idle machine a stage takes no longer than
//! that, except for waiting, of which there is 0.1 s before the import; on a busy one they are what counts.

use std::error::Error;
use std::fs::{self, File};
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use image::{ImageFormat, Rgba, RgbaImage};
use quadratura::task::Task;
use quadratura::testing::document::Stack;
use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::editing::editing::{document_to_edit, folder as editing_folder};
use quadratura::testing::editing::export::ExportOptions;
use quadratura::testing::editing::import::Imported;
use quadratura::testing::editing::watch::{WatchOptions, watch};
use quadratura::testing::geometry::Pinhole;
use quadratura::testing::gpu::Gpu;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::projection::Renders;
use quadratura::testing::sites::open::{Opened, open};
use quadratura::testing::stacks::fill::projected::{PaintProjection, nearest_first};
use quadratura::testing::stacks::fill::{FillRequest, fill};
use quadratura::testing::view::{Picture, Shot};
use quadratura::testing::views::preview::{self, Preview, PreviewOptions};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The size of a stroke in pixels: 19,200 in all.
const STROKE: [u32; 2] = [160, 120];

/// The stages, in the order in which they end.
const STAGES: [&str; 7] = [
    "file closed -> imported",
    "its own photo",
    "projected to the 4 nearest photos",
    "first picture",
    "all photos",
    "files of the other photos",
    "picture of the files",
];

/// The seconds and processor seconds since a save, at the end of each stage.
struct Clock {
    closed: Instant,
    processor: f64,
    times: Vec<[f64; 2]>,
}

impl Clock {
    fn start() -> Self {
        Self { closed: Instant::now(), processor: processor_seconds(), times: Vec::new() }
    }

    fn stage_over(&mut self) {
        self.times.push([self.closed.elapsed().as_secs_f64(), processor_seconds() - self.processor]);
    }
}

/// The processor time of all threads of this process in seconds; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in brackets, may contain spaces; clock ticks are hundredths of a second.
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [project, photo, layer, x, y, from, rest @ ..] = &arguments[..] else {
        return Err("usage: save_to_view PROJECT PHOTO LAYER X Y FROM [SAVES]".into());
    };
    let saves: u32 = rest.first().map_or(Ok(10), |count| count.parse())?;
    let project = Path::new(project);
    let opened = open(project, &Task::silent())?;
    let site = Arc::new(opened.site.clone());
    let painted = site.photos.iter().find(|it| it.name == *photo).ok_or("there is no such photo")?;
    let options = ExportOptions { format: ExportFormat::Ora, ..ExportOptions::default() };
    let document = document_to_edit(project, painted, &options, true, &Task::silent())?.file;
    let at = [x.parse()?, y.parse()?];
    let versions = versions(&document, layer, at, saves)?;

    let gpu = Gpu::headless()?;
    let mut preview = preview::open(
        project,
        &opened.project,
        &opened.site,
        &gpu,
        &PreviewOptions::default(),
        &Task::silent(),
    )?;
    let viewer = site.photos.iter().find(|it| it.name == *from).ok_or("there is no photo to look from")?;
    let shot = Shot::new(smaller(&viewer.camera), viewer.pose);
    let mut before = preview.picture(&shot, &Task::silent())?;
    save_picture(&before, "save_to_view_before.png")?;

    let (send, receive) = channel();
    let (folder, watched) = (editing_folder(project), project.to_owned());
    let task = Task::silent();
    let stop = task.stop_flag();
    let watching = std::thread::spawn(move || {
        let report = |imported: Imported, _: Duration| drop(send.send(imported));
        watch(&watched, &folder, WatchOptions::default(), || Ok(()), &task, report)
    });
    std::thread::sleep(Duration::from_secs(1));
    let mut all: Vec<Vec<[f64; 2]>> = vec![Vec::new(); STAGES.len()];
    for (number, version) in versions.iter().enumerate() {
        let mut clock = Clock::start();
        fs::rename(version, &document)?;
        let imported = receive.recv_timeout(Duration::from_secs(60))?;
        clock.stage_over();
        let pixels = imported.changed;
        let shown = show(project, &opened, &mut preview, &shot, photo, &imported, &mut clock)?;
        let times = clock.times;
        let changed = differing(&before, &shown[0]);
        println!("save {}: {pixels} pixels, {changed} of the picture change, {times:.2?}", number + 1);
        if changed < 100 {
            return Err("the stroke does not show from the other photo's side".into());
        }
        if number == 0 {
            save_picture(&shown[0], "save_to_view_first.png")?;
            save_picture(&shown[1], "save_to_view_filed.png")?;
        }
        before = shown[1].clone();
        all.iter_mut().zip(times).for_each(|(all, time)| all.push(time));
    }
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    watching.join().map_err(|_| "the watch failed")??;
    for (which, unit) in ["seconds", "processor seconds"].iter().enumerate() {
        println!("\n{:<45}{:>8}{:>8}{:>8}", format!("{unit} from the file's close"), "50 %", "90 %", "most");
        for (stage, times) in STAGES.iter().zip(&all) {
            let mut times: Vec<f64> = times.iter().map(|time| time[which]).collect();
            times.sort_by(f64::total_cmp);
            let percentile = |share: f64| times[((times.len() as f64 * share).ceil() as usize).max(1) - 1];
            let [half, nine, most] = [0.5, 0.9, 1.0].map(percentile);
            println!("{stage:<45}{half:>8.2}{nine:>8.2}{most:>8.2}");
        }
    }
    Ok(())
}

/// Does what the window does after an import; returns the first picture and that of the files, and adds when each stage
/// was over.
fn show(
    project: &Path,
    opened: &Opened,
    preview: &mut Preview,
    shot: &Shot,
    photo: &str,
    imported: &Imported,
    clock: &mut Clock,
) -> Outcome<[Picture; 2]> {
    let task = Task::silent();
    let mut over = || clock.stage_over();
    preview.reload_paint(&[photo.to_owned()], &imported.book, &task)?;
    over();
    let stacks = stacks(project, opened)?;
    let viewpoint = shot.viewpoint();
    let ahead = shot.pose.rotation.transpose() * glam::DVec3::Z;
    let photos = nearest_first(&opened.site, viewpoint, viewpoint + ahead);
    let projection = PaintProjection::new(project, &opened.project, &opened.site, &stacks, &task)?;
    let (first, later) = photos.split_at(4.min(photos.len()));
    preview.show_projected(first, projection.project(&imported.book, first, &task)?, &task)?;
    over();
    let picture = preview.picture(shot, &task)?;
    over();
    preview.show_projected(later, projection.project(&imported.book, later, &task)?, &task)?;
    preview.picture(shot, &task)?;
    over();
    let request =
        FillRequest { options: opened.project.fill.clone(), keep_former: true, ..FillRequest::default() };
    for filled in fill(project, &opened.project, &opened.site, &request, &task)? {
        filled.stack?;
    }
    over();
    preview.refill(&self::stacks(project, opened)?, &task)?;
    let filed = preview.picture(shot, &task)?;
    over();
    StackStore::new(project).clear_former()?;
    Ok([picture, filed])
}

fn stacks(project: &Path, opened: &Opened) -> Outcome<Vec<Option<Arc<Stack>>>> {
    let store = StackStore::new(project);
    let stack = |photo: &quadratura::testing::scene::Photo| Ok(store.current(&photo.name)?.map(Arc::new));
    opened.site.photos.iter().map(stack).collect()
}

/// Writes the document with one more stroke for each save, beside it.
fn versions(document: &Path, layer: &str, [x, y]: [i64; 2], saves: u32) -> Outcome<Vec<PathBuf>> {
    let mut archive = ZipArchive::new(File::open(document)?)?;
    let mut text = String::new();
    archive.by_name("stack.xml")?.read_to_string(&mut text)?;
    let tag = text.split('<').find(|tag| tag.starts_with("layer ") && tag.contains(layer));
    let tag = tag.ok_or("there is no such layer")?;
    let value = |name: &str| {
        let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let source = value("src").ok_or("the layer has no picture")?;
    let corner = ["x", "y"].map(|name| value(name).and_then(|at| at.parse::<i64>().ok()).unwrap_or(0));
    let mut bytes = Vec::new();
    archive.by_name(&source)?.read_to_end(&mut bytes)?;
    let mut picture: RgbaImage = image::load_from_memory_with_format(&bytes, ImageFormat::Png)?.to_rgba8();
    let folder = document.parent().and_then(Path::parent).ok_or("the document has no folder")?;
    (0..saves)
        .map(|number| {
            let hue =
                [[255, 0, 0], [0, 200, 0], [0, 0, 255], [255, 200, 0], [200, 0, 255]][number as usize % 5];
            let shift = [i64::from(number % 5) * 40, i64::from(number / 5) * 130];
            for (dx, dy) in (0..STROKE[1]).flat_map(|dy| (0..STROKE[0]).map(move |dx| (dx, dy))) {
                let at = [x + shift[0] + i64::from(dx) - corner[0], y + shift[1] + i64::from(dy) - corner[1]];
                let pixel = picture.get_pixel_mut_checked(at[0].try_into()?, at[1].try_into()?);
                *pixel.ok_or("the stroke is not on the layer")? = Rgba([hue[0], hue[1], hue[2], 255]);
            }
            let mut encoded = Cursor::new(Vec::new());
            picture.write_to(&mut encoded, ImageFormat::Png)?;
            let target = folder.join(format!("save_to_view-{number}.tmp"));
            let mut writer = ZipWriter::new(File::create(&target)?);
            for index in 0..archive.len() {
                let entry = archive.by_index_raw(index)?;
                if entry.name()? != source {
                    writer.raw_copy_file(entry)?;
                    continue;
                }
                drop(entry);
                let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
                writer.start_file(&source, stored)?;
                writer.write_all(encoded.get_ref())?;
            }
            writer.finish()?;
            Ok(target)
        })
        .collect()
}

/// A camera with pictures of a third of the size, as large as a view in a window.
fn smaller(camera: &Pinhole) -> Pinhole {
    let Pinhole { width, height, fx, fy, cx, cy } = *camera;
    Pinhole { width: width / 3, height: height / 3, fx: fx / 3.0, fy: fy / 3.0, cx: cx / 3.0, cy: cy / 3.0 }
}

/// Counts the pixels that clearly differ.
fn differing(a: &Picture, b: &Picture) -> usize {
    let pixels = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    pixels.filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 40)).count()
}

fn save_picture(picture: &Picture, name: &str) -> Outcome<()> {
    let target = std::env::temp_dir().join(name);
    image::save_buffer(&target, &picture.rgba, picture.width, picture.height, image::ColorType::Rgba8)?;
    eprintln!("{}", target.display());
    Ok(())
}
