//! Tables for a terminal, with columns as wide as their contents.

/// A table with text aligned left and numbers aligned right.
#[derive(Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates a table with these headings.
    pub fn new(headings: &[&str]) -> Self {
        Self { rows: vec![headings.iter().map(ToString::to_string).collect()] }
    }

    /// Adds a row of cells, in the order of the headings.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Returns the table as lines without trailing spaces.
    pub fn render(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<_> = (0..columns).map(|column| self.width(column)).collect();
        let numeric: Vec<_> = (0..columns).map(|column| self.is_numeric(column)).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                let padding = " ".repeat(widths[column] - cell.chars().count());
                let gap = if column == 0 { "" } else { "  " };
                match numeric[column] {
                    true => line.extend([gap, &padding, cell]),
                    false => line.extend([gap, cell, &padding]),
                }
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }

    fn cells(&self, column: usize) -> impl Iterator<Item = &String> {
        self.rows.iter().filter_map(move |row| row.get(column))
    }

    fn width(&self, column: usize) -> usize {
        self.cells(column).map(|cell| cell.chars().count()).max().unwrap_or(0)
    }

    /// Returns whether every cell below the heading is a number, a dash or empty.
    fn is_numeric(&self, column: usize) -> bool {
        self.cells(column).skip(1).all(|cell| cell.is_empty() || cell == "-" || is_number(cell))
    }
}

/// Returns whether a cell is a number, possibly with a unit of at most three letters.
fn is_number(cell: &str) -> bool {
    let (number, unit) = cell.split_once(' ').unwrap_or((cell, ""));
    number.parse::<f64>().is_ok() && unit.chars().count() <= 3
}

/// Returns `1 photo`, `2 photos`.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_aligned_left_and_numbers_right() {
        let mut table = Table::new(&["photo", "faces", "share"]);
        table.row(["tür.jpg".into(), "7".into(), "12 %".into()]);
        table.row(["b".into(), "1000".into(), "-".into()]);
        assert_eq!(table.render(), "photo    faces  share\ntür.jpg      7   12 %\nb         1000      -\n");
    }
}
