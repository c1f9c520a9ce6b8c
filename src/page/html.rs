//! Text in HTML and in scripts, and templates.

/// Returns text that means itself in HTML.
pub fn escaped(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(letter),
        }
    }
    out
}

/// Returns JSON that may be a literal in a script, in a file of its own or within HTML: nothing in it ends the script or its line.
pub fn in_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// Fills a template, in which `{{NAME}}` stands for a value. What is put in is not looked at again, so that it may hold anything.
///
/// # Panics
/// Where the template, which is one of the program's own, names what is not among the values.
pub fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut parts = template.split("{{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("the template's brackets are in pairs");
        let value = values.iter().find(|(known, _)| *known == name).expect("the template names known values");
        out.push_str(value.1);
        out.push_str(rest);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_into_a_template_is_not_looked_at_again() {
        let text = filled("<p>{{a}} {{b}}</p>", &[("a", "{{b}}"), ("b", &escaped("<\"&>"))]);
        assert_eq!(text, "<p>{{b}} &lt;&quot;&amp;&gt;</p>");
    }

    #[test]
    fn json_in_a_script_neither_ends_it_nor_its_line() {
        let json = serde_json::to_string("</script>\u{2028}").unwrap();
        assert_eq!(in_script(&json), "\"\\u003c/script>\\u2028\"");
        let read: String = serde_json::from_str(&in_script(&json)).unwrap();
        assert_eq!(read, "</script>\u{2028}");
    }
}
