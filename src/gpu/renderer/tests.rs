//! Tests of the renderer's shaders without a GPU: all that can be generated is valid and agrees with Rust.

use std::mem::offset_of;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::agreement::PlaceWords;
use super::frame::CameraUniform;
use super::grids::{FaceGridsWords, GridWords};
use super::pipeline::FrameTable;
use super::plants;
use super::plants::daylight::{CrownGridWords, CrownWords, DaylightWords};
use super::plants::flake::{self, FlakeImageWords, FlakeRowsWords};
use super::plants::flaked::{self, ShownWords};
use super::plants::flakes::{self, SamplePass};
use super::plants::hidden::{self, TestedWords};
use super::plants::pipeline::{self, Cuts, PlacementWords};
use super::plants::ratio::RatioWords;
use super::plants::species::MatterWords;
use super::program::{Program, SiteFeatures};
use super::project::{PhotoTable, source};
use super::shadows::{ShadowsWords, SunViewWords};
use super::surfaces::SurfaceWords;
use super::tables::{FaceCellsWords, PhotoWords};
use crate::{Gpu, Renderer, TileStore};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_base::task::{Event, Task};
use quadratura_foliage::RATIO_CELLS;
use quadratura_projection::TextureOptions;
use quadratura_projection::continuation::{Continuation, SeenPoint};
use quadratura_projection::relief::{LEAST_FACING, Relief};
use quadratura_projection::turned::MIRRORED;
use quadratura_projection::{
    Gains, LayerTextureId, LayerTexturePixels, Renders, SiteRenderer, Sources, Texels,
};
use quadratura_view::weights::{LEAST_ANGLE, OTHER_SIDE};
use quadratura_view::{Blend, DisplayMode, Mode, Quality, Shot, Unseen};

const DISPLAY_MODES: [DisplayMode; 12] = [
    DisplayMode::Colour,
    DisplayMode::Weights,
    DisplayMode::BestPhoto,
    DisplayMode::Group,
    DisplayMode::Density,
    DisplayMode::Confidence,
    DisplayMode::Agreement,
    DisplayMode::Layer,
    DisplayMode::Item,
    DisplayMode::Coverage,
    DisplayMode::Matte,
    DisplayMode::Provenance,
];

fn picture(mode: Mode, photos: u32, display: DisplayMode, quality: Quality) -> Program {
    Program::Picture {
        mode,
        photos,
        display,
        quality,
        undoes_optics: false,
        pins: false,
        impostors: false,
        agreement: false,
        mattes: false,
        outlines: false,
        see_through: false,
        numbers: false,
        shadows: false,
        linear: false,
    }
}

fn programs() -> Vec<Program> {
    let mut programs = vec![Program::Faces];
    for quality in [Quality::Preview, Quality::Final] {
        for mode in Mode::ALL {
            programs.push(picture(mode, 4, DisplayMode::Colour, quality));
        }
        for display in DISPLAY_MODES {
            programs.push(picture(Mode::Smooth, Blend::MOST, display, quality));
        }
    }
    let quality = Quality::Final;
    let everything = SiteFeatures {
        undoes_optics: true,
        pins: true,
        impostors: true,
        contradicted: true,
        mattes: true,
        outlines: true,
    };
    for display in DISPLAY_MODES {
        let program = Program::new(&Shot { quality, display, ..shot(70, 3) }, &everything);
        programs.extend([program, program.of_see_through()]);
        programs.extend([program, program.of_see_through()].map(|program| program.with_shadows(true)));
    }
    programs.push(Program::of_seen_faces(&shot(70, 3), &everything));
    let program = Program::new(&Shot { quality, linear: true, ..shot(70, 3) }, &everything);
    programs.extend([program, program.of_see_through()]);
    programs
}

/// Returns a task that is cancelled once the tables of a picture are ready, just before it is drawn.
pub(super) fn cancelled_before_drawing() -> Task {
    let stop = Arc::<AtomicBool>::default();
    let sets = stop.clone();
    let task = Task::new(move |event| {
        if matches!(event, Event::Timing { stage: "tiles", .. }) {
            sets.store(true, Ordering::Relaxed);
        }
    });
    task.with_stop_flag(stop)
}

#[test]
fn a_colour_times_its_alpha_becomes_straight() {
    use super::render_target::straight;
    assert_eq!([straight([9, 8, 7, 255]), straight([0, 0, 0, 0])], [[9, 8, 7, 255], [0, 0, 0, 0]]);
    // Half the light of sRGB 255 is 188, that of 187 is 137.
    assert_eq!(straight([188, 137, 0, 128]), [255, 187, 0, 128]);
}

