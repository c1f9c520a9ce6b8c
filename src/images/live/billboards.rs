//! Billboards that turn towards the camera: images are drawn without them, and the projective renderer draws them before the images.
//!
//! Each photo has its billboard in a place of its own, and a view of images would show each of them from the side.

use std::sync::Arc;

use rayon::prelude::*;

use super::rows::{drawn_rows, rows_of};
use crate::exposed_shot::ExposedShot;
use crate::site_view::laid_over;
use quadratura_base::error::Result;
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_ldi::Ldi;
use quadratura_projection::{Renders, shown_face};
use quadratura_view::srgb::Srgb;
use quadratura_view::{Picture, Shot, TreeMethod};

/// Returns an image without the billboards of a model that turn.
pub fn without_billboards(ldi: Arc<Ldi>, model: &Model) -> Arc<Ldi> {
    let turns =
        |name: &str| model.objects.iter().any(|object| object.name == name && object.impostor.is_some());
    let turning: Vec<bool> = ldi.surfaces.iter().map(|surface| turns(&surface.object)).collect();
    if !turning.contains(&true) {
        return ldi;
    }
    Arc::new(ldi.without_surfaces(&turning))
}

/// Billboards of a view that are drawn by the renderer.
pub struct Billboards {
    /// The billboards alone, with their alpha.
    picture: Picture,
    /// Where the view shows one, by pixel.
    is_shown: Vec<bool>,
}

