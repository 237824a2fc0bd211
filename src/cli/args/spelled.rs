//! From settings back to options, for the commands that the window prints.

use super::{
    choices::Choice,
    picture::{name_of, usual_filter, usual_pattern, usual_samples},
};
use crate::{
    classic,
    cli::plan::Style,
    render::{Edges, Settings, Transfer},
};

/// Returns the options of `octray render` that give these settings and this transfer, each after a space, as far as they
/// are not the usual ones of a mesh in `style`, or of a scene.
pub fn spelled(settings: &Settings, transfer: Transfer, style: Option<Style>) -> String {
    let is_soft = style.is_some_and(Style::is_soft);
    let mut options = String::new();
    if let Some(style) = style.filter(|&style| style != Style::Studio) {
        options += &format!(" --style={}", name_of(&style));
    }
    let &Settings {
        samples, adaptive, ..
    } = settings;
    if samples != usual_samples(is_soft) || adaptive != is_soft {
        let auto = if adaptive { "auto:" } else { "" };
        options += &format!(" --samples={auto}{samples}");
    }
    if !adaptive && settings.pattern != usual_pattern(samples) {
        options += &format!(" --pattern={}", name_of(&Choice(settings.pattern)));
    }
    if settings.filter != usual_filter(is_soft) {
        options += &format!(" --filter={}", name_of(&Choice(settings.filter)));
    }
    match (is_soft, transfer) {
        (true, Transfer::Linear) => options += " --linear",
        (false, Transfer::Srgb) => options += " --srgb",
        _ => {}
    }
    if let Some(Edges { width, color }) = settings.edges {
        options += &format!(" --edges={width}");
        if color != Edges::default().color {
            let [r, g, b] = transfer.encode(color);
            options += &format!(" --edge-color={r:02x}{g:02x}{b:02x}");
        }
    }
    if !settings.shadows {
        options += " --no-shadows";
    }
    if settings.max_depth != classic::MAX_DEPTH {
        options += &format!(" --max-depth={}", settings.max_depth);
    }
    options
}
