//! Materials.

use std::sync::Arc;

use gltf::json::material::{AlphaMode, Material as Described};
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;
use rustc_hash::FxHashMap;
use serde::Deserialize;

use super::super::leaf_names::is_called_leaf;
use super::super::notes::Notes;
use super::pictures::{Pictures, mean};
use crate::{Material, Pixels, Wrap};
use quadratura_base::error::Result;
use quadratura_import::models::gltf::{Source, parse};

/// The alpha below which there is nothing, where the file does not say.
const CUTOUT: f32 = 0.5;

/// What the package does not read of materials.
#[derive(Deserialize)]
struct MoreOfMaterials {
    #[serde(default)]
    materials: Vec<MoreOfMaterial>,
}

#[derive(Deserialize)]
struct MoreOfMaterial {
    #[serde(default)]
    extensions: Option<MaterialExtensions>,
}

#[derive(Deserialize)]
struct MaterialExtensions {
    #[serde(default, rename = "KHR_materials_diffuse_transmission")]
    transmission: Option<Transmission>,
}

/// `KHR_materials_diffuse_transmission`: the share `factor` of the light is let through and has the colour, the rest is
/// reflected.
#[derive(Deserialize)]
struct Transmission {
    #[serde(default, rename = "diffuseTransmissionFactor")]
    factor: f32,
    #[serde(default, rename = "diffuseTransmissionTexture")]
    factor_texture: Option<Info>,
    #[serde(default = "white", rename = "diffuseTransmissionColorFactor")]
    colour: [f32; 3],
    #[serde(default, rename = "diffuseTransmissionColorTexture")]
    colour_texture: Option<Info>,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// A material, and where its picture is on the surface.
#[derive(Clone)]
pub struct TexturedMaterial {
    /// The material.
    pub material: Arc<Material>,
    /// The set of texture coordinates, if there is a picture.
    pub texture_set: Option<u32>,
}

/// Reads materials, each once.
pub struct Materials<'a> {
    source: &'a Source<'a>,
    more: MoreOfMaterials,
    pictures: Pictures<'a>,
    /// The surfaces by the material's index; `None` inside for what is never seen.
    known: FxHashMap<Option<usize>, Option<TexturedMaterial>>,
}

impl<'a> Materials<'a> {
    /// Prepares the materials of a file.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with line and column, where extensions are damaged.
    pub fn new(source: &'a Source<'a>) -> Result<Self> {
        let more = parse(source.path, source.json)?;
        Ok(Self { source, more, pictures: Pictures::new(source), known: FxHashMap::default() })
    }

    /// Returns a material, or the usual one; `None`, with a note, for one that is never seen, because its alpha is below
    /// what is cut out.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with the JSON path; [`quadratura_base::Error::Io`] for pictures.
    pub fn surface(
        &mut self,
        material: Option<usize>,
        notes: &mut Notes,
    ) -> Result<Option<TexturedMaterial>> {
        if let Some(known) = self.known.get(&material) {
            return Ok(known.clone());
        }
        let surface = match material {
            None => self.described(&Described::default(), "", None, notes)?,
            Some(index) => {
                let place = format!("materials[{index}]");
                let source = self.source;
                let described = source.root.materials.get(index);
                let missing = || source.error(&place, "this material does not exist");
                self.described(described.ok_or_else(missing)?, &place, Some(index), notes)?
            }
        };
        self.known.insert(material, surface.clone());
        Ok(surface)
    }

