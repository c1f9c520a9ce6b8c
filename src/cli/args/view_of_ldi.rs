//! Arguments of `render` and `score` about views from layered depth images.

use clap::{Args, ValueEnum};

use super::ldi::{CombinedArgs, LdiFrom, SPLATS, refuse};
use super::one_of::one_of;
use crate::bytes::parse_bytes;
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_images::StackLdiOptions;
use quadratura_images::site_view::{LdiViewOptions, LdiViewSource};
use quadratura_ldi::{Spacing, SplatKind};
use quadratura_sites::budget::default_memory;

/// How `render` and `score` make views.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Views from layered depth images")]
pub struct AsArgs {
    /// How views are made: the photos projected onto the model; or by moving the pixels of a layered depth image, or of the
    /// best photo's depth image alone
    #[arg(long = "as", value_name = "WHAT", value_enum, default_value_t)]
    pub as_what: AsArg,
    /// What layered depth images are made from: the image layers of the best photos, or the whole site in the cameras of these
    /// photos; each image is moved by itself and blended [default: stack]
    #[arg(long, value_enum)]
    pub from: Option<LdiFrom>,
    /// How a depth pixel of one image is drawn; images that are blended are summed [default: sums; with --published over]
    #[arg(long, value_parser = one_of(SPLATS))]
    pub splat: Option<SplatKind>,
    #[command(flatten)]
    pub combined: CombinedArgs,
    /// Memory for images that later views may use again, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes, allow_hyphen_values = true)]
    pub memory: Option<u64>,
}

/// What views are made with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum AsArg {
    /// The photos projected onto the model
    #[default]
    Model,
    /// Layered depth images
    Ldi,
    /// The depth image of the photo that shows most of the view
    Photo,
}

impl AsArgs {
    /// Returns in words what views are made with, as on the command line.
    pub fn name(&self) -> String {
        let Self { as_what, combined, from, .. } = self;
        match as_what {
            AsArg::Model => "model".into(),
            AsArg::Photo => "photo".into(),
            AsArg::Ldi if combined.published => "ldi, published".into(),
            AsArg::Ldi => format!("ldi of {}", from.unwrap_or_default().name()),
        }
    }

    /// Returns how views are made from layered depth images; `None` for the projective renderer.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for an unknown photo, and [`quadratura_base::Error::Usage`] for arguments that have no effect.
    pub fn options(&self, stack: StackLdiOptions, site: &Site) -> Result<Option<LdiViewOptions>> {
        let published = self.combined.published;
        if self.as_what != AsArg::Ldi {
            let given = [
                (self.from.is_some(), "--from"),
                (self.memory.is_some(), "--memory"),
                (published, "--published"),
            ];
            refuse(&given, "--as ldi")?;
            self.combined.refuse_choice("--as ldi")?;
        }
        let is_of_site = self.from == Some(LdiFrom::Site);
        if is_of_site {
            self.combined.refuse_of_merging()?;
        } else if !published {
            self.combined.refuse_of_photos()?;
        }
        if !published && self.as_what != AsArg::Photo {
            refuse(&[(self.splat.is_some(), "--splat")], "--as photo or --published")?;
        }
        let source = match self.as_what {
            AsArg::Model => return Ok(None),
            AsArg::Photo => LdiViewSource::Photo,
            AsArg::Ldi if published => LdiViewSource::Photos(self.combined.options(stack)),
            AsArg::Ldi if is_of_site => LdiViewSource::Site(self.combined.site_options(stack)),
            AsArg::Ldi => LdiViewSource::Stacks,
        };
        let usual = if published { SplatKind::Over } else { SplatKind::Sums };
        let source_is_stacks = source == LdiViewSource::Stacks;
        Ok(Some(LdiViewOptions {
            source,
            stack,
            best: self.combined.best(if source_is_stacks { 5 } else { 3 }),
            with: self.combined.with(site)?,
            splat: self.splat.unwrap_or(usual),
            memory: self.memory.unwrap_or_else(default_memory),
            spacing: if published { Spacing::Table } else { Spacing::Exact },
            shown: None,
        }))
    }
}
