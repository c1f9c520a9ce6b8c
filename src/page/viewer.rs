//! The sources of viewers. They are classic scripts, in the order in which a page names them: browsers refuse modules that are opened
//! from disk. What all viewers share is in `common`, and what shows sites in `viewer`.

/// The name and content of a source.
pub type Source = (&'static str, &'static str);

/// What shows a kind of page, beside what all pages share.
#[derive(Debug, Clone, Copy)]
pub struct PageViewer {
    /// The page, a template.
    pub index: &'static str,
    /// The style.
    pub style: &'static str,
    /// The scripts without shaders, by file name.
    pub scripts: &'static [Source],
    /// The shaders, by the names that scripts know them by.
    pub shaders: &'static [Source],
}

/// The scripts of all viewers, of which shaders follow the first.
const SHARED_SCRIPTS: &[Source] = &[
    ("base.js", include_str!("common/base.js")),
    ("chunks.js", include_str!("common/chunks.js")),
    ("target.js", include_str!("common/target.js")),
    ("headset.js", include_str!("common/headset.js")),
];
/// The shaders of all viewers.
const SHARED_SHADERS: &[Source] =
    &[("whole", include_str!("common/whole.glsl")), ("reduce", include_str!("common/reduce.glsl"))];
/// The style of all pages.
const SHARED_STYLE: &str = include_str!("common/base.css");

/// The viewer of sites.
pub const SITE: PageViewer = PageViewer {
    index: include_str!("viewer/index.html"),
    style: include_str!("viewer/viewer.css"),
    scripts: &[
        ("math.js", include_str!("viewer/math.js")),
        ("description.js", include_str!("viewer/description.js")),
        ("geometry.js", include_str!("viewer/geometry.js")),
        ("lists.js", include_str!("viewer/lists.js")),
        ("exposure.js", include_str!("viewer/exposure.js")),
        ("levels.js", include_str!("viewer/levels.js")),
        ("textures.js", include_str!("viewer/textures.js")),
        ("tables.js", include_str!("viewer/tables.js")),
        ("meter.js", include_str!("viewer/meter.js")),
        ("painter.js", include_str!("viewer/painter.js")),
        ("ground.js", include_str!("viewer/ground.js")),
        ("walk.js", include_str!("viewer/walk.js")),
        ("walk_in_headset.js", include_str!("viewer/walk_in_headset.js")),
        ("input.js", include_str!("viewer/input.js")),
        ("stations.js", include_str!("viewer/stations.js")),
        ("texts.js", include_str!("viewer/texts.js")),
        ("share.js", include_str!("viewer/share.js")),
        ("start.js", include_str!("viewer/start.js")),
    ],
    shaders: &[
        ("weights", include_str!("viewer/weights.glsl")),
        ("tables", include_str!("viewer/tables.glsl")),
        ("meter", include_str!("viewer/meter.glsl")),
        ("texels", include_str!("viewer/texels.glsl")),
        ("blend", include_str!("viewer/blend.glsl")),
        ("around", include_str!("viewer/around.glsl")),
        ("surface_vertex", include_str!("viewer/surface_vertex.glsl")),
        ("surface", include_str!("viewer/surface.glsl")),
        ("depth", include_str!("viewer/depth.glsl")),
        ("behind", include_str!("viewer/behind.glsl")),
        ("halve", include_str!("viewer/halve.glsl")),
    ],
};

impl PageViewer {
    /// Returns the names and contents of the files of the viewer: scripts in `code`, in the order in which a page names them, and the
    /// style.
    pub fn files(&self) -> Vec<(String, String)> {
        let code = self.code().into_iter().map(|(name, content)| (format!("code/{name}"), content));
        code.chain([("viewer.css".to_owned(), format!("{SHARED_STYLE}{}", self.style))]).collect()
    }

    /// Returns the elements by which a page names the scripts.
    pub fn script_elements(&self) -> String {
        let element = |name: &str| format!("<script src=\"code/{name}\" defer></script>\n");
        self.code().iter().map(|(name, _)| element(name)).collect()
    }

    fn code(&self) -> Vec<(&'static str, String)> {
        let text = |source: &str| serde_json::to_string(&without_indents(source)).expect("text is JSON");
        let lines: String = SHARED_SHADERS
            .iter()
            .chain(self.shaders)
            .map(|(name, source)| format!("quadratura.shaders.{name} = {};\n", text(source)))
            .collect();
        let scripts = SHARED_SCRIPTS.iter().chain(self.scripts);
        let mut code: Vec<_> = scripts.map(|(name, source)| (*name, shortened(source))).collect();
        code.insert(1, ("shaders.js", format!("// The shaders of the viewer, one a line.\n{lines}")));
        code
    }
}

/// Returns a source without lines of comments and empty ones, with a tab for two blanks of indent, and without the first of them, which
/// nearly every line has: every visitor loads them.
fn shortened(source: &str) -> String {
    let says_something = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with("//");
    let lines = source.lines().filter(says_something);
    let indented = |line: &str| {
        let text = line.trim_start_matches(' ');
        let level = (line.len() - text.len()).div_ceil(2);
        format!("{}{text}\n", "\t".repeat(level.saturating_sub(1)))
    };
    lines.map(indented).collect()
}

/// Returns a shader without comments and indents, which nobody reads within a line of a script.
fn without_indents(source: &str) -> String {
    shortened(source).lines().map(|line| format!("{}\n", line.trim_start())).collect()
}

/// Checks that the sources of a viewer can be read, and are small enough to be sent.
///
/// # Panics
/// Where one has more than 250 lines, or all together more than 120 kB.
pub fn assert_small(viewer: &PageViewer) {
    let sources = SHARED_SCRIPTS.iter().chain(SHARED_SHADERS).chain(viewer.scripts).chain(viewer.shaders);
    for (name, source) in sources {
        let lines = source.lines().count();
        assert!(lines <= 250, "{name} has {lines} lines");
    }
    let bytes: usize = viewer.files().iter().map(|(_, content)| content.len()).sum();
    assert!(bytes + viewer.index.len() <= 120_000, "{bytes} bytes");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_short_enough_to_be_read_and_small_enough_to_be_sent() {
        assert_small(&SITE);
    }
}
