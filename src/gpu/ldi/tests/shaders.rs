//! The shaders without a device: they are valid, agree with Rust, and make pipelines.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::gpu::Gpu;
use crate::gpu::ldi::view::{ViewUniform, WORKGROUP};
use crate::gpu::ldi::{GpuWarp, level, pixel, resolve, show, slots, wide_pixel};

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
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("View")).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("View is no struct") };
    let members: Vec<_> = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
    macro_rules! rust {
        ($($member:ident)*) => { vec![$((stringify!($member).to_string(), offset_of!(ViewUniform, $member))),*] };
    }
    assert_eq!(members, rust!(step zero depth runs half size rows within));
    assert_eq!(*span as usize, size_of::<ViewUniform>());
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
