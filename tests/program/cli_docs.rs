//! `docs/cli.md` matches the program's definition.

use std::{env, fs, path::Path};

#[test]
fn the_reference_of_options_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/cli.md");
    let mut definition = octray::cli::definition()
        .version(env!("CARGO_PKG_VERSION"))
        .long_version(None)
        .disable_help_subcommand(true)
        // Else `octray-render`, as the manual pages are called.
        .mut_subcommands(|command| {
            let name = command.get_name().to_owned();
            command.display_name(name)
        });
    definition.build();
    let options = clap_markdown::MarkdownOptions::new()
        .title("Commands and options".into())
        .show_footer(false)
        .show_table_of_contents(true);
    let made = clap_markdown::help_markdown_command_custom(&definition, &options);
    let made = as_markdown(made.trim_end());
    if env::var_os("OCTRAY_BLESS").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "docs/cli.md is stale: OCTRAY_BLESS=1 cargo test --test program cli_docs makes it again"
    );
}

/// Puts examples into blocks of code, corrects usages, and leaves out the defaults of switches.
fn as_markdown(help: &str) -> String {
    let mut made = String::new();
    let mut in_examples = false;
    for line in help.lines() {
        if in_examples && line.is_empty() {
            made += "```\n";
            in_examples = false;
        }
        made += if in_examples {
            line.strip_prefix("  ").unwrap_or(line)
        } else {
            line
        };
        made.push('\n');
        if matches!(line, "Examples:" | "Example of a config file:") {
            made += "\n```text\n";
            in_examples = true;
        }
    }
    if in_examples {
        made += "```\n";
    }
    made.replace("\n       octray <COMMAND> ...`", "` or `octray <COMMAND> ...`")
        .replace("`octray octray ", "`octray ")
        .replace("\n\n  Default value: `false`\n", "\n")
}
