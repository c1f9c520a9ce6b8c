//! The command `render`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::AsArg;
use super::fill::note_stale;
use super::table::{Table, counted};
use super::view_args::{Background, RenderArgs, ShowArg, size};
use super::words::{error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_editing::exploded::exploded;
use quadratura_files::writable::check_file;
use quadratura_gpu::Gpu;
use quadratura_images::viewer::Viewer;
use quadratura_io::camera_path::write_camera_path;
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::sky_model::{Daylight, SkyKind};
use quadratura_ldi::Shown;
use quadratura_projection::Renders;
use quadratura_sites::open::open;
use quadratura_sites::views::{RequestedView, RequestedViews, Size, ViewRequest};
use quadratura_stacks::fill::stale_among;
use quadratura_view::legend::{ColourRamp, Legend, UNCOVERED, UNCOVERED_NAME, colour_at, legend};
use quadratura_view::{DisplayMode, Exposure};
use quadratura_views::colour::{colour_report, usual_exposure};
use quadratura_views::preview::{self, PreviewOptions};
use quadratura_views::render::{RenderOptions, RenderReport, RenderedView, VideoOptions, render};
use quadratura_views::written_exposure::written_exposures;

/// Maximum number of pictures in the table; `--json` has all.
const MOST_ROWS: usize = 40;
/// The frame rate of videos where nothing else is said, in frames per second.
pub const USUAL_FPS: f64 = 25.0;
/// The default size of exploded views in pixels.
const EXPLODED: (u32, u32) = (1800, 920);

/// Runs `render`: renders views of the site to pictures or a video.
pub fn run(args: &RenderArgs, task: &Task) -> Result<Outcome> {
    // What cannot be written is reported before the work, not after it.
    args.pictures.check_places()?;
    args.write_path.as_deref().map(check_file).transpose()?;
    if args.show == ShowArg::Exploded && !args.look.without.is_empty() {
        let found = "--show exploded shows the layers of each photo by itself; give the photos with --cameras, and no --without";
        return Err(Error::Request(found.into()));
    }
    let content = content_of(args)?;
    check_format(args, content)?;
    let opened = open(&args.project, task)?;
    // Stacks that change meanwhile stay readable as they were.
    let _reader = StackReader::begin(&args.project);
    let usual =
        if content == PictureContent::Exploded { Size::Exactly(EXPLODED.0, EXPLODED.1) } else { Size::Own };
    let size = size(args.pictures.size, args.pictures.scale).unwrap_or(usual);
    let asked = ViewRequest { source: args.source(), size, fps: args.pictures.fps };
    let mut views =
        if args.in_frame { opened.views_in_frame(&asked, task)? } else { opened.views(&asked, task)? };
    if let Some(frames) = args.frames {
        views.list = views.list.drain(frames.range(views.list.len())?).collect();
    }
    if content == PictureContent::Exploded && views.list.iter().any(|view| view.photo.is_none()) {
        let found = "--show exploded shows the layers of photos, not of other views; give --cameras photos, or a text \
                     file with names of photos";
        return Err(Error::Request(found.into()));
    }
    write_path(args, &views, &opened.project)?;
    let legend = legend_of(args, content, &opened.project, &opened.site, task)?;
    let film = film(args, &views);
    let drawn = legend.clone().filter(|_| args.legend);
    let out = args.pictures.out.clone();
    let (format, grey) = (args.format, legend.is_some());
    let options = RenderOptions { out, format, film, legend: drawn, grey, ..RenderOptions::default() };
    let DrawnShots { report, problems: of_layers, continued } = match content {
        PictureContent::Exploded => {
            let report = draw_exploded(args, &opened.site, &views, &options, task)?;
            DrawnShots { report, ..DrawnShots::default() }
        }
        content => draw_shots(args, content, &opened.project, &opened.site, &views, &options, task)?,
    };
    let mut problems: Vec<_> = opened.problems.errors.iter().chain(&views.problems).map(error_text).collect();
    problems.extend(report.failed.iter().map(|(view, error)| format!("{view}: {}", error_text(error))));
    problems.extend(of_layers);
    let mut outcome = outcome(args, &report, views.path.is_some(), problems);
    outcome.tell_continued(&continued);
    // Without a picture there is nothing to explain.
    if let Some(legend) = legend.as_ref().filter(|_| !report.done.is_empty() || report.film.is_some()) {
        let uncovered = match content {
            PictureContent::OfImages(Shown::Holes) => "no surface (transparent)".to_owned(),
            PictureContent::OfImages(_) => "in none of the images (transparent)".to_owned(),
            PictureContent::Model(_) | PictureContent::Exploded => format!("{UNCOVERED_NAME} (transparent)"),
        };
        outcome.explain(legend, Some(&uncovered));
    }
    Ok(outcome)
}

/// What pictures show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PictureContent {
    /// What the projective renderer shows, or colours.
    Model(DisplayMode),
    /// A quantity of layered depth images.
    OfImages(Shown),
    /// The layers of photos as sheets.
    Exploded,
}

