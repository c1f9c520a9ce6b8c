//! Makes a synthetic town: photos along its streets at one density, COLMAP's text files with tracks, and a coarse model with named
//! objects. The same arguments give the same bytes. `tests/scale.sh` measures how the program scales with it.
//!
//! ```sh
//! cargo run --release -p town -- OUT --photos 100
//! ```

mod colmap;
mod colours;
mod houses;
mod photo;
mod plan;

use std::error::Error;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use image::codecs::jpeg::JpegEncoder;
use quadratura_base::scene::synthetic::centred;
use rayon::prelude::*;

use self::plan::Plan;

/// The quality of the JPEG files.
const QUALITY: u8 = 92;

/// Makes a synthetic town of any number of photos
#[derive(Debug, Parser)]
#[command(name = "town")]
struct Arguments {
    /// The folder for photos/, sparse/ and town.obj; it is made
    out: PathBuf,
    /// The number of photos; their density is the same for all numbers
    #[arg(long, default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=20_000))]
    photos: u32,
    /// The width of the photos in pixels; the height is two thirds of it
    #[arg(long, default_value_t = 1500, value_parser = clap::value_parser!(u32).range(60..=12_000))]
    width: u32,
    /// Decides about houses, colours and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let Arguments { out, photos, width, seed } = Arguments::parse();
    let camera = centred(width, width * 2 / 3, 0.72 * f64::from(width));
    let plan = Plan::new(photos);
    let town = houses::build(&plan, seed);
    for folder in ["photos", "sparse"] {
        fs::create_dir_all(out.join(folder))?;
    }
    fs::write(out.join("town.obj"), town.obj())?;
    colmap::write(&out.join("sparse"), &town, &plan.stations, &camera, seed)?;
    let done = AtomicUsize::new(0);
    plan.stations.par_iter().enumerate().try_for_each(|(number, station)| {
        let picture = photo::taken(&town, station, &camera, seed.wrapping_add(number as u64));
        let file = BufWriter::new(File::create(out.join("photos").join(&station.name))?);
        JpegEncoder::new_with_quality(file, QUALITY).encode_image(&picture)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(25) || done == plan.stations.len() {
            eprintln!("{done} of {} photos", plan.stations.len());
        }
        Ok(())
    })
}
