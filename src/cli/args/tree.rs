//! Arguments of `tree`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand, ValueEnum};

use super::number::{degrees, whole};
use super::one_of::one_of;
use super::{PhotoArgs, PictureArgs, TreeExportArgs, TreeImportArgs};
use crate::view_args::OnOff;
use quadratura_document::trees::PlantAxis;
use quadratura_import::cameras::accepted;

#[derive(Debug, Args)]
pub struct TreeArgs {
    #[command(subcommand)]
    pub command: TreeCommand,
}

#[derive(Debug, Subcommand)]
pub enum TreeCommand {
    /// Show what a plant holds: sub-objects, polygons, bounds and materials
    Info(TreeInfoArgs),
    /// Render pictures of a plant, without a project
    Render(TreeRenderArgs),
    /// List the species and trees of a project
    List(TreeListArgs),
    /// Add, replace or remove a species of a project
    Species(TreeSpeciesArgs),
    /// Place trees in a project
    Place(TreePlaceArgs),
    /// Move, turn, resize or tint trees
    Move(TreeMoveArgs),
    /// Remove trees from a project
    Remove(TreeRemoveArgs),
    /// Show or set the light on the trees of a project
    Light(TreeLightArgs),
    /// Make the images from which the trees of a project are drawn
    Bake(TreeBakeArgs),
    /// Mask the real trees in the photos, where trees of the project stand
    Mask(TreeMaskArgs),
    /// Write a species as a layered file, to paint on it in an image editor: six views with a layer for each slab
    Export(TreeExportArgs),
    /// Import what was painted on exported species, list these imports, or undo the last one
    Import(TreeImportArgs),
}

/// A plant, and how it is grown.
#[derive(Debug, Args)]
pub struct PlantArgs {
    /// The plant: a file of the keyword format (.plant) or of glTF (.gltf, .glb), a species to be grown
    /// (.json), or `maple` or `oak` (for files of these names give ./maple)
    #[arg(value_name = "PLANT")]
    pub plant: PathBuf,
    /// Grow another plant of the species [default: the species' own number]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
}

#[derive(Debug, Args)]
pub struct TreeInfoArgs {
    #[command(flatten)]
    pub plant: PlantArgs,
}

#[derive(Debug, Args)]
pub struct TreeRenderArgs {
    #[command(flatten)]
    pub plant: PlantArgs,
    #[arg(long, value_name = "PATH", help = format!(
        "The viewpoints, in the plant's frame and unit: the word `orbit` for eight views around the plant, 600 x 600 unless \
         --size says otherwise (for a folder of that name give ./orbit), a camera path (.json), or cameras: {}",
        accepted()
    ))]
    pub cameras: PathBuf,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// How the plant is drawn
    #[arg(long, value_enum, default_value_t)]
    pub method: TreeMethod,
    /// Which images flakes are the texels of [default: slabs]
    #[arg(long, value_enum, value_name = "IMAGES")]
    pub flakes_of: Option<FlakesOf>,
    /// How fine pictures from images are: `preview` takes coarse images, with `--method layers` 4 surfaces in a pixel, and with `planes`
    /// an error of a pixel; `final` fine ones, 8 surfaces, and half a pixel
    #[arg(long, value_enum, default_value_t)]
    pub quality: TreeQuality,
    /// The most that a pixel of an image may take in the picture, in pixels [default: 0.8 of previews, 0.36 of final pictures]
    #[arg(long, value_name = "PIXELS", value_parser = length)]
    pub tau: Option<f64>,
    /// Keep the plant's images in this folder: they are read where they are up to date, and made where they are not [default: they
    /// are made anew and not kept]
    #[arg(long, value_name = "FOLDER")]
    pub images: Option<PathBuf>,
    /// Make the images of a sub-object from those of its parts instead of all its polygons, where they are not up to date: faster for
    /// plants of many polygons, and less accurate
    #[arg(long)]
    pub from_parts: bool,
    /// Draw each view by polygons, too, and say how like the pictures are, and how much longer that took
    #[arg(long)]
    pub compare: bool,
    /// Whether the plant casts shadows on itself, and its crown keeps light of sky and ground from what is inside [default: on;
    /// pictures from images have none]
    #[arg(long, value_enum, value_name = "ON|OFF")]
    pub shadows: Option<Shadows>,
    /// The direction from the plant to the sun, in the plant's frame [default: halfway up, towards x and -y where z is up]
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub sun: Option<[f64; 3]>,
}

#[derive(Debug, Args)]
pub struct TreeListArgs {
    /// The project folder
    pub project: PathBuf,
}

