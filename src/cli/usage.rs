//! What would do instead of a command line that does not: added to clap's own words.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// How other renderers call what is called otherwise here.
const ELSEWHERE: [(&[&str], &str); 11] = [
    (
        &[
            "--width",
            "--height",
            "--resolution",
            "--res",
            "--dimensions",
            "-w",
            "-s",
        ],
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
        "--aov depth,normal,albedo writes these; --max-depth N limits mirrors",
    ),
    (&["--jobs", "--nthreads", "-j", "-t"], "--threads N"),
    (&["--outfile", "--out", "--image"], "--output FILE"),
    (
        &["--position", "--from", "--lookat", "--look-at"],
        "--eye x,y,z and --target x,y,z",
    ),
    (&["--animation", "--animate", "--rotate"], "--turntable N"),
    (&["-q", "--silent"], "--quiet"),
];

/// Adds what would do, where that is known.
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

/// Of an option that there is none of: the one that other programs' users may mean.
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
        // clap's tip is how to pass it as a value, which no scene's name is.
        suggest(error, "--help lists the options");
    }
}

/// Of options that exclude each other: which of them would do.
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
        let tip = "each of --camera, --view and --eye says where the camera stands: give one of them, and --target, \
                   --up or --fov to change the rest";
        suggest(error, tip);
    }
}