impl Billboards {
    /// Draws the billboards of a view; `None` where it shows none. `faces` are the faces that it shows
    /// ([`Renders::seen_faces`]): billboards that something hides are not shown.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    pub fn drawn(
        renderer: &mut impl Renders,
        model: &Model,
        view: ExposedShot,
        faces: &[u32],
        task: &Task,
    ) -> Result<Option<Self>> {
        let ExposedShot { shot, exposure } = view;
        let turns = |number: &u32| shown_face(*number).is_some_and(|face| model.impostor(face).is_some());
        let is_shown: Vec<bool> = faces.par_iter().map(turns).collect();
        if !is_shown.contains(&true) {
            return Ok(None);
        }
        let is_other = |face| model.impostor(face).is_none() || shot.hidden.contains(face);
        let hidden = model.face_ids().filter(|face| is_other(*face)).collect();
        // Trees are drawn where no face is, and those before a billboard hide it.
        let alone =
            Shot { hidden, backs: false, surroundings: false, trees: TreeMethod::None, ..shot.clone() };
        let rows = rows_of(|mut row| row.any(|at| is_shown[at]), [shot.camera.width, shot.camera.height]);
        Ok(Some(Self {
            picture: drawn_rows(renderer, ExposedShot { shot: &alone, exposure }, rows, task)?,
            is_shown,
        }))
    }

    /// Returns whether the view shows a billboard at a pixel.
    pub fn is_shown(&self, at: usize) -> bool {
        self.is_shown[at]
    }

    /// Lays them over a view of images, and that over what is behind the images, where a billboard is shown; all other pixels are
    /// those of `view`.
    pub fn over(&self, view: &Picture, behind: Option<&Picture>) -> Picture {
        let srgb = Srgb::tables();
        let mixed = |at: usize| {
            let image = view.pixels()[at];
            if !self.is_shown[at] {
                return image;
            }
            let below = behind.map_or(image, |behind| laid_over(&image, &behind.pixels()[at], &srgb));
            laid_over(&self.picture.pixels()[at], &below, &srgb)
        };
        let rgba: Vec<[u8; 4]> = (0..self.is_shown.len()).into_par_iter().map(mixed).collect();
        Picture { rgba: rgba.into_flattened(), ..*view }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::geometry::Pinhole;
    use quadratura_base::scene::Object;
    use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
    use quadratura_ldi::synthetic::of_model;
    use quadratura_projection::exposure::ViewExposure;

    const LEAF: [u8; 4] = [0, 200, 0, 255];

    /// A wall at depth 4, a billboard before its middle at depth 2, and one behind it at depth 8.
    fn model(turns: bool) -> Arc<Model> {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(4.0, [-2.0, -2.0, 2.0, 2.0]);
        modeller.object("oak.billboard").screen(2.0, [-0.5, -1.0, 0.5, 1.0]);
        modeller.object("elm.billboard").screen(8.0, [-0.5, -1.0, 0.5, 1.0]);
        let is_tree = |object: &Object| turns && object.name.ends_with("billboard");
        let (model, refused) = (*modeller.finish()).clone().with_impostors(DVec3::NEG_Y, is_tree);
        assert!(refused.is_empty());
        Arc::new(model)
    }

    fn camera() -> Pinhole {
        centred(16, 16, 8.0)
    }

    /// Draws a leaf in each pixel, half of it where `x` is odd, and keeps what it was asked for.
    struct Leaves(Vec<Shot>);

    impl Renders for Leaves {
        fn picture(&mut self, shot: &Shot, _: &Task) -> Result<Picture> {
            self.0.push(shot.clone());
            let (width, height) = (shot.camera.width, shot.camera.height);
            let alpha = |at: u32| if at % width % 2 == 1 { 128 } else { 255 };
            let rgba = (0..width * height).flat_map(|at| [LEAF[0], LEAF[1], LEAF[2], alpha(at)]).collect();
            Ok(Picture { width, height, rgba })
        }

        fn faces(&mut self, shot: &Shot, _: &Task) -> Result<Vec<u32>> {
            Ok(vec![0; (shot.camera.width * shot.camera.height) as usize])
        }
    }

    #[test]
    fn images_lose_billboards_that_turn_and_keep_the_wall_behind_them() {
        let (model, solid) = (model(true), model(false));
        let mut image = of_model(&model, camera(), camera_is_world(), |_, _| LEAF);
        for (surface, object) in image.surfaces.iter_mut().zip(&model.objects) {
            surface.object.clone_from(&object.name);
        }
        let image = Arc::new(image);
        let of = |ldi: &Ldi, name: &str| {
            let level = &ldi.levels[0];
            let is_of = |index: &usize| match level.surfaces[*index] {
                0 => false,
                number => ldi.surfaces[usize::from(number) - 1].object == name,
            };
            (0..level.len()).filter(is_of).count()
        };
        assert!(of(&image, "oak.billboard") > 0 && of(&image, "elm.billboard") > 0);
        let without = without_billboards(image.clone(), &model);
        let left = ["oak.billboard", "elm.billboard", "wall"].map(|name| of(&without, name));
        assert_eq!(left, [0, 0, of(&image, "wall")]);
        assert!(Arc::ptr_eq(&without_billboards(image.clone(), &solid), &image), "nothing turns");
    }

    #[test]
    fn the_renderer_draws_billboards_alone_and_only_where_the_view_shows_one() {
        let (model, shot) = (model(true), Shot::new(camera(), camera_is_world()));
        let neutral = ViewExposure::neutral(1);
        let count = (camera().width * camera().height) as usize;
        // The faces are numbered in the order of the model, from 1.
        let faces_with = |number: u32, at: &[usize]| {
            let mut faces = vec![1; count];
            at.iter().for_each(|at| faces[*at] = number);
            faces
        };
        let mut leaves = Leaves(Vec::new());
        let view = ExposedShot { shot: &shot, exposure: &neutral };
        let drawn = Billboards::drawn(&mut leaves, &model, view, &vec![1; count], &Task::silent());
        assert!(drawn.unwrap().is_none() && leaves.0.is_empty(), "nothing is drawn where none is seen");
        let faces = faces_with(2, &[4, 5, 6]);
        let drawn = Billboards::drawn(&mut leaves, &model, view, &faces, &Task::silent());
        let billboards = drawn.unwrap().expect("a billboard is seen");
        let [asked] = &leaves.0[..] else { panic!("{} pictures", leaves.0.len()) };
        let hidden: Vec<u32> = asked.hidden.iter().map(|face| face.0).collect();
        assert_eq!((hidden, asked.surroundings, asked.trees), (vec![0], false, TreeMethod::None));
        // The image is red, and has a hole at pixel 6, behind which is blue.
        let (width, height) = (camera().width, camera().height);
        let whole = |colour: [u8; 4]| Picture { width, height, rgba: colour.repeat(count) };
        let (mut view, behind) = (whole([255, 0, 0, 255]), whole([0, 0, 255, 255]));
        view.rgba[4 * 6..4 * 7].fill(0);
        let mixed = billboards.over(&view, Some(&behind));
        assert_eq!((mixed.pixels()[3], mixed.pixels()[4]), ([255, 0, 0, 255], LEAF));
        let [red, green, blue, alpha] = mixed.pixels()[5];
        assert!(red > 150 && green > 100 && blue == 0 && alpha == 255, "{:?}", mixed.pixels()[5]);
        assert_eq!(mixed.pixels()[6], LEAF);
        view.rgba[4 * 5..4 * 6].fill(0);
        let [red, green, blue, _] = billboards.over(&view, Some(&behind)).pixels()[5];
        assert!(red == 0 && green > 100 && blue > 150, "{green} {blue}");
        assert_eq!(billboards.over(&view, None).pixels()[5][3], 128);
    }
}
