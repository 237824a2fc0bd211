//! The results of all comparisons of a call.

use super::note;
use crate::cli::{CliError, write::Verdict};

/// The results of all comparisons of a call.
#[derive(Default)]
pub struct Verdicts {
    compared: usize,
    differing: usize,
    /// The texts of the first ones.
    texts: Vec<String>,
}

/// More than fit on a screen.
const MOST_TEXTS: usize = 100;

impl Verdicts {
    /// Adds a result. Says so if the pictures agree, unless `quiet`.
    pub fn add(&mut self, verdict: Verdict, quiet: bool) {
        self.compared += 1;
        if !verdict.agrees {
            self.differing += 1;
            if self.texts.len() < MOST_TEXTS {
                self.texts.push(verdict.text);
            }
        } else if !quiet {
            note(&(verdict.text + "\n"));
        }
    }

    /// # Errors
    /// [`CliError::Differs`], with a line for each picture that differs.
    pub fn finish(self) -> Result<(), CliError> {
        match self.differing {
            0 => Ok(()),
            1 if self.compared == 1 => Err(CliError::Differs(self.texts.join("\n"))),
            many => Err(CliError::Differs(format!(
                "{many} of {} pictures differ from their references\n  {}",
                self.compared,
                self.texts.join("\n  ")
            ))),
        }
    }
}
