//! Layered files of every kind from invented stacks, for `tests/editors.sh`:
//! `invented_exports FOLDER [ICC-PROFILE]`.
//!
//! Writes a project with a photo of 8 and one of 16 bits into `FOLDER/project`, and their exports into
//! `FOLDER/out`: PSD, OpenRaster, folder, and the first as a PSB, too.

#[path = "../tests/invented/mod.rs"]
mod invented;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use invented::Plan;
use quadratura::layered::{
    Depth, ExportFormat, ExportOptions, FormatFit, PsdVariant, Raster, export, write_psd,
};
use quadratura::site::{Photo, read_photo};
use quadratura::stack::{Stack, StackStore};
use quadratura::task::Task;
use quadratura::testing::editing::export::StackContent;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let folder = arguments.first().ok_or("usage: invented_exports FOLDER [ICC-PROFILE]")?;
    let icc = arguments.get(1).map(std::fs::read).transpose()?;
    let (project, out) = (folder.join("project"), folder.join("out"));
    std::fs::create_dir_all(&project)?;
    let (width, height, layers) = (400, 300, 12);
    let eight = Plan { photo: "eight.png", width, height, layers, icc, ..Plan::default() };
    let sixteen =
        Plan { photo: "sixteen.png", depth: Depth::Sixteen, invalid: 30, seed: 2, ..Plan::default() };
    let (eight, stack) = invented::write(&project, &eight);
    let (sixteen, _) = invented::write(&project, &sixteen);
    for &format in ExportFormat::ALL {
        let options = ExportOptions { format, ..ExportOptions::default() };
        let exported = export(&project, &[&eight, &sixteen], &out, &options, &Task::silent())?;
        if let Some((photo, problem)) = exported.failed.first() {
            return Err(format!("{photo}: {problem}").into());
        }
    }
    write_psb(&project, &eight, &stack, &out.join("eight.png.psb"))
}

/// A PSB although a PSD would do.
fn write_psb(
    project: &Path,
    photo: &Photo,
    stack: &Stack,
    file: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
    let (icc, raster) = (pixels.icc.clone(), Arc::new(Raster::of_photo(pixels)));
    let folder = StackStore::new(project).folder(&photo.name);
    let task = Task::silent();
    let content = StackContent::new(stack, folder, raster, icc, &task);
    let fit = write_psd(File::create(file)?, file, &content.document("psb"), PsdVariant::Psb)?;
    assert_eq!(fit, FormatFit::Whole, "a PSB holds everything");
    Ok(())
}