fn parsed(program: Program) -> naga::Module {
    declared(program, false)
}

fn declared(program: Program, in_storage: bool) -> naga::Module {
    let photos = PhotoTable::new(&Gpu::noop(), &Sources::default());
    let source = source(program, &FrameTable::declared(in_storage), &photos);
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("{program:?}: {}", e.emit_to_string(&source)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|e| panic!("{program:?}: {}", e.emit_to_string(&source)));
    module
}

#[test]
fn every_program_is_valid() {
    for program in programs() {
        for in_storage in [false, true] {
            let module = declared(program, in_storage);
            let frame = module.global_variables.iter().find(|(_, of)| of.name.as_deref() == Some("frame"));
            let space = frame.expect("every program has a frame").1.space;
            assert_eq!(space == naga::AddressSpace::Uniform, !in_storage, "{program:?}");
        }
    }
}

/// Returns the size of a WGSL struct, and the offsets of its members, in bytes.
fn wgsl_struct(module: &naga::Module, name: &str) -> (u32, Vec<(String, u32)>) {
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    (*span, members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect())
}

macro_rules! assert_alike {
    ($module:expr, $wgsl:literal, $name:ident: $($member:ident)*) => {
        let rust = (
            size_of::<$name>() as u32,
            vec![$((stringify!($member).to_string(), offset_of!($name, $member) as u32)),*],
        );
        assert_eq!(wgsl_struct($module, $wgsl), rust);
    };
}

#[test]
fn structs_lie_alike_in_rust_and_in_wgsl() {
    let module = parsed(picture(Mode::Smooth, 4, DisplayMode::Colour, Quality::Final));
    assert_alike!(&module, "Frame", CameraUniform: right focal_x down focal_y forward near center size
        eye_high density eye_low lambda cell_px reach relief backs
        transient_angle widest falloff surroundings_first surroundings_columns per_surroundings_scale dome_first
        light_first light_groups parallel far of_common continues of_sky surroundings_reach);
    assert_alike!(&module, "Surface", SurfaceWords: normal distance_high distance_low face flags half_width
        foot_high pad0 foot_low pad1 axis pad2);
    assert_alike!(&module, "FaceCells", FaceCellsWords: corner size first hidden);
    assert_alike!(&module, "Photo", PhotoWords: row_x row_y row_z center density size per_border offset gain left
        axis falloff leaning group sky sky_share);
    assert_alike!(&module, "FaceGrids", FaceGridsWords: relief continued);
    assert_alike!(&module, "FaceGrid", GridWords: across across_high up up_high across_low up_low corner size pad0);
    let module = parsed(picture(Mode::Smooth, 4, DisplayMode::Colour, Quality::Final).with_shadows(true));
    assert_alike!(&module, "SunView", SunViewWords: row_u row_v row_z near until texel widest);
    assert_alike!(&module, "Shadows", ShadowsWords: views towards_sun count up pad0 sun pad1 sky pad2 ground pad3);
    assert_alike!(&module, "AgreementPlace", PlaceWords: cells_per_px origin size corner);
}

#[test]
fn programs_of_trees_are_valid_and_their_structs_lie_alike() {
    assert!(plants::daylight::SOURCE.contains(&format!("const RATIO_CELLS = {RATIO_CELLS}.0;")));
    for (by_picture, by_stipple) in [(false, false), (true, false), (false, true), (true, true)] {
        let source = pipeline::source(Cuts { by_picture, by_stipple });
        let module =
            naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
        let capabilities = Capabilities::MULTISAMPLED_SHADING;
        let mut validator = Validator::new(ValidationFlags::all(), capabilities);
        validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
        assert_alike!(&module, "Placement", PlacementWords: right down forward first pad0 pad1 pad2);
        assert_alike!(&module, "Shown", ShownWords: tint number plain crown first_ratio ratio_count sunlit pad0);
        assert_alike!(&module, "Ratio", RatioWords: x y w corner weight pad0);
        assert_alike!(&module, "Crown", CrownWords: x y z suns weights);
        assert_alike!(&module, "Grid", CrownGridWords: size pad0);
        assert_alike!(&module, "Daylight", DaylightWords: towards_sun pad0 up pad1 sun pad2 sky pad3 ground pad4);
        assert_alike!(&module, "Matter", MatterWords: reflected leaf through cutout size pad0);
    }
}

