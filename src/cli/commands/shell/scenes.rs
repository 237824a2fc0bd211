//! What completion scripts of clap_complete lack. Above all `octray SCENE ...`, which is short for `octray render SCENE ...`.
//!
//! clap knows nothing of it, so what clap_complete makes of its definition is told that the first word is `render` unless it
//! is a command.

use clap_complete::Shell;

/// Stands for the names of all commands, separated by spaces.
const COMMANDS: &str = "COMMANDS";

/// Replaces clap_complete's registration, as the last one counts.
const BASH: &str = r#"
# The first word is a command or a scene; `octray SCENE ...` completes as `octray render SCENE ...`.
_octray_or_scene() {
    local commands=" COMMANDS " words=() word current=$2 previous=$3 listed=
    if [[ $COMP_CWORD -eq 1 && $2 != -* ]]; then
        COMPREPLY=( $(compgen -W "$commands" -- "$2") )
        while IFS= read -r word; do
            COMPREPLY+=("$word")
        done < <(compgen -f -- "$2")
        compopt -o filenames 2>/dev/null
        return
    fi
    # Bash splits `--option=value` into three words.
    if [[ $previous == = && $COMP_CWORD -gt 2 ]]; then
        previous=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    # Of a list the last value is completed.
    if [[ $previous == -* && $current == *,* ]]; then
        listed=${current%,*},
        current=${current##*,}
    fi
    if [[ $commands != *" ${COMP_WORDS[1]} "* ]]; then
        COMP_WORDS=("${COMP_WORDS[0]}" render "${COMP_WORDS[@]:1}")
        COMP_CWORD=$((COMP_CWORD + 1))
    fi
    _octray "$1" "$current" "$previous"
    if [[ $2 != -* ]]; then
        # Neither options nor the names of arguments: files are completed if nothing else is left.
        for word in "${COMPREPLY[@]}"; do
            [[ $word == [-\<\[]* ]] || words+=("$listed$word")
        done
        COMPREPLY=("${words[@]}")
    fi
}
complete -F _octray_or_scene -o bashdefault -o default octray
"#;

/// Begins the body of clap_complete's function.
const ZSH: &str = r#"    # The first word is a command or a scene; `octray SCENE ...` completes as `octray render SCENE ...`.
    local -a octray_commands
    octray_commands=(COMMANDS)
    if (( CURRENT == 2 )) && [[ $words[2] != -* ]]; then
        _alternative 'commands:octray command:_octray_commands' 'files:scene:_files'
        return
    fi
    if (( ! $octray_commands[(Ie)$words[2]] )); then
        words=("$words[1]" render "${(@)words[2,-1]}")
        (( CURRENT += 1 ))
    fi

"#;

/// Replaces clap_complete's functions, as the last ones count.
const FISH: &str = r#"
# The first word is a command or a scene; `octray SCENE ...` completes as `octray render SCENE ...`.
function __fish_octray_needs_command
    set -l words (commandline -opc)
    set -q words[2]
    or return 0
    if contains -- $words[2] COMMANDS
        echo $words[2]
    else
        echo render
    end
    return 1
end

function __fish_octray_using_subcommand
    set -l command (__fish_octray_needs_command)
    # The options of `render` may come first.
    and set command render
    contains -- $command $argv
end

complete -c octray -n "__fish_octray_needs_command" -F
"#;

/// How clap_complete completes files, which breaks names at spaces. Without an answer bash completes them itself.
const BASH_FILES: &str = r#"COMPREPLY=($(compgen -f "${cur}"))"#;

/// Where the body of clap_complete's function for zsh begins.
const ZSH_START: &str = "\n_octray() {\n";
/// How clap_complete begins an argument that takes all further words for itself: no options complete after the first one.
const ZSH_REST: &str = "\n'*::";
/// The same with options between them.
const ZSH_MIXED: &str = "\n'*:";

/// A script of clap_complete that also completes `octray SCENE ...`: for bash, zsh and fish. `fish_words` is what fish needs
/// besides.
pub fn with_scenes(shell: Shell, script: &str, commands: &[&str], fish_words: &str) -> String {
    let filled = |text: &str| text.replace(COMMANDS, &commands.join(" "));
    match shell {
        Shell::Bash => script.replace(BASH_FILES, "COMPREPLY=()") + &filled(BASH),
        Shell::Zsh => {
            script
                .replace(ZSH_REST, ZSH_MIXED)
                .replacen(ZSH_START, &(ZSH_START.to_owned() + &filled(ZSH)), 1)
        }
        Shell::Fish => script.to_owned() + &filled(FISH) + fish_words,
        _ => script.to_owned(),
    }
}
