//! The textures that views are drawn into, and their read-back.

use std::sync::OnceLock;

use bytemuck::Pod;
use half::f16;
use rayon::prelude::*;
use wgpu::{Buffer, Extent3d, Texture, TextureFormat, TextureUsages, TextureView};

use crate::device::Gpu;
use crate::drawing::DEPTH;
use crate::readback;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_view::{LinearPicture, Picture, Shot};

/// The format of images: written in linear light, stored as sRGB.
pub const COLOR: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// The format of images in linear light.
pub const LINEAR: TextureFormat = TextureFormat::Rgba16Float;

/// The format of faces: 1 + an index, 0 where there is none.
pub const FACES: TextureFormat = TextureFormat::R32Uint;

/// The grey of untextured surfaces and of the background: sRGB 128, in linear light.
pub const FLAT_LINEAR: f64 = 0.215_860_5;

/// The number of samples per pixel in *final* quality.
pub const SAMPLES: u32 = 4;

/// What textures are made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TargetKey {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// Whether there are several samples per pixel.
    pub multisampled: bool,
    /// Whether images are in linear light, with 16-bit floats.
    pub linear: bool,
}

impl TargetKey {
    /// Returns what the image of a view is drawn into.
    pub fn of_picture(shot: &Shot) -> Self {
        let multisampled = shot.quality.is_multisampled();
        Self { multisampled, linear: shot.linear, ..Self::of_faces(shot) }
    }

    /// Returns what the faces of a view are drawn into.
    pub fn of_faces(shot: &Shot) -> Self {
        let (width, height) = (shot.camera.width, shot.camera.height);
        Self { width, height, multisampled: false, linear: false }
    }
}

/// The textures for one image size.
#[derive(Debug)]
pub struct RenderTarget {
    width: u32,
    height: u32,
    is_linear: bool,
    /// The number of samples per pixel.
    pub samples: u32,
    /// The depth buffer.
    pub depth: TextureView,
    /// Its texture.
    pub depth_texture: Texture,
    color: Texture,
    /// The view of the image.
    pub color_view: TextureView,
    /// The multisampled texture that is resolved to pixels; `None` without multisampling.
    pub samples_view: Option<TextureView>,
    faces: Option<Texture>,
    /// The view of the faces; `None` with multisampling.
    pub faces_view: Option<TextureView>,
    /// What textures are read back through.
    reading: OnceLock<Buffer>,
}

/// The largest number of pixels of an image that is drawn in slices: as many as 16384 x 16384.
const MOST_PX: u64 = 1 << 28;
/// The same of an orthographic image, whose rows are taken while it is drawn.
const MOST_PARALLEL_PX: u64 = 1 << 34;

/// Checks that an image of the view's size can be drawn in slices.
///
/// # Errors
/// [`Error::Gpu`] where it has no pixels, or too many.
pub fn judge_size(shot: &Shot) -> Result<()> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let most = if shot.parallel.is_some() { MOST_PARALLEL_PX } else { MOST_PX };
    if (1..=most).contains(&(u64::from(width) * u64::from(height))) {
        return Ok(());
    }
    Err(Error::Gpu(format!(
        "a picture of {width} x {height} pixels cannot be drawn; pictures have 1 to {most} pixels"
    )))
}

/// Checks that the device can draw images of the view's size at once.
///
/// # Errors
/// [`Error::Gpu`] with the device's limits, where it cannot.
pub fn judge(gpu: &Gpu, shot: &Shot) -> Result<()> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let limits = gpu.device.limits();
    let (longest, largest) = (limits.max_texture_dimension_2d, limits.max_buffer_size);
    let picture = format!("a picture of {width} x {height} pixels");
    if width.min(height) == 0 {
        return Err(Error::Gpu(format!("{picture} is empty; sides are 1 to {longest}")));
    }
    if width.max(height) > longest {
        let most = format!("sides of {longest} pixels at most");
        return Err(Error::Gpu(format!("{picture} is too large for this device, which draws {most}")));
    }
    let px_bytes = if shot.linear { LINEAR_BYTES } else { 4 };
    if row_bytes(width, px_bytes) * u64::from(height) > largest {
        let most = format!("buffers of {largest} bytes at most");
        return Err(Error::Gpu(format!("{picture} is too large for this device, which has {most}")));
    }
    Ok(())
}

