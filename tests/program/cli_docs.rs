//! `docs/cli.md` says what the program's own definition says.

use std::{env, fs, path::Path};

#[test]
fn the_reference_of_options_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/cli.md");
    let mut definition = octray::cli::definition()
        .version(env!("CARGO_PKG_VERSION"))
        .long_version(None);
    definition.build();
    let options = clap_markdown::MarkdownOptions::new()
        .title("Commands and options".into())
        .show_footer(false)
        .show_table_of_contents(true);
    let made = clap_markdown::help_markdown_command_custom(&definition, &options);
    let made = format!("{}\n", made.trim_end());
    if env::var_os("OCTRAY_BLESS").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "docs/cli.md is stale: OCTRAY_BLESS=1 cargo test --test program cli_docs makes it again"
    );
}
