//! The formats of other programs, by the names that are typed on the command line.

/// A format of other programs that a site is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandoverFormat {
    /// Cameras alone: COLMAP's text files, `transforms.json` and `cameras.json`.
    Cameras,
    /// A script that builds the site in Blender, with its data.
    Blender,
    /// The model with one set of textures in one file.
    Glb,
    /// The same as polygons in text.
    Obj,
    /// The same as a stage with cameras.
    Usd,
    /// The image layers of each photo as an OpenEXR file of several parts.
    Exr,
    /// A script for Nuke, with layers, geometry and cameras.
    Nuke,
}

impl HandoverFormat {
    /// All formats with their names and help texts.
    pub const TABLE: &'static [(&'static str, Self, &'static str)] = &[
        (
            "blender",
            Self::Blender,
            "The site for Blender 4.2 or newer: a script that builds it, with cameras, model and image layers",
        ),
        (
            "cameras",
            Self::Cameras,
            "Cameras of the undistorted photos: COLMAP's text files, transforms.json and a plain cameras.json",
        ),
        (
            "glb",
            Self::Glb,
            "The model with one set of textures, in one glTF 2.0 file: for viewers, engines and pages",
        ),
        ("obj", Self::Obj, "The model with one set of textures: Wavefront OBJ, MTL and pictures"),
        (
            "usd",
            Self::Usd,
            "The model with one set of textures and the photos' cameras: .usda with pictures, and .usdz",
        ),
        (
            "exr",
            Self::Exr,
            "Image layers for compositing: an OpenEXR file of several parts per photo, in linear light",
        ),
        (
            "nuke",
            Self::Nuke,
            "Experimental: a script for Nuke that projects the image layers of one photo at a time onto the model",
        ),
    ];

    /// Returns whether the format is a model with one set of textures.
    pub fn is_baked(self) -> bool {
        match self {
            Self::Glb | Self::Obj | Self::Usd => true,
            Self::Blender | Self::Cameras | Self::Exr | Self::Nuke => false,
        }
    }

    /// Returns whether pages can be tiles of one picture (UDIM); GLB has none, its pages are materials.
    pub fn has_tiles(self) -> bool {
        matches!(self, Self::Obj | Self::Usd)
    }

    /// Returns whether its folders follow the project (`live`): those whose files are image layers.
    pub fn is_live(self) -> bool {
        match self {
            Self::Blender | Self::Exr | Self::Nuke => true,
            Self::Cameras | Self::Glb | Self::Obj | Self::Usd => false,
        }
    }

    /// Returns the format with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::TABLE.iter().find(|(known, ..)| *known == name).map(|(_, format, _)| *format)
    }

    /// Returns the name in the window's lists.
    pub fn title(self) -> &'static str {
        match self {
            Self::Cameras => "Cameras",
            Self::Blender => "Blender",
            Self::Glb => "GLB",
            Self::Obj => "OBJ",
            Self::Usd => "USD",
            Self::Exr => "OpenEXR",
            Self::Nuke => "Nuke (experimental)",
        }
    }

    /// Returns what it is, for help.
    pub fn about(self) -> &'static str {
        Self::TABLE.iter().find(|(_, format, _)| *format == self).expect("the table has all formats").2
    }

    /// Returns the name that is typed on the command line.
    pub fn name(self) -> &'static str {
        Self::TABLE.iter().find(|(_, format, _)| *format == self).expect("the table has all formats").0
    }
}
