//! The grammar of Nuke's scripts: nodes with knobs, and a stack of nodes that become inputs.

use std::fmt::Write as _;

/// A script while it is written.
pub struct Script {
    text: String,
    indent: &'static str,
}

impl Script {
    /// Begins a script.
    pub fn new(generator: &str) -> Self {
        Self { text: format!("#! Nuke -nx\n# {generator}\nversion 12.0\n"), indent: "" }
    }

    /// Writes a node, which takes `inputs` nodes from the stack, the topmost as input 0, and is put on it. Values are as they stand in
    /// scripts.
    pub fn node(&mut self, class: &str, inputs: usize, knobs: &[(&str, String)]) {
        let indent = self.indent;
        self.line(format_args!("{indent}{class} {{"));
        // One input is what a node takes where nothing is said.
        if inputs != 1 && class != "Root" {
            self.line(format_args!("{indent} inputs {inputs}"));
        }
        for (knob, value) in knobs {
            self.line(format_args!("{indent} {knob} {value}"));
        }
        self.line(format_args!("{indent}}}"));
    }

    /// Names the topmost node of the stack.
    pub fn set(&mut self, name: &str) {
        let indent = self.indent;
        self.line(format_args!("{indent}set {name} [stack 0]"));
    }

    /// Puts a named node on the stack.
    pub fn push(&mut self, name: &str) {
        let indent = self.indent;
        self.line(format_args!("{indent}push ${name}"));
    }

    /// Begins a group without inputs; nodes of a group have a stack of their own.
    pub fn begin_group(&mut self, name: &str, label: &str) {
        self.node("Group", 0, &[("label", quoted(label)), ("name", name.to_owned())]);
        self.indent = " ";
    }

    /// Ends the group, which is on the stack now.
    pub fn end_group(&mut self) {
        self.indent = "";
        self.line(format_args!("end_group"));
    }

    /// Returns the text.
    pub fn finish(self) -> String {
        self.text
    }

    fn line(&mut self, line: std::fmt::Arguments) {
        writeln!(self.text, "{line}").expect("memory does not fail");
    }
}

/// Returns a text in quotes, in which Tcl replaces nothing.
pub fn quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' | '[' | ']' | '$' | '{' | '}' => quoted.extend(['\\', c]),
            // Knobs of a line: a name with a break in it keeps its words.
            '\n' | '\r' => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// Returns a number with all its digits, without an exponent.
pub fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}
