//! The table of `--timings`: seconds by stage and photo, and the peak memory.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::{Value, json};

use super::bytes::readable_bytes;
use super::machine::peak_memory;
use super::table::Table;

/// The times that [`quadratura_base::task::Event::Timing`] reported.
#[derive(Debug, Default, Clone)]
pub struct Timings {
    /// Stages in order of first appearance.
    stages: Vec<&'static str>,
    /// Times by subject, then stage.
    spent: BTreeMap<String, BTreeMap<&'static str, Duration>>,
}

impl Timings {
    /// Adds to the time of a stage of a subject.
    pub fn add(&mut self, subject: String, stage: &'static str, spent: Duration) {
        if !self.stages.contains(&stage) {
            self.stages.push(stage);
        }
        *self.spent.entry(subject).or_default().entry(stage).or_default() += spent;
    }

    /// Returns a table with a row for each photo and one for the sum, and a column for each stage, in seconds
    /// of the thread that worked on it: with several threads the sum exceeds the elapsed time.
    pub fn render(&self, wall: Duration) -> String {
        let mut headings = vec!["seconds"];
        headings.extend(&self.stages);
        let mut table = Table::new(&headings);
        for (subject, spent) in &self.spent {
            let subject = if subject.is_empty() { "(all photos)" } else { subject };
            table.row(self.cells(subject, |stage| spent.get(stage).copied()));
        }
        table.row(self.cells("sum", |stage| Some(self.sum(stage))));
        let memory = peak_memory().map(|bytes| format!(", peak memory {}", readable_bytes(bytes)));
        let memory = memory.unwrap_or_default();
        format!("{}{:.2} s elapsed{memory}\n", table.render(), wall.as_secs_f64())
    }

    /// Returns the same as JSON.
    pub fn to_json(&self, wall: Duration) -> Value {
        let seconds = |spent: &BTreeMap<&'static str, Duration>| -> BTreeMap<&str, f64> {
            spent.iter().map(|(stage, spent)| (*stage, spent.as_secs_f64())).collect()
        };
        let by_subject: BTreeMap<_, _> =
            self.spent.iter().map(|(name, spent)| (name, seconds(spent))).collect();
        json!({
            "seconds": by_subject,
            "wall_seconds": wall.as_secs_f64(),
            "peak_memory_bytes": peak_memory(),
        })
    }

    fn sum(&self, stage: &str) -> Duration {
        self.spent.values().filter_map(|spent| spent.get(stage)).sum()
    }

    fn cells(&self, subject: &str, spent: impl Fn(&str) -> Option<Duration>) -> Vec<String> {
        let seconds = |spent: Duration| format!("{:.3}", spent.as_secs_f64());
        let cell = |stage: &&'static str| spent(stage).map_or_else(|| "-".into(), seconds);
        [subject.to_owned()].into_iter().chain(self.stages.iter().map(cell)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_columns_photos_are_rows_and_both_add_up() {
        let mut timings = Timings::default();
        for (photo, stage, ms) in
            [("b", "sort", 500), ("a", "sort", 250), ("a", "save", 100), ("a", "sort", 250)]
        {
            timings.add(photo.into(), stage, Duration::from_millis(ms));
        }
        let text = timings.render(Duration::from_secs(2));
        let rows: Vec<Vec<_>> = text.lines().take(4).map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows[0], ["seconds", "sort", "save"]);
        assert_eq!(rows[1], ["a", "0.500", "0.100"]);
        assert_eq!(rows[2], ["b", "0.500", "-"]);
        assert_eq!(rows[3], ["sum", "1.000", "0.100"]);
        assert!(text.lines().last().unwrap().starts_with("2.00 s elapsed"));
        assert_eq!(timings.to_json(Duration::ZERO)["seconds"]["a"]["sort"], 0.5);
    }
}