#[derive(Debug, Args)]
pub struct TreeSpeciesArgs {
    /// The project folder
    pub project: PathBuf,
    /// The name of the species
    pub name: String,
    /// The plant: a file of a format that `tree info` reads, or `maple` or `oak`
    #[arg(long, value_name = "PLANT", required_unless_present = "remove")]
    pub from: Option<PathBuf>,
    /// Grow another maple or oak [default: the species' own number]
    #[arg(long, value_name = "N", requires = "from", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
    /// What is up in the plant's frame [default: as its file says]
    #[arg(long, value_name = "AXIS", value_parser = one_of(AXES), allow_hyphen_values = true, requires = "from")]
    pub up: Option<PlantAxis>,
    /// The length of the plant's unit in world units [default: as its file says in metres]
    #[arg(long, value_name = "LENGTH", requires = "from", value_parser = length)]
    pub unit: Option<f64>,
    /// Remove the species; no tree may be of it
    #[arg(long, conflicts_with = "from")]
    pub remove: bool,
}

/// What is up in a plant's frame.
const AXES: &[(&str, PlantAxis, &str)] = &[
    ("x", PlantAxis::X, ""),
    ("y", PlantAxis::Y, ""),
    ("z", PlantAxis::Z, ""),
    ("-x", PlantAxis::MinusX, ""),
    ("-y", PlantAxis::MinusY, ""),
    ("-z", PlantAxis::MinusZ, ""),
];

/// Where and how large trees are.
#[derive(Debug, Args)]
pub struct TreeChangeArgs {
    /// The foot, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    pub at: Option<[f64; 3]>,
    /// The height above the foot, in world units
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub height: Option<f64>,
    /// The width of the crown, in world units
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub width: Option<f64>,
    /// The turn about what is up in degrees, against the clock as seen from above
    #[arg(long, value_name = "DEGREES", value_parser = degrees)]
    pub turn: Option<f64>,
    /// How much brighter than the species, in stops
    #[arg(long, value_name = "R,G,B", value_parser = three, allow_hyphen_values = true)]
    pub tint: Option<[f64; 3]>,
    /// Whether the tree's sun shadow darkens faces; `--casts` is `--casts=on` [default of new trees: on, and off for one that
    /// replaces an object, whose shadow the photos show; `move` leaves it as it is]
    #[arg(long, value_enum, value_name = "ON|OFF", num_args = 0..=1, require_equals = true, default_missing_value = "on")]
    pub casts: Option<Casts>,
}

/// Whether a tree casts a shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Casts {
    /// It darkens faces
    On,
    /// It does not
    Off,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("where").required(true).args(["at", "on", "list"]))]
pub struct TreePlaceArgs {
    /// The project folder
    pub project: PathBuf,
    /// The species: one of the project's (`tree species` adds them), `maple` or `oak`; with --list that of trees for which the
    /// list says none
    #[arg(required_unless_present = "list")]
    pub species: Option<String>,
    #[command(flatten)]
    pub change: TreeChangeArgs,
    /// Place a tree where this object of the model stands, as high and as wide, in its place (may be given several times; `*`
    /// stands for any characters)
    #[arg(long, value_name = "OBJECT", conflicts_with = "name")]
    pub on: Vec<String>,
    /// Place the trees of a list: CSV with the columns name, species, x, y, height, crown and casts (yes or no), of which x and y
    /// are needed; feet stand on the model's highest surface there. Either all are placed or none
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    pub list: Option<PathBuf>,
    /// The tree's name [default: the species' with a number]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
}

#[derive(Debug, Args)]
pub struct TreeMoveArgs {
    /// The project folder
    pub project: PathBuf,
    /// The trees by name (`*` stands for any characters)
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
    #[command(flatten)]
    pub change: TreeChangeArgs,
    /// How far the foot moves, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true, conflicts_with = "at")]
    pub by: Option<[f64; 3]>,
    /// Another species
    #[arg(long, value_name = "SPECIES")]
    pub species: Option<String>,
}

#[derive(Debug, Args)]
pub struct TreeRemoveArgs {
    /// The project folder
    pub project: PathBuf,
    /// The trees by name (`*` stands for any characters)
    #[arg(required = true, value_name = "NAME")]
    pub names: Vec<String>,
}

