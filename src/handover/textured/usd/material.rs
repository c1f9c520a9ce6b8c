//! The material of a page, or of the tiles of a picture.

use crate::textured::{PageKind, TexturePage};

/// Writes the material of a page, which is called `name`; of tiles, `page` is one of them.
pub(super) fn write(text: &mut String, name: &str, page: &TexturePage) {
    let file = match page.tile {
        Some(_) => format!("{}.<UDIM>{}", page.set(), page.kind.ending()),
        None => page.file.clone(),
    };
    let (opacity, alpha) = match page.kind {
        PageKind::PngWithAlpha => (
            format!(
                "                float inputs:opacity.connect = </site/materials/{name}/texture.outputs:a>\n                \
                 float inputs:opacityThreshold = 0.5\n"
            ),
            "                float outputs:a\n",
        ),
        PageKind::Jpeg | PageKind::Png | PageKind::Grey => (String::new(), ""),
    };
    text.push_str(&format!(
        r#"        def Material "{name}"
        {{
            token outputs:surface.connect = </site/materials/{name}/surface.outputs:surface>

            def Shader "surface"
            {{
                uniform token info:id = "UsdPreviewSurface"
                color3f inputs:diffuseColor = (0, 0, 0)
                color3f inputs:emissiveColor.connect = </site/materials/{name}/texture.outputs:rgb>
{opacity}                float inputs:roughness = 1
                color3f inputs:specularColor = (0, 0, 0)
                int inputs:useSpecularWorkflow = 1
                token outputs:surface
            }}

            def Shader "texture"
            {{
                uniform token info:id = "UsdUVTexture"
                asset inputs:file = @./{file}@
                token inputs:sourceColorSpace = "sRGB"
                float2 inputs:st.connect = </site/materials/{name}/coordinates.outputs:result>
                token inputs:wrapS = "clamp"
                token inputs:wrapT = "clamp"
{alpha}                float3 outputs:rgb
            }}

            def Shader "coordinates"
            {{
                uniform token info:id = "UsdPrimvarReader_float2"
                string inputs:varname = "st"
                float2 outputs:result
            }}
        }}

"#
    ));
}
