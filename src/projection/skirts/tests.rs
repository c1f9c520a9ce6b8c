//! Tests of skirts on a wall before the sky.

use super::*;
use crate::Domain;
use crate::sources::COVERED;
use quadratura_base::error::Error;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};

/// The number of rows and columns of the photos.
const SIDE: u32 = 64;

/// Two photos, from a little to the left and to the right, each with one layer of all faces and one of the surroundings.
fn sources(model: &Model) -> Arc<Sources> {
    let eyes = [-1.0, 1.0].map(|x| DVec3::new(x, -10.0, 0.0));
    let projector = |eye: DVec3| Projector {
        name: String::new(),
        camera: centred(SIDE, SIDE, f64::from(SIDE)),
        pose: look_at(eye, DVec3::new(eye.x, 0.0, 0.0)),
    };
    let texture = |photo: u32| LayerTexture {
        photo: PhotoId(photo),
        id: String::new(),
        rect: PixelRect::of_size(SIDE, SIDE),
        see_through: false,
    };
    let server = |layer_texture: u32| Server {
        layer_texture: LayerTextureId(layer_texture),
        photo: PhotoId(layer_texture / 2),
        back: false,
        pinned: false,
        domain: Domain::Whole,
    };
    let faces = model.faces.len() as u32;
    let mut servers: Vec<Server> = (0..faces).flat_map(|_| [server(0), server(2)]).collect();
    servers.extend([server(1), server(3)]);
    Arc::new(Sources {
        photos: eyes.map(projector).to_vec(),
        layer_textures: [0, 0, 1, 1].map(texture).to_vec(),
        servers,
        of_face: (0..faces).map(|face| 2 * face..2 * face + 2).collect(),
        surroundings: 2 * faces..2 * faces + 2,
        ..Sources::default()
    })
}

fn wall(m: &mut Modeller, y: f64, half: f64) {
    let corner = DVec3::new(-half, y, -half);
    m.object(format!("wall {y}")).quad_facing(
        DVec3::NEG_Y,
        corner,
        DVec3::X * 2.0 * half,
        DVec3::Z * 2.0 * half,
    );
}

fn skirts(model: Arc<Model>) -> Skirts {
    let sources = sources(&model);
    Skirts::new(&model, &sources, &ModelSurface::from_model(&model))
}

#[test]
fn a_wall_before_the_sky_has_a_skirt_along_each_edge_that_continues_it() {
    let mut m = Modeller::new();
    wall(&mut m, 0.0, 2.0);
    let skirts = skirts(m.finish());
    assert_eq!(skirts.faces(), 1..5);
    // 0.75 % of 64 pixels at a distance of 10 focal lengths of 64 pixels.
    let width = BAND * 10.0;
    let mut reaches = Vec::new();
    for face in skirts.faces().map(FaceId) {
        let corners: Vec<DVec3> = skirts.model.ring_points(face).collect();
        let along = corners.iter().map(|p| p.x.abs().max(p.z.abs())).fold(0.0, f64::max);
        assert!((along - 2.0 - width).abs() < 1e-9, "past the ends: {along}");
        reaches.push(corners.iter().map(|p| p.x.abs().min(p.z.abs())).fold(0.0, f64::max));
        let middle = corners.iter().sum::<DVec3>() / 4.0;
        let towards = (DVec3::new(0.0, -10.0, 0.0) - middle).normalize();
        let normal = skirts.model.face(face).plane.normal;
        // The photos' directions are unit vectors before they are added, and the plane contains the edge.
        assert!(normal.dot(towards) > 0.999, "{normal} {towards}");
        let ring = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
        assert!(ring.y < 0.0 && skirts.model.face(face).plane.normal.dot(ring) > 0.0);
        assert_eq!(skirts.sources.servers_of(face).len(), 2);
    }
    // The strip is tilted by as much as its edge is beside the photos: by 11 degrees.
    let tilted = width * 0.97;
    assert!(reaches.iter().all(|reach| (2.0 + tilted..2.0 + width).contains(reach)), "{reaches:?}");
}

