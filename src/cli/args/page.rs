//! Arguments of `export` for pages.

use clap::Args;

use quadratura_exports::page::{MOST_SIDE, PageOptions};

#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Pages (page)")]
pub struct PageArgs {
    /// The title of the page [default: that of `text about`]
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// The quality of JPEGs, from 1 to 100 [default: 80]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub quality: Option<u8>,
    /// The longest side of published photos, in pixels [default: 4096]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(64..=i64::from(MOST_SIDE)))]
    pub longest: Option<u32>,
    /// The size that the page should not exceed, in megabytes: where it would, those photos are published that together show most of
    /// the site well [default: 150]
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(1..))]
    pub budget: Option<u64>,
    /// Who is to be named below the page, such as photographers; may be given several times [default: those of `text about`]
    #[arg(long, value_name = "TEXT")]
    pub credit: Vec<String>,
    /// The licence of the photos: an SPDX name such as CC-BY-4.0, or the address of a text [default: that of `text about`]
    #[arg(long, value_name = "NAME|URL")]
    pub licence: Option<String>,
    /// The bookmark at which a visit starts [default: the first one, else the first photo]
    #[arg(long, value_name = "NAME")]
    pub viewpoint: Option<String>,
    /// Publish the names of photos, instead of p001, p002 and so on
    #[arg(long)]
    pub keep_names: bool,
    /// Publish the coordinates of the world, instead of those from the middle of the cameras
    #[arg(long)]
    pub keep_coordinates: bool,
    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,
}

impl PageArgs {
    /// Returns the options.
    pub fn options(&self, memory: u64) -> PageOptions {
        let usual = PageOptions::default();
        PageOptions {
            title: self.title.clone(),
            quality: self.quality.unwrap_or(usual.quality),
            longest: self.longest.unwrap_or(usual.longest),
            budget: self.budget.map_or(usual.budget, |megabytes| megabytes.saturating_mul(1_000_000)),
            credits: self.credit.clone(),
            licence: self.licence.clone(),
            viewpoint: self.viewpoint.clone(),
            keep_names: self.keep_names,
            keep_coordinates: self.keep_coordinates,
            memory,
        }
    }
}
