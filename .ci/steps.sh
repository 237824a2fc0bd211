# Shared by .ci/run, .ci/long, .ci/same and .ci/portable. Source it from the package's folder.

# step HEADING COMMAND...: prints the heading, runs the command, prints its seconds.
step() {
    local heading=$1 start=$SECONDS
    shift
    printf '\n=== %s\n' "$heading"
    "$@"
    printf '=== %s: %d s\n' "$heading" "$((SECONDS - start))"
}

# apt_install COMMAND PACKAGE: installs PACKAGE with apt if COMMAND is missing, or says why it cannot.
apt_install() {
    local command=$1 package=$2 sudo=()
    if command -v "$command" >/dev/null; then
        return
    fi
    if ! command -v apt-get >/dev/null; then
        echo "$command is missing and there is no apt-get: tests that need it skip themselves"
        return
    fi
    if [ "$(id -u)" != 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            echo "$command is missing and installing $package needs root: tests that need it skip themselves"
            return
        fi
        sudo=(sudo -n)
    fi
    export DEBIAN_FRONTEND=noninteractive
    if ! { "${sudo[@]}" apt-get update -qq && "${sudo[@]}" apt-get install -qq -y --no-install-recommends "$package"; }; then
        echo "$package could not be installed: tests that need $command skip themselves"
    fi
}

# cargo_install COMMAND CRATE [OPTION...]: installs a cargo subcommand if it is missing.
cargo_install() {
    command -v "$1" >/dev/null || cargo install --locked "${@:2}"
}

# fuzz SECONDS: builds all fuzz targets and runs each on a copy of its seeds, so that the checkout stays clean.
# Sanitizers need an unstable compiler flag: nightly if it is installed, else stable with RUSTC_BOOTSTRAP.
fuzz() {
    local seconds=$1 toolchain=() target corpus work dictionary options
    cargo_install cargo-fuzz cargo-fuzz
    if rustup toolchain list 2>/dev/null | grep -q '^nightly'; then
        toolchain=(+nightly)
    else
        export RUSTC_BOOTSTRAP=1
    fi
    # cargo-fuzz sets RUSTFLAGS, which replaces the target CPU of .cargo/config.toml.
    if [ "$(uname -m)" = x86_64 ]; then
        export RUSTFLAGS="-C target-cpu=x86-64-v3"
    fi
    cargo "${toolchain[@]}" fuzz build
    work=$(mktemp -d)
    for target in $(cargo "${toolchain[@]}" fuzz list); do
        printf '\n--- fuzz target %s, %d s\n' "$target" "$seconds"
        corpus=$work/$target
        mkdir "$corpus"
        cp -r "fuzz/seeds/$target/." "$corpus"
        dictionary=fuzz/dictionaries/${target/render/scn}.dict
        options=(-max_total_time="$seconds" -rss_limit_mb=1024 -timeout=5 -print_final_stats=1)
        if [ -e "$dictionary" ]; then
            options+=(-dict="$dictionary")
        fi
        cargo "${toolchain[@]}" fuzz run "$target" "$corpus" -- "${options[@]}"
    done
    rm -rf "$work"
    unset RUSTFLAGS RUSTC_BOOTSTRAP
}
