//! Measures how often, how exactly and how quickly a model that was turned, scaled and shifted at random is aligned with its
//! photos again, and whether models of other sites are refused.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use glam::{DMat3, DQuat, DVec2, DVec3};

use quadratura_align::{Aligner, AlignmentAnswer, AlignmentCandidate};
use quadratura_base::geometry::{Pinhole, Pose, Similarity};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::scene::{Model, SparsePoint};
use quadratura_base::task::Task;

/// Turns, scales and shifts the models of sites at random, takes faces away, and aligns them again.
#[derive(Parser)]
struct Args {
    /// Folders of sites, each with `sparse` and one model: castle.gltf or model.obj
    sites: Vec<PathBuf>,
    /// Random similarities per site; the scale is from 10^-3 to 10^3
    #[arg(long, default_value_t = 10)]
    count: u64,
    /// The number of the first one: each has its own seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// The share of the faces that is taken away
    #[arg(long, default_value_t = 0.2)]
    without: f64,
    /// Also lay each model on the points of each other site, so many times
    #[arg(long, default_value_t = 0)]
    foreign: u64,
    /// Print each run
    #[arg(long)]
    each: bool,
}

struct Measured {
    name: String,
    model: Model,
    cameras: Vec<(Pinhole, Pose)>,
    points: Vec<SparsePoint>,
}

fn main() {
    let args = Args::parse();
    let sites: Vec<Measured> = args.sites.iter().map(|folder| read(folder)).collect();
    println!(
        "{:10} {:>5} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8}  {:>7} {:>7}  called aligned, several, foreign",
        "site", "runs", "first", "in 3", "px", "90 %", "worst", "E", "ratio", "s", "worst"
    );
    for site in &sites {
        measure(site, &args);
    }
    for (model, site) in sites.iter().flat_map(|model| sites.iter().map(move |site| (model, site))) {
        if args.foreign > 0 && model.name != site.name {
            measure_foreign(model, site, &args);
        }
    }
}

fn read(folder: &Path) -> Measured {
    let task = Task::silent();
    let cameras = quadratura_import::cameras::read_cameras(&folder.join("sparse"), &task).expect("cameras");
    let file =
        ["castle.gltf", "model.obj", "piazza.gltf", "model.gltf", "piazza.obj"].map(|name| folder.join(name));
    let file = file.into_iter().find(|file| file.exists()).expect("a model");
    let (model, _) = quadratura_import::models::read_model(&file, &task).expect("a model");
    Measured {
        name: folder.file_name().expect("a folder").to_string_lossy().into_owned(),
        model,
        cameras: cameras.photos.iter().map(|photo| (photo.camera, photo.pose)).collect(),
        points: cameras.points,
    }
}

/// Takes faces away and moves the rest; returns the true transform from the moved model to the world, too.
fn moved(model: &Model, without: f64, seed: u64) -> (Model, Similarity) {
    let mut rng = Rng::new(1000 + seed);
    let mut normal = || (-2.0 * (1.0 - rng.unit()).ln()).sqrt() * (std::f64::consts::TAU * rng.unit()).cos();
    let turn = DQuat::from_xyzw(normal(), normal(), normal(), normal()).normalize();
    let mut model = model.clone();
    for face in &mut model.faces {
        if rng.chance(without) {
            face.triangles = face.triangles.start..face.triangles.start;
        }
    }
    let scale = 10f64.powf(rng.between(-3.0, 3.0));
    let shift = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
    let there = Similarity { scale, rotation: DMat3::from_quat(turn), translation: shift * scale * 1000.0 };
    (model.transformed(&there), there.inverse())
}

struct Run {
    answer: Option<AlignmentAnswer>,
    found: Vec<AlignmentCandidate>,
    errors: Vec<f64>,
    seconds: f64,
}

fn run(model: &Model, site: &Measured, truth: Option<Similarity>) -> Run {
    let start = Instant::now();
    let aligner = Aligner::new(model, &site.cameras, &site.points);
    let (answer, found) = match &aligner {
        Ok(aligner) => {
            let (answer, found) = aligner.search(&Task::silent()).expect("nobody stops it");
            (Some(answer), found)
        }
        Err(_) => (None, Vec::new()),
    };
    let seconds = start.elapsed().as_secs_f64();
    let error = |found: &AlignmentCandidate| {
        truth.map_or(f64::INFINITY, |truth| {
            corner_error(model, &site.cameras, &truth, &found.world_from_model)
        })
    };
    let errors = found.iter().map(error).collect();
    Run { answer, found, errors, seconds }
}

