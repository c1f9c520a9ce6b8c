//! The graph of jobs that make a project: stages, each with jobs that may run side by side, and each after the stage before it.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

/// Memory that a job needs beside what it may use for photos, in bytes: program, driver, model and stacks.
const BESIDE: u64 = 1 << 30;
/// What the estimates keep of each photo in memory beside that, in bytes, as measured: lists of faces, of pixels that others contradict.
const KEPT_OF_PHOTO: u64 = 4 << 20;

/// What is to be made, and from what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanRequest {
    /// The project's folder.
    pub project: PathBuf,
    /// The folder of the plan.
    pub out: PathBuf,
    /// The photos, in the site's order.
    pub photos: Vec<PlannedPhoto>,
    /// Files that every stack depends on: `project.json`, cameras, model.
    pub of_site: Vec<PathBuf>,
    /// Photos of a job.
    pub photos_per_job: usize,
    /// The cameras of the frames, how many there are, and how many a job renders.
    pub frames: Option<PlannedFrames>,
    /// Whether layered depth images are made.
    pub ldi: bool,
    /// Whether photos are exported.
    pub exports: bool,
    /// Memory that a job may use for photos, in bytes.
    pub memory: u64,
    /// Cores of a job.
    pub cores: u32,
}

/// A photo and its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedPhoto {
    /// The photo and its masks.
    pub files: Vec<PathBuf>,
    /// The stack's file.
    pub stack: PathBuf,
    /// The layered depth image in the cache.
    pub ldi: PathBuf,
}

/// Frames to be rendered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedFrames {
    /// The cameras, as for `render --cameras`.
    pub cameras: PathBuf,
    /// The number of frames.
    pub count: usize,
    /// Frames of a job.
    pub per_job: usize,
}

/// A word of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Word {
    /// A word that all jobs of a stage have.
    Same(String),
    /// The project's folder.
    Project,
    /// The folder of the plan, with a folder in it.
    InPlan(&'static str),
    /// `K/N`: which job of the stage it is.
    Part,
}

/// Jobs that may run side by side. Each is one command, which may be run again: it leaves alone what is done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobStage {
    /// The name, of lower-case letters.
    pub name: &'static str,
    /// The stage that has to be done before.
    pub after: Option<&'static str>,
    /// The words after the program's name.
    pub words: Vec<Word>,
    /// What each job reads that is not made by the stage before.
    pub inputs: Vec<Vec<PathBuf>>,
    /// What each job writes: files, or a folder.
    pub outputs: Vec<Vec<PathBuf>>,
    /// Memory that a job needs, in bytes.
    pub memory: u64,
    /// Cores that a job uses.
    pub cores: u32,
}

impl JobStage {
    /// Returns the number of jobs.
    pub fn jobs(&self) -> usize {
        self.inputs.len()
    }
}

/// Returns the stages in an order in which each comes after what it needs.
pub fn stages(wanted: &PlanRequest) -> Vec<JobStage> {
    let parts = parts_of(wanted.photos.len(), wanted.photos_per_job);
    let photos = |of: &dyn Fn(&PlannedPhoto) -> Vec<PathBuf>| -> Vec<Vec<PathBuf>> {
        parts.iter().map(|part| wanted.photos[part.clone()].iter().flat_map(of).collect()).collect()
    };
    let stacks = photos(&|photo| vec![photo.stack.clone()]);
    let with_site = |mut inputs: Vec<Vec<PathBuf>>| {
        inputs.iter_mut().for_each(|inputs| inputs.extend(wanted.of_site.iter().cloned()));
        inputs
    };
    let files = with_site(photos(&|photo| photo.files.clone()));
    let memory = format!("{}", wanted.memory);
    let stage = |name, after, command: &str, inputs, outputs| JobStage {
        name,
        after,
        words: words(command, &memory, wanted.cores),
        inputs,
        outputs,
        memory: wanted.memory + BESIDE,
        cores: wanted.cores,
    };
    let estimates = ["gains", "relief", "agreement", "surroundings"];
    let estimates = estimates.map(|name| wanted.project.join(format!("cache/{name}.bin")));
    let none = || vec![Vec::new(); parts.len()];
    let mut stages = vec![
        stage(
            "stacks",
            None,
            "build PROJECT --stacks-only --part PART --memory MEMORY",
            files.clone(),
            stacks.clone(),
        ),
        stage(
            "estimates",
            Some("stacks"),
            "estimate PROJECT --memory MEMORY",
            vec![Vec::new()],
            vec![estimates.into()],
        ),
        stage("fillings", Some("estimates"), "fill PROJECT --part PART --memory MEMORY", files, stacks),
    ];
    stages[1].memory += wanted.photos.len() as u64 * KEPT_OF_PHOTO;
    if let Some(PlannedFrames { cameras, count, per_job }) = &wanted.frames {
        let jobs = parts_of(*count, *per_job).len();
        let mut frames = stage(
            "frames",
            Some("fillings"),
            "render PROJECT --frames PART --cameras CAMERAS --out FRAMES",
            vec![vec![cameras.clone()]; jobs],
            vec![vec![wanted.out.join("frames")]; jobs],
        );
        let at = frames.words.iter().position(|word| *word == Word::Same("CAMERAS".into()));
        frames.words[at.expect("the line above has it")] = Word::Same(cameras.display().to_string());
        stages.push(frames);
    }
    if wanted.ldi {
        let images = photos(&|photo| vec![photo.ldi.clone()]);
        stages.push(stage("images", Some("fillings"), "ldi build PROJECT --part PART", none(), images));
    }
    if wanted.exports {
        let outputs = vec![vec![wanted.out.join("exports")]; parts.len()];
        let command = "export PROJECT --part PART --out EXPORTS --memory MEMORY";
        stages.push(stage("exports", Some("fillings"), command, none(), outputs));
    }
    stages
}

