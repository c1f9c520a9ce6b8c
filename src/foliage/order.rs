//! The order of sub-objects in which each comes after those that it uses.

/// Returns the indices that can be reached from `root` through `children`, those that are used before those that use
/// them, in the order of a walk that takes children in turn.
///
/// # Errors
/// A cycle: the indices on the way from a sub-object to its next use of itself, which is repeated at the end.
pub fn children_first(children: &[Vec<usize>], root: usize) -> Result<Vec<usize>, Vec<usize>> {
    /// How far the walk is with a sub-object.
    #[derive(Clone, Copy, PartialEq)]
    enum VisitState {
        New,
        OnTheWay,
        Done,
    }
    let mut states = vec![VisitState::New; children.len()];
    let mut order = Vec::new();
    // The way from the root to where the walk is, each with the number of children that it has finished.
    let mut way = vec![(root, 0)];
    states[root] = VisitState::OnTheWay;
    while let Some((object, next)) = way.last_mut() {
        let Some(&child) = children[*object].get(*next) else {
            states[*object] = VisitState::Done;
            order.push(*object);
            way.pop();
            continue;
        };
        *next += 1;
        match states[child] {
            VisitState::Done => (),
            VisitState::New => {
                states[child] = VisitState::OnTheWay;
                way.push((child, 0));
            }
            VisitState::OnTheWay => {
                let on_cycle = way.iter().map(|(object, _)| *object).skip_while(|object| *object != child);
                return Err(on_cycle.chain([child]).collect());
            }
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_come_first_and_what_nobody_uses_is_left_out() {
        let children = [vec![2, 1, 2], vec![3], vec![3, 1], vec![], vec![0]];
        assert_eq!(children_first(&children, 0), Ok(vec![3, 1, 2, 0]));
    }

    #[test]
    fn a_cycle_is_returned_from_where_it_is_entered_to_itself() {
        let children = [vec![1], vec![2], vec![3], vec![1]];
        assert_eq!(children_first(&children, 0), Err(vec![1, 2, 3, 1]));
        assert_eq!(children_first(&[vec![0]], 0), Err(vec![0, 0]));
    }
}