#[test]
fn edges_before_another_face_and_edges_of_what_one_sees_through_have_none() {
    let mut m = Modeller::new();
    wall(&mut m, 0.0, 2.0);
    let before_a_larger_one = {
        wall(&mut m, 1.0, 50.0);
        skirts(m.finish())
    };
    assert!(before_a_larger_one.faces().is_empty());
    let mut m = Modeller::new();
    wall(&mut m, 0.0, 2.0);
    let through = Model::clone(&m.finish()).with_see_through(|_| true);
    assert!(skirts(Arc::new(through)).faces().is_empty());
}

#[test]
fn views_that_hide_a_face_or_show_no_surroundings_have_none() {
    let mut m = Modeller::new();
    wall(&mut m, 0.0, 2.0);
    let skirts = skirts(m.finish());
    let photo = &skirts.sources.photos[0];
    let shot = Shot::new(photo.camera, photo.pose);
    let drawn = skirts.of_view(&shot);
    assert_eq!(drawn.len(), 4);
    let hidden = Shot { hidden: [FaceId(0)].into_iter().collect(), ..shot.clone() };
    assert!(skirts.of_view(&hidden).is_empty());
    assert!(skirts.of_view(&Shot { surroundings: false, ..shot.clone() }).is_empty());
    assert!(skirts.of_view(&Shot { display: DisplayMode::Layer, ..shot.clone() }).is_empty());
    // The ray beside the wall's right edge meets the skirt there, and the one far from it none.
    let right = |x: f64| {
        let direction = DVec3::new(x, 0.0, 0.0) - shot.viewpoint();
        drawn
            .iter()
            .filter(|skirt| met(&skirts.model, **skirt, shot.viewpoint(), direction).is_some())
            .count()
    };
    assert_eq!([right(2.03), right(2.2), right(1.5)], [1, 0, 0]);
}

/// Texels of which the first row is filled and the second one empty.
struct Rows;

impl Texels for Rows {
    fn layer_texture(&self, id: LayerTextureId) -> Result<LayerTexturePixels> {
        if id.0 > 3 {
            return Err(Error::Request("this is no layer texture of the site".into()));
        }
        let row = |y: u32| (if y == 0 { COVERED | FILLED } else { COVERED }, [99, 0, 40][y.min(2) as usize]);
        let all = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |_| row(y)));
        Ok(LayerTexturePixels {
            rect: PixelRect::of_size(SIDE, SIDE),
            rgba: all().flat_map(|(_, alpha)| [7, 8, 9, alpha]).collect(),
            needed: all().map(|(needed, _)| needed).collect(),
            matte: None,
        })
    }
}

#[test]
fn what_counts_less_in_the_surroundings_is_what_a_skirt_shows_and_what_was_filled_hardly_counts() {
    let mut m = Modeller::new();
    wall(&mut m, 0.0, 2.0);
    let skirts = skirts(m.finish());
    let cells: BTreeMap<(u16, u16), u8> = (0..16).map(|y| ((y, 5), 3)).collect();
    let mut agreement = Agreement { of_texture: vec![None; 4], ..Agreement::default() };
    agreement.of_texture[3] = AgreementGrid::new(DVec2::splat(0.25), &cells);
    let texels = skirts.texels(Arc::new(Rows), &agreement);
    let textures: Vec<LayerTextureId> = skirts.textures().collect();
    assert_eq!(textures, [LayerTextureId(4), LayerTextureId(5)]);
    assert_eq!(skirts.textures_of(|of| of == LayerTextureId(3)), [LayerTextureId(5)]);
    let [plain, standing] = [0, 1].map(|at| texels.layer_texture(textures[at]).unwrap());
    assert!(plain.matte.unwrap().iter().all(|matte| *matte == 0), "the sky alone");
    let at = |x: usize, y: usize| y * SIDE as usize + x;
    let matte = standing.matte.unwrap();
    // The sixth cell of four pixels, from pixel 20 on.
    assert_eq!([matte[at(22, 9)], matte[at(10, 9)]], [255, 0]);
    let alpha = |x: usize, y: usize| standing.rgba[4 * at(x, y) + 3];
    assert_eq!([alpha(22, 0), alpha(22, 1), alpha(22, 2)], [24, 0, 255]);
    assert_eq!(
        texels.layer_texture(LayerTextureId(3)).unwrap(),
        Rows.layer_texture(LayerTextureId(3)).unwrap()
    );
}
