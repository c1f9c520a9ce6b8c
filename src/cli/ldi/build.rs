//! The command `ldi build`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::several;
use crate::Outcome;
use crate::args::{LdiBackground, LdiBuildArgs, LdiFrom, refuse};
use crate::bytes::readable_bytes;
use crate::table::{Table, counted};
use crate::words::error_text;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_gpu::start_device;
use quadratura_images::{
    BuildFrom, BuildRequest, BuiltLdi, DepthRequest, StackLdiOptions, build_ldis, build_of_depth_images,
};
use quadratura_ldi::file::Packing;
use quadratura_sites::open::{Opened, open};
use quadratura_sites::views::{RequestedView, Size, ViewRequest, ViewSource};
use quadratura_trees::PlantParts;
use quadratura_views::preview::PreviewOptions;

/// Runs `ldi build`.
pub fn run(args: &LdiBuildArgs, task: &Task) -> Result<Outcome> {
    args.out.as_deref().map(refuse_other_extension).transpose()?;
    match (&args.project, &args.depth_images) {
        (Some(project), None) => of_project(args, project, task),
        (_, Some(list)) => of_depth_images(args, list, task),
        (None, None) => Err(Error::Usage("give a project, or --depth-images".into())),
    }
}

/// Refuses a file with another extension than that of layered depth images.
fn refuse_other_extension(file: &Path) -> Result<()> {
    let extension = file.extension().unwrap_or_default();
    if extension.is_empty() || extension.eq_ignore_ascii_case("ldi") {
        return Ok(());
    }
    // Digits after a dot are part of a name, as in `v1.2`.
    let is_number = extension.to_string_lossy().chars().all(|c| c.is_ascii_digit());
    let better = if is_number { file.with_added_extension("ldi") } else { file.with_extension("ldi") };
    let (file, better) = (file.display(), better.display());
    Err(Error::Request(format!("{file}: layered depth images have the extension .ldi; write to {better}")))
}

/// Makes one image of depth images from elsewhere.
fn of_depth_images(args: &LdiBuildArgs, list: &Path, task: &Task) -> Result<Outcome> {
    let (Some(out), Some(reference)) = (&args.out, &args.reference) else {
        return Err(Error::Usage("--depth-images needs --reference NAME and --out FILE".into()));
    };
    args.refuse_of_projects()?;
    let stack = StackLdiOptions::default();
    let request = DepthRequest {
        list,
        reference,
        options: args.combined.options(stack),
        force: args.force,
        out,
        packing: args.packing.unwrap_or(Packing::Deflate),
    };
    let (built, failed) = build_of_depth_images(&request, task)?;
    note_spared(&built.spared, &built.file, task);
    let problems: Vec<String> = failed.iter().map(error_text).collect();
    let built = [built];
    Ok(Outcome {
        text: text(&built),
        json: json!({ "images": [described(&built[0])], "problems": problems }),
        problems,
    })
}

fn of_project(args: &LdiBuildArgs, project: &Path, task: &Task) -> Result<Outcome> {
    let opened = open(project, task)?;
    let named = args.part.of(&args.photos, &opened.site)?;
    let chosen = opened.photos_named(&named.names)?;
    let mut photos: Vec<PhotoId> =
        chosen.iter().filter_map(|photo| opened.site.photo_named(&photo.name)).collect();
    let from = from(args, &opened, task)?;
    // Of photos that are named the first one is the reference, unless another one is asked for.
    if let BuildFrom::Photos { with, .. } = &from
        && let Some(first) = with.first().filter(|_| named.names.is_empty() && args.set.is_none())
    {
        photos = vec![*first];
    }
    if args.cube || args.set.is_some() {
        return several::run(args, project, &opened, photos, from, task);
    }
    let usual = if args.out.is_some() { Packing::Deflate } else { Packing::None };
    let packing = args.packing.unwrap_or(usual);
    let request = BuildRequest { photos, from, out: args.out.clone(), packing };
    let (built, failed) = build_ldis(project, &opened.project, &opened.site, &request, &start_device, task)?;
    // What the whole site lacks is what no photo shows.
    if args.from != LdiFrom::Site {
        note_empty(&built, project, task);
    }
    for one in &built {
        note_spared(&one.spared, &one.file, &task.with_subject(&one.photo));
    }
    let mut problems = named.problems_of(&opened.problems, task);
    problems.extend(failed.iter().map(error_text));
    let images: Vec<Value> = built.iter().map(described).collect();
    Ok(Outcome { text: text(&built), json: json!({ "images": images, "problems": problems }), problems })
}

