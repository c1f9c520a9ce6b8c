//! The cursor of the lists: it moves along the rows, opens and closes them, and selects one layer or a range.

use super::ListsState;
use super::row::ListRow;
use super::rows::ListedSite;
use crate::state::request::{Request, SelectRequest};
use crate::state::selection::Selection;
use quadratura_layers::LayerIndex;

impl ListsState {
    /// Returns the place of the cursor among the rows.
    pub fn here(&self, rows: &[ListRow]) -> Option<usize> {
        self.cursor.and_then(|cursor| rows.iter().position(|row| *row == cursor))
    }

    /// Opens a closed row; returns the place of the first row below an open one.
    pub fn enter(&mut self, rows: &[ListRow], here: usize, as_table: bool) -> Option<usize> {
        let row = rows[here];
        if row.opens() && !self.is_open(row) {
            self.set_open(row, true);
            return None;
        }
        let to = along(rows, Some(here), true)?;
        (rows[to].level(as_table) > row.level(as_table)).then_some(to)
    }

    /// Closes an open row; returns the place of the parent of a closed one.
    pub fn leave(&mut self, rows: &[ListRow], here: usize, as_table: bool) -> Option<usize> {
        let row = rows[here];
        if row.opens() && self.is_open(row) {
            self.set_open(row, false);
            return None;
        }
        let is_above = |other: &ListRow| other.is_stop() && other.level(as_table) < row.level(as_table);
        rows[..here].iter().rposition(is_above)
    }

    /// Moves the cursor to a row and selects it, or all layers from the anchor to it. `selected` is what is selected
    /// before.
    pub fn go(
        &mut self,
        site: &ListedSite<'_>,
        selected: Selection,
        rows: &[ListRow],
        to: usize,
        extends: bool,
    ) -> Option<Request> {
        let row = rows[to];
        self.cursor = Some(row);
        match row {
            ListRow::Layer(layer) if extends => self.select_range(site, selected, rows, layer),
            ListRow::Layer(layer) => self.select_layer(site, layer),
            _ => site.selection(row).map(|it| SelectRequest::Only(it).into()),
        }
    }

    /// Selects one layer and makes it the anchor of a range.
    pub fn select_layer(&mut self, site: &ListedSite<'_>, layer: LayerIndex) -> Option<Request> {
        let photo = site.photo?;
        self.anchor = Some((photo, layer));
        Some(SelectRequest::Only(Selection::Layer { photo, layer }).into())
    }

    /// Adds a layer to the selection or removes it, and makes it the anchor of a range.
    pub fn toggle_layer(&mut self, site: &ListedSite<'_>, layer: LayerIndex) -> Option<Request> {
        let photo = site.photo?;
        self.anchor = Some((photo, layer));
        Some(SelectRequest::Toggle(photo, layer).into())
    }

    /// Selects the listed layers from the anchor to this one.
    pub fn select_range(
        &mut self,
        site: &ListedSite<'_>,
        selected: Selection,
        rows: &[ListRow],
        to: LayerIndex,
    ) -> Option<Request> {
        let photo = site.photo?;
        let begun = self.anchor.filter(|(of, _)| *of == photo).map(|(_, layer)| layer);
        let selected = match selected {
            Selection::Layer { photo: of, layer } if of == photo => Some(layer),
            _ => None,
        };
        let layers: Vec<LayerIndex> = rows
            .iter()
            .filter_map(|row| if let ListRow::Layer(layer) = row { Some(*layer) } else { None })
            .collect();
        let from = begun.or(selected).unwrap_or(to);
        self.anchor = Some((photo, from));
        Some(SelectRequest::Layers(photo, between(&layers, from, to)).into())
    }
}

/// Returns the part of a list between two entries, inclusive, with `to` last; only `to` where `from` is not in the
/// list.
fn between(listed: &[LayerIndex], from: LayerIndex, to: LayerIndex) -> Vec<LayerIndex> {
    let index = |of: LayerIndex| listed.iter().position(|layer| *layer == of);
    let (Some(a), Some(b)) = (index(from), index(to)) else { return vec![to] };
    let mut range = listed[a.min(b)..=a.max(b)].to_vec();
    if b < a {
        range.reverse();
    }
    range
}

