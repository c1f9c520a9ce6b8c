//! The command `new`.

use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::{NewArgs, SampleArgs};
use super::table::{Table, counted};
use super::words::{as_typed, error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_import::cameras::{CameraOptions, Reprojection};
use quadratura_layers::Options;
use quadratura_sites::create::{NewProject, create_project};
use quadratura_sites::open::Opened;
use quadratura_sites::sample::{create_sample, project_of_sample};

/// Runs `new`: creates a project from photos, cameras and a model, and summarises it.
pub fn run(args: &NewArgs, task: &Task) -> Result<Outcome> {
    let model = args.model.clone().ok_or_else(|| without_model(args))?;
    let new = NewProject {
        photos: args.photos.clone(),
        cameras: args.cameras.clone(),
        model,
        camera_options: CameraOptions { chunk: args.chunk.clone(), rolling_shutter: args.rolling_shutter },
        world_from_model: args.model_transform.unwrap_or_default(),
        options: args.options.applied_to(&Options::default()),
        surroundings: args.surroundings.clone().map(|file| (file, args.middle)),
    };
    let opened = create_project(&args.project, &new, task)?;
    Ok(created(&opened, &args.project))
}

/// Says how to get a model.
fn without_model(args: &NewArgs) -> Error {
    let [photos, cameras] = [&args.photos, &args.cameras].map(|path| as_typed(path));
    Error::Usage(format!(
        "a project needs a coarse model: give one with --model FILE, or make a first one from the photos:\n  quadratura model \
         suggest --photos {photos} --cameras {cameras} --out model.obj"
    ))
}

/// Runs `sample`: writes the sample's site, creates its project and summarises it.
pub fn run_sample(args: &SampleArgs, task: &Task) -> Result<Outcome> {
    let opened = create_sample(&args.folder, task)?;
    Ok(created(&opened, &project_of_sample(&args.folder)))
}

/// Summarises a new project and says what comes next.
fn created(opened: &Opened, project: &Path) -> Outcome {
    let mut outcome = summary(opened);
    outcome.text.push_str(&format!(
        "\nNext: run `quadratura check {0}` to check the site, and `quadratura update {0}` to make the layers.\n",
        project.display()
    ));
    outcome.json["project"] = project.display().to_string().into();
    outcome
}

/// Summarises the contents of the project.
fn summary(opened: &Opened) -> Outcome {
    let (site, problems) = (&opened.site, &opened.problems.errors);
    let photos = site.photos.len();
    let faces = site.model.faces.len();
    let objects = site.model.objects.len();
    let mut table = Table::new(&["", ""]);
    let mut line = |name: &str, text: String| table.row([name.to_owned(), text]);
    line("photos", format!("{photos} of {} matched with their cameras", opened.problems.listed));
    line("size", sizes(&opened.site));
    line("model", format!("{} in {}", counted(faces, "face"), counted(objects, "object")));
    line("sparse points", opened.points.len().to_string());
    if let Some(reprojection) = &opened.reprojection {
        line("reprojection error", reprojection.to_string());
    }
    Outcome {
        text: table.render().trim_start().to_owned(),
        json: json!({
            "photos": photos,
            "left_out": problems.iter().map(error_text).collect::<Vec<_>>(),
            "faces": faces,
            "objects": objects,
            "sparse_points": opened.points.len(),
            "reprojection": opened.reprojection.as_ref().map(reprojection_json),
        }),
        problems: Error::gathered(&problems.iter().collect::<Vec<_>>()).iter().map(worded).collect(),
    }
}

/// Returns the error of reprojection for `--json`; the median is null where it is infinite.
pub(super) fn reprojection_json(reprojection: &Reprojection) -> serde_json::Value {
    let variants =
        reprojection.variants.iter().map(|(name, median)| json!({ "convention": name, "median_px": median }));
    json!({
        "median_px": reprojection.median_px,
        "observations": reprojection.observations,
        "variants": variants.collect::<Vec<_>>(),
    })
}

/// Returns `3072 x 2048 px`, or the smallest and the largest size.
fn sizes(site: &Site) -> String {
    let size = |photo: &&quadratura_base::scene::Photo| (photo.camera.width, photo.camera.height);
    let area = |photo: &&quadratura_base::scene::Photo| {
        u64::from(photo.camera.width) * u64::from(photo.camera.height)
    };
    let photos = || site.photos.iter();
    let bounds = photos().min_by_key(area).zip(photos().max_by_key(area));
    let Some((smallest, largest)) = bounds.map(|(a, b)| (size(&a), size(&b))) else { return String::new() };
    let text = |(w, h): (u32, u32)| format!("{w} x {h}");
    if smallest == largest {
        format!("{} px", text(largest))
    } else {
        format!("{} to {} px", text(smallest), text(largest))
    }
}