/// The bytes of a pixel in linear light.
const LINEAR_BYTES: u64 = 8;

/// Returns the bytes of a row, aligned for copies from textures to buffers.
fn row_bytes(width: u32, px_bytes: u64) -> u64 {
    (px_bytes * u64::from(width)).next_multiple_of(u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT))
}

impl RenderTarget {
    /// Creates the textures.
    pub fn new(gpu: &Gpu, key: TargetKey) -> Self {
        let TargetKey { width, height, multisampled, linear: is_linear } = key;
        let color_format = if is_linear { LINEAR } else { COLOR };
        let samples = if multisampled { SAMPLES } else { 1 };
        let made = |label, format, samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let view = |texture: &Texture| texture.create_view(&Default::default());
        let color =
            made("picture", color_format, 1, TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING);
        let many = multisampled.then(|| made("samples", color_format, samples, TextureUsages::empty()));
        let faces = (!multisampled).then(|| made("faces", FACES, 1, TextureUsages::COPY_SRC));
        // Layers that are peeled off are drawn without samples.
        let copied = if multisampled { TextureUsages::empty() } else { TextureUsages::COPY_SRC };
        let depth = made("depth", DEPTH, samples, copied | TextureUsages::TEXTURE_BINDING);
        Self {
            width,
            height,
            is_linear,
            samples,
            depth: view(&depth),
            depth_texture: depth,
            color_view: view(&color),
            color,
            samples_view: many.as_ref().map(view),
            faces_view: faces.as_ref().map(view),
            faces,
            reading: OnceLock::new(),
        }
    }

    /// Reads back the image that was drawn.
    pub fn picture(&self, gpu: &Gpu) -> Result<Picture> {
        if self.is_linear {
            return Ok(self.linear_picture(gpu)?.picture());
        }
        let rgba = self.read(gpu, &self.color, |pixels: &mut [[u8; 4]]| {
            pixels.iter_mut().filter(|pixel| !matches!(pixel[3], 0 | 255)).for_each(without_background);
        })?;
        Ok(Picture { width: self.width, height: self.height, rgba: rgba.into_flattened() })
    }

    /// Reads back the image that was drawn in linear light.
    pub fn linear_picture(&self, gpu: &Gpu) -> Result<LinearPicture> {
        debug_assert!(self.is_linear);
        let halves = self.read(gpu, &self.color, |_: &mut [[u16; 4]]| ())?;
        let light = |bits: u16| f16::from_bits(bits).to_f32();
        let rgba = halves.par_iter().map(|pixel| without_flat(pixel.map(light))).collect();
        Ok(LinearPicture { width: self.width, height: self.height, rgba, depths: None })
    }

    /// Reads back the depth buffer.
    pub fn depth_buffer(&self, gpu: &Gpu) -> Result<Vec<f32>> {
        self.read(gpu, &self.depth_texture, |_: &mut [f32]| ())
    }

    /// Reads back colours that were multiplied by their alpha and laid over nothing.
    pub fn colours(&self, gpu: &Gpu) -> Result<Vec<[u8; 4]>> {
        self.read(gpu, &self.color, |pixels: &mut [[u8; 4]]| {
            pixels.iter_mut().for_each(|pixel| *pixel = straight(*pixel));
        })
    }

    /// Reads back the faces that were drawn.
    pub fn faces(&self, gpu: &Gpu) -> Result<Vec<u32>> {
        self.read(gpu, self.faces.as_ref().expect("faces are drawn without samples"), |_: &mut [u32]| ())
    }

