//! Hints added to clap's usage errors.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Options of other renderers, and what octray has instead.
const ELSEWHERE: [(&[&str], &str); 10] = [
    (
        &["--width", "--height", "--resolution", "--res", "--dimensions"],
        "--size WIDTHxHEIGHT, such as --size 800x600",
    ),
    (
        &["--spp", "--aa", "--antialias", "--antialiasing"],
        "--samples N, such as --samples 16",
    ),
    (&["--gamma"], "--srgb encodes for screens; the default is linear"),
    (&["--transparent", "--alpha"], "--background transparent"),
    (
        &["--region", "--window", "--cropwindow", "--pixelbounds"],
        "--crop x0,y0,x1,y1",
    ),
    (
        &["--depth", "--normals", "--albedo"],
        "--aov depth,normal,albedo writes these; --max-depth N limits reflections",
    ),
    (&["--jobs", "--nthreads"], "--threads N"),
    (&["--outfile", "--out", "--image"], "--output FILE"),
    (
        &["--position", "--from", "--lookat", "--look-at"],
        "--eye x,y,z and --target x,y,z",
    ),
    (&["--animation", "--animate", "--rotate"], "--turntable N"),
];

/// Adds a hint, if there is one.
pub fn explain(error: &mut clap::Error) {
    explain_conflict(error);
    explain_unknown(error);
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
    } else if error.get(ContextKind::SuggestedArg).is_none() {
        // clap's own tip, how to pass it as a value, does not help: no scene is called like an option.
        suggest(error, "--help lists the options");
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
        let tip = "--camera, --view and --eye each place the camera: use one of them, and --target, --up or --fov for \
                   the rest";
        suggest(error, tip);
    }
}
