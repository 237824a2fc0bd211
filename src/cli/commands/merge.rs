//! `octray merge`: tiles to the whole picture.

use crate::{
    cli::{
        CliError,
        plan::MergePlan,
        process::Interrupt,
        report::{self, Written},
        write::{Inputs, Output, Tiles},
    },
    error::clip_path,
};
use std::time::Instant;

/// Merges tiles and writes the picture. `start` is when the program began.
///
/// # Errors
/// [`CliError`]; the picture's file is then unchanged.
pub fn run(plan: &MergePlan, start: Instant) -> Result<(), CliError> {
    let interrupt = Interrupt::install()?;
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
    if plan.skip_existing && output.exists() {
        return Ok(());
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
    let bytes = tiles.merge(plan.memory, || interrupt.check())?;
    output.write_bytes(&bytes)?;
    if !plan.quiet && report::notes_to_terminal() {
        let mut written = Written::default();
        written.add(&clip_path(&plan.output.path), start.elapsed());
        report::note(&written.line((width, height)));
    }
    Ok(())
}
