//! Arguments of `octray completions` and `octray man`.

use clap::Args;
use clap_complete::Shell;

/// Arguments of `octray completions`.
#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: Shell,
}

/// Arguments of `octray man`.
#[derive(Args, Debug)]
pub struct ManArgs {
    /// The page of one command [default: the page of octray]
    pub command: Option<String>,
}