    fn described(
        &mut self,
        described: &Described,
        place: &str,
        index: Option<usize>,
        notes: &mut Notes,
    ) -> Result<Option<TexturedMaterial>> {
        let base = &described.pbr_metallic_roughness;
        let [r, g, b, alpha] = base.base_color_factor.0.map(|share| share.clamp(0.0, 1.0));
        let texture = base.base_color_texture.as_ref();
        let at = || format!("{place}.pbrMetallicRoughness.baseColorTexture");
        let (picture, wrap) = match texture {
            Some(info) => self.picture(info, at)?,
            None => (None, [Wrap::Held; 2]),
        };
        let has_picture = picture.is_some();
        let Some(cutout) = cutout(described, alpha, has_picture) else {
            notes.add("a surface is left out, because its alpha is below what is cut out", || {
                place.to_owned()
            });
            return Ok(None);
        };
        if described.alpha_mode != Checked::Valid(AlphaMode::Opaque) && !has_picture {
            notes.add("alphaMode has no effect without a picture", || place.to_owned());
        }
        let (kept, through) = self.through(index, place)?;
        let name = name_of(described, index);
        let leaf = through.is_some() || (described.double_sided && cutout.is_some()) || is_called_leaf(&name);
        let (reflected, through) = ([r, g, b].map(|share| kept * share), through.unwrap_or_default());
        let material = Material { name, reflected, through, leaf, cutout, picture, wrap };
        let texture_set = texture.map(|info| info.tex_coord);
        Ok(Some(TexturedMaterial { material: Arc::new(material), texture_set }))
    }

    /// Returns the share of light that is left to be reflected, and what a leaf lets through.
    fn through(&mut self, index: Option<usize>, place: &str) -> Result<(f32, Option<[f32; 3]>)> {
        let more = index.and_then(|index| self.more.materials.get(index));
        let transmission = more.and_then(|more| more.extensions.as_ref()?.transmission.as_ref());
        let Some(Transmission { factor, factor_texture, colour, colour_texture }) = transmission else {
            return Ok((1.0, None));
        };
        let at = |name: &str| format!("{place}.extensions.KHR_materials_diffuse_transmission.{name}");
        let (mut factor, mut colour) = (factor.clamp(0.0, 1.0), colour.map(|share| share.clamp(0.0, 1.0)));
        // What is let through is one colour for the whole surface: pictures of it count by their means.
        if let Some(info) = factor_texture {
            factor *=
                mean(&*self.pictures.of_texture(info.index.value(), || at("diffuseTransmissionTexture"))?)[3];
        }
        if let Some(info) = colour_texture {
            let mean = mean(
                &*self.pictures.of_texture(info.index.value(), || at("diffuseTransmissionColorTexture"))?,
            );
            colour = std::array::from_fn(|channel| colour[channel] * mean[channel]);
        }
        Ok((1.0 - factor, Some(colour.map(|share| factor * share))))
    }

    /// Returns the picture of a texture, and how it goes on beyond its sides.
    fn picture(
        &mut self,
        info: &Info,
        place: impl Fn() -> String,
    ) -> Result<(Option<Arc<Pixels>>, [Wrap; 2])> {
        let picture = self.pictures.of_texture(info.index.value(), place)?;
        let root = &self.source.root;
        let sampler = root.textures.get(info.index.value()).and_then(|texture| texture.sampler);
        let sampler = sampler.and_then(|sampler| root.samplers.get(sampler.value()));
        let wrap = |mode: Option<&Checked<WrappingMode>>| match mode {
            Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::Held,
            Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::Mirrored,
            // Without a sampler, and where it does not say, pictures are repeated.
            _ => Wrap::Repeated,
        };
        let wrap = [wrap(sampler.map(|s| &s.wrap_s)), wrap(sampler.map(|s| &s.wrap_t))];
        Ok((Some(picture), wrap))
    }
}

/// Returns the alpha of the picture below which there is nothing, if it is cut out; `None` where nothing is left at all.
fn cutout(described: &Described, alpha: f32, has_picture: bool) -> Option<Option<f32>> {
    let threshold = match described.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => described.alpha_cutoff.map_or(CUTOUT, |cutoff| cutoff.0),
        Checked::Valid(AlphaMode::Blend) => CUTOUT,
        _ => return Some(None),
    };
    // The file's threshold is for the picture's alpha times the factor.
    (alpha >= threshold).then(|| has_picture.then(|| threshold.max(0.0) / alpha.max(f32::MIN_POSITIVE)))
}

/// Returns the name of a material, or one by its number; that of the usual material is its colour.
fn name_of(described: &Described, index: Option<usize>) -> String {
    let given = described.name.clone().filter(|name| !name.is_empty());
    given.unwrap_or_else(|| index.map_or("white".into(), |index| format!("material_{index}")))
}
