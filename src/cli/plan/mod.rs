//! The command `plan`: the jobs that make a project on several machines, for a job scheduler of others.

mod cuecmd;
mod graph;
mod openjd;
mod snakemake;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;

use self::graph::{JobStage, PlanRequest, PlannedFrames, PlannedPhoto, stages, to_json};
use super::Outcome;
use super::args::{PlanArgs, Scheduler};
use super::table::{Table, counted};
use super::view_args::photos_or_path;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::to_json as json_bytes;
use quadratura_images::cached_file;
use quadratura_io::project::PROJECT_FILE;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::open::{Opened, open};
use quadratura_sites::views::{Size, ViewRequest};

/// Runs `plan`: writes the jobs of a project for a scheduler.
pub fn run(args: &PlanArgs, task: &Task) -> Result<Outcome> {
    let opened = open(&args.project, task)?;
    if opened.site.photos.is_empty() {
        return Err(Error::Request(
            "the project has no photos that can be read, so there is nothing to plan".into(),
        ));
    }
    fs::create_dir_all(&args.out).map_err(Error::io(&args.out, "create the folder"))?;
    let wanted = wanted(args, &opened, task)?;
    let stages = stages(&wanted);
    let files = files(args.scheduler, &stages, &wanted);
    for (name, bytes) in &files {
        write_atomically(args.out.join(name), bytes)?;
    }
    let out = &args.out.display();
    let next = match args.scheduler {
        Scheduler::Snakemake => format!("run `snakemake --cores N` in {out}"),
        Scheduler::Openjd => format!("submit {out}/template.json, or run `openjd run {out}/template.json`"),
        Scheduler::Cuecmd => {
            format!("run `sh {out}/submit.sh stacks`, and the other stages when the one before is done")
        }
    };
    let mut table = Table::new(&["stage", "jobs", "after", "memory of a job", "cores"]);
    for JobStage { name, after, memory, cores, inputs, .. } in &stages {
        let memory = format!("{:.1} GiB", *memory as f64 / f64::from(1 << 30));
        table.row([
            (*name).to_owned(),
            inputs.len().to_string(),
            after.unwrap_or("").to_owned(),
            memory,
            cores.to_string(),
        ]);
    }
    let text = format!("{}\n{} written; {next}\n", table.render(), counted(files.len(), "file"));
    let files: Vec<&String> = files.iter().map(|(name, _)| name).collect();
    let json = json!({ "plan": to_json(&stages, &wanted.project, &wanted.out), "files": files });
    let problems = opened.problems.errors.iter().map(super::words::error_text).collect();
    Ok(Outcome { text, json, problems })
}

/// Returns the files of a plan by name.
fn files(scheduler: Scheduler, stages: &[JobStage], wanted: &PlanRequest) -> Vec<(String, Vec<u8>)> {
    let (project, out) = (&wanted.project, &wanted.out);
    let mut files = vec![("plan.json".to_owned(), json_bytes(&to_json(stages, project, out)))];
    match scheduler {
        Scheduler::Snakemake => {
            files.push(("Snakefile".into(), snakemake::snakefile(stages, project).into()))
        }
        Scheduler::Openjd => {
            files.push(("template.json".into(), json_bytes(&openjd::template(stages, project, out))));
        }
        Scheduler::Cuecmd => {
            let lists = (0..stages.len()).map(|at| cuecmd::list(stages, at, project, out));
            files.extend(lists.map(|(name, lines)| (name, lines.into_bytes())));
            files.push(("submit.sh".into(), cuecmd::submit(stages).into()));
        }
    }
    files
}

/// Returns what the arguments ask for, with whole paths.
fn wanted(args: &PlanArgs, opened: &Opened, task: &Task) -> Result<PlanRequest> {
    let whole = |path: &Path| fs::canonicalize(path).map_err(Error::io(path, "find it"));
    let project = whole(&args.project)?;
    let store = StackStore::new(&project);
    // Paths of the site are relative to the project as it was given.
    let known = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let photo = |photo: &Photo| PlannedPhoto {
        files: std::iter::once(&photo.file).chain(&photo.masks).map(|file| known(file)).collect(),
        stack: store.stack_file(&photo.name),
        ldi: cached_file(&project, &photo.name),
    };
    let of_site = [&opened.project.cameras, &opened.project.model];
    let of_site = of_site.iter().map(|path| known(&args.project.join(path)));
    let frames = args.frames.as_deref().map(|cameras| -> Result<PlannedFrames> {
        let source = photos_or_path(cameras);
        let views = opened.views(&ViewRequest { source, size: Size::Own, fps: None }, task)?;
        let cameras: PathBuf = if cameras.exists() { known(cameras) } else { cameras.to_path_buf() };
        Ok(PlannedFrames { cameras, count: views.list.len(), per_job: args.frames_per_job })
    });
    Ok(PlanRequest {
        photos: opened.site.photos.iter().map(photo).collect(),
        of_site: std::iter::once(project.join(PROJECT_FILE)).chain(of_site).collect(),
        photos_per_job: args.photos_per_job,
        frames: frames.transpose()?,
        ldi: args.ldi,
        exports: args.exports,
        memory: args.memory,
        cores: args.cores,
        out: whole(&args.out)?,
        project,
    })
}
