//! The command palette: what is typed in it, and which of the commands found is chosen.

/// The state of the command palette.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Palette {
    open: bool,
    /// The text that was typed.
    pub typed: String,
    /// The index of the chosen command among those found.
    pub chosen: usize,
}

impl Palette {
    /// Returns whether the palette is open.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Opens the palette empty, or closes it.
    pub fn toggle(&mut self) {
        *self = Self { open: !self.open, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_palette_that_is_opened_again_is_empty() {
        let mut palette = Palette::default();
        palette.toggle();
        (palette.typed, palette.chosen) = ("build".into(), 3);
        palette.toggle();
        assert!(!palette.is_open());
        palette.toggle();
        assert!(palette.is_open() && palette.typed.is_empty() && palette.chosen == 0);
    }
}
