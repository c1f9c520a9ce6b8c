//! Which materials are leaves, by their names.

/// Returns true for materials such as `leaf`, `Leaves` and `maple_leaf.001`.
pub fn is_called_leaf(name: &str) -> bool {
    let name = name.to_lowercase();
    name.split(|c: char| !c.is_alphabetic()).any(|word| word.starts_with("leaf") || word == "leaves")
}
