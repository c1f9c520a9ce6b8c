//! A first model from the photos, as a file of named polygons.

mod addition;
mod obj;
mod read;

pub use self::addition::{Added, Addition, add_to_model, free_name, model_hash, write_model_change};
pub use quadratura_suggest::edit::{is_bridge, with_edge_through};
pub use quadratura_suggest::planes::PlaneKind;
pub use quadratura_suggest::{SuggestedFace, SuggestedObject};

use std::path::{Path, PathBuf};

use serde::Serialize;

use self::obj::{is_ours, obj_text};
use self::read::{SuggestionSources, of_folders, of_opened, of_project, seen_points};
use crate::open::Opened;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::task::Task;
use quadratura_files::atomic::write_atomically;
use quadratura_import::cameras::CameraOptions;
use quadratura_import::meshes::{DenseMesh, read_mesh};
use quadratura_suggest::{Input, Reason, SourcePhoto, SourcePoint, points_of_mesh, suggest};

/// What a model is suggested for.
#[derive(Debug, Clone)]
pub enum SuggestFor {
    /// A project, or what its model does not explain.
    Project {
        /// The project's folder.
        folder: PathBuf,
        /// Whether the model stays, and only what it does not explain is suggested.
        add: bool,
    },
    /// Photos and cameras without a project.
    Folders {
        /// The folder of the photos.
        photos: PathBuf,
        /// The cameras: a file or a folder of one of the formats that are read.
        cameras: PathBuf,
        /// What is read of the cameras.
        options: CameraOptions,
    },
}

/// A suggestion as it was written.
#[derive(Debug)]
pub struct SuggestedModel {
    /// The objects.
    pub objects: Vec<SuggestedObject>,
    /// Faces that were dropped because they hardly show, or because photos are predicted better without them.
    pub dropped: usize,
    /// How well photos that are left out are predicted from the others, as PSNR in dB.
    pub psnr_db: f64,
    /// Photos that were used.
    pub photos: usize,
    /// Sparse points that were read.
    pub points: usize,
    /// Photos and entries of the cameras' files that could not be used, one error each.
    pub problems: Vec<Error>,
}

/// An object for programs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectFigures {
    /// The name.
    pub name: String,
    /// The number of faces.
    pub faces: usize,
    /// The number of corners.
    pub corners: usize,
    /// Sparse points on its plane.
    pub points: usize,
    /// The mean number of photos that show a place of it.
    pub photos_for: f64,
    /// The mean number of photos that see through a place of it.
    pub photos_against: f64,
    /// By how much it lowers the root mean square error of left-out photos where they show it, of 255; null where it is not known.
    pub gain: Option<f64>,
    /// How many of the photos that could confirm it do, 0 to 1.
    pub confidence: f64,
}

impl ObjectFigures {
    /// Collects the figures of an object.
    pub fn new(object: &SuggestedObject) -> Self {
        Self {
            name: object.name.clone(),
            faces: object.faces.len(),
            corners: object.faces.iter().map(|face| face.ring.len()).sum(),
            points: object.points,
            photos_for: object.photos_for,
            photos_against: object.photos_against,
            gain: object.gain,
            confidence: object.confidence(),
        }
    }
}

/// Checks that a suggestion may be written to a file: nothing is there, or with `replace` an unchanged suggestion of this program.
///
/// # Errors
/// [`Error::Input`] when another file is there, or one that was changed since; [`Error::Io`].
pub fn check_target(out: &Path, replace: bool) -> Result<()> {
    if out.symlink_metadata().is_err() {
        return Ok(());
    }
    let is_ours = is_ours(out)?;
    match (is_ours, replace) {
        (true, true) => Ok(()),
        (true, false) => Err(Error::input(
            out,
            "",
            "a suggested model is here already",
            "give --replace to write it anew, or another file with --out",
        )),
        (false, _) => Err(Error::input(
            out,
            "",
            "this file was not written by `model suggest`, or was changed since",
            "give another file with --out",
        )),
    }
}

