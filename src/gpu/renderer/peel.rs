//! Layers of a view, peeled off one by one ([`quadratura_projection::peeling`]): *nearness* of what is behind the layer before,
//! then the surfaces and the colours of the new layer. The depth buffer of a layer is the texture that the next one is
//! compared with.

use std::ops::Range;
use std::sync::Arc;

use rustc_hash::FxHashMap;
use wgpu::{
    BindGroup, BindGroupLayout, Extent3d, LoadOp, RenderPipeline, Texture, TextureUsages, TextureView,
};

use super::pipeline::PipelineDescription;
use super::program::Program;
use super::project::{Pass, Passes, source};
use super::render_target::{self, COLOR, FACES, RenderTarget, TargetKey};
use super::{DrawnSurfaces, Prepared, Renderer};
use crate::device::Gpu;
use crate::drawing::DEPTH;
use quadratura_base::error::Result;
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::peeling::{Peeled, PeeledLayer, Peels, PlanarPart};
use quadratura_view::optics::ViewLens;
use quadratura_view::{Picture, Shot};

/// A pass by which a layer is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum LayerPass {
    Nearness,
    Surfaces,
    Colours(Program),
}

/// The pipelines that peel layers off, as far as they were made.
#[derive(Debug)]
pub struct Peeling {
    pipelines: FxHashMap<LayerPass, RenderPipeline>,
    /// What is bound as the depth of the layer before where no layers are peeled off.
    nothing: TextureView,
}

impl Peeling {
    /// Creates the texture that is bound where no layers are peeled off.
    pub fn new(gpu: &Gpu) -> Self {
        let texture = depth_texture(gpu, 1, 1);
        Self { pipelines: FxHashMap::default(), nothing: texture.create_view(&Default::default()) }
    }

    /// Returns what is bound as the depth of the layer before where no layers are peeled off.
    pub fn nothing(&self) -> &TextureView {
        &self.nothing
    }
}

/// Creates a texture for the depth of the layer before.
fn depth_texture(gpu: &Gpu, width: u32, height: u32) -> Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("peeled depths"),
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DEPTH,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

impl Passes {
    /// Makes the pipelines that peel layers off, the colours with these programs.
    fn make_peeling(&mut self, gpu: &Gpu, programs: [Program; 2]) {
        let Self { shot, texels, frame, photos, peeling, .. } = self;
        let both: &[&BindGroupLayout] = &[shot, &texels.layout];
        let colours = programs.map(LayerPass::Colours);
        for step in [LayerPass::Nearness, LayerPass::Surfaces].into_iter().chain(colours) {
            let (vertex, fragment, groups, text) = match step {
                LayerPass::Nearness => {
                    ("peeled_nearness", ("unpeeled", None), &both[..1], frame.source.clone())
                }
                LayerPass::Surfaces => {
                    ("peeled_owner", ("peeled_surfaces", Some(FACES)), both, frame.source.clone())
                }
                LayerPass::Colours(program) => {
                    ("peeled_drawn", ("peeled", Some(COLOR)), both, source(program, frame, photos))
                }
            };
            let fragment = Some(fragment);
            peeling.pipelines.entry(step).or_insert_with(|| {
                PipelineDescription { vertex, fragment, groups, samples: 1, corners: true, blends: false }
                    .pipeline(gpu, &text)
            });
        }
    }

    /// Draws the next layer into the target.
    fn peel(&self, pass: &Pass, programs: [Program; 2], surfaces: Peeled, peeled: &Texture) {
        let groups = self.groups(pass, programs[0], &peeled.create_view(&Default::default()));
        let mut encoder = pass.gpu.device.create_command_encoder(&Default::default());
        let faces = pass.target.faces_view.as_ref().expect("layers are drawn without samples");
        for (step, color) in [
            (LayerPass::Nearness, None),
            (LayerPass::Surfaces, Some(faces)),
            (LayerPass::Colours(programs[0]), Some(&pass.target.color_view)),
        ] {
            let attachment = color.map(|view| {
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })
            });
            let load = if color.is_none() { LoadOp::Clear(0.0) } else { LoadOp::Load };
            let mut drawing = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                color_attachments: attachment.as_slice(),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &pass.target.depth,
                    depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            self.draw_layer(&mut drawing, pass, step, programs[1], surfaces, &groups);
        }
        let size = peeled.size();
        encoder.copy_texture_to_texture(
            pass.target.depth_texture.as_image_copy(),
            peeled.as_image_copy(),
            size,
        );
        pass.gpu.queue.submit([encoder.finish()]);
    }

    /// Records one pass of a layer; see-through surfaces have a program of their own for their colours.
    fn draw_layer(
        &self,
        drawing: &mut wgpu::RenderPass,
        pass: &Pass,
        step: LayerPass,
        of_see_through: Program,
        surfaces: Peeled,
        [shot, texels]: &[BindGroup; 2],
    ) {
        let pipeline = |step: LayerPass| &self.peeling.pipelines[&step];
        drawing.set_bind_group(0, shot, &[]);
        if step != LayerPass::Nearness {
            drawing.set_bind_group(1, texels, &[]);
        }
        let see_through = match step {
            LayerPass::Nearness | LayerPass::Surfaces => step,
            LayerPass::Colours(_) => LayerPass::Colours(of_see_through),
        };
        match surfaces {
            Peeled::Faces => {
                drawing.set_vertex_buffer(0, pass.surfaces.corners.slice(..));
                let mut draw = |step: LayerPass, ranges: &[Range<u32>]| {
                    drawing.set_pipeline(pipeline(step));
                    ranges.iter().for_each(|range| drawing.draw(range.clone(), 0..1));
                };
                draw(step, &pass.surfaces.opaque);
                draw(see_through, &pass.surfaces.not_opaque);
            }
            Peeled::Skirts => {
                let (corners, [skirts, _]) = pass.see_through;
                if skirts > 0 {
                    drawing.set_vertex_buffer(0, corners.slice());
                    drawing.set_pipeline(pipeline(see_through));
                    drawing.draw(0..skirts, 0..1);
                }
            }
        }
    }
}

