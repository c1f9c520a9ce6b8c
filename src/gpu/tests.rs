//! Tests of the shaders without a GPU: they are valid, agree with Rust on struct layouts, and make pipelines.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::frame::{FrameUniform, PlaneWords};
use super::presence::Sighting;
use super::{Gpu, GpuRasteriser};
use super::{count, drawing, farthest, fill, frame, mark, nearest, pairs, presence, scan, stencil};

/// Returns every shader as it is compiled: name and WGSL.
fn shaders() -> Vec<(&'static str, String)> {
    let drawn = [
        ("nearest", nearest::SOURCE),
        ("presence", presence::SOURCE),
        ("count", count::SOURCE),
        ("fill", fill::SOURCE),
        ("mark", mark::SOURCE),
        ("farthest", farthest::SOURCE),
        ("stencil", stencil::SOURCE),
    ];
    let drawn = drawn.map(|(name, source)| (name, [frame::SOURCE, drawing::VERTEX, source].concat()));
    let computed = [("scan", scan::SOURCE), ("pairs", pairs::SOURCE)];
    let computed = computed.map(|(name, source)| (name, [frame::SOURCE, source].concat()));
    drawn.into_iter().chain(computed).collect()
}

fn parsed(name: &str, source: &str) -> naga::Module {
    let fault = |error: naga::front::wgsl::ParseError| panic!("{name}: {}", error.emit_to_string(source));
    naga::front::wgsl::parse_str(source).unwrap_or_else(fault)
}

/// Returns the size of a WGSL struct, and the offsets of its members, in bytes.
fn wgsl_struct(shader: &str, name: &str) -> (u32, Vec<(String, u32)>) {
    let (_, source) = shaders().into_iter().find(|(own, _)| *own == shader).expect("it is in the list");
    let module = parsed(shader, &source);
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some(TypeInner::Struct { members, span }) = found.map(|(_, ty)| &ty.inner) else {
        panic!("{shader} has no struct {name}");
    };
    let members = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
    (*span, members)
}

/// The size and offsets of a Rust struct whose members have the same names.
macro_rules! rust_struct {
    ($name:ident: $($member:ident)*) => {
        (size_of::<$name>() as u32, vec![$((stringify!($member).to_string(), offset_of!($name, $member) as u32)),*])
    };
}

#[test]
fn every_shader_is_valid() {
    for (name, source) in shaders() {
        let module = parsed(name, &source);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&source)));
    }
}

#[test]
fn structs_lie_alike_in_rust_and_in_wgsl() {
    let frame = rust_struct!(FrameUniform: width y0 row row_end first_entry nearer depth_scale zero);
    assert_eq!(wgsl_struct("count", "Frame"), frame);
    assert_eq!(wgsl_struct("count", "Plane"), rust_struct!(PlaneWords: a b c u0 v0 number));
    assert_eq!(wgsl_struct("presence", "Sighting"), rust_struct!(Sighting: visible hidden));
}

#[test]
fn constants_are_alike_in_rust_and_in_wgsl() {
    let says =
        |source: &str, line: String| assert!(source.contains(&line), "the shader does not say {line:?}");
    says(scan::SOURCE, format!("const RUN: u32 = {}u;", scan::RUN));
    says(pairs::SOURCE, format!("const RUN: u32 = {}u;", pairs::RUN));
    says(pairs::SOURCE, format!("const PROBES: u32 = {}u;", 1 << pairs::PROBE_BITS));
    says(pairs::SOURCE, format!("const HALF_BITS: u32 = {}u;", pairs::HALF_BITS));
    says(pairs::SOURCE, format!("@workgroup_size(1, {})", pairs::WORKGROUP));
    says(frame::SOURCE, format!("const VISIBLE: u32 = {:#x}u;", quadratura_layers::rasteriser::VISIBLE));
}

#[test]
fn every_shader_has_a_rust_file_of_the_same_name() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for shader in std::fs::read_dir(root.join("shaders")).expect("the folder is there") {
        let name = shader.expect("it can be listed").path().with_extension("rs");
        let name = name.file_name().expect("a file has a name");
        // The Rust files beside `weights` and `surroundings` are their CPU references; their pass is `project`. Names of shaders of layered depth images
        // begin with the name of their folder.
        let rooms = ["src/gpu", "src/gpu/renderer", "src/gpu/renderer/plants", "src/projection", "src/view"];
        let of_ldi = name.to_str().and_then(|name| name.strip_prefix("ldi_"));
        let found = rooms.iter().any(|room| root.join(room).join(name).exists())
            || of_ldi.is_some_and(|name| root.join("src/gpu/ldi").join(name).exists());
        assert!(found, "{} is in none of {rooms:?}", name.display());
    }
}

#[test]
fn all_pipelines_build_on_the_noop_backend() {
    GpuRasteriser::new(&Gpu::noop()).expect("layouts, shaders and targets agree");
}