/// Returns the next row that the cursor stops at, or the previous one; the first where there is no cursor.
pub fn along(rows: &[ListRow], here: Option<usize>, down: bool) -> Option<usize> {
    match (here, down) {
        (None, _) => rows.iter().position(|row| row.is_stop()),
        (Some(here), true) => {
            rows.iter().skip(here + 1).position(|row| row.is_stop()).map(|more| here + 1 + more)
        }
        (Some(here), false) => rows[..here].iter().rposition(|row| row.is_stop()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::FaceIndex;
    use quadratura_base::scene::ObjectId;

    const ROWS: [ListRow; 6] = [
        ListRow::Layers,
        ListRow::Depth(0),
        ListRow::Layer(LayerIndex(4)),
        ListRow::Layer(LayerIndex(2)),
        ListRow::Objects,
        ListRow::Object(ObjectId(0)),
    ];

    #[test]
    fn arrows_pass_over_what_cannot_be_selected() {
        let rows = [
            ListRow::Layers,
            ListRow::Head,
            ListRow::Layer(LayerIndex(2)),
            ListRow::Layer(LayerIndex(0)),
            ListRow::Objects,
            ListRow::Say("none"),
        ];
        assert_eq!(along(&rows, None, true), Some(0));
        assert_eq!(along(&rows, Some(0), true), Some(2));
        assert_eq!(along(&rows, Some(2), false), Some(0));
        assert_eq!(along(&rows, Some(4), true), None);
        assert_eq!(along(&rows, Some(0), false), None);
    }

    #[test]
    fn a_range_goes_by_what_is_listed_whichever_way_it_is_drawn() {
        let range = |from, to| -> Vec<u32> {
            let listed = [4, 2, 9, 1].map(LayerIndex);
            between(&listed, LayerIndex(from), LayerIndex(to)).into_iter().map(|layer| layer.0).collect()
        };
        assert_eq!(range(2, 1), [2, 9, 1]);
        assert_eq!(range(1, 2), [1, 9, 2], "the one gone to is last");
        assert_eq!(range(7, 9), [9], "where it began is not listed any more");
    }

    #[test]
    fn right_opens_what_is_closed_and_then_goes_into_it() {
        let mut lists = ListsState::default();
        assert_eq!(lists.enter(&ROWS, 0, false), Some(1), "titles are open at first");
        assert_eq!(lists.enter(&ROWS, 2, false), None, "a layer has nothing below it");
        assert_eq!(lists.enter(&ROWS, 5, false), None, "the object is opened, and the cursor stays");
        assert!(lists.is_open(ListRow::Object(ObjectId(0))));
        let below = [ListRow::Object(ObjectId(0)), ListRow::Face(ObjectId(0), FaceIndex(0))];
        assert_eq!(lists.enter(&below, 0, false), Some(1));
    }

    #[test]
    fn left_closes_what_is_open_and_then_goes_to_what_it_is_in() {
        let mut lists = ListsState::default();
        assert_eq!(lists.leave(&ROWS, 3, false), Some(1), "from a layer to its depth");
        assert_eq!(lists.leave(&ROWS, 3, true), Some(0), "a table has no depths: to the title");
        assert_eq!(lists.leave(&ROWS, 1, false), None, "the depth is closed");
        assert!(!lists.is_open(ListRow::Depth(0)));
        assert_eq!(lists.leave(&ROWS, 1, false), Some(0), "a closed one is left");
        assert_eq!(lists.leave(&ROWS, 5, false), Some(4));
    }

    #[test]
    fn the_cursor_is_nowhere_where_its_row_is_not_listed() {
        let mut lists = ListsState::default();
        assert_eq!(lists.here(&ROWS), None);
        lists.cursor = Some(ListRow::Layer(LayerIndex(2)));
        assert_eq!(lists.here(&ROWS), Some(3));
        lists.cursor = Some(ListRow::Layer(LayerIndex(9)));
        assert_eq!(lists.here(&ROWS), None);
    }
}
