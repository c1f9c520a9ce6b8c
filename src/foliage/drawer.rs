//! Draws the polygons of a plant onto a canvas: every instance in view, in the order of the plant, as fragments of pixels with
//! what is needed to light them.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};

use super::clip::clipped;
use super::facet::Facet;
use super::mesh::{Mesh, Meshes};
use super::paint::{Change, PaintAt};
use super::pixels::Pixels;
use super::plant::{Plant, Use};
use super::primitive::{Corner, Material};
use super::raster::{Fragment, ImageCorner, Target, rasterise, share_in_pixel};
use super::seed::mixed;
use super::stipple::Stipple;
use super::view::{HalfSpace, Projection, View, normal_map};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;

/// What is drawn on: it keeps what it wants of the fragments that it gets.
pub(super) trait FragmentCanvas {
    /// Returns the sub-pixels of a fragment that are kept, as far as is known without its colour; 0 leaves it out.
    fn visible(&self, fragment: &Fragment) -> u16;
    /// Keeps a fragment of which only the nearness matters and returns true; false asks for its surface.
    #[inline]
    fn cover(&mut self, _fragment: &Fragment) -> bool {
        false
    }
    /// Keeps these sub-pixels of a fragment.
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet);
}

/// A corner of the present instance, in the view's frame and, where it has one, in the image.
#[derive(Clone, Copy)]
struct ProjectedCorner {
    position: DVec3,
    image: Option<ImageCorner>,
}

/// A triangle of the present instance's mesh.
struct MeshTriangle<'a> {
    corners: [&'a Corner; 3],
    /// Where the corners are in the view's frame.
    positions: [DVec3; 3],
}

/// Draws instances onto a canvas.
pub(super) struct Drawer<'a, C> {
    plant: &'a Plant,
    meshes: &'a Meshes,
    view: &'a View,
    half_spaces: Vec<HalfSpace>,
    target: Target,
    /// What is drawn on.
    pub canvas: C,
    corners: Vec<ProjectedCorner>,
    /// The triangles that were projected.
    pub triangles: u64,
    task: &'a Task,
}

impl<'a, C: FragmentCanvas> Drawer<'a, C> {
    /// Prepares the drawing of a rectangle of a view; `meshes` are those of the plant's sub-objects that are drawn.
    pub fn new(
        plant: &'a Plant,
        meshes: &'a Meshes,
        view: &'a View,
        rect: PixelRect,
        canvas: C,
        task: &'a Task,
    ) -> Self {
        Self {
            plant,
            meshes,
            view,
            half_spaces: view.projection.half_spaces(&rect),
            target: Target { bounds: rect, perspective: view.projection.is_perspective() },
            canvas,
            corners: Vec::new(),
            triangles: 0,
            task,
        }
    }

    /// Draws an instance with all that it uses, in the order of the plant, unless its ball is out of view.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn visit(&mut self, object: usize, view_from_object: &DAffine3) -> Result<()> {
        let plant = self.plant;
        let of = &plant.objects[object];
        let ball = of.bounds.ball.mapped(view_from_object);
        if of.counts.triangles == 0 || !self.half_spaces.iter().all(|half_space| half_space.touches(&ball)) {
            return Ok(());
        }
        self.task.check_cancelled()?;
        self.own(object, 0, view_from_object, &Stipple::wide(0));
        for Use { child, parent_from_child } in &of.uses {
            self.visit(*child, &(*view_from_object * *parent_from_child))?;
        }
        Ok(())
    }

    /// Draws the primitives that an instance of a sub-object has of its own, at a level of detail, where a stipple is open.
    pub fn own(&mut self, object: usize, level: usize, view_from_object: &DAffine3, stipple: &Stipple) {
        let (meshes, plant) = (self.meshes, self.plant);
        for mesh in meshes.get(object, level) {
            self.mesh(mesh, stipple, &plant.objects[object].paint, view_from_object);
        }
    }

    fn mesh(&mut self, mesh: &Mesh, stipple: &Stipple, paint: &[PaintAt], view_from_object: &DAffine3) {
        let projection = &self.view.projection;
        self.corners.clear();
        self.corners.extend(mesh.corners.iter().map(|corner| {
            let position = view_from_object.transform_point3(corner.position);
            ProjectedCorner { position, image: image_corner(projection, position) }
        }));
        self.triangles += mesh.triangles.len() as u64;
        let painter = TrianglePainter {
            projection,
            material: &mesh.material,
            paint,
            stipple: Some(stipple).filter(|stipple| !stipple.is_wide()),
            view_from_normal: normal_map(&view_from_object.matrix3),
        };
        // Written out: closures over arrays stay calls in builds that do not optimise across functions.
        for &[a, b, c] in &mesh.triangles {
            let (a, b, c) = (a as usize, b as usize, c as usize);
            let (p, q, r) = (self.corners[a], self.corners[b], self.corners[c]);
            let triangle = MeshTriangle {
                corners: [&mesh.corners[a], &mesh.corners[b], &mesh.corners[c]],
                positions: [p.position, q.position, r.position],
            };
            match (p.image, q.image, r.image) {
                (Some(p), Some(q), Some(r)) => {
                    painter.paint(&mut self.canvas, &self.target, [p, q, r], &|w| w, &triangle);
                }
                _ => self.clipped(&painter, &triangle),
            }
        }
    }

    /// Draws what is left of a triangle that reaches out of what can be projected.
    fn clipped(&mut self, painter: &TrianglePainter, triangle: &MeshTriangle) {
        let left = clipped(triangle.positions, &self.half_spaces);
        let image = |position| {
            let (px, nearness) = self.view.projection.image_from_view(position);
            ImageCorner::new(px, nearness)
        };
        for i in 2..left.len() {
            let fan = [left[0], left[i - 1], left[i]];
            let weights = DMat3::from_cols(fan[0].weights, fan[1].weights, fan[2].weights);
            if let [Some(a), Some(b), Some(c)] = fan.map(|corner| image(corner.position)) {
                painter.paint(&mut self.canvas, &self.target, [a, b, c], &|w| weights * w, triangle);
            }
        }
    }
}

