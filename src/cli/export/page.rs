//! `export` to a page.

use serde_json::json;

use super::super::Outcome;
use super::super::args::ExportArgs;
use super::super::bytes::readable_bytes;
use super::super::fill::note_stale_fillings;
use super::super::table::counted;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_exports::page::{Publication, Published};
use quadratura_gpu::Gpu;
use quadratura_io::programs::open_with_system;
use quadratura_sites::open::Opened;

/// Publishes the page, and returns what is in it and what it lacks.
pub fn run(args: &ExportArgs, opened: &Opened, task: &Task) -> Result<Outcome> {
    let chosen = args.part.of(&args.photos, &opened.site)?;
    let photos = opened.photos_named(&chosen.names)?;
    let options = args.page.options(args.memory.or_default());
    note_stale_fillings(&args.project, &opened.project, &opened.site, task)?;
    let gpu = task.timed("start the GPU", Gpu::headless)?;
    let publication = Publication::prepare(&args.project, opened, &photos, &options, &gpu, task)?;
    for photo in publication.photos() {
        let [width, height] = photo.size;
        task.note(format!("{} is published as {}, {width} x {height} pixels", photo.photo, photo.published));
    }
    let done = publication.write(&args.out, task)?;
    for spared in &done.spared {
        task.note(format!("{} holds other files, or was changed, and is kept", spared.display()));
    }
    if done.bytes > options.budget {
        task.note(format!(
            "the page has {}, more than {} of --budget; --longest, --quality and fewer photos make it smaller",
            readable_bytes(done.bytes),
            readable_bytes(options.budget),
        ));
    }
    if args.page.open {
        open_with_system(&done.folder.join("index.html"))?;
    }
    let problems = chosen.problems_of(&opened.problems, task);
    let text = text(&done);
    let json = json!({ "page": done, "problems": problems });
    Ok(Outcome { text, json, problems })
}

fn text(done: &Published) -> String {
    let mut text = format!(
        "{} in {}: {}, of which {} are needed for the first picture\n",
        counted(done.photos.len(), "photo"),
        done.folder.display(),
        readable_bytes(done.bytes),
        readable_bytes(done.first),
    );
    for part in done.parts.iter().filter(|part| part.bytes > 0) {
        text.push_str(&format!("  {:>9}  {}\n", readable_bytes(part.bytes), part.what));
    }
    text.push_str(&format!("  {:>9}  the viewer\n", readable_bytes(done.viewer)));
    for what in &done.left_out {
        text.push_str(&format!("not on the page: {what}\n"));
    }
    text.push_str(
        "All that the page shows can be copied. Open index.html, or put the folder on any web server.\n",
    );
    text
}