#[derive(Debug, Default, Args)]
pub struct TreeLightArgs {
    /// The project folder
    pub project: PathBuf,
    /// The direction to the sun, in the world
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub sun: Option<[f64; 3]>,
    /// The direction to the sun from two points of the world: the tip of a shadow, and what casts it
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", value_parser = two_points, allow_hyphen_values = true, conflicts_with = "sun")]
    pub shadow: Option<[[f64; 3]; 2]>,
    /// Estimate what sun, sky and ground give from the photos, instead of what was set before
    #[arg(long, conflicts_with_all = ["sun_light", "sky_light", "ground_light"])]
    pub estimate: bool,
    /// What a white surface reflects that faces the sun: linear light in the photos' common exposure, where 1 is the brightest
    /// light of a picture
    #[arg(long, value_name = "R,G,B", value_parser = three, allow_hyphen_values = true)]
    pub sun_light: Option<[f64; 3]>,
    /// The same of the sky on a surface that looks up
    #[arg(long, value_name = "R,G,B", value_parser = three, allow_hyphen_values = true)]
    pub sky_light: Option<[f64; 3]>,
    /// The same of the ground on a surface that looks down
    #[arg(long, value_name = "R,G,B", value_parser = three, allow_hyphen_values = true)]
    pub ground_light: Option<[f64; 3]>,
    /// Whether trees are as bright and coloured as photos show them, where they are seen from near these: photos in which
    /// `tree mask` masked them [at first: on]
    #[arg(long, value_enum, value_name = "ON|OFF")]
    pub photos: Option<OnOff>,
    /// Forget what was set before: the sun is that of a clear day, the rest is estimated, and trees match the photos
    #[arg(long)]
    pub reset: bool,
}

#[derive(Debug, Args)]
pub struct TreeBakeArgs {
    /// The project folder
    pub project: PathBuf,
    /// Only this species (may be given several times)
    #[arg(long, value_name = "NAME")]
    pub species: Vec<String>,
    /// Make images that are up to date anew, too
    #[arg(long)]
    pub force: bool,
    /// Make the images of a sub-object from those of its parts instead of all its polygons: faster for plants of many polygons,
    /// and less accurate. Images that are up to date stay, unless --force is given
    #[arg(long)]
    pub from_parts: bool,
}

#[derive(Debug, Args)]
pub struct TreeMaskArgs {
    /// The project folder
    pub project: PathBuf,
    /// The trees by name (`*` stands for any characters) [default: all]
    #[arg(value_name = "NAME")]
    pub trees: Vec<String>,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Also mask pixels within this distance, because trees are not quite like the real ones
    #[arg(long, value_name = "PX", default_value_t = 24, value_parser = whole::<u32>(0..=4096))]
    pub margin: u32,
}

fn two_points(text: &str) -> Result<[[f64; 3]; 2], String> {
    let expected = "expected two points with a colon between them, such as 1.5,0,0:1,0.5,6";
    let (tip, top) = text.split_once(':').ok_or(expected)?;
    Ok([three(tip).map_err(|_| expected)?, three(top).map_err(|_| expected)?])
}

fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.map(<[f64; 3]>::try_from) {
        Ok(Ok(numbers)) if numbers.iter().all(|number: &f64| number.is_finite()) => Ok(numbers),
        _ => Err("expected three numbers with commas between them, such as 1.5,0,-2".into()),
    }
}

fn direction(text: &str) -> Result<[f64; 3], String> {
    let direction = three(text)?;
    let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        Ok(direction)
    } else {
        Err("expected a direction: three numbers, not all 0, and none beyond 1e150".into())
    }
}

fn length(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|length: &f64| *length > 0.0 && length.is_finite());
    number.ok_or_else(|| "expected a length above 0".into())
}

/// How plants are drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum TreeMethod {
    /// Every polygon of every instance, with 16 sub-pixels a pixel
    #[default]
    Polygons,
    /// From images of its sub-objects from 22 directions with several surfaces in a pixel, which are made first (Max 1996)
    Layers,
    /// From images of slabs from six directions, each pixel on the nearest of many planes (Max, Deussen & Keating 1999)
    Planes,
    /// From the same images, each pixel as a small leaning piece of surface at its own depth: faster than layers, and finer and faster than planes
    Flakes,
}

/// Which images flakes are the texels of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FlakesOf {
    /// Those of slabs, from six directions: smaller, and faster to make and to draw
    Slabs,
    /// Those of `--method layers`, from 22 directions: finer
    Layers,
}

/// How fine pictures from images are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum TreeQuality {
    /// Coarse and fast
    Preview,
    /// Fine
    #[default]
    Final,
}

/// Whether plants have shadows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Shadows {
    /// Shadows
    On,
    /// Sun, sky and ground light everything
    Off,
}
