//! The texts of a page: `index.html`, which is also the page without a viewer.

use super::place_texts::DescribedText;
use quadratura_document::page::is_harmless;
use quadratura_page::html::{escaped, filled};
use quadratura_page::viewer;

/// What the page says.
pub struct PageTexts<'a> {
    /// The title.
    pub title: &'a str,
    /// The names of the viewpoints, of which there are pictures.
    pub views: &'a [&'a str],
    /// The texts at places.
    pub texts: &'a [DescribedText],
    /// Who is named, and the licence of the photos.
    pub credits: &'a [String],
    /// See [`Self::credits`].
    pub licence: Option<&'a str>,
    /// The chunks of the first picture, which the browser may read before the viewer asks for them.
    pub first_chunks: &'a [String],
}

/// Returns the HTML.
pub fn index(texts: &PageTexts) -> String {
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
    let articles: String = texts.texts.iter().map(article).collect();
    let title = escaped(texts.title);
    let values = [
        ("title", title.as_str()),
        ("version", env!("CARGO_PKG_VERSION")),
        ("views", &views),
        ("scripts", &viewer::SITE.script_elements()),
        ("preloads", &preloads),
        ("articles", &articles),
        ("credits", &credits(texts)),
    ];
    filled(viewer::SITE.index, &values)
}

/// Returns a text as it is read without the viewer.
fn article(text: &DescribedText) -> String {
    let link = text
        .link
        .as_ref()
        .map(|link| format!("<p><a href=\"{0}\">{0}</a></p>", escaped(link)))
        .unwrap_or_default();
    let language =
        text.language.as_ref().map(|tag| format!(" lang=\"{}\"", escaped(tag))).unwrap_or_default();
    let (title, text) = (escaped(&text.title), escaped(&text.text));
    format!("<article{language}><h2>{title}</h2><p>{text}</p>{link}</article>\n")
}

/// Returns who is named, and the licence, with a link to its text where it is an address or an SPDX name.
fn credits(texts: &PageTexts) -> String {
    let named: String = texts.credits.iter().map(|credit| format!("<p>{}</p>", escaped(credit))).collect();
    let licence = texts.licence.map(|licence| {
        let is_spdx = licence.chars().all(|letter| letter.is_ascii_alphanumeric() || "-.+".contains(letter));
        let address =
            if is_spdx { format!("https://spdx.org/licenses/{licence}.html") } else { licence.to_owned() };
        match is_harmless(&address) && address.contains("://") {
            true => format!(
                "<p>Photos: <a rel=\"license\" href=\"{}\">{}</a></p>",
                escaped(&address),
                escaped(licence)
            ),
            false => format!("<p>Photos: {}</p>", escaped(licence)),
        }
    });
    format!("{named}{}<p>Made with Quadratura.</p>", licence.unwrap_or_default())
}
