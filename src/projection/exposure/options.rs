//! Options of the estimation of gains.

/// What is done about the darkening of corners by lenses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Vignetting {
    /// Nothing.
    Ignored,
    /// It is removed from photos before they are blended; views have none.
    Removed,
    /// It is removed from photos before they are blended, and views get that of the lenses of the photos that they show, if
    /// left-out photos are predicted better so; else it is ignored.
    #[default]
    Kept,
}

/// Options of the estimation of gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposureOptions {
    /// The number of surface points looked for in a photo, on a regular grid.
    pub points_per_photo: u32,
    /// Half the side of the square over which a colour is averaged, in pixels of the photo.
    pub half_patch_px: f64,
    /// The additional width, in pixels of the photo, in which the surface around a patch has to be visible:
    /// edges of a coarse model are off by a few pixels, and lenses and noise filters smear.
    pub border_px: f64,
    /// What is done about vignetting.
    pub vignetting: Vignetting,
    /// True when the offset of each photo, light added everywhere, is estimated.
    pub offset: bool,
}

impl Default for ExposureOptions {
    fn default() -> Self {
        Self {
            points_per_photo: 384,
            half_patch_px: 6.0,
            border_px: 6.0,
            vignetting: Vignetting::Ignored,
            offset: false,
        }
    }
}
