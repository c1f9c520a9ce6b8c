//! The command `ldi export`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::input::read_image;
use crate::Outcome;
use crate::args::{LdiExportArgs, LdiExportFormat, refuse};
use crate::bytes::readable_bytes;
use crate::table::counted;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::writable::check_beside;
use quadratura_images::export::{ExportedMesh, MeshOptions, export_glb, export_page};
use quadratura_ldi::Ldi;
use quadratura_ldi::mesh::write_ply;
use quadratura_ldi::segments::SegmentOptions;

/// The size of a page that is shown within 3 s at 20 Mbit/s.
const PAGE_GOAL: u64 = 7_500_000;

/// Runs `ldi export`.
pub fn run(args: &LdiExportArgs, task: &Task) -> Result<Outcome> {
    refuse_of_others(args)?;
    refuse_ending(args)?;
    // What cannot be written is reported before the work, not after it.
    check_beside(&args.out)?;
    let ldi = task.timed("read", || read_image(&args.file, task))?;
    if ldi.levels[0].is_empty() {
        let remedy = "build it of a photo that shows the model, or with its surroundings";
        return Err(Error::input(&args.file, "", "there is no depth pixel in it to export", remedy));
    }
    match args.format {
        LdiExportFormat::Page => page(args, &ldi, task),
        LdiExportFormat::Glb => glb(args, &ldi, task),
        LdiExportFormat::Ply => ply(args, &ldi, task),
    }
}

/// Refuses options of other formats, which would have no effect.
fn refuse_of_others(args: &LdiExportArgs) -> Result<()> {
    let (is_page, is_glb) = (args.format == LdiExportFormat::Page, args.format == LdiExportFormat::Glb);
    if !is_page {
        refuse(&[(args.caption.is_some(), "--caption")], "--format page")?;
    }
    if !(is_page || is_glb) {
        let given = [(args.triangles.is_some(), "--triangles"), (args.quality.is_some(), "--quality")];
        refuse(&given, "--format page or --format glb")?;
    }
    Ok(())
}

/// Refuses a name that programs would take for a file of another kind, and a file where a folder is to be.
fn refuse_ending(args: &LdiExportArgs) -> Result<()> {
    let (format, kind, ending) = match args.format {
        LdiExportFormat::Glb => ("glb", "one file of binary glTF", "glb"),
        LdiExportFormat::Ply => ("ply", "a cloud of points", "ply"),
        LdiExportFormat::Page if args.out.is_file() => {
            let found = "this is a file, and the export is a folder";
            return Err(Error::input(&args.out, "", found, "give the name of a new folder"));
        }
        LdiExportFormat::Page => return Ok(()),
    };
    if args.out.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    let (given, meant) = (args.out.display(), args.out.with_extension(ending));
    Err(Error::Usage(format!(
        "--format {format} writes {kind}, and {given} does not end in .{ending}; give --out {}",
        meant.display()
    )))
}

fn ply(args: &LdiExportArgs, ldi: &Ldi, task: &Task) -> Result<Outcome> {
    let written = task.timed("write", || write_ply(&args.out, ldi))?;
    note_spared(&written.spared, &written.file, task);
    if written.at_infinity > 0 {
        let left_out = counted(written.at_infinity as usize, "depth pixel");
        task.note(format!("{left_out} infinitely far away are no points and are left out"));
    }
    let (points, size) = (counted(written.points as usize, "point"), readable_bytes(written.bytes));
    let text = format!("{}: {points}, {size}\n", written.file.display());
    let json = json!({
        "path": written.file,
        "points": written.points,
        "at_infinity": written.at_infinity,
        "bytes": written.bytes,
        "spared": written.spared,
        "problems": [],
    });
    Ok(Outcome { text, json, problems: Vec::new() })
}

fn page(args: &LdiExportArgs, ldi: &Ldi, task: &Task) -> Result<Outcome> {
    let name = name_of(args, ldi);
    let caption = args.caption.clone().filter(|caption| !caption.trim().is_empty()).unwrap_or(name);
    let exported = export_page(ldi, &args.out, &caption, &options(args), task)?;
    note(&exported, args, task);
    if exported.bytes() > PAGE_GOAL {
        task.note(format!(
            "the page has {}, more than {}, which takes longer than 3 seconds at 20 Mbit/s; a lower --quality makes it smaller",
            readable_bytes(exported.bytes()),
            readable_bytes(PAGE_GOAL)
        ));
    }
    Ok(outcome(&exported))
}

fn glb(args: &LdiExportArgs, ldi: &Ldi, task: &Task) -> Result<Outcome> {
    let exported = export_glb(ldi, &args.out, &name_of(args, ldi), &options(args), task)?;
    note(&exported, args, task);
    Ok(outcome(&exported))
}

fn options(args: &LdiExportArgs) -> MeshOptions {
    let usual = MeshOptions::default();
    MeshOptions {
        triangles: args.triangles.unwrap_or(usual.triangles),
        quality: args.quality.unwrap_or(usual.quality),
    }
}

/// Returns the name of the photo, or of the file where it has none.
fn name_of(args: &LdiExportArgs, ldi: &Ldi) -> String {
    let of = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    ldi.sources.first().map_or_else(|| of(&args.file), |source| of(Path::new(source)))
}

/// Notes files and folders that were not overwritten.
fn note_spared(spared: &[PathBuf], written: &Path, task: &Task) {
    for kept in spared {
        let (old, new) = (kept.display(), written.display());
        task.note(format!(
            "{old} was not written by this program or was changed since, and is kept; this export is {new}"
        ));
    }
}

fn note(exported: &ExportedMesh, args: &LdiExportArgs, task: &Task) {
    note_spared(&exported.spared, &exported.path, task);
    let most = options(args).triangles;
    if exported.triangles > most {
        task.note(format!("the coarsest mesh has {} triangles, more than {most}", exported.triangles));
    } else if exported.parallax > SegmentOptions::default().parallax {
        task.note(format!(
            "cells were made coarser to stay below {most} triangles: depths err by up to {:.1} pixels of parallax for a step of {:.3} \
             world units; a larger --triangles makes them finer",
            exported.parallax,
            exported.reach / 2.0
        ));
    }
    if let Some((_, safe)) = &exported.seen
        && safe.width() <= 0.0
    {
        task.note("large holes open as soon as the viewpoint moves aside; fill occluded areas (`quadratura fill`) before the image is built");
    }
}

fn outcome(exported: &ExportedMesh) -> Outcome {
    let size = readable_bytes(exported.bytes());
    let text = format!(
        "{}: {}, {} in {}, {size}\n",
        exported.path.display(),
        counted(exported.triangles, "triangle"),
        counted(exported.segments as usize, "segment"),
        counted(exported.files.len(), "file"),
    );
    let safe = exported.seen.as_ref().map(|(_, safe)| json!({ "across": safe.across, "along": safe.along }));
    let pivot = exported.seen.as_ref().map(|(window, _)| window.pivot);
    let json: Value = json!({
        "path": exported.path,
        "files": exported.files,
        "bytes": exported.bytes(),
        "segments": exported.segments,
        "triangles": exported.triangles,
        "parallax": exported.parallax,
        "reach": exported.reach,
        "pivot": pivot,
        "safe_region": safe,
        "spared": exported.spared,
        "problems": [],
    });
    Outcome { text, json, problems: Vec::new() }
}
