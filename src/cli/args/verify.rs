//! Arguments of `octray verify`.

use super::{limits::ThreadsArgs, values};
use crate::{
    cli::{
        CliError,
        plan::{JsonTarget, VerifyPlan},
    },
    verify::Settings,
};
use clap::Args;
use std::{path::PathBuf, time::Duration};

/// Some seconds on most machines.
const DEFAULT_RAYS: u64 = 10_000_000;

/// Arguments of `octray verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Number of rays, rounded up to whole scenes [default: 10000000, or no limit with --seconds]
    #[arg(long, value_name = "N", value_parser = values::count)]
    pub rays: Option<u64>,

    /// Stop after this time, seconds
    #[arg(long, value_name = "T", value_parser = values::long_seconds)]
    pub seconds: Option<f64>,

    /// Another seed makes other scenes and rays
    #[arg(long, value_name = "S", value_parser = values::number, default_value_t = 1)]
    pub seed: u64,

    /// Check only the scene with this number
    #[arg(long, value_name = "N", value_parser = values::number, conflicts_with_all = ["rays", "seconds"])]
    pub scene: Option<u64>,

    #[command(flatten)]
    pub threads: ThreadsArgs,

    /// Write the counts as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl VerifyArgs {
    /// As plain values.
    ///
    /// # Errors
    /// [`CliError`], as of [`JsonTarget::new`].
    pub fn plan(&self) -> Result<VerifyPlan, CliError> {
        Ok(VerifyPlan {
            settings: Settings {
                seed: self.seed,
                rays: self.rays.or(self.seconds.is_none().then_some(DEFAULT_RAYS)),
                scene: self.scene,
                threads: self.threads.count().map(|threads| threads as usize),
            },
            time_limit: self.seconds.map(Duration::from_secs_f64),
            json: self.json.as_deref().map(JsonTarget::new).transpose()?,
        })
    }
}