/// Returns a point in the image; `None` where it has to be clipped.
#[inline]
fn image_corner(projection: &Projection, position: DVec3) -> Option<ImageCorner> {
    let (px, nearness) = projection.image_from_view(position);
    ImageCorner::new(px, nearness).filter(|_| projection.is_ahead(position))
}

/// What colours the triangles of an instance's mesh.
struct TrianglePainter<'a> {
    projection: &'a Projection,
    material: &'a Material,
    /// The paint on the sub-object.
    paint: &'a [PaintAt],
    /// Where it is drawn in a part of the sub-pixels.
    stipple: Option<&'a Stipple>,
    view_from_normal: DMat3,
}

impl TrianglePainter<'_> {
    /// Draws what is left of a triangle between these corners of the image; `weights` gives those of the triangle's corners from those
    /// of `corners`.
    #[inline]
    fn paint(
        &self,
        canvas: &mut impl FragmentCanvas,
        target: &Target,
        corners: [ImageCorner; 3],
        weights: &dyn Fn(DVec3) -> DVec3,
        triangle: &MeshTriangle,
    ) {
        let texture = |w: DVec3| -> DVec2 {
            let w = weights(w);
            let [a, b, c] = triangle.corners;
            w.x * a.texture + w.y * b.texture + w.z * c.texture
        };
        let Material { picture, cutout, wrap, .. } = self.material;
        let keeps = picture
            .as_ref()
            .zip(*cutout)
            .map(|(pixels, cutout)| move |w: DVec3| pixels.alpha(texture(w), *wrap) >= cutout);
        let keeps = keeps.as_ref().map(|keeps| keeps as &dyn Fn(DVec3) -> bool);
        let mut put = |fragment: &Fragment, change: Option<&Change>| {
            if canvas.cover(fragment) {
                return;
            }
            let visible = canvas.visible(fragment);
            if visible == 0 {
                return;
            }
            let of_picture = picture.as_ref().map_or(Vec3::ONE, |pixels| {
                let share = share_in_pixel(target.perspective, &corners, fragment.middle);
                let area = share * area_in_picture(pixels, [DVec3::X, DVec3::Y, DVec3::Z].map(texture));
                pixels.light(texture(fragment.weights), *wrap, area)
            });
            let facet = self.facet(weights(fragment.weights), of_picture, triangle);
            canvas.put(fragment, visible, &change.map_or(facet, |change| facet.painted(change)));
        };
        rasterise(target, corners, keeps, |whole| {
            let open = self.stipple.map(|stipple| whole.within(stipple.open_at(whole.x, whole.y)));
            let fragment = match &open {
                None => whole,
                Some(Some(left)) => left,
                Some(None) => return,
            };
            if self.paint.is_empty() {
                return put(fragment, None);
            }
            let change = self.change(weights(fragment.weights), triangle.corners);
            let open = Stipple::open(f64::from(change.alpha), seed_of(triangle.corners))
                .open_at(fragment.x, fragment.y);
            match fragment.within(open) {
                Some(left) if left.mask == fragment.mask => put(fragment, Some(&change)),
                Some(left) => put(&left, Some(&change)),
                None => (),
            }
        });
    }

    /// Returns what paint changes at a triangle's point.
    fn change(&self, w: DVec3, of: [&Corner; 3]) -> Change {
        let point = w.x * of[0].position + w.y * of[1].position + w.z * of[2].position;
        let at = |paint: &PaintAt| {
            paint.field.at(paint.field_from_object.transform_point3(point), self.material.leaf)
        };
        self.paint.iter().map(at).fold(Change::NONE, |all, change| all.then(&change))
    }

    /// Returns the surface at a triangle's point, whose picture has the light `of_picture` there.
    #[inline]
    fn facet(&self, w: DVec3, of_picture: Vec3, triangle: &MeshTriangle) -> Facet {
        let mean = |value: [DVec3; 3]| w.x * value[0] + w.y * value[1] + w.z * value[2];
        let Material { reflected, through, leaf, .. } = self.material;
        let mut normal =
            (self.view_from_normal * mean(triangle.corners.map(|corner| corner.normal))).normalize_or_zero();
        let looks_away = normal.dot(self.projection.towards_viewer(mean(triangle.positions))) < 0.0;
        if *leaf && looks_away {
            normal = -normal;
        }
        Facet {
            normal,
            is_back: !*leaf && looks_away,
            reflected: of_picture * Vec3::from_array(*reflected),
            through: leaf.then_some(Vec3::from_array(*through)),
        }
    }
}

/// Returns a number of a triangle by which it is told from others.
fn seed_of([a, b, _]: [&Corner; 3]) -> u64 {
    let bits = |at: DVec3| at.x.to_bits() ^ at.y.to_bits().rotate_left(21) ^ at.z.to_bits().rotate_left(42);
    mixed(bits(a.position) ^ mixed(bits(b.position)))
}

/// Returns the area of a triangle in a picture, in its pixels.
fn area_in_picture(pixels: &Pixels, [a, b, c]: [DVec2; 3]) -> f64 {
    let [width, height] = pixels.size();
    0.5 * (b - a).perp_dot(c - a).abs() * (width * height) as f64
}