/// Suggests a model from sparse points, or from a dense `mesh` in the cameras' coordinates, and writes it as an OBJ. The file has the cameras' coordinates; with `add`, those of the project's model, so
/// that the two can be joined.
///
/// # Errors
/// The errors of reading cameras, photos and, with `add`, the model; [`Error::Missing`] with the reason where nothing can be
/// suggested; the errors of [`check_target`]; [`Error::Cancelled`], after which no file is written.
pub fn write_suggestion(
    source: &SuggestFor,
    mesh: Option<&Path>,
    out: &Path,
    replace: bool,
    task: &Task,
) -> Result<SuggestedModel> {
    check_target(out, replace)?;
    let mesh = mesh.map(|file| Ok((file, read_mesh(file, task)?))).transpose()?;
    let sources = match source {
        SuggestFor::Project { folder, add } => of_project(folder, *add, task)?,
        SuggestFor::Folders { photos, cameras, options } => of_folders(photos, cameras, options, task)?,
    };
    let to_file = sources.given.as_ref().map(|given| given.world_from_model.inverse());
    let suggested = suggested(sources, mesh, task)?;
    let text = obj_text(&suggested.objects, &to_file.unwrap_or(Similarity::IDENTITY));
    check_target(out, replace)?;
    write_atomically(out, text.as_bytes())?;
    Ok(suggested)
}

/// Suggests what the model of an opened project in `folder` does not explain, in the cameras' world; nothing is written.
///
/// # Errors
/// The errors of reading cameras and photos; [`Error::Input`] with the reason where nothing is suggested; [`Error::Cancelled`].
pub fn suggest_missing(folder: &Path, opened: &Opened, task: &Task) -> Result<SuggestedModel> {
    suggested(of_opened(folder, opened, true, task)?, None, task)
}

/// Suggests from sparse points, or from what photos see of a mesh in their place.
fn suggested(
    sources: SuggestionSources,
    mesh: Option<(&Path, DenseMesh)>,
    task: &Task,
) -> Result<SuggestedModel> {
    let SuggestionSources { cameras, photos, given, problems } = sources;
    let names: Vec<&str> = photos.iter().map(|(name, _)| name.as_str()).collect();
    let seen: Vec<_> = photos.iter().map(|(_, photo)| photo.clone()).collect();
    let points = match mesh {
        Some((file, mesh)) => seen_of_mesh(file, mesh, &seen, task)?,
        None => seen_points(&cameras, &names),
    };
    let model = given.as_ref().map(|given| &*given.model);
    let input = Input { photos: &seen, points: &points, given: model };
    let suggestion =
        suggest(&input, task)?.map_err(|reason| nothing(reason, &cameras.file, seen.len(), points.len()))?;
    Ok(SuggestedModel {
        objects: suggestion.objects,
        dropped: suggestion.dropped,
        psnr_db: suggestion.psnr_db,
        photos: seen.len(),
        points: points.len(),
        problems,
    })
}

/// Returns points on a mesh with the photos that see them.
fn seen_of_mesh(
    file: &Path,
    mesh: DenseMesh,
    photos: &[SourcePhoto],
    task: &Task,
) -> Result<Vec<SourcePoint>> {
    let DenseMesh { vertices, triangles } = mesh;
    let corners = triangles.iter().map(|triangle| triangle.map(|vertex| vertices[vertex as usize])).collect();
    drop((vertices, triangles));
    let points = points_of_mesh(&Bvh::new(corners), photos, task)?;
    if points.is_empty() {
        let found = "no two photos see a part of it";
        let remedy = "export the mesh in the coordinates of the cameras, from the program that made both";
        return Err(Error::input(file, "", found, remedy));
    }
    Ok(points)
}

/// Says why nothing is suggested, and what to do.
fn nothing(reason: Reason, cameras: &Path, photos: usize, points: usize) -> Error {
    let (found, remedy) = match reason {
        Reason::FewPhotos => (
            format!("{photos} photo(s) can be used, and a model is suggested from two or more of one place"),
            "add photos from other viewpoints, or model what the photo shows by hand",
        ),
        Reason::NoPoints => (
            "no sparse points were read, and planes are found by them".to_owned(),
            "export the cameras together with their points (for COLMAP points3D.txt or points3D.bin, for Metashape the tie points)",
        ),
        Reason::OnePlace => (
            "all photos were taken from one place, so that no distance is known".to_owned(),
            "add photos from other viewpoints; a panorama alone has no depth",
        ),
        Reason::FewPoints => (
            format!(
                "fewer than 30 of {points} sparse points have a distance that two photos determine within 5 %"
            ),
            "add photos from other viewpoints, or align the photos again with more points",
        ),
        Reason::NoPlanes => (
            format!("the {points} sparse points lie on no plane that the photos confirm"),
            "add photos, or model the site by hand",
        ),
        Reason::AllExplained => {
            ("the model explains all that the photos show of planes".to_owned(), "nothing needs to be added")
        }
    };
    Error::input(cameras, "", format!("no model can be suggested: {found}"), remedy)
}
