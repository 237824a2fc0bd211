//! `octray merge`: tiles to the whole picture.

use crate::{
    cli::{
        CliError,
        plan::MergePlan,
        process::Interrupt,
        report::{self, SCHEMA, Written},
        write::{Inputs, Output, Tiles, json_line, write_json},
    },
    error::clip_path,
};
use serde::Serialize;
use std::time::Instant;

/// What was merged, as JSON.
#[derive(Serialize)]
struct Json<'a> {
    schema: u32,
    output: &'a str,
    width: u32,
    height: u32,
    tiles: usize,
    seconds: f64,
}

/// Merges tiles and writes the picture. `start` is when the program began.
///
/// # Errors
/// [`CliError`]; the picture's file is then unchanged.
pub fn run(plan: &MergePlan, start: Instant) -> Result<(), CliError> {
    let interrupt = Interrupt::install()?;
    // Before the tiles are looked at, which may be gone by then. The picture's size does not matter here.
    if plan.skip_existing && Output::prepare(&plan.output, (1, 1), false)?.exists() {
        return Ok(());
    }
    let tiles = Tiles::open(&plan.tiles, plan.memory)?;
    let [width, height] = tiles.size()?;
    let output = Output::prepare(&plan.output, (width, height), false)?.synced_if(plan.skip_existing);
    let format = tiles.format()?;
    if output.format() != format {
        return Err(CliError::Usage(format!(
            "{} would be {}, but the tiles are {}: name a picture of their format",
            output.name(),
            output.format().name(),
            format.name()
        )));
    }
    if plan.json.as_ref().is_some_and(|json| json.is_file_of(&output)) {
        return Err(CliError::Usage(format!(
            "both the picture and the JSON would be written to {}",
            output.name()
        )));
    }
    let mut inputs = Inputs::default();
    for tile in &plan.tiles {
        inputs.add(tile, "the tile");
    }
    let objection = output
        .replaced()
        .and_then(|file| inputs.objection(output.name(), file));
    if let Some(objection) = objection {
        return Err(CliError::Usage(objection));
    }
    inputs.check_json(plan.json.as_ref())?;
    let bytes = tiles.merge(plan.memory, || interrupt.check())?;
    output.write_bytes(&bytes)?;
    if !plan.quiet && report::notes_to_terminal() {
        let mut written = Written::default();
        written.add(&clip_path(&plan.output.path), start.elapsed());
        report::note(&written.line((width, height)));
    }
    let Some(target) = &plan.json else {
        return Ok(());
    };
    let json = Json {
        schema: SCHEMA,
        output: &plan.output.path.to_string_lossy(),
        width,
        height,
        tiles: plan.tiles.len(),
        seconds: start.elapsed().as_secs_f64(),
    };
    write_json(target, &json_line(&json))
}
