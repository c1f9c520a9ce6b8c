//! The shaders without a device: they are valid, agree with Rust, and make pipelines.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::Gpu;
use crate::ldi::view::{ViewUniform, WORKGROUP};
use crate::ldi::{GpuWarp, level, pixel, resolve, show, slots, wide_pixel};
use quadratura_ldi::warp::moves::SurfaceMove;

/// Returns every pass as it is compiled, with what the device has to have for it.
fn passes() -> Vec<(String, Capabilities)> {
    let plain = [
        resolve::source(),
        pixel::source(false),
        pixel::source(true),
        show::source(false),
        show::source(true),
    ];
    let wide = Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX;
    let filling = [false, true].map(|far| level::FILLING.map(|pass| pass.source(far)));
    let plain = plain.into_iter().chain(filling.into_iter().flatten());
    plain.map(|source| (source, Capabilities::empty())).chain([(wide_pixel::source(), wide)]).collect()
}

fn parsed(source: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

#[test]
fn every_pass_is_valid() {
    for (source, capabilities) in passes() {
        let mut validator = Validator::new(ValidationFlags::all(), capabilities);
        validator.validate(&parsed(&source)).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    }
}

#[test]
fn structs_lie_alike_in_rust_and_in_wgsl() {
    let module = parsed(&resolve::source());
    let of_shader = |name: &str| {
        let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
        let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
        let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize));
        (members.collect::<Vec<_>>(), *span as usize)
    };
    macro_rules! rust {
        ($name:ty: $($member:ident)*) => {
            (vec![$((stringify!($member).to_string(), offset_of!($name, $member))),*], size_of::<$name>())
        };
    }
    assert_eq!(of_shader("View"), rust!(ViewUniform: step zero depth runs half size rows within));
    // Rows of the map have names in the shader.
    let (mut members, size) = rust!(SurfaceMove: factor slope gradient map);
    let (_, first) = members.pop().unwrap();
    members.extend(
        ["of_u", "of_v", "of_omega"].iter().zip(0..).map(|(row, i)| (row.to_string(), first + 8 * i)),
    );
    assert_eq!(of_shader("Surface"), (members, size));
}

#[test]
fn constants_are_alike_in_rust_and_in_wgsl() {
    let module = parsed(&resolve::source());
    let says = |name: &str| {
        let (_, found) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
        match module.global_expressions[found.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => u64::from(value),
            ref other => panic!("{name} is {other:?}"),
        }
    };
    assert_eq!(says("PLANES"), slots::PLANES);
    assert_eq!(says("SLOTS") * says("SUMS"), slots::SUMS);
    for (source, _) in passes() {
        assert_eq!(parsed(&source).entry_points[0].workgroup_size, [WORKGROUP, 1, 1]);
    }
}

#[test]
fn all_pipelines_build_on_the_noop_backend() {
    GpuWarp::new(&Gpu::noop()).expect("layouts and shaders agree");
}
