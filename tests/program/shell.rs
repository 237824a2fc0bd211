//! Completions of shells, and manual pages.

use crate::program::{Folder, PROGRAM, Run};

#[test]
fn completions_for_every_shell() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = folder.run(&["completions", shell]);
        let text = run.succeeded().text();
        for word in ["octray", "turntable", "generate"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    folder.fails(&["completions", "csh"], 2, "bash");
    let run = folder.shell("\"$0\" completions bash > c.sh && bash -n c.sh");
    run.succeeded();
    // zsh: the first word may be a scene, and options may follow scenes.
    let script = folder.run(&["completions", "zsh"]);
    let (before, _) = script.text().split_once("'-h[").unwrap();
    assert!(before.contains("_octray() {\n    # The first word is a command or a scene"));
    assert!(before.contains("octray_commands=(render ") && !script.text().contains("\n'*::"));
    // fish: the last definition of a function counts.
    let script = folder.run(&["completions", "fish"]);
    let (_, last) = script
        .text()
        .rsplit_once("function __fish_octray_needs_command")
        .unwrap();
    assert!(last.contains("contains -- $words[2] render ") && last.contains("echo render"));
    for words in [
        "completions\" -f -a \"bash",
        "man\" -f -a \"render",
        "generate\" -f -a \"",
    ] {
        assert!(last.contains(words), "{words}: {last}");
    }
}

/// What bash offers for the last word of a command line.
fn offered(folder: &Folder, line: &[&str]) -> Vec<String> {
    const SCRIPT: &str = r#"
        eval "$("$0" completions bash)"
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
        function=$(complete -p octray); function=${function#*-F }
        ${function%% *} octray "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
        printf '%s\n' "${COMPREPLY[@]}""#;
    let run = folder.any_command("bash", &[&["-c", SCRIPT, PROGRAM], line].concat());
    let run = Run::new({ run }.output().unwrap());
    let words = run.text().lines().map(str::to_owned);
    words.filter(|word| !word.is_empty()).collect()
}

#[test]
fn bash_completes_a_scene_without_a_command() {
    let folder = Folder::new();
    folder.write("bunny two.ply", "");
    for (line, expected) in [
        (&["octray", "b"][..], &["bench", "bunny two.ply"][..]),
        (&["octray", "a.scn", "--st"], &["--style", "--stats"]),
        (&["octray", "--st"], &["--style", "--stats"]),
        (
            &["octray", "--ground", "bunny two.ply", "--st"],
            &["--style", "--stats"],
        ),
        (&["octray", "a.scn", "--mode", ""], &["packet", "scalar"]),
        (&["octray", "a.scn", "--mode", "=", "s"], &["scalar"]),
        (&["octray", "--style", "=", "cl"], &["clay"]),
        (&["octray", "a.scn", "--aov", "depth,no"], &["depth,normal"]),
        (&["octray", "view", "a,b.obj", "b,"], &[]),
        (&["octray", "a.scn", "--background", "w"], &["white"]),
        (&["octray", "info", "--js"], &["--json"]),
        // Left to bash, which completes files.
        (&["octray", "a.scn", ""], &[]),
        (&["octray", "render", ""], &[]),
    ] {
        assert_eq!(offered(&folder, line), expected, "{line:?}");
    }
    let offers = |line: &[&str], word: &str| offered(&folder, line).iter().any(|offer| offer == word);
    assert!(offers(&["octray", ""], "a.scn") && offers(&["octray", ""], "render"));
    assert!(offers(&["octray", "man", ""], "merge") && offers(&["octray", "help", ""], "merge"));
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = Folder::new();
    let run = folder.run(&["man"]);
    let page = run.succeeded().text();
    assert!(page.contains(".TH octray 1") && page.contains("render"), "{page}");
    for command in "render info bench generate merge job completions man".split(' ') {
        let run = folder.run(&["man", command]);
        let page = run.succeeded().text();
        assert!(page.contains(&format!("octray-{command}")), "{page}");
        assert!(page.contains("OPTIONS"), "{page}");
    }
    let help = folder.run(&["man", "help"]);
    assert!(!help.succeeded().text().contains("octray\\-help\\-"), "{help:?}");
    folder.fails(&["man", "rendre"], 2, "expected one of render, ");
}