#[test]
fn passes_over_images_of_trees_are_valid_and_their_structs_lie_alike() {
    let valid = |source: String| {
        let module =
            naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
        let wide = Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::MULTISAMPLED_SHADING | wide);
        validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
        module
    };
    let workgroups = |module: &naga::Module| -> Vec<[u32; 3]> {
        let compute = module.entry_points.iter().filter(|entry| entry.stage == naga::ShaderStage::Compute);
        compute.map(|entry| entry.workgroup_size).collect()
    };
    for samples in [1, 4] {
        for (pass, is_software) in
            [SamplePass::Only, SamplePass::First, SamplePass::Second].into_iter().zip([true, false, true])
        {
            let invocations = flakes::invocations(is_software);
            let module = valid(flakes::source(samples, invocations, pass));
            assert_alike!(&module, "FlakeImage", FlakeImageWords: right down forward normal_right delta normal_down
                depth_step normal_forward first_depth through half gain length first count before of_direction of_part tree species first_block);
            assert_eq!(workgroups(&module), [[invocations, 1, 1]]);
            assert_alike!(&module, "FlakeRows", FlakeRowsWords: first count width reach);
        }
        let module = valid(hidden::source(samples));
        assert_alike!(&module, "Tested", TestedWords: first count pad0 pad1);
        assert_eq!(workgroups(&module), [[hidden::WORKGROUP, 1, 1]; 2]);
        for (name, rust) in
            [("TILE", hidden::TILE), ("BLOCK", flake::BLOCK), ("WORKGROUP", hidden::WORKGROUP)]
        {
            let (_, found) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
            let says = &module.global_expressions[found.init];
            assert!(
                matches!(says, naga::Expression::Literal(naga::Literal::U32(value)) if *value == rust),
                "{name} is {says:?}"
            );
        }
        assert!(hidden::source(samples).contains(&format!("const ROUNDING = {:e};", hidden::ROUNDING)));
        let module = valid(flaked::source(samples));
        assert_alike!(&module, "Shown", ShownWords: tint number plain crown first_ratio ratio_count sunlit pad0);
        assert_alike!(&module, "Ratio", RatioWords: x y w corner weight pad0);
        assert_alike!(&module, "Daylight", DaylightWords: towards_sun pad0 up pad1 sun pad2 sky pad3 ground pad4);
    }
}

#[test]
fn constants_are_alike_in_rust_and_in_wgsl() {
    let module = parsed(picture(Mode::Smooth, 4, DisplayMode::Colour, Quality::Preview).with_shadows(true));
    let says = |name: &str| {
        let (_, found) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
        match module.global_expressions[found.init] {
            naga::Expression::Literal(naga::Literal::F32(value)) => value,
            ref other => panic!("{name} is {other:?}"),
        }
    };
    for (name, rust) in [
        ("LEAST_ANGLE", LEAST_ANGLE),
        ("OTHER_SIDE", OTHER_SIDE),
        ("LEAST_FACING", LEAST_FACING),
        ("MIRRORED", MIRRORED),
        ("ON_AXIS", quadratura_base::scene::impostor::ON_AXIS),
        ("SUN_TANGENT", quadratura_foliage::SUN_TANGENT),
        ("TAKES_OVER", quadratura_foliage::TAKES_OVER),
        ("DOME_PENALTY", quadratura_projection::dome::PENALTY),
        ("LEAST_MATTE", f64::from(quadratura_projection::sources::LEAST_MATTE)),
    ] {
        assert_eq!(says(name), rust as f32, "{name}");
    }
    let counts = |name: &str| {
        let (_, found) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
        match module.global_expressions[found.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value as usize,
            ref other => panic!("{name} is {other:?}"),
        }
    };
    assert_eq!(counts("SKY_GRID"), quadratura_projection::exposure::surroundings::GRID);
    assert_eq!(counts("SKY_COLUMNS"), super::sky::COLUMNS);
}

/// A source for a site without layer textures.
pub(super) struct NoTextures;

impl Texels for NoTextures {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        unreachable!("no source has {layer_texture:?}")
    }
}

/// Builds a renderer of a site without faces and photos.
fn of_nothing(gpu: &Gpu) -> Renderer {
    let (model, sources) = (Arc::new(Model::default()), Arc::new(Sources::default()));
    let tiles = TileStore::new(gpu, &sources, Arc::new(NoTextures), TextureOptions::default()).unwrap();
    Renderer::new(gpu, model, sources, Gains::none(0), &Relief::default(), tiles).unwrap()
}

fn shot(width: u32, height: u32) -> Shot {
    Shot::new(centred(width, height, 50.0), look_at(glam::DVec3::X, glam::DVec3::ZERO))
}