/// Returns what the images are made from.
fn from(args: &LdiBuildArgs, opened: &Opened, task: &Task) -> Result<BuildFrom> {
    let stack = StackLdiOptions {
        relief: !args.flat,
        filled: !args.unfilled,
        surroundings: args.background == LdiBackground::Surroundings,
    };
    if args.from != LdiFrom::Site {
        refuse(&[(args.at.is_some(), "--at")], "--from site")?;
    }
    Ok(match args.from {
        _ if args.combined.published => {
            let with = args.combined.with(&opened.site)?;
            BuildFrom::Photos { options: args.combined.options(stack), best: args.combined.best(3), with }
        }
        LdiFrom::Site => {
            args.combined.refuse_of_merging()?;
            args.combined.refuse_choice("--published")?;
            let options = args.combined.site_options(stack);
            // Images of the site hold no trees.
            let preview = PreviewOptions {
                relief: stack.relief,
                filled: stack.filled,
                tree_parts: PlantParts::Nothing,
                ..PreviewOptions::default()
            };
            BuildFrom::Site { options, preview, at: at(args, opened, task)? }
        }
        LdiFrom::Stack => {
            args.combined.refuse_of_photos()?;
            args.combined.refuse_choice("--published")?;
            BuildFrom::Stack(stack)
        }
    })
}

/// Returns the saved view in whose camera the image is made.
fn at(args: &LdiBuildArgs, opened: &Opened, task: &Task) -> Result<Option<RequestedView>> {
    let Some(name) = &args.at else { return Ok(None) };
    let source = ViewSource::Saved(vec![name.clone()]);
    let views = opened.views(&ViewRequest { source, size: Size::Own, fps: None }, task)?;
    Error::of_all(views.problems).map_or(Ok(()), Err)?;
    let several = || Error::Request(format!("several saved views are called {name}; rename one of them"));
    match &views.list[..] {
        [view] => Ok(Some(view.clone())),
        _ => Err(several()),
    }
}

/// The share of empty texels among all from which on filling is recommended.
const MANY_EMPTY: f64 = 0.05;

/// Notes that occluded areas have not been filled.
fn note_empty(built: &[BuiltLdi], project: &Path, task: &Task) {
    let sum =
        |of: &dyn Fn(&BuiltLdi) -> u64| built.iter().filter(|one| !one.kept).map(of).sum::<u64>() as f64;
    let (empty, held) = (sum(&|one| one.report.empty_needed), sum(&|one| one.depth_pixels));
    if empty > MANY_EMPTY * (empty + held) {
        let project = project.display();
        task.note(format!(
            "{empty} texels of occluded areas are empty and become holes in views from aside; `quadratura fill {project}` fills \
             them"
        ));
    }
}

/// Notes files that were not overwritten.
pub(super) fn note_spared(spared: &[PathBuf], file: &Path, task: &Task) {
    for old in spared {
        let (old, new) = (old.display(), file.display());
        task.note(format!("{old} holds something else, or an image of another photo or with other options, and is kept; this image is {new}"));
    }
}

fn text(built: &[BuiltLdi]) -> String {
    let mut table =
        Table::new(&["photo", "depth pixels", "complexity", "layers", "empty", "left out", "size", "file"]);
    for one in built {
        let report = &one.report;
        let left_out = report.dropped;
        table.row([
            one.photo.clone(),
            one.depth_pixels.to_string(),
            format!("{:.2}", report.depth_complexity),
            report.layers.to_string(),
            report.empty_needed.to_string(),
            left_out.to_string(),
            readable_bytes(one.bytes),
            one.file.display().to_string(),
        ]);
    }
    let kept = built.iter().filter(|one| one.kept).count();
    let made = counted(built.len() - kept, "layered depth image");
    let up_to_date = if kept > 0 { format!(", {kept} already up to date") } else { String::new() };
    let table = if built.is_empty() { String::new() } else { table.render() + "\n" };
    format!("{table}{made} built{up_to_date}\n")
}

fn described(one: &BuiltLdi) -> Value {
    json!({
        "photo": one.photo,
        "file": one.file,
        "up_to_date": one.kept,
        "depth_pixels": one.depth_pixels,
        "bytes": one.bytes,
        "report": one.report,
        "spared": one.spared,
    })
}
