//! Calls of the command line: options, config files, references, standard streams.
