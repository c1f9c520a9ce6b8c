//! Options of the sorting method, which `new` and `build` take.

use clap::{ArgAction, Args};

use super::number::whole;
use super::one_of::one_of;
use quadratura_layers::{BoxShape, Method, Options};

/// The options of the method; options that are not given are the project's.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Options of the method")]
pub struct OptionArgs {
    /// How visibility layers are computed: with the occlusion graph, or by stencil peeling as published in
    /// 2003
    #[arg(long, value_parser = one_of(METHODS))]
    pub method: Option<Method>,
    /// A surface occludes another one when it is nearer by more than this fraction of its depth
    #[arg(long, value_name = "T", value_parser = tolerance)]
    pub tolerance: Option<f32>,
    /// Ignore contradictions of at most this many pixels as contact noise
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX))]
    pub min_support: Option<u32>,
    /// Pixels to add around an image layer on every side
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=4096))]
    pub margin: Option<u32>,
    /// Sizes of image layers: as needed, or powers of two
    #[arg(long, value_parser = one_of(BOXES))]
    pub boxes: Option<BoxShape>,
    /// Merge image layers within one visibility layer only, as published in 2003
    #[arg(long, action = ArgAction::Set, num_args = 0..=1, require_equals = true,
          default_missing_value = "true", value_name = "true|false", hide_possible_values = true)]
    pub published: Option<bool>,
    /// Longest side of an image layer, in pixels: larger surfaces are split into several layers side by side
    #[arg(long, value_name = "N", value_parser = whole::<u32>(64..=1 << 20))]
    pub largest_side: Option<u32>,
    /// Make no image layer of a face that the photo shows at fewer pixels than this and at less than --min-share of the
    /// pixels that it covers; 0 makes all (OBJECT=N for one object; may be given several times)
    #[arg(long, value_name = "N", value_parser = of_object(number), allow_hyphen_values = true)]
    pub min_visible: Vec<OfObject<u32>>,
    /// See --min-visible: a share from 0 to 1 (OBJECT=S for one object; may be given several times)
    #[arg(long, value_name = "S", value_parser = of_object(share), allow_hyphen_values = true)]
    pub min_share: Vec<OfObject<f32>>,
    /// How far behind the model the surroundings (sky, hills, far houses) are needed, as a share of the photo's longer
    /// side from 0 to 1; `all` for the whole photo
    #[arg(long, value_name = "S|all", value_parser = reach, allow_hyphen_values = true)]
    pub reach: Option<f32>,
    /// Keep an object whole where its parts occlude each other at no more than this share of the pixels that the photo
    /// shows of the smaller part; other photos texture what is behind (0 to 1; OBJECT=S for one object; may be given
    /// several times)
    #[arg(long, value_name = "S", value_parser = of_object(share), allow_hyphen_values = true)]
    pub tolerated: Vec<OfObject<f32>>,
}

/// A value for one object, or for all objects without a value of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct OfObject<T> {
    object: Option<String>,
    value: T,
}

/// Returns a parser of `VALUE` and `OBJECT=VALUE`.
fn of_object<T>(
    parse: impl Fn(&str) -> Result<T, String> + Clone,
) -> impl Fn(&str) -> Result<OfObject<T>, String> + Clone {
    move |text| {
        // Names of objects may contain `=`.
        let (object, value) = match text.rsplit_once('=') {
            Some((object, value)) => (Some(object.to_owned()), value),
            None => (None, text),
        };
        Ok(OfObject { object, value: parse(value)? })
    }
}

const METHODS: &[(&str, Method, &str)] = &[("graph", Method::Graph, ""), ("stencil", Method::Stencil, "")];

const BOXES: &[(&str, BoxShape, &str)] =
    &[("exact", BoxShape::Exact, ""), ("power-of-two", BoxShape::PowerOfTwo, "")];

