//! Arguments about the pictures that commands render.

use std::path::PathBuf;

use clap::Args;

use crate::view_args::{parse_fps, parse_scale, parse_size};
use quadratura_base::error::Result;
use quadratura_files::writable::{check_file, check_folder};
use quadratura_io::film;
use quadratura_views::render::PictureFormat;

/// Where pictures are written, how large they are, and whether they become a video.
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// The folder to write to; camera 0001.jpg gives 0001.png, flights give frame-00001.png and so on
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Size of the pictures [default: the camera's]. Another aspect ratio keeps the vertical field of view
    /// and crops or extends left and right equally
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: Option<(u32, u32)>,
    /// Size of the pictures as a factor of the camera's width and height
    #[arg(long, value_name = "S", value_parser = parse_scale, conflicts_with = "size")]
    pub scale: Option<f64>,
    /// Write a video of all pictures; its name ends with .apng, or where ffmpeg is installed with .mp4,
    /// .webm, .gif or .webp. An existing file is replaced
    #[arg(long, value_name = "FILE")]
    pub video: Option<PathBuf>,
    /// Frames per second of a flight and of the video [default: the path's, else 25]
    #[arg(long, value_name = "N", value_parser = parse_fps)]
    pub fps: Option<f64>,
}

/// The formats of pictures.
pub const PICTURE_FORMATS: &[(&str, PictureFormat, &str)] = &[
    ("png", PictureFormat::Png, "PNG with 8 bits a channel, sRGB"),
    ("png16", PictureFormat::Png16, "PNG with 16 bits a channel, sRGB"),
    (
        "exr",
        PictureFormat::Exr,
        "OpenEXR: R, G, B and A as 16-bit floats in linear light, times alpha, and Z, the depth along the camera's axis",
    ),
];

impl PictureArgs {
    /// Checks where pictures and video go, before they are made.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a video of a kind that is not made, or not without ffmpeg; those of [`check_folder`] and [`check_file`].
    pub fn check_places(&self) -> Result<()> {
        check_folder(&self.out)?;
        let Some(video) = &self.video else { return Ok(()) };
        film::check(video)?;
        check_file(video)
    }
}
