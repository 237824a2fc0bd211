//! The results of all comparisons of a call.

use super::note;
use crate::cli::{CliError, write::Verdict};

/// The results of all comparisons of a call.
#[derive(Default)]
pub struct Verdicts {
    compared: usize,
    differing: Vec<String>,
}

impl Verdicts {
    /// Adds a result. Says so if the pictures agree, unless `quiet`.
    pub fn add(&mut self, verdict: Verdict, quiet: bool) {
        self.compared += 1;
        if !verdict.agrees {
            self.differing.push(verdict.text);
        } else if !quiet {
            note(&(verdict.text + "\n"));
        }
    }

    /// # Errors
    /// [`CliError::Differs`], with a line for each picture that differs.
    pub fn finish(self) -> Result<(), CliError> {
        match self.differing.len() {
            0 => Ok(()),
            1 if self.compared == 1 => Err(CliError::Differs(self.differing.join("\n"))),
            many => Err(CliError::Differs(format!(
                "{many} of {} pictures differ from their references\n  {}",
                self.compared,
                self.differing.join("\n  ")
            ))),
        }
    }
}
