# What .ci/run and .ci/long share. Sourced by bash, from the package's root.

# step HEADING COMMAND...: prints the heading, runs the command, prints its seconds and keeps them for step_table.
step_seconds=()
step() {
    local heading=$1 start=$SECONDS
    shift
    printf '\n=== %s\n' "$heading"
    "$@"
    printf '=== %s: %d s\n' "$heading" "$((SECONDS - start))"
    step_seconds+=("$(printf '%5d s  %s' "$((SECONDS - start))" "$heading")")
}

# step_table: the seconds of every step so far.
step_table() {
    printf '\n'
    printf '%s\n' "${step_seconds[@]}"
}

# apt_install COMMAND PACKAGE: installs PACKAGE if COMMAND is missing; says so if it cannot.
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

# fuzz SECONDS: builds all fuzz targets once, as cargo-fuzz would, then runs them two at a time on copies of their seeds.
# Sanitizers need an unstable compiler flag: nightly if it is installed, else stable with RUSTC_BOOTSTRAP.
fuzz() {
    local seconds=$1 toolchain=() host flags
    if rustup toolchain list 2>/dev/null | grep -q '^nightly'; then
        toolchain=(+nightly)
    else
        export RUSTC_BOOTSTRAP=1
    fi
    host=$(rustc -vV | sed -n 's/^host: //p')
    flags="--cfg fuzzing -Zsanitizer=address -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
    flags+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
    flags+=" -Cllvm-args=-sanitizer-coverage-trace-compares -Cllvm-args=-simplifycfg-branch-fold-threshold=0"
    # Without line numbers: 15 programs with them fill 4 GB instead of 1.3. `cargo fuzz` has them for a found input.
    CARGO_PROFILE_RELEASE_DEBUG=false RUSTFLAGS=$flags cargo "${toolchain[@]}" build --release \
        --manifest-path fuzz/Cargo.toml --target "$host" --target-dir target/fuzz
    unset RUSTC_BOOTSTRAP

    fuzz_work=$(mktemp -d)
    export fuzz_work fuzz_seconds=$seconds fuzz_programs=target/fuzz/$host/release
    export -f fuzz_one
    ls fuzz/fuzz_targets | sed 's/\.rs$//' | xargs -P 2 -I NAME bash -c 'fuzz_one NAME'
    rm -rf "$fuzz_work"
}

# fuzz_one TARGET: runs one target for $fuzz_seconds and prints the number of executions, or the log if it fails.
fuzz_one() {
    local target=$1 log=$fuzz_work/$1.log corpus=$fuzz_work/$1 dictionary=fuzz/dictionaries/${1/render/scn}.dict
    local options=(-max_total_time="$fuzz_seconds" -rss_limit_mb=1024 -timeout=5 -print_final_stats=1)
    mkdir -p "$corpus" "fuzz/artifacts/$target"
    cp -r "fuzz/seeds/$target/." "$corpus"
    options+=(-artifact_prefix="fuzz/artifacts/$target/")
    if [ -e "$dictionary" ]; then
        options+=(-dict="$dictionary")
    fi
    if ! ASAN_OPTIONS=detect_odr_violation=0 "$fuzz_programs/$target" "$corpus" "${options[@]}" >"$log" 2>&1; then
        cat "$log"
        echo "fuzz target $target failed"
        return 1
    fi
    printf '%-12s %s executions\n' "$target" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")"
}