/// Returns the words of a command, whose words in capitals stand for what differs.
fn words(command: &str, memory: &str, cores: u32) -> Vec<Word> {
    let threads = ["--threads".to_owned(), cores.to_string()].map(Word::Same);
    let word = |word| match word {
        "PROJECT" => Word::Project,
        "PART" => Word::Part,
        "FRAMES" => Word::InPlan("frames"),
        "EXPORTS" => Word::InPlan("exports"),
        "MEMORY" => Word::Same(memory.to_owned()),
        word => Word::Same(word.to_owned()),
    };
    threads.into_iter().chain(command.split(' ').map(word)).collect()
}

/// Returns the places of the parts of a list, as `--part` divides it.
fn parts_of(count: usize, per_job: usize) -> Vec<std::ops::Range<usize>> {
    let jobs = count.div_ceil(per_job).max(1);
    (0..jobs).map(|job| job * count / jobs..(job + 1) * count / jobs).collect()
}

/// Returns the graph for programs: for each stage the jobs with their commands, inputs, outputs, memory and cores.
pub fn to_json(stages: &[JobStage], project: &Path, out: &Path) -> Value {
    let stage = |stage: &JobStage| {
        let jobs = (0..stage.jobs()).map(|job| {
            json!({
                "command": command(stage, job, &project.display().to_string(), out),
                "inputs": stage.inputs[job],
                "outputs": stage.outputs[job],
            })
        });
        json!({
            "name": stage.name,
            "after": stage.after,
            "memory": stage.memory,
            "cores": stage.cores,
            "jobs": jobs.collect::<Vec<_>>(),
        })
    };
    json!({ "project": project, "stages": stages.iter().map(stage).collect::<Vec<_>>() })
}

/// Returns the words of a job's command, with the program's name.
pub fn command(stage: &JobStage, job: usize, project: &str, out: &Path) -> Vec<String> {
    let word = |word: &Word| match word {
        Word::Same(word) => word.clone(),
        Word::Project => project.to_owned(),
        Word::InPlan(folder) => out.join(folder).display().to_string(),
        Word::Part => format!("{}/{}", job + 1, stage.jobs()),
    };
    std::iter::once("quadratura".to_owned()).chain(stage.words.iter().map(word)).collect()
}

/// Returns a word as a POSIX shell reads it as one.
pub fn quoted(word: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-=:,+".contains(&byte);
    match !word.is_empty() && word.bytes().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A plan of 5 photos with all that there is.
    pub fn all() -> PlanRequest {
        let photo = |index: u32| PlannedPhoto {
            files: vec![format!("/site/photos/{index}.jpg").into()],
            stack: format!("/site/it's one/stacks/{index}.jpg/stack.json").into(),
            ldi: format!("/site/it's one/cache/ldi/{index}.jpg.ldi").into(),
        };
        PlanRequest {
            project: "/site/it's one".into(),
            out: "/site/jobs".into(),
            photos: (0..5).map(photo).collect(),
            of_site: vec!["/site/it's one/project.json".into()],
            photos_per_job: 2,
            frames: Some(PlannedFrames { cameras: "/site/flight.json".into(), count: 51, per_job: 25 }),
            ldi: true,
            exports: true,
            memory: 4 << 30,
            cores: 4,
        }
    }

    #[test]
    fn every_photo_is_in_one_job_of_each_stage_and_every_stage_comes_after_one_before_it() {
        let stages = stages(&all());
        let names: Vec<_> = stages.iter().map(|stage| (stage.name, stage.jobs())).collect();
        let expected =
            [("stacks", 3), ("estimates", 1), ("fillings", 3), ("frames", 3), ("images", 3), ("exports", 3)];
        assert_eq!(names, expected);
        assert!(stages[1].memory > stages[0].memory, "the estimates keep something of each photo");
        for (at, stage) in stages.iter().enumerate() {
            assert_eq!(stage.after.is_none(), at == 0);
            assert!(stage.after.is_none_or(|after| stages[..at].iter().any(|before| before.name == after)));
        }
        let stacks: Vec<_> = stages[0].outputs.concat();
        assert_eq!(stacks, all().photos.into_iter().map(|photo| photo.stack).collect::<Vec<_>>());
        assert_eq!(
            stages[0].inputs[1],
            ["/site/photos/1.jpg", "/site/photos/2.jpg", "/site/it's one/project.json"].map(PathBuf::from)
        );
    }

    #[test]
    fn commands_name_their_part_and_words_survive_a_shell() {
        let stages = stages(&all());
        let words = command(&stages[2], 1, "/site/it's one", Path::new("/jobs"));
        assert_eq!(
            words.join(" "),
            "quadratura --threads 4 fill /site/it's one --part 2/3 --memory 4294967296"
        );
        let frames = command(&stages[3], 2, "p", Path::new("/jobs")).join(" ");
        assert!(
            frames.ends_with("render p --frames 3/3 --cameras /site/flight.json --out /jobs/frames"),
            "{frames}"
        );
        assert_eq!(quoted("/site/it's one"), r"'/site/it'\''s one'");
        assert_eq!((quoted("2/3"), quoted("")), ("2/3".to_owned(), "''".to_owned()));
    }
}
