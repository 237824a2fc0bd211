//! Arguments of `octray generate`.

use super::values;
use crate::{
    cli::{
        CliError,
        plan::{GeneratePlan, JsonTarget},
    },
    generate::{Kind, Options},
    whole_file::folder_of,
};
use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};
use std::path::{Path, PathBuf, absolute};

/// Arguments of `octray generate`.
#[derive(Args, Debug)]
pub struct GenerateArgs {
    /// Kind of scene
    #[arg(value_parser = kind_parser())]
    pub kind: Kind,

    /// Directory for KIND.scn and its meshes; created if missing
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    pub output: PathBuf,

    /// Also replace files that octray did not write
    #[arg(long)]
    pub force: bool,

    /// Another seed makes another scene of the same kind
    #[arg(long, value_name = "S", value_parser = values::number, default_value_t = 0)]
    pub seed: u64,

    /// Number of spheres (flake, spheres: exactly) or triangles (others: at most) [default: 100000 spheres; terrain and
    /// blobs 1000000, interior 370000, pipes 192000, figure 70000 triangles]
    #[arg(long, value_name = "N", value_parser = values::count)]
    pub count: Option<u64>,

    /// Write the files' names and counts as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

fn kind_parser() -> impl TypedValueParser<Value = Kind> {
    PossibleValuesParser::new(Kind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.summary())))
        .try_map(|name| {
            Kind::ALL
                .into_iter()
                .find(|kind| kind.name() == name)
                .ok_or("not a kind")
        })
}

impl GenerateArgs {
    /// As plain values.
    ///
    /// # Errors
    /// [`CliError`], as of [`JsonTarget::new`].
    pub fn plan(self) -> Result<GeneratePlan, CliError> {
        Ok(GeneratePlan {
            json: self
                .json
                .as_deref()
                .map(|json| self.json_target(json))
                .transpose()?,
            kind: self.kind,
            options: Options {
                seed: self.seed,
                // More than memory holds is refused by its number.
                count: self
                    .count
                    .map(|count| usize::try_from(count).unwrap_or(usize::MAX)),
            },
            folder: self.output,
            force: self.force,
        })
    }

    /// A file in the folder that the command makes cannot be checked yet.
    fn json_target(&self, json: &Path) -> Result<JsonTarget, CliError> {
        let same = |a: &Path, b: &Path| absolute(a).ok() == absolute(b).ok();
        if !self.output.exists() && same(folder_of(json), &self.output) {
            return Ok(JsonTarget::File(json.to_owned()));
        }
        JsonTarget::new(json)
    }
}
