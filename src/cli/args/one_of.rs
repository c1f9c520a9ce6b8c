//! Values of an enum of the library on the command line.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Returns a parser of the values of a table: each has its name on the command line, and its help text, which may be empty.
pub fn one_of<T>(values: &'static [(&'static str, T, &'static str)]) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let possible = values.iter().map(|(name, _, help)| {
        let possible = PossibleValue::new(*name);
        if help.is_empty() { possible } else { possible.help(*help) }
    });
    PossibleValuesParser::new(possible).map(|typed| {
        let value = values.iter().find(|(name, ..)| *name == typed);
        value.expect("the parser knows the names of the table alone").1
    })
}