#[test]
fn a_model_without_faces_is_drawn_without_a_fault() {
    let mut renderer = of_nothing(&Gpu::noop());
    for quality in [Quality::Preview, Quality::Final] {
        let picture = renderer.picture(&Shot { quality, ..shot(70, 3) }, &Task::silent()).unwrap();
        assert_eq!((picture.width, picture.height, picture.rgba.len()), (70, 3, 840));
    }
    assert_eq!(renderer.faces(&shot(5, 4), &Task::silent()).unwrap().len(), 20);
}

#[test]
fn pictures_that_the_device_cannot_draw_are_refused_with_what_it_can() {
    let gpu = Gpu::noop();
    let longest = gpu.device.limits().max_texture_dimension_2d;
    let mut renderer = of_nothing(&gpu);
    for (width, height) in [(longest + 1, 10), (10, u32::MAX), (0, 10)] {
        let shot = shot(width, height);
        let size = format!("{width} x {height}");
        let refused = renderer.faces(&shot, &Task::silent()).unwrap_err().to_string();
        assert!(refused.contains(&size) && refused.contains(&longest.to_string()), "{refused}");
        // Pictures that are wider than textures are drawn in tiles.
        match renderer.picture(&shot, &Task::silent()) {
            Ok(picture) => assert_eq!((picture.width, picture.height), (longest + 1, 10)),
            Err(error) => assert!(width <= longest && error.to_string().contains(&size), "{error}"),
        }
    }
    assert!(renderer.faces(&shot(4, 4), &Task::silent()).is_ok(), "a refused picture leaves nothing behind");
}

#[test]
fn a_face_that_no_photo_shows_continues_in_final_pictures_alone() {
    let Some(gpu) = crate::left_out::on_adapter(Gpu::headless()) else { return };
    let mut modeller = Modeller::new();
    let (corner, side) = (DVec3::new(5.0, -9.0, -9.0), 18.0);
    modeller.object("wall").quad_facing(DVec3::NEG_X, corner, DVec3::Y * side, DVec3::Z * side);
    let model = modeller.finish();
    let sources = Arc::new(Sources { of_face: std::iter::once(0..0).collect(), ..Sources::default() });
    let tiles = TileStore::new(&gpu, &sources, Arc::new(NoTextures), TextureOptions::default()).unwrap();
    let relief = Relief::default();
    let mut renderer = Renderer::new(&gpu, model.clone(), sources, Gains::none(0), &relief, tiles).unwrap();
    // The left half is red, the right half blue, as the viewer sees them.
    let light = |y: i32| if y > 0 { [0.5, 0.0, 0.0] } else { [0.0, 0.0, 0.5] };
    let point = |(y, z): (i32, i32)| SeenPoint {
        face: FaceId(0),
        at: DVec3::new(5.0, f64::from(y) / 2.0, f64::from(z) / 2.0),
        photo: PhotoId(0),
        light: light(y),
    };
    let seen: Vec<SeenPoint> = (-18..19).flat_map(|y| (-18..19).map(move |z| (y, z))).map(point).collect();
    renderer.set_continuation(Continuation::new(&model, &seen, |_| Some([0.0; 3]))).unwrap();
    let pose = look_at(DVec3::ZERO, DVec3::X);
    for quality in [Quality::Preview, Quality::Final, Quality::Finer] {
        let shot = |unseen| Shot { unseen, quality, ..Shot::new(centred(40, 20, 20.0), pose) };
        let picture = renderer.picture(&shot(Unseen::Continued), &Task::silent()).unwrap();
        let (left, right) = (picture.pixels()[10 * 40 + 5], picture.pixels()[10 * 40 + 35]);
        // Half of the light is 188 in sRGB; either way of filtering is within two steps of it.
        let near =
            |pixel: [u8; 4], expected: [u8; 4]| pixel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 2);
        assert!(
            near(left, [188, 0, 0, 255]) && near(right, [0, 0, 188, 255]),
            "{quality:?}: {left:?} {right:?}"
        );
        for unseen in [Unseen::Marked, Unseen::Empty] {
            let picture = renderer.picture(&shot(unseen), &Task::silent()).unwrap();
            assert!(picture.pixels().iter().all(|pixel| pixel[3] == 0), "{unseen:?}");
        }
    }
}

#[test]
fn a_lost_device_is_an_error_of_the_gpu_and_no_crash() {
    let Some(gpu) = crate::left_out::on_adapter(Gpu::headless()) else { return };
    let mut renderer = of_nothing(&gpu);
    renderer.picture(&shot(70, 30), &Task::silent()).unwrap();
    gpu.device.destroy();
    for _ in 0..2 {
        let lost = renderer.picture(&shot(70, 30), &Task::silent());
        assert!(matches!(lost, Err(Error::Gpu(_))), "{lost:?}");
    }
}
