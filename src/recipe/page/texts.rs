//! The texts of a page: `index.html`, which is also the page without a viewer.

use quadratura_page::html::{escaped, filled};
use quadratura_page::viewer;

/// What the page says.
pub struct PageTexts<'a> {
    /// The title.
    pub title: &'a str,
    /// The names of the viewpoints, of which there are pictures.
    pub views: &'a [&'a str],
    /// The chunks of the first picture, which the browser may read before the viewer asks for them.
    pub first_chunks: &'a [String],
}

/// Returns the HTML.
pub fn index(texts: &PageTexts) -> String {
    let scripts: String = viewer::scripts()
        .iter()
        .map(|(name, _)| format!("<script src=\"code/{name}\" defer></script>\n"))
        .collect();
    let preloads: String = texts
        .first_chunks
        .iter()
        .map(|name| format!("<link rel=\"preload\" as=\"script\" href=\"data/{name}.js\">\n"))
        .collect();
    let view = |(number, name): (usize, &&str)| {
        let name = escaped(name);
        format!(
            "<figure><img src=\"views/{}.jpg\" width=\"1280\" height=\"800\" loading=\"lazy\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>\n",
            number + 1
        )
    };
    let views: String = texts.views.iter().enumerate().map(view).collect();
    let title = escaped(texts.title);
    let values = [
        ("title", title.as_str()),
        ("version", env!("CARGO_PKG_VERSION")),
        ("views", &views),
        ("scripts", &scripts),
        ("preloads", &preloads),
        ("credits", ""),
    ];
    filled(viewer::INDEX, &values)
}
