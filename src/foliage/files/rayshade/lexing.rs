//! The next word, comment or directive of a text.

use super::source::{Frame, Kind, Place};

/// What is next in a text.
pub(super) enum Lexeme {
    /// A word, or a sign within parentheses.
    Word(String),
    /// A word that was between quotation marks, and is no macro.
    Quoted(String),
    /// A line that began with `#`, without it.
    Directive(String),
    /// A comment that is never closed, and where it begins.
    OpenComment(Place),
    /// The end of the text.
    End,
}

/// Takes what is next. Within parentheses signs are words of their own. Where lines are skipped, only directives are found.
pub(super) fn lexeme(frame: &mut Frame, is_expression: bool, is_skipped: bool) -> Lexeme {
    loop {
        let rest = &frame.text[frame.at..];
        let Some(sign) = rest.chars().next() else { return Lexeme::End };
        if sign == '\n' {
            frame.at += 1;
            frame.next_line();
        } else if sign.is_whitespace() {
            frame.at += sign.len_utf8();
        } else if sign == '#' && frame.is_line_start && matches!(frame.kind, Kind::File { .. }) {
            return Lexeme::Directive(frame.rest_of_line());
        } else if is_skipped {
            frame.at += rest.find('\n').unwrap_or(rest.len());
        } else if let Some(comment) = rest.strip_prefix("/*") {
            let Some(length) = comment.find("*/") else {
                return Lexeme::OpenComment(frame.own_place());
            };
            frame.pass(length + 4);
        } else {
            frame.is_line_start = false;
            return frame.word(sign, is_expression);
        }
    }
}

impl Frame {
    /// Takes a number of bytes, which may hold ends of lines.
    fn pass(&mut self, bytes: usize) {
        let end = self.at + bytes;
        let lines = self.text[self.at..end].matches('\n').count();
        self.at = end;
        (0..lines).for_each(|_| self.next_line());
    }

    fn next_line(&mut self) {
        self.is_line_start = true;
        if let Kind::File { place, .. } = &mut self.kind {
            place.line = place.line.saturating_add(1);
        }
    }

    fn own_place(&self) -> Place {
        match &self.kind {
            Kind::File { place, .. } => place.clone(),
            Kind::Macro(name) => Place { file: std::path::Path::new(name).into(), line: 1 },
        }
    }

    /// Takes what is after a `#` up to the end of the line, or of the lines that `\` joins, without comments.
    fn rest_of_line(&mut self) -> String {
        let mut line = String::new();
        self.at += 1;
        loop {
            let rest = &self.text[self.at..];
            let Some(sign) = rest.chars().next().filter(|sign| *sign != '\n') else { return line };
            let joined = ["\\\n", "\\\r\n"].iter().find(|end| rest.starts_with(**end));
            let comment = rest.strip_prefix("/*").and_then(|rest| rest.find("*/"));
            match (joined, comment) {
                (Some(end), _) => {
                    let end = end.len();
                    self.pass(end);
                    line.push(' ');
                }
                (_, Some(length)) => {
                    self.pass(length + 4);
                    line.push(' ');
                }
                _ => {
                    line.push(sign);
                    self.at += sign.len_utf8();
                }
            }
        }
    }

    /// Takes the word that begins with a sign.
    fn word(&mut self, sign: char, is_expression: bool) -> Lexeme {
        let rest = &self.text[self.at..];
        if sign == '"' {
            let text = rest[1..].split(['"', '\n']).next().unwrap_or_default().to_owned();
            let closing = usize::from(rest[1 + text.len()..].starts_with('"'));
            self.at += 1 + text.len() + closing;
            return Lexeme::Quoted(text);
        }
        let length = match sign {
            '(' | ')' => 1,
            _ if is_expression => length_in_expression(rest, sign),
            _ => {
                let end = rest.find(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | '"'));
                let word = &rest[..end.unwrap_or(rest.len())];
                word.find("/*").unwrap_or(word.len())
            }
        };
        let word = rest[..length].to_owned();
        self.at += length;
        Lexeme::Word(word)
    }
}

/// Returns the length of a number, a name or a sign.
fn length_in_expression(text: &str, sign: char) -> usize {
    if sign.is_alphabetic() || sign == '_' {
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
        return end.unwrap_or(text.len());
    }
    if !sign.is_ascii_digit() && sign != '.' {
        return sign.len_utf8();
    }
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count()
    };
    let end = digits(0);
    if !matches!(bytes.get(end), Some(b'e' | b'E')) {
        return end;
    }
    let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
    let more = digits(end + 1 + sign);
    if more > end + 1 + sign { more } else { end }
}
