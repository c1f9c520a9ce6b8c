//! The table of the formats that are read.

use std::sync::OnceLock;

use super::bundler::Bundler;
use super::colmap::Colmap;
use super::format::CameraFormat;
use super::fspy::FSpy;
use super::meshroom::Meshroom;
use super::metashape::Metashape;
use super::mve::Mve;
use super::nvm::Nvm;
use super::openmvg::OpenMvg;
use super::opensfm::OpenSfm;
use super::pix4d::Pix4d;
use super::polycam::Polycam;
use super::realityscan::table::RealityTable;
use super::realityscan::xmp::RealityXmp;
use super::transforms::Transforms;

/// All formats. Of several in one folder, the first in this table is read.
static FORMATS: &[&dyn CameraFormat] = &[
    &Colmap,
    &Metashape,
    &Meshroom,
    &OpenSfm,
    &OpenMvg,
    &Transforms,
    &Nvm,
    &Bundler,
    &Pix4d,
    &Mve,
    &Polycam,
    &RealityTable,
    &RealityXmp,
    &FSpy,
];

static PLUGGED_IN: OnceLock<&dyn CameraFormat> = OnceLock::new();

/// Adds a format to the end of the table; the first one of a process counts. A test shows by it that a format needs nothing else.
pub fn plug_in(format: &'static dyn CameraFormat) {
    let _ = PLUGGED_IN.set(format);
}

/// The table, with the format that was plugged in.
pub(super) fn formats() -> impl Iterator<Item = &'static dyn CameraFormat> {
    FORMATS.iter().chain(PLUGGED_IN.get()).copied()
}

/// A format of the table. The order is that of the table: of two formats, the smaller one is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatId(usize);

impl FormatId {
    /// Returns all formats, in their order.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (0..formats().count()).map(Self)
    }

    /// Returns the format.
    pub(super) fn format(self) -> &'static dyn CameraFormat {
        formats().nth(self.0).expect("numbers are those of the table, which never gets shorter")
    }
}
