//! Checks of the names in options of filling.

use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_document::Project;
use quadratura_layers::fill::FillOptions;
use quadratura_layers::fill::options::matches_pattern;
use quadratura_sites::unknown_name::no_such;

/// Checks that the objects to leave unfilled and the photos whose paint is propagated exist.
///
/// # Errors
/// Returns [`Error::Request`] that names what does not exist.
pub fn check_options(project: &Project, site: &Site, options: &FillOptions) -> Result<()> {
    check_objects(project, site, options)?;
    check_painters(&site.photos, options)
}

/// Checks that the objects to leave unfilled exist.
fn check_objects(project: &Project, site: &Site, options: &FillOptions) -> Result<()> {
    let objects = site.model.objects.iter().map(|object| &object.name);
    // Removed objects are valid names, too; they are not filled in any case.
    let names: Vec<&String> = objects.chain(&project.objects_off).collect();
    let unknown = |pattern: &&String| {
        let alone = FillOptions { without: vec![(*pattern).clone()], ..FillOptions::default() };
        names.iter().all(|name| alone.fills(name))
    };
    let errors = options.without.iter().filter(unknown);
    let known = || names.iter().map(|name| name.as_str());
    let errors = errors.map(|name| no_such("object", name, known(), Some(Remedy::ListObjects)));
    Error::of_all(errors.collect()).map_or(Ok(()), Err)
}

/// Checks that the photos whose paint is propagated exist.
fn check_painters(photos: &[Photo], options: &FillOptions) -> Result<()> {
    let unknown = |pattern: &&String| !photos.iter().any(|photo| matches_pattern(&photo.name, pattern));
    let errors = options.propagate.patterns().iter().filter(unknown);
    let known = || photos.iter().map(|photo| photo.name.as_str());
    let errors = errors.map(|name| no_such("photo", name, known(), Some(Remedy::List)));
    Error::of_all(errors.collect()).map_or(Ok(()), Err)
}