impl PictureContent {
    /// Returns what the projective renderer shows.
    fn display(self) -> DisplayMode {
        match self {
            Self::Model(display) => display,
            Self::OfImages(_) | Self::Exploded => DisplayMode::Colour,
        }
    }
}

/// Checks that what is shown can be written in the format.
fn check_format(args: &RenderArgs, content: PictureContent) -> Result<()> {
    let format = args.format;
    let found = match content {
        _ if !format.is_linear() => return Ok(()),
        _ if args.legend => {
            "--legend draws into pictures of 8 bits a channel; leave it out, or give --format png"
        }
        PictureContent::Model(_) if args.made.as_what == AsArg::Model => return Ok(()),
        _ => {
            "--format png16 and exr are for views that are drawn from the model; exploded views and views of layered depth \
             images have 8 bits a channel: give --format png"
        }
    };
    Err(Error::Usage(found.into()))
}

/// Returns what the arguments ask for.
fn content_of(args: &RenderArgs) -> Result<PictureContent> {
    let of_images = args.made.as_what != AsArg::Model;
    if of_images && args.background == Background::Sky {
        let found = "--background sky is for views of the model; leave out --as, or give another background";
        return Err(Error::Usage(found.into()));
    }
    if of_images && args.look.holes {
        let found = "--holes is for views of the model; give --show holes to see where layered depth images show nothing, or leave out --as";
        return Err(Error::Usage(found.into()));
    }
    let found = match (args.show, args.show.display()) {
        (ShowArg::Holes, _) if of_images => return Ok(PictureContent::OfImages(Shown::Holes)),
        (ShowArg::Layer, _) if of_images => return Ok(PictureContent::OfImages(Shown::Layer)),
        (ShowArg::Provenance, _) if of_images => return Ok(PictureContent::OfImages(Shown::Provenance)),
        (ShowArg::Density, _) if of_images => return Ok(PictureContent::OfImages(Shown::Density)),
        (ShowArg::Holes, _) => "--show holes tells about layered depth images; give --as ldi, or --as photo",
        (ShowArg::Exploded, _) if !of_images => return Ok(PictureContent::Exploded),
        (_, Some(display)) if !of_images || display == DisplayMode::Colour => {
            return Ok(PictureContent::Model(display));
        }
        _ => {
            "views of layered depth images show colour, holes, layer, provenance and density alone; give one of these to \
             --show, or leave out --as"
        }
    };
    Err(Error::Usage(found.into()))
}

/// Returns the legend of what is shown; `None` for the photos' own colours.
fn legend_of(
    args: &RenderArgs,
    content: PictureContent,
    project: &Project,
    site: &Site,
    task: &Task,
) -> Result<Option<Legend>> {
    let display = match content {
        PictureContent::Model(display) => display,
        PictureContent::OfImages(shown) => return Ok(Some(shown.legend(u32::MAX))),
        PictureContent::Exploded => {
            return Ok(Some(Legend::Words(
                "Sheets are image layers, the nearest one in front; hatched parts are hidden in the photo.",
            )));
        }
    };
    let photos: Vec<&str> = site.photos.iter().map(|photo| photo.name.as_str()).collect();
    let groups = match display {
        DisplayMode::Group => colour_report(&args.project, project, site, task)?.described_groups(),
        _ => Vec::new(),
    };
    Ok(legend(display, &photos, &groups))
}