impl Renderer {
    /// Prepares tables and tiles for the layers of a view, which has no lens.
    fn prepare_layers(&mut self, shot: &Shot, task: &Task) -> Result<Prepared> {
        let side_px = self.cell_px(shot);
        self.face(shot);
        let (_, exposure) = self.cells_and_exposure(shot, side_px, None);
        let exposure = ViewExposure { lens: ViewLens::default(), ..exposure };
        self.prepare(shot, side_px, Some(&exposure), DrawnSurfaces::All, task)
    }
}

impl Peels for Renderer {
    fn surroundings(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        let hidden = self.site_model.face_ids().collect();
        let shot = &Shot { hidden, surroundings: true, linear: false, ..shot.clone() };
        let gpu = self.gpu.clone();
        render_target::judge(&gpu, shot)?;
        gpu.guarded("drawing surroundings", || {
            let prepared = self.prepare_layers(shot, task)?;
            let program = Program::new(shot, &self.features(prepared.undoes_optics));
            self.draw(shot, [program, program.of_see_through()], &prepared, task)?;
            self.targets[&TargetKey::of_picture(shot)].picture(&gpu)
        })
    }

    fn parts(&self) -> (Arc<Model>, Vec<PlanarPart>) {
        (self.model.clone(), self.surfaces.parts.clone())
    }

    fn peel(
        &mut self,
        shot: &Shot,
        surfaces: Peeled,
        each: &mut dyn FnMut(PeeledLayer) -> Result<bool>,
        task: &Task,
    ) -> Result<()> {
        // Without surroundings there are no skirts, and without these no surroundings are needed.
        let shot = &Shot { surroundings: surfaces == Peeled::Skirts, linear: false, ..shot.clone() };
        let gpu = self.gpu.clone();
        render_target::judge(&gpu, shot)?;
        let (width, height) = (shot.camera.width, shot.camera.height);
        let (prepared, target, peeled, programs) = gpu.guarded("preparing layers", || {
            let prepared = self.prepare_layers(shot, task)?;
            let program = Program::new(shot, &self.features(prepared.undoes_optics)).without_outlines();
            let programs = [program, program.of_see_through()];
            self.passes.make_peeling(&gpu, programs);
            let peeled = depth_texture(&gpu, width, height);
            clear(&gpu, &peeled);
            Ok((prepared, RenderTarget::new(&gpu, TargetKey::of_faces(shot)), peeled, programs))
        })?;
        loop {
            task.check_cancelled()?;
            let layer = gpu.guarded("drawing a layer", || {
                let pass = self.pass(shot, &target, &prepared, programs[1]);
                self.passes.peel(&pass, programs, surfaces, &peeled);
                let parts = target.faces(&gpu)?;
                if parts.iter().all(|part| *part == 0) {
                    return Ok(None);
                }
                Ok(Some(PeeledLayer { parts, colours: target.colours(&gpu)? }))
            })?;
            let Some(layer) = layer else { return Ok(()) };
            if !each(layer)? {
                return Ok(());
            }
        }
    }
}

/// Fills the depth of the layer before the first one: nearer than all surfaces.
fn clear(gpu: &Gpu, peeled: &Texture) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("no layer"),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &peeled.create_view(&Default::default()),
            depth_ops: Some(wgpu::Operations { load: LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    gpu.queue.submit([encoder.finish()]);
}
