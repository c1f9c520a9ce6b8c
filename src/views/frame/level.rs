//! The up direction of a site.

use glam::{DMat3, DVec3};

use super::named::{area_vector, faces_named};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Edges, Model, up};
use quadratura_document::frame::Stated;
use quadratura_sites::open::Opened;

/// What the up direction is taken from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Level {
    /// The model's upright edges.
    #[default]
    Verticals,
    /// The mean up direction of the cameras.
    Cameras,
    /// These faces: level ones and upright ones.
    Faces(Vec<String>),
}

/// The cosine of the largest angle to the cameras' up direction, 15 degrees, at which an edge can be upright, and the same of edges that
/// take part, 3 degrees from what the first found.
const UPRIGHT: [f64; 2] = [0.965_925_826_289_068_3, 0.998_629_534_754_573_9];

/// The share that the cameras' up direction has where faces leave a direction open: of walls that are all parallel.
const PRIOR: f64 = 1e-6;

/// The steps of the iteration, which gains a factor of two at least in each where walls have two directions.
const STEPS: usize = 200;

/// Finds the up direction.
///
/// # Errors
/// Returns [`Error::Request`] where the model has no upright edges, and for faces that do not exist or are neither level nor upright.
pub fn leveled(opened: &Opened, level: &Level) -> Result<Stated<[f64; 3]>> {
    let model = &opened.site.model;
    let of_cameras = up(&opened.site.photos);
    let (direction, from) = match level {
        Level::Cameras => (of_cameras, "the mean up direction of the cameras".to_owned()),
        Level::Verticals => of_verticals(model, of_cameras)?,
        Level::Faces(names) => of_faces(model, of_cameras, names)?,
    };
    Ok(Stated { value: direction.to_array(), from })
}

/// Returns the up direction of a site: its frame's, else that of the model's upright edges, else that of the cameras.
pub fn up_of(opened: &Opened) -> DVec3 {
    let of_frame = opened.project.frame.up.as_ref().map(|up| DVec3::from_array(up.value));
    let of_cameras = up(&opened.site.photos);
    let of_model = || of_verticals(&opened.site.model, of_cameras).map_or(of_cameras, |(up, _)| up);
    of_frame.unwrap_or_else(of_model)
}

/// Returns the mean direction of the model's upright edges, by length.
fn of_verticals(model: &Model, of_cameras: DVec3) -> Result<(DVec3, String)> {
    let edges = Edges::from_model(model);
    let sides = edges.all().iter().map(|&[a, b]| model.vertices[b as usize] - model.vertices[a as usize]);
    let sides: Vec<DVec3> = sides.filter(|side| side.length() > 0.0).collect();
    let (mut direction, mut count) = (of_cameras, 0);
    for least in UPRIGHT {
        let near = sides.iter().map(|side| *side * side.dot(direction).signum());
        let near: Vec<DVec3> = near.filter(|side| side.dot(direction) >= least * side.length()).collect();
        count = near.len();
        direction = near.iter().sum::<DVec3>().try_normalize().ok_or_else(|| {
            let found = "the model has no edge within 15 degrees of the cameras' up direction";
            Error::Request(format!("{found}; give --level cameras, or the names of level or upright faces"))
        })?;
    }
    Ok((direction, format!("{count} upright edges of the model")))
}

/// Returns the direction that is most nearly the normal of level faces and at right angles to the normals of upright ones, by area.
fn of_faces(model: &Model, of_cameras: DVec3, names: &[String]) -> Result<(DVec3, String)> {
    let mut sum = DMat3::ZERO;
    let mut all = 0.0;
    for name in names {
        for face in faces_named(model, name)? {
            let area = area_vector(model, face);
            let Some(normal) = area.try_normalize() else { continue };
            let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            let share = area.length() * if normal.dot(of_cameras).abs() > 0.5f64.sqrt() { 1.0 } else { -1.0 };
            sum += outer * share;
            all += area.length();
        }
    }
    if all <= 0.0 {
        return Err(Error::Request(format!("{}: these faces have no area; name others", names.join(", "))));
    }
    let c = of_cameras;
    sum += DMat3::from_cols(c * c.x, c * c.y, c * c.z) * (PRIOR * all);
    // The largest eigenvector; all eigenvalues become positive.
    sum += DMat3::IDENTITY * all;
    let mut direction = of_cameras;
    for _ in 0..STEPS {
        direction = (sum * direction).normalize();
    }
    Ok((direction, format!("the faces {}", names.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    /// A house whose walls lean with the whole world by six degrees.
    fn tilted() -> (Model, DVec3) {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 0.1);
        let at = |x: f64, y: f64, z: f64| turn * DVec3::new(x, y, z);
        let mut modeller = Modeller::new();
        let house = modeller.object("house");
        house.polygon(&[at(0., 0., 0.), at(4., 0., 0.), at(4., 0., 3.), at(0., 0., 3.)]);
        house.polygon(&[at(4., 0., 0.), at(4., 5., 0.), at(4., 5., 3.), at(4., 0., 3.)]);
        let floor = modeller.object("floor");
        floor.polygon(&[at(0., 0., 0.), at(4., 0., 0.), at(4., 5., 0.), at(0., 5., 0.)]);
        (Model::clone(&modeller.finish()), turn * DVec3::Z)
    }

    #[test]
    fn verticals_walls_and_floors_all_say_what_is_up() {
        let (model, expected) = tilted();
        let (found, from) = of_verticals(&model, DVec3::Z).unwrap();
        assert!((found - expected).length() < 1e-9, "{found} from {from}");
        // Both walls have two; faces of the modeller share no vertices.
        assert!(from.starts_with('4'), "{from}");
        for names in
            [vec!["house".to_owned()], vec!["floor".to_owned()], vec!["house[0]".into(), "floor".into()]]
        {
            let (found, _) = of_faces(&model, DVec3::Z, &names).unwrap();
            assert!((found - expected).length() < 1e-5, "{found} of {names:?}");
        }
    }

    #[test]
    fn one_wall_alone_leaves_the_rest_to_the_cameras() {
        let (model, _) = tilted();
        let (found, _) = of_faces(&model, DVec3::Z, &["house[0]".to_owned()]).unwrap();
        let normal = model.face(quadratura_base::scene::FaceId(0)).plane.normal;
        assert!(found.dot(normal).abs() < 1e-3 && found.z > 0.99, "{found}");
    }
}
