//! The pixels of a cyclic component: where its items lie and where they meet, row by row, from the fragment
//! lists.

use rustc_hash::FxHashMap;

use super::runs::{RowRuns, Run, Runs, is_visible, item_of};

/// A span of pixels of a row where several items of one component meet.
#[derive(Debug, Clone)]
pub struct Meeting {
    /// The row.
    pub y: u32,
    /// The first column.
    pub x0: u32,
    /// One past the last column.
    pub x1: u32,
    /// The items; two at least.
    pub items: Vec<u32>,
}

/// A span of pixels of a row that a node covers.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    /// The row.
    pub y: u32,
    /// The first column.
    pub x0: u32,
    /// One past the last column.
    pub x1: u32,
    /// True where nothing is nearer.
    pub visible: bool,
    /// Index of the run of row `y` that the span is part of.
    pub run: u32,
}

/// The pixels of one component.
#[derive(Debug, Clone, Default)]
pub struct ComponentPixels {
    /// The spans where items meet, row by row.
    pub meetings: Vec<Meeting>,
    /// The spans that each item covers, row by row.
    pub spans: FxHashMap<u32, Vec<Span>>,
}

/// Gathers the pixels of each of `components`, which are lists of item indices below `items`.
pub fn gather_components(runs: &Runs, components: &[Vec<u32>], items: usize) -> Vec<ComponentPixels> {
    const NONE: u32 = u32::MAX;
    let mut component_of = vec![NONE; items];
    for (c, nodes) in components.iter().enumerate() {
        nodes.iter().for_each(|&n| component_of[n as usize] = c as u32);
    }
    let mut pixels = vec![ComponentPixels::default(); components.len()];
    if components.is_empty() {
        return pixels;
    }
    // Items are few and runs are many: spans are gathered in a list by item, and moved to their components at the end.
    let mut spans: Vec<Vec<Span>> = vec![Vec::new(); items];
    let mut of_run: Vec<(u32, u32)> = Vec::new();
    for (y, i, run, entries) in runs.rows.iter().enumerate().flat_map(numbered_runs) {
        of_run.clear();
        for &entry in entries {
            let item = item_of(entry);
            let c = component_of[item as usize];
            if c != NONE {
                let span = Span { y, x0: run.x0, x1: run.x1, visible: is_visible(entry), run: i };
                spans[item as usize].push(span);
                of_run.push((c, item));
            }
        }
        of_run.sort_unstable();
        for group in of_run.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() > 1) {
            let items = group.iter().map(|g| g.1).collect();
            let meeting = Meeting { y, x0: run.x0, x1: run.x1, items };
            pixels[group[0].0 as usize].meetings.push(meeting);
        }
    }
    for (item, spans) in spans.into_iter().enumerate().filter(|(_, spans)| !spans.is_empty()) {
        pixels[component_of[item] as usize].spans.insert(item as u32, spans);
    }
    pixels
}

/// Iterates over the runs of a row: row, index within the row, run and entries.
fn numbered_runs((y, row): (usize, &RowRuns)) -> impl Iterator<Item = (u32, u32, &Run, &[u32])> {
    (0..).zip(&row.runs).map(move |(i, run)| (y as u32, i, run, row.entries(run)))
}

/// Counts the pixels of the spans where `holds` is true. Depths are linear along a row, so the result of
/// `holds` changes at most once per span, apart from rounding at the crossing.
pub fn count_in(spans: &[Span], holds: impl Fn(u32, u32) -> bool) -> u64 {
    spans
        .iter()
        .map(|s| {
            let (first, last) = (holds(s.x0, s.y), holds(s.x1 - 1, s.y));
            let crossing = crossing(s, |x| holds(x, s.y) == first);
            match (first, last) {
                (true, true) => s.x1 - s.x0,
                (false, false) => 0,
                (true, false) => crossing - s.x0,
                (false, true) => s.x1 - crossing,
            }
        })
        .map(u64::from)
        .sum()
}

/// Finds the first column of the span where `like_first` no longer holds.
fn crossing(span: &Span, like_first: impl Fn(u32) -> bool) -> u32 {
    let (mut low, mut high) = (span.x0, span.x1);
    while low < high {
        let middle = low + (high - low) / 2;
        if like_first(middle) { low = middle + 1 } else { high = middle }
    }
    low
}

/// Returns the part of a span where `on_side` holds. Rounding may put a pixel at the crossing on the wrong
/// side, so these spans serve to estimate counts, never for decisions.
#[inline]
pub fn split_span(span: &Span, on_side: impl Fn(u32, u32) -> bool) -> Option<Span> {
    let (first, last) = (on_side(span.x0, span.y), on_side(span.x1 - 1, span.y));
    let crossing = crossing(span, |x| on_side(x, span.y) == first);
    match (first, last) {
        (true, true) => Some(*span),
        (false, false) => None,
        (true, false) => Some(Span { x1: crossing, ..*span }),
        (false, true) => Some(Span { x0: crossing, ..*span }),
    }
}
