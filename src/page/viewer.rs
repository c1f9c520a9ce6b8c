//! The sources of the viewer of sites. They are classic scripts, in the order in which a page names them: browsers refuse modules that
//! are opened from disk.

/// The page, a template.
pub const INDEX: &str = include_str!("viewer/index.html");

/// The style.
pub const STYLE: &str = include_str!("viewer/viewer.css");

/// The scripts without shaders.
const SCRIPTS: &[(&str, &str)] = &[
    ("math.js", include_str!("viewer/math.js")),
    ("chunks.js", include_str!("viewer/chunks.js")),
    ("geometry.js", include_str!("viewer/geometry.js")),
    ("lists.js", include_str!("viewer/lists.js")),
    ("exposure.js", include_str!("viewer/exposure.js")),
    ("textures.js", include_str!("viewer/textures.js")),
    ("tables.js", include_str!("viewer/tables.js")),
    ("target.js", include_str!("viewer/target.js")),
    ("painter.js", include_str!("viewer/painter.js")),
    ("ground.js", include_str!("viewer/ground.js")),
    ("walk.js", include_str!("viewer/walk.js")),
    ("input.js", include_str!("viewer/input.js")),
    ("stations.js", include_str!("viewer/stations.js")),
    ("texts.js", include_str!("viewer/texts.js")),
    ("share.js", include_str!("viewer/share.js")),
    ("start.js", include_str!("viewer/start.js")),
];

/// The shaders, each with the file that it is read from.
const SHADERS: &[(&str, &str)] = &[
    ("weights", include_str!("viewer/weights.glsl")),
    ("tables", include_str!("viewer/tables.glsl")),
    ("texels", include_str!("viewer/texels.glsl")),
    ("blend", include_str!("viewer/blend.glsl")),
    ("around", include_str!("viewer/around.glsl")),
    ("surface_vertex", include_str!("viewer/surface_vertex.glsl")),
    ("surface", include_str!("viewer/surface.glsl")),
    ("depth", include_str!("viewer/depth.glsl")),
    ("whole", include_str!("viewer/whole.glsl")),
    ("behind", include_str!("viewer/behind.glsl")),
    ("reduce", include_str!("viewer/reduce.glsl")),
    ("halve", include_str!("viewer/halve.glsl")),
];

/// Returns the names and contents of all scripts, in the order in which a page names them.
pub fn scripts() -> Vec<(&'static str, String)> {
    let text = |source: &str| serde_json::to_string(&without_indents(source)).expect("text is JSON");
    let lines: String = SHADERS
        .iter()
        .map(|(name, source)| format!("quadratura.shaders.{name} = {};\n", text(source)))
        .collect();
    let shaders = format!("// The shaders of the viewer, one a line.\n{lines}");
    let mut scripts: Vec<(&str, String)> =
        SCRIPTS.iter().map(|(name, source)| (*name, without_comments(source))).collect();
    scripts.insert(1, ("shaders.js", shaders));
    scripts
}

/// Returns a source without lines of comments: every visitor would load them.
fn without_comments(source: &str) -> String {
    let lines = source.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// Returns a shader without comments and indents, which nobody reads within a line of a script.
fn without_indents(source: &str) -> String {
    let source = without_comments(source);
    let lines = source.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.map(|line| format!("{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_short_enough_to_be_read_and_small_enough_to_be_sent() {
        for (name, source) in SCRIPTS.iter().chain(SHADERS) {
            let lines = source.lines().count();
            assert!(lines <= 250, "{name} has {lines} lines");
        }
        let bytes: usize = scripts().iter().map(|(_, source)| source.len()).sum();
        assert!(bytes + STYLE.len() + INDEX.len() <= 120_000, "{bytes} bytes");
    }
}