    /// Reads the texels of a texture; `finish` is called for every row of them.
    fn read<T: Pod + Send>(
        &self,
        gpu: &Gpu,
        texture: &Texture,
        finish: impl Fn(&mut [T]) + Sync,
    ) -> Result<Vec<T>> {
        let texel_bytes = size_of::<T>();
        let (row_bytes, width) = (row_bytes(self.width, texel_bytes as u64), self.width as usize);
        let buffer = self.reading.get_or_init(|| {
            // Depths and faces have 4 bytes a pixel, images in linear light more.
            let most_bytes = self::row_bytes(self.width, if self.is_linear { LINEAR_BYTES } else { 4 });
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: most_bytes * u64::from(self.height),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let bytes_per_row = Some(row_bytes as u32);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer, layout },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        readback::mapped(gpu, buffer, |bytes| {
            let mut texels = vec![T::zeroed(); width * self.height as usize];
            let rows = texels.par_chunks_exact_mut(width).zip(bytes.par_chunks_exact(row_bytes as usize));
            rows.for_each(|(row, bytes)| {
                row.copy_from_slice(bytemuck::cast_slice(&bytes[..texel_bytes * width]));
                finish(row);
            });
            texels
        })
    }
}

/// Divides a colour by its alpha, in linear light.
pub(super) fn straight(pixel: [u8; 4]) -> [u8; 4] {
    let [r, g, b, alpha] = pixel;
    if matches!(alpha, 0 | u8::MAX) {
        return pixel;
    }
    let own = |channel: u8| {
        let light = linear_of_srgb(f64::from(channel) / 255.0) * 255.0 / f64::from(alpha);
        (srgb_from_linear(light.clamp(0.0, 1.0)) * 255.0).round() as u8
    };
    [own(r), own(g), own(b), alpha]
}

/// As [`without_background`], in linear light. What covers less than a thousandth is nothing: its colour is noise.
fn without_flat([r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
    if alpha < 1e-3 {
        let flat = FLAT_LINEAR as f32;
        return [flat, flat, flat, 0.0];
    }
    let own = |light: f32| ((light - (1.0 - alpha) * FLAT_LINEAR as f32) / alpha).max(0.0);
    [own(r), own(g), own(b), alpha]
}

/// Removes the flat grey that a partly textured pixel was blended with, so that colour and alpha are
/// straight.
fn without_background(pixel: &mut [u8; 4]) {
    let alpha = f64::from(pixel[3]) / 255.0;
    for channel in &mut pixel[..3] {
        let linear = linear_of_srgb(f64::from(*channel) / 255.0);
        let own = (linear - (1.0 - alpha) * FLAT_LINEAR) / alpha;
        *channel = (srgb_from_linear(own.clamp(0.0, 1.0)) * 255.0).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_half_textured_gets_its_own_colour_back() {
        for (own, alpha) in [(20u8, 64u8), (200, 128), (255, 191)] {
            let share = f64::from(alpha) / 255.0;
            let mixed = linear_of_srgb(f64::from(own) / 255.0) * share + FLAT_LINEAR * (1.0 - share);
            let seen = (srgb_from_linear(mixed) * 255.0).round() as u8;
            let mut pixel = [seen, seen, seen, alpha];
            without_background(&mut pixel);
            // The mixture is off by half a step of 8 bits, 0.002 in linear light near the grey, and its
            // textured part by 1 / alpha times that.
            let error = linear_of_srgb(f64::from(pixel[0]) / 255.0) - linear_of_srgb(f64::from(own) / 255.0);
            assert!(error.abs() <= 0.004 / share, "{own} at {alpha}: {pixel:?}");
        }
    }

    #[test]
    fn a_pixel_in_linear_light_gets_its_own_light_back_also_above_white() {
        for (own, alpha) in [(0.02f32, 0.25f32), (3.5, 0.5), (0.7, 1.0)] {
            let mixed = own * alpha + FLAT_LINEAR as f32 * (1.0 - alpha);
            let [red, .., same] = without_flat([mixed, mixed, mixed, alpha]);
            assert!((red - own).abs() < 1e-5 && same == alpha, "{own} at {alpha}: {red}");
        }
        assert_eq!(without_flat([0.9, 0.9, 0.9, 0.0])[3], 0.0);
    }

    #[test]
    fn the_flat_grey_is_that_of_the_legend() {
        use quadratura_view::legend::UNCOVERED;
        assert!((linear_of_srgb(f64::from(UNCOVERED[0]) / 255.0) - FLAT_LINEAR).abs() < 1e-6);
    }
}