impl OptionArgs {
    /// Returns `options` with those that were given replaced.
    pub fn applied_to(&self, options: &Options) -> Options {
        let mut objects = options.objects.clone();
        for of in &self.min_visible {
            let own = of.object.as_ref().map(|object| objects.entry(object.clone()).or_default());
            own.into_iter().for_each(|own| own.min_visible = Some(of.value));
        }
        for of in &self.min_share {
            let own = of.object.as_ref().map(|object| objects.entry(object.clone()).or_default());
            own.into_iter().for_each(|own| own.min_share = Some(of.value));
        }
        for of in &self.tolerated {
            let own = of.object.as_ref().map(|object| objects.entry(object.clone()).or_default());
            own.into_iter().for_each(|own| own.tolerated = Some(of.value));
        }
        let tolerated = self.tolerated.iter().rfind(|of| of.object.is_none());
        let min_visible = self.min_visible.iter().rfind(|of| of.object.is_none());
        let min_share = self.min_share.iter().rfind(|of| of.object.is_none());
        Options {
            method: self.method.unwrap_or(options.method),
            tolerance: self.tolerance.unwrap_or(options.tolerance),
            min_support: self.min_support.unwrap_or(options.min_support),
            margin: self.margin.unwrap_or(options.margin),
            boxes: self.boxes.unwrap_or(options.boxes),
            published: self.published.unwrap_or(options.published),
            largest_side: self.largest_side.unwrap_or(options.largest_side),
            min_visible: min_visible.map_or(options.min_visible, |of| of.value),
            min_share: min_share.map_or(options.min_share, |of| of.value),
            tolerated: tolerated.map_or(options.tolerated, |of| of.value),
            reach: self.reach.unwrap_or(options.reach),
            objects,
        }
    }
}

/// Parses a depth tolerance and checks its range.
pub(super) fn tolerance(text: &str) -> Result<f32, String> {
    let tolerance = text.parse().map_err(|_| "expected a number such as 0.0001".to_string())?;
    let options = Options { tolerance, ..Options::default() };
    options.problem().map_or(Ok(tolerance), Err)
}

/// Parses a number of pixels.
pub(super) fn number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("expected a whole number of 0 or more, not {text:?}"))
}

/// Parses the reach of the surroundings: a share, or `all`.
fn reach(text: &str) -> Result<f32, String> {
    if text == "all" { Ok(1.0) } else { share(text) }
}

/// Parses a share and checks its range.
pub(super) fn share(text: &str) -> Result<f32, String> {
    let share: f32 = text.parse().map_err(|_| "expected a share such as 0.005".to_string())?;
    let options = Options { min_share: share, ..Options::default() };
    options.problem().map_or(Ok(share), Err)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::{Cli, CommandArgs};
    use super::*;

    const NEW: &str = "quadratura new p --photos a --cameras b --model c";

    #[test]
    fn options_that_were_not_given_are_the_projects() {
        let typed = NEW.split(' ').chain(["--margin", "4", "--published", "--boxes", "exact"]);
        let Some(CommandArgs::New(args)) = Cli::parse_from(typed).command else { unreachable!() };
        let of_project = Options { min_support: 3, ..Options::default() };
        let expected = Options { margin: 4, published: true, boxes: BoxShape::Exact, ..of_project.clone() };
        assert_eq!(args.options.applied_to(&of_project), expected);
    }

    #[test]
    fn a_value_may_be_of_one_object_and_the_last_one_counts() {
        let values = [
            "--min-visible",
            "9",
            "--min-visible",
            "a=b=3",
            "--min-visible",
            "7",
            "--min-share",
            "tower=0.5",
        ];
        let Some(CommandArgs::New(args)) = Cli::parse_from(NEW.split(' ').chain(values)).command else {
            unreachable!()
        };
        let options = args.options.applied_to(&Options::default());
        assert_eq!(options.least_visible("gate"), (7, 0.005));
        assert_eq!(options.least_visible("a=b"), (3, 0.005));
        assert_eq!(options.least_visible("tower"), (7, 0.5));
    }

    #[test]
    fn values_out_of_range_are_wrong_usage() {
        for option in [
            "--tolerance=1",
            "--tolerance=NaN",
            "--margin=-1",
            "--largest-side=0",
            "--min-visible=-1",
            "--min-visible=tower=x",
            "--min-share=NaN",
            "--min-share=tower=1.5",
        ] {
            let error = Cli::try_parse_from(NEW.split(' ').chain([option])).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{option}");
        }
    }
}
