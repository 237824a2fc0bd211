//! Hints added to clap's usage errors.

use super::definition;
use crate::{cli::write::AovKind, error::clip_path};
use clap::{
    ValueEnum,
    error::{ContextKind, ContextValue, ErrorKind},
};
use std::{ffi::OsString, path::Path};

/// Options of other renderers, and what octray has instead.
const ELSEWHERE: [(&[&str], &str); 27] = [
    (
        &[
            "--width",
            "--height",
            "--resolution",
            "--res",
            "--dimensions",
            "-w",
        ],
        "--size WIDTHxHEIGHT, such as --size 800x600",
    ),
    (
        &["--spp", "--aa", "--antialias", "--antialiasing", "--quality"],
        "--samples N, such as --samples 16, or --samples auto",
    ),
    (
        &["--gamma"],
        "--srgb encodes for screens (the default for meshes), --linear does not",
    ),
    (&["--transparent", "--alpha"], "--background transparent"),
    (
        &["--wireframe", "--show-edges", "--mesh-edges", "-e"],
        "--edges draws the edges of triangles, --edges=2 as wider lines",
    ),
    (
        &["--bg", "--bg-color", "--background-color"],
        "--background COLOR, such as --background white",
    ),
    (
        &["--region", "--tile", "--cropwindow", "--pixelbounds"],
        "--crop x0,y0,x1,y1",
    ),
    (
        &["--depth", "--normals", "--albedo"],
        "--aov depth,normal,albedo writes these; --max-depth N limits reflections",
    ),
    (&["--jobs", "--nthreads"], "-j N or --threads N"),
    (&["--outfile", "--out", "--image"], "--output FILE"),
    (
        &["--position", "--lookat", "--look-at"],
        "--eye x,y,z and --target x,y,z",
    ),
    (
        &[
            "--azimuth",
            "--elevation",
            "--camera-azimuth-angle",
            "--camera-elevation-angle",
            "--camera-direction",
            "--side",
        ],
        "--from AZIMUTH,ELEVATION in degrees, such as --from 35,20, or --from top",
    ),
    (&["--rotate"], "--turntable N"),
    (
        &["--animate", "--play", "--video"],
        "-o FILE.gif, .apng or .y4m plays a glTF animation or a scene with keyframes; --turntable N turns others",
    ),
    (&["--time"], "--animation-time SECONDS"),
    (&["--silent"], "-q or --quiet"),
    (&["--interactive", "--window"], "octray view SCENE opens a window"),
    (
        &["--overwrite"],
        "--force replaces files that octray did not write; those that it wrote are replaced without it",
    ),
    (
        &["--bounces", "--max-bounces", "--ray-depth", "--recursion"],
        "--max-depth N limits reflections and refraction",
    ),
    (&["--format"], "the extension of --output FILE is the format"),
    (&["--verbose"], "--stats prints rays, times and memory"),
    (
        &["--light", "--lights"],
        "a scene (.scn) has lines `light x y z intensity`",
    ),
    (
        &["--env", "--envmap", "--environment-map", "--hdri", "--hdri-file"],
        "--environment FILE for a mesh; a scene (.scn) has a line `environment PATH`",
    ),
    (
        &["--color", "--colour", "--material"],
        "a scene (.scn) has lines such as `material matte cd 1 0 0` and `mesh PATH`; --style clay shows one colour, \
         --color-by NAME numbers",
    ),
    (
        &["--scalars", "--scalar", "--coloring-array", "--color-array"],
        "--color-by NAME, such as --color-by quality or --color-by z; octray info lists the names",
    ),
    (
        &["--bar", "--scalar-bar", "--colorbar", "--legend"],
        "--color-bar with --color-by NAME",
    ),
    (
        &["--cmap", "--colormap", "--palette"],
        "--color-map MAP with --color-by NAME, such as --color-map turbo",
    ),
];

/// The error if the command is `view`, and no file has that name.
#[cfg(not(feature = "viewer"))]
pub fn no_window(arguments: &[OsString]) -> Option<String> {
    let is_view = arguments.get(1).is_some_and(|first| first == "view") && !Path::new("view").exists();
    is_view.then(|| {
        "this build has no window: `octray view` needs a program built with the feature `viewer`, as by `cargo install`"
            .to_owned()
    })
}

