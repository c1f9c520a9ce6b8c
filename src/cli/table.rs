//! Tables for a terminal: columns as wide as what they hold.

/// A table; text stands left, numbers right.
#[derive(Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With these headings.
    pub fn new(headings: &[&str]) -> Self {
        Self { rows: vec![headings.iter().map(ToString::to_string).collect()] }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The table as lines, without spaces at their ends.
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

    /// True when every cell below the heading begins like a number (or is a dash or nothing).
    fn is_numeric(&self, column: usize) -> bool {
        self.cells(column).skip(1).all(|cell| cell.is_empty() || cell == "-" || is_number(cell))
    }
}

/// A number, with a unit of three letters at most.
fn is_number(cell: &str) -> bool {
    let (number, unit) = cell.split_once(' ').unwrap_or((cell, ""));
    number.parse::<f64>().is_ok() && unit.chars().count() <= 3
}

/// `1 photo`, `2 photos`.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_left_and_numbers_right() {
        let mut table = Table::new(&["photo", "faces", "share"]);
        table.row(["tür.jpg".into(), "7".into(), "12 %".into()]);
        table.row(["b".into(), "1000".into(), "-".into()]);
        assert_eq!(table.render(), "photo    faces  share\ntür.jpg      7   12 %\nb         1000      -\n");
    }
}
