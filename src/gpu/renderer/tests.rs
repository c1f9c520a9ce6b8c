//! The renderer's shaders without a GPU: all that can be generated is valid and agrees with Rust.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::frame::FrameUniform;
use super::heights::ReliefWords;
use super::program::Program;
use super::project::{PhotoTable, source};
use super::surfaces::SurfaceWords;
use super::tables::{FaceCellsWords, PhotoWords};
use crate::gpu::Gpu;
use crate::projection::{Blend, Mode, Quality, Shown, Sources};

const SHOWN: [Shown; 8] = [
    Shown::Colour,
    Shown::Weights,
    Shown::BestPhoto,
    Shown::Density,
    Shown::Confidence,
    Shown::Layer,
    Shown::Item,
    Shown::Coverage,
];

fn programs() -> Vec<Program> {
    let mut programs = vec![Program::Faces];
    for quality in [Quality::Preview, Quality::Final] {
        for mode in Mode::ALL {
            programs.push(Program::Picture { mode, photos: 4, shown: Shown::Colour, quality });
        }
        for shown in SHOWN {
            programs.push(Program::Picture { mode: Mode::Smooth, photos: Blend::MOST, shown, quality });
        }
    }
    programs
}

fn parsed(program: Program) -> naga::Module {
    let source = source(program, &PhotoTable::new(&Gpu::noop(), &Sources::default()));
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("{program:?}: {}", e.emit_to_string(&source)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|e| panic!("{program:?}: {}", e.emit_to_string(&source)));
    module
}

#[test]
fn every_program_is_valid() {
    for program in programs() {
        parsed(program);
    }
}

/// Size of a WGSL struct, and where its members lie, in bytes.
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
    let quality = Quality::Final;
    let module = parsed(Program::Picture { mode: Mode::Smooth, photos: 4, shown: Shown::Colour, quality });
    assert_alike!(&module, "Frame", FrameUniform: right focal_x down focal_y forward near center size
        eye_high density eye_low lambda cell_px reach relief pad0);
    assert_alike!(&module, "Surface", SurfaceWords: normal distance_high distance_low face flags pad0);
    assert_alike!(&module, "FaceCells", FaceCellsWords: corner size first pad0);
    assert_alike!(&module, "Photo", PhotoWords: row_x row_y row_z center density size per_border pad0 gain);
    assert_alike!(&module, "Relief", ReliefWords: across across_high up up_high across_low up_low corner size pad0);
}