/// Adds a hint, if there is one.
pub fn explain(error: &mut clap::Error, arguments: &[OsString]) {
    explain_conflict(error);
    explain_unknown(error);
    explain_second(error, arguments);
    explain_command(error);
    explain_file(error, arguments);
    if arguments.get(1).is_some_and(|command| command == "bench") {
        explain_bench(error);
    }
    let is_stats = matches!(error.get(ContextKind::InvalidArg), Some(ContextValue::String(option)) if option == "--stats");
    if error.kind() == ErrorKind::TooManyValues && is_stats {
        suggest(error, "--json FILE writes JSON");
    }
}

/// Options whose value is several numbers: how many, and an example.
const LISTS: [(&[&str], usize, &str); 4] = [
    (&["--eye", "--target", "--up", "--lit-from"], 3, "-1,2.5,3"),
    (&["--crop"], 4, "0,0,256,128"),
    (&["-s", "--size"], 2, "800x600"),
    (&["--color-range"], 2, "0,2.5"),
];

/// The message for arguments that clap takes for others.
pub fn misread(arguments: &[OsString]) -> Option<String> {
    let words: Vec<&str> = texts(arguments).collect();
    numbers_apart(&words).or_else(|| aovs_apart(&words))
}

/// The message for long options with one hyphen, as in `-output=a.png`, which clap reads as `-o utput=a.png`, or with a dash
/// of word processors.
pub fn one_dash(arguments: &[OsString]) -> Option<String> {
    let is_long = |name: &&str| {
        name.len() > 1
            && !name.starts_with('-')
            && definition()
                .get_subcommands()
                .flat_map(clap::Command::get_arguments)
                .any(|option| option.get_long() == Some(*name))
    };
    let options_only = texts(arguments).take_while(|&word| word != "--");
    let mut names = options_only.filter_map(|word| word.strip_prefix(['-', '–', '—'])?.split('=').next());
    let name = names.find(|name| *name == "version" || is_long(name))?;
    Some(format!("long options have two hyphens: write --{name}"))
}

/// The message for `octray help` with several commands, which clap takes for commands of commands.
pub fn two_pages(arguments: &[OsString]) -> Option<String> {
    let words: Vec<&str> = texts(arguments).skip(1).collect();
    let ["help", first, _, ..] = words[..] else {
        return None;
    };
    let is_command = definition()
        .get_subcommands()
        .any(|command| command.get_name() == first);
    (is_command || first == "help")
        .then(|| format!("`octray help` takes one command, such as octray help {first}"))
}

fn texts(arguments: &[OsString]) -> impl Iterator<Item = &str> {
    arguments.iter().map(|word| word.to_str().unwrap_or_default())
}

/// AOVs with spaces between them, as in `--aov depth normal`.
fn aovs_apart(words: &[&str]) -> Option<String> {
    let first = words.iter().position(|&word| word == "--aov")? + 1;
    let names = words.get(first..)?.iter().map(|word| word.trim_matches(','));
    let names: Vec<&str> = names
        .take_while(|name| AovKind::from_str(name, false).is_ok())
        .collect();
    let names = (names.len() > 1).then(|| names.join(","))?;
    Some(format!(
        "--aov takes its names as one argument: write --aov {names} (no spaces)"
    ))
}

/// Numbers of one option with spaces between them, as in `--eye 3 -4 2`.
fn numbers_apart(words: &[&str]) -> Option<String> {
    words.iter().enumerate().find_map(|(i, word)| {
        let (option, first) = match word.split_once('=') {
            Some((option, first)) => (option, Some(first)),
            None => (*word, None),
        };
        let &(_, count, example) = LISTS.iter().find(|(options, ..)| options.contains(&option))?;
        let number = |word: &&str| word.trim_matches(',').parse::<f64>().is_ok();
        let rest = words[i + 1..].iter().copied();
        let numbers: Vec<&str> = first
            .into_iter()
            .chain(rest)
            .take_while(number)
            .take(count)
            .collect();
        match numbers.len() {
            0 | 1 => None,
            found if found == count => {
                let separator = if example.contains('x') { "x" } else { "," };
                let parts: Vec<&str> = numbers.iter().map(|part| part.trim_matches(',')).collect();
                Some(format!(
                    "{option} takes its numbers as one argument: write {option} {} (no spaces)",
                    parts.join(separator)
                ))
            }
            found => Some(format!(
                "{option} takes {count} numbers as one argument, such as {option} {example} (no spaces), found {found}"
            )),
        }
    })
}