fn hexadecimal([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Returns the values along a scale with their colours.
fn marked(ramp: ColourRamp, marks: &[&str]) -> Vec<(String, [u8; 3])> {
    let last = marks.len().saturating_sub(1).max(1) as f32;
    let mark = |(mark, at): (&&str, u8)| ((*mark).to_owned(), colour_at(ramp, f32::from(at) / last));
    marks.iter().zip(0..).map(mark).collect()
}

impl Outcome {
    /// Tells how much of the pictures no photo shows.
    fn tell_continued(&mut self, continued: &BTreeMap<String, f64>) {
        self.json["continued"] = json!(continued);
        let share = continued.values().sum::<f64>() / continued.len().max(1) as f64;
        if share >= LEAST_CONTINUED {
            let percent = 100.0 * share;
            self.text.push_str(&format!(
                "{percent:.1} % of the pixels show what no photo shows: surfaces and surroundings continue there; \
                 --show provenance shows where, and --holes leaves them out\n"
            ));
        }
    }

    /// Adds the legend of the pictures. `uncovered` is the meaning of pixels without any colour.
    pub(super) fn explain(&mut self, legend: &Legend, uncovered: Option<&str>) {
        self.text.push_str(&legend_text(legend, uncovered));
        self.json["legend"] = legend_json(legend);
    }
}

/// Returns the legend as text. Where it explains colours, the last line is that of surfaces without any.
fn legend_text(legend: &Legend, uncovered: Option<&str>) -> String {
    let line = |text: &str| format!("  {}  {text}\n", hexadecimal(UNCOVERED));
    let uncovered = uncovered.map_or(String::new(), line);
    let listed = |title: &str, entries: &[(String, [u8; 3])]| {
        let line = |(text, colour): &(String, [u8; 3])| format!("  {}  {text}\n", hexadecimal(*colour));
        format!("\n{title}:\n{}", entries.iter().map(line).collect::<String>())
    };
    match legend {
        Legend::Entries { title, entries } => listed(title, entries) + &uncovered,
        Legend::Scale { title, ramp, marks } => listed(title, &marked(ramp, marks)) + &uncovered,
        Legend::Words(words) => format!("\n{words}\n"),
    }
}

fn legend_json(legend: &Legend) -> serde_json::Value {
    let listed = |title: &str, entries: &[(String, [u8; 3])]| {
        let entry =
            |(text, colour): &(String, [u8; 3])| json!({ "text": text, "colour": hexadecimal(*colour) });
        json!({ "title": title, "colours": entries.iter().map(entry).collect::<Vec<_>>() })
    };
    match legend {
        Legend::Entries { title, entries } => listed(title, entries),
        Legend::Scale { title, ramp, marks } => listed(title, &marked(ramp, marks)),
        Legend::Words(words) => json!({ "title": words, "colours": [] }),
    }
}

/// The least share of all pixels that is told.
const LEAST_CONTINUED: f64 = 0.0005;
/// The largest number of views of which it is found how much is continued.
const MOST_EXAMINED: usize = 50;

/// What was drawn.
#[derive(Default)]
struct DrawnShots {
    report: RenderReport,
    /// The layers that could not be used.
    problems: Vec<String>,
    /// The share of views that is continued where no photo shows it, 0 to 1; of a flight, of some frames.
    continued: BTreeMap<String, f64>,
}

/// Returns whether a background shows something in every direction around the model.
fn is_around(background: Background) -> bool {
    matches!(background, Background::Surroundings | Background::Sky)
}

/// Draws the pictures.
fn draw_shots(
    args: &RenderArgs,
    content: PictureContent,
    project: &Project,
    site: &Site,
    views: &RequestedViews,
    options: &RenderOptions,
    task: &Task,
) -> Result<DrawnShots> {
    let mut look = args.look.look(project, site, content.display(), usual_exposure(project, site))?;
    look.without_surroundings = !is_around(args.background);
    let gpu = task.timed("start the GPU", Gpu::headless)?;
    let preview = PreviewOptions { modelled_sky: args.background == Background::Sky, ..args.look.preview() };
    let stack = args.look.stack(is_around(args.background));
    let mut of_images = args.made.options(stack, site)?;
    if let (Some(options), PictureContent::OfImages(shown)) = (&mut of_images, content) {
        options.shown = Some(shown);
    }
    let read = preview::read(&args.project, project, site, &preview, task)?;
    note_stale(&args.project, stale_among(&args.project, project, site, &read.stacks)?.len(), task);
    let renderer = preview::open_read(&args.project, project, site, read, &gpu, &preview, task)?;
    if let Some(daylight) = renderer.daylight() {
        task.note(sky_text(daylight));
    }
    let mut renderer = Viewer::new(&args.project, project, site, renderer, of_images)?;
    let taken = match look.exposure {
        Exposure::Decided => written_exposures(&args.project, project, site, &views.list, task)?,
        _ => BTreeMap::new(),
    };
    let (mut continued, mut number) = (BTreeMap::new(), 0);
    let every = views.list.len().div_ceil(MOST_EXAMINED).max(1);
    let mut draw = |view: &RequestedView, task: &Task| {
        let mut shot = look.shot(view.camera, view.pose);
        shot.exposure = taken.get(&view.name).map_or(shot.exposure, |log| Exposure::AsTaken(*log));
        if number % every == 0
            && look.display == DisplayMode::Colour
            && let Some(share) = renderer.continued_share(&shot, task)?
        {
            continued.insert(view.name.clone(), share);
        }
        number += 1;
        if options.format.is_linear() {
            let picture = renderer.linear_picture(&shot, task)?;
            return Ok(match args.background {
                Background::Colour(colour) => picture.on(colour),
                Background::Surroundings | Background::Sky | Background::None => picture,
            }
            .into());
        }
        let picture = renderer.picture(&shot, task)?;
        Ok(match args.background {
            Background::Colour(colour) => picture.on(colour),
            Background::Surroundings | Background::Sky | Background::None => picture,
        }
        .into())
    };
    let report = render(&views.list, &mut draw, options, task)?;
    task.detail(format!("textures: {}", renderer.preview().statistics()));
    let problems = renderer.preview().problems().iter().map(worded).collect();
    Ok(DrawnShots { report, problems, continued })
}

fn draw_exploded(
    args: &RenderArgs,
    site: &Site,
    views: &RequestedViews,
    options: &RenderOptions,
    task: &Task,
) -> Result<RenderReport> {
    let store = StackStore::new(&args.project);
    let mut draw = |view: &RequestedView, task: &Task| {
        let id = view.photo.expect("exploded views of anything but photos were refused");
        let photo = &site.photo(id).name;
        let missing =
            || Error::Request(format!("photo {photo} has no stack yet; run `quadratura update` first"));
        let stack = store.current(photo)?.ok_or_else(missing)?;
        exploded(&store.folder(photo), &stack, (view.camera.width, view.camera.height), task).map(Into::into)
    };
    render(&views.list, &mut draw, options, task)
}

/// Describes a plain sky.
fn sky_text(daylight: &Daylight) -> String {
    let sky = match daylight.kind {
        SkyKind::Clear { towards_sun, turbidity } => {
            let elevation = daylight.elevation(towards_sun).to_degrees();
            format!("a sun elevation of {elevation:.0} degrees and a turbidity of {turbidity}")
        }
        SkyKind::Overcast { .. } => "no sun: it is overcast".to_owned(),
    };
    let why = match daylight.is_estimated {
        true => "estimated from the sky in the photos",
        false => "default values, because the photos show too little of the sky",
    };
    format!("the sky has {sky} ({why})")
}

/// The colour of videos where nothing is drawn, sRGB.
pub const BEHIND_VIDEOS: [u8; 3] = [0xc9, 0xd4, 0xde];

fn film(args: &RenderArgs, views: &RequestedViews) -> Option<VideoOptions> {
    let fps = args.pictures.fps.or(views.path.as_ref().map(|path| path.fps)).unwrap_or(USUAL_FPS);
    let background = match args.background {
        Background::Colour(colour) => colour,
        Background::Surroundings | Background::Sky | Background::None => BEHIND_VIDEOS,
    };
    args.pictures.video.clone().map(|file| VideoOptions { file, fps, background })
}

/// Writes the camera path, but never over an existing file, which may have been edited.
fn write_path(args: &RenderArgs, views: &RequestedViews, project: &Project) -> Result<()> {
    match (&args.write_path, &views.path) {
        (Some(file), _) if file.exists() => {
            let file = file.display();
            Err(Error::Request(format!(
                "{file} already exists; give --write-path another name, or move the file away"
            )))
        }
        (Some(file), Some(path)) => {
            if let Some(folder) = file.parent().filter(|folder| *folder != Path::new("")) {
                fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
            }
            match args.in_frame {
                true => write_camera_path(file, &path.moved(&project.frame.frame_from_world())),
                false => write_camera_path(file, path),
            }
        }
        _ => Ok(()),
    }
}

/// Reports the pictures; the frames of a flight are not listed.
fn outcome(args: &RenderArgs, report: &RenderReport, is_flight: bool, problems: Vec<String>) -> Outcome {
    let table = if is_flight { String::new() } else { table(&report.done) + "\n" };
    let film = report.film.as_ref().map_or(String::new(), |film| format!("video: {}\n", film.display()));
    let path =
        args.write_path.as_ref().map_or(String::new(), |path| format!("camera path: {}\n", path.display()));
    let done = counted(report.done.len(), "picture");
    let textured = match report.done.iter().map(|done| done.textured).reduce(|a, b| a + b) {
        Some(sum) => {
            format!("; {:.1} % of their pixels are textured", 100.0 * sum / report.done.len() as f64)
        }
        None => String::new(),
    };
    let text = format!("{table}{done} in {}{textured}\n{film}{path}", args.pictures.out.display());
    let json = json!({
        "pictures": report.done,
        "film": report.film,
        "camera_path": args.write_path,
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Lists pictures.
pub fn table(pictures: &[RenderedView]) -> String {
    let mut table = Table::new(&["view", "size", "textured", "file"]);
    for done in pictures.iter().take(MOST_ROWS) {
        let size = format!("{} x {}", done.width, done.height);
        let textured = format!("{:.1} %", 100.0 * done.textured);
        table.row([done.view.clone(), size, textured, done.path.display().to_string()]);
    }
    let more = if pictures.len() > MOST_ROWS { "...\n" } else { "" };
    table.render() + more
}
