//! Arguments of the commands for several machines, and which part of a work a job does.

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::number::whole;
use super::{MemoryArg, PhotoArgs};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;

/// A part of a list: part `number` of `of`, counted from 1. All parts together are the list, and differ by one at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    number: usize,
    of: usize,
}

impl Part {
    fn parse(text: &str) -> Result<Self, String> {
        let whole = |text: &str| text.parse::<usize>().ok().filter(|number| *number > 0);
        let part = text
            .split_once('/')
            .and_then(|(number, of)| Some(Self { number: whole(number)?, of: whole(of)? }));
        part.filter(|part| part.number <= part.of)
            .ok_or_else(|| "write K/N, such as 3/40 for part 3 of 40".into())
    }

    /// Returns the places of the part in a list of `len` things; none where the list is shorter than the number of parts.
    pub fn range(self, len: usize) -> Range<usize> {
        let edge = |number: usize| (number as u128 * len as u128 / self.of as u128) as usize;
        edge(self.number - 1)..edge(self.number)
    }
}

/// The part of the photos that a job of several is about.
#[derive(Debug, Args)]
pub struct PartArg {
    /// Use only part K of N of the photos, in the order of the project; for jobs on several machines (see `plan`)
    #[arg(long, value_name = "K/N", value_parser = Part::parse, conflicts_with = "names")]
    pub part: Option<Part>,
}

impl PartArg {
    /// Returns the chosen photos by name.
    ///
    /// # Errors
    /// [`Error::Request`] for more parts than photos.
    pub fn of(&self, chosen: &PhotoArgs, site: &Site) -> Result<PhotoArgs> {
        let Some(part) = self.part else { return Ok(PhotoArgs { names: chosen.names.clone() }) };
        let photos = &site.photos[part.range(site.photos.len())];
        if photos.is_empty() {
            let found =
                format!("{} photos cannot be divided into {} parts; give fewer", site.photos.len(), part.of);
            return Err(Error::Request(found));
        }
        Ok(PhotoArgs { names: photos.iter().map(|photo| photo.name.clone()).collect() })
    }
}

/// The views that are rendered of those that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FramesArg {
    /// These, counted from 1.
    Range(usize, usize),
    /// A part of all.
    Part(Part),
}

impl FramesArg {
    /// Reads `101-200`, `7` or `3/40`.
    ///
    /// # Errors
    /// What is to be written instead.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.contains('/') {
            return Part::parse(text).map(Self::Part);
        }
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        let range =
            first.parse().ok().zip(last.parse().ok()).filter(|(first, last)| 0 < *first && first <= last);
        let wrong = || "write a range such as 101-200, or a part such as 3/40".to_owned();
        range.map(|(first, last)| Self::Range(first, last)).ok_or_else(wrong)
    }

    /// Returns the places of the views in a list of `len`.
    ///
    /// # Errors
    /// [`Error::Request`] where there are none.
    pub fn range(self, len: usize) -> Result<Range<usize>> {
        let range = match self {
            Self::Range(first, last) => (first - 1).min(len)..last.min(len),
            Self::Part(part) => part.range(len),
        };
        if range.is_empty() {
            return Err(Error::Request(format!("--frames: there are only {len} views")));
        }
        Ok(range)
    }
}

/// Arguments of `estimate`.
#[derive(Debug, Args)]
pub struct EstimateArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub memory: MemoryArg,
}

/// Arguments of `status`.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The project folder
    pub project: PathBuf,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The project folder, on a disk that all machines share
    pub project: PathBuf,
    /// The scheduler that runs the jobs
    #[arg(long = "for", value_enum, value_name = "SCHEDULER")]
    pub scheduler: Scheduler,
    /// The folder to write the plan to, on the same disk: new or empty, or that of an earlier plan. Frames and exports go there, too
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Photos of a job
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = whole::<usize>(1..=1_000_000))]
    pub photos_per_job: usize,
    /// Also render these cameras or this flight, given as for `render --cameras`, to the folder `frames` of the plan
    #[arg(long, value_name = "CAMERAS")]
    pub frames: Option<PathBuf>,
    /// Frames of a job
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = whole::<usize>(1..=1_000_000))]
    pub frames_per_job: usize,
    /// Also make a layered depth image of each photo, in the project's cache
    #[arg(long)]
    pub ldi: bool,
    /// Also export each photo, to the folder `exports` of the plan
    #[arg(long)]
    pub exports: bool,
    /// Memory that a job may use for photos, such as 4G or 800M. It takes part in what is filled, so it is the same on all machines
    #[arg(long, value_name = "BYTES", value_parser = super::parse_bytes, default_value = "4G")]
    pub memory: u64,
    /// Cores of a job
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = whole::<u32>(1..=1024))]
    pub cores: u32,
}

/// The schedulers for which jobs are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Scheduler {
    /// Snakemake: a file `Snakefile`, for one machine or a cluster
    Snakemake,
    /// Open Job Description: a job template, for the farms that read it, or `openjd run`
    Openjd,
    /// OpenCue: a list of commands for each stage, and the script that submits them with `cuecmd`
    Cuecmd,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_parts_together_are_the_list_and_differ_by_one_at_most() {
        for (len, of) in [(6, 4), (25, 25), (10_000, 333), (3, 5), (usize::MAX / 2, 7)] {
            let parts = (1..=of).map(|number| Part { number, of }.range(len));
            let mut end = 0;
            let mut sizes = Vec::new();
            for part in parts {
                assert_eq!(part.start, end);
                end = part.end;
                sizes.push(part.len());
            }
            assert_eq!(end, len);
            assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn parts_and_frames_are_read_and_others_are_refused() {
        assert_eq!(Part::parse("3/40"), Ok(Part { number: 3, of: 40 }));
        for wrong in ["0/4", "5/4", "3", "a/b", "/", "3/", "-1/4"] {
            assert!(Part::parse(wrong).is_err(), "{wrong}");
        }
        let range = |text: &str, len| FramesArg::parse(text).unwrap().range(len).unwrap();
        assert_eq!((range("101-200", 150), range("7", 7), range("2/2", 5)), (100..150, 6..7, 2..5));
        for wrong in ["0", "9-3", "a", "3-", "5/4"] {
            assert!(FramesArg::parse(wrong).is_err(), "{wrong}");
        }
        assert!(FramesArg::parse("8-9").unwrap().range(7).is_err());
    }
}