fn suggest(error: &mut clap::Error, tip: &str) {
    error.insert(
        ContextKind::Suggested,
        ContextValue::StyledStrs(vec![tip.to_owned().into()]),
    );
}

/// Unknown options.
fn explain_unknown(error: &mut clap::Error) {
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else {
        return;
    };
    let given = given.split('=').next().unwrap_or_default();
    let known = ELSEWHERE.iter().find(|(names, _)| names.contains(&given));
    if let Some((_, tip)) = known {
        error.remove(ContextKind::SuggestedArg);
        suggest(error, tip);
        return;
    }
    let is_close = match error.get(ContextKind::SuggestedArg) {
        Some(ContextValue::String(option)) => is_close(given, option),
        _ => false,
    };
    if !is_close {
        error.remove(ContextKind::SuggestedArg);
        // clap's own tip, how to pass it as a value, does not help: no scene is called like an option.
        suggest(error, "--help lists the options");
    }
}

/// Whether an option may be a slip of another one: one letter in three is wrong, or a part is left out or added. What clap
/// suggests need only have some letters in common.
fn is_close(given: &str, option: &str) -> bool {
    let [given, option] = [given, option].map(|word| word.trim_start_matches('-'));
    let is_part = given.len() > 3 && (option.contains(given) || given.contains(option));
    is_part || strsim::damerau_levenshtein(given, option) <= (given.chars().count() / 3).max(1)
}

/// Further inputs of a command that takes one.
fn explain_second(error: &mut clap::Error, arguments: &[OsString]) {
    let command = arguments.get(1).and_then(|command| command.to_str());
    if let Some(command @ ("info" | "view" | "bench")) = command
        && error.kind() == ErrorKind::UnknownArgument
        && matches!(error.get(ContextKind::InvalidArg), Some(ContextValue::String(given)) if !given.starts_with('-'))
    {
        suggest(error, &format!("octray {command} takes one scene"));
    }
}

/// Unknown commands after `help`: clap suggests only those before it.
fn explain_command(error: &mut clap::Error) {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidSubcommand) else {
        return;
    };
    let all = definition();
    let near = all
        .get_subcommands()
        .map(clap::Command::get_name)
        .find(|name| strsim::damerau_levenshtein(given, name) <= name.len() / 3);
    if let Some(near) = near.filter(|_| error.get(ContextKind::SuggestedSubcommand).is_none()) {
        let near = ContextValue::Strings(vec![near.to_owned()]);
        error.insert(ContextKind::SuggestedSubcommand, near);
    }
}

/// Files whose names begin like options.
fn explain_file(error: &mut clap::Error, arguments: &[OsString]) {
    let is_file = |word: &&OsString| word.as_encoded_bytes().starts_with(b"-") && Path::new(word).is_file();
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(file) = arguments.iter().skip(1).find(is_file)
    {
        error.remove(ContextKind::SuggestedArg);
        suggest(error, &format!("the file is ./{}", clip_path(Path::new(file))));
    }
}

/// Calls of `bench` without a scene, or with one beside --quick.
fn explain_bench(error: &mut clap::Error) {
    match error.kind() {
        ErrorKind::MissingRequiredArgument => {
            suggest(error, "name a scene, or time generated ones with --all");
        }
        ErrorKind::ArgumentConflict if error.to_string().contains("--quick") => {
            suggest(error, "--quick goes with --all: octray bench --all --quick");
        }
        _ => {}
    }
}

/// Options that exclude each other.
fn explain_conflict(error: &mut clap::Error) {
    const PLACES: [&str; 3] = ["--camera", "--view", "--eye"];
    let is_place = |value: Option<&ContextValue>| {
        let options = match value {
            Some(ContextValue::String(option)) => std::slice::from_ref(option),
            Some(ContextValue::Strings(options)) => options,
            _ => &[],
        };
        !options.is_empty()
            && options
                .iter()
                .all(|option| PLACES.iter().any(|place| option.starts_with(place)))
    };
    if error.kind() == ErrorKind::ArgumentConflict
        && is_place(error.get(ContextKind::InvalidArg))
        && is_place(error.get(ContextKind::PriorArg))
    {
        let tip = "--camera, --view and --eye each place the camera: use one of them, and --target, --up, --fov or \
                   --ortho for the rest";
        suggest(error, tip);
    }
}