/// The median distance of the model's corners in the photos from where they belong, in pixels of photos of 3072 pixels.
fn corner_error(model: &Model, cameras: &[(Pinhole, Pose)], truth: &Similarity, found: &Similarity) -> f64 {
    let mut errors = Vec::new();
    for (camera, pose) in cameras {
        let px = |similarity: &Similarity, corner: DVec3| -> Option<DVec2> {
            camera.image_from_camera(pose.camera_from_world(similarity.apply(corner)))
        };
        for face in model.face_ids().filter(|face| !model.face_triangles(*face).is_empty()) {
            for corner in model.ring_points(face) {
                let Some(right) = px(truth, corner) else { continue };
                let size = DVec2::new(camera.width.into(), camera.height.into());
                if right.cmplt(DVec2::ZERO).any() || right.cmpgt(size).any() {
                    continue;
                }
                let off = px(found, corner).map_or(f64::INFINITY, |px| px.distance(right));
                errors.push(off * 3072.0 / size.x);
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(f64::INFINITY)
}

const FOUND_PX: f64 = 50.0;

fn measure(site: &Measured, args: &Args) {
    let (mut first, mut in_three) = (0, 0);
    let (mut px, mut seconds, mut worths, mut ratios) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut called = [0; 3];
    for seed in args.first..args.first + args.count {
        let (model, truth) = moved(&site.model, args.without, seed);
        let run = run(&model, site, Some(truth));
        let at = run.errors.iter().position(|px| *px < FOUND_PX);
        first += u32::from(at == Some(0));
        in_three += u32::from(at.is_some_and(|at| at < 3));
        px.extend(at.map(|at| run.errors[at]));
        seconds.push(run.seconds);
        let score = |i: usize| run.found.get(i).map_or(0.0, |found| found.score);
        worths.push(score(0));
        ratios.push(score(0) / score(1).max(1e-9));
        if let Some(answer) = run.answer {
            called[answer as usize] += 1;
        }
        if args.each {
            let scores: Vec<String> = run.found.iter().map(|found| format!("{:.3}", found.score)).collect();
            let right =
                Aligner::new(&model, &site.cameras, &site.points).map_or(0.0, |a| a.judge(&truth).score);
            println!(
                "  {} {seed}: {:?} at {at:?} {:.1} px, {:.1} s, {} (truth {right:.3})",
                site.name,
                run.answer,
                at.map_or(f64::NAN, |at| run.errors[at]),
                run.seconds,
                scores.join(" ")
            );
        }
    }
    let sorted = |values: &mut Vec<f64>| values.sort_by(f64::total_cmp);
    [&mut px, &mut seconds, &mut worths, &mut ratios].into_iter().for_each(sorted);
    let at = |values: &[f64], share: f64| {
        values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{:10} {:5} {first:6} {in_three:6} {:8.1} {:8.1} {:8.1} {:8.3} {:8.2}  {:7.1} {:7.1}  {called:?}",
        site.name,
        args.count,
        at(&px, 0.5),
        at(&px, 0.9),
        at(&px, 1.0),
        at(&worths, 0.0),
        at(&ratios, 0.0),
        at(&seconds, 0.5),
        at(&seconds, 1.0)
    );
}

fn measure_foreign(model: &Measured, site: &Measured, args: &Args) {
    let mut called = [0; 3];
    let (mut worst, mut slowest) = ((0.0, 0.0), 0.0f64);
    for seed in 0..args.foreign {
        let (moved, _) = moved(&model.model, args.without, seed);
        let run = run(&moved, site, None);
        let score = |i: usize| run.found.get(i).map_or(0.0, |found| found.score);
        if score(0) > worst.0 {
            worst = (score(0), score(0) / score(1).max(1e-9));
        }
        slowest = slowest.max(run.seconds);
        if let Some(answer) = run.answer {
            called[answer as usize] += 1;
        }
    }
    println!(
        "model of {} on {}: highest score {:.3}, ratio {:.2}; {called:?}; {slowest:.1} s at most",
        model.name, site.name, worst.0, worst.1
    );
}
