#!/usr/bin/env bash
# From a file to a picture: octray against f3d, alternately on the same binary PLY.
#
#   bash benches/f3d/run.sh [TRIANGLES ...]     (1 and 10 million by default)
#
# Needs f3d and xvfb (Debian: apt-get install f3d xvfb) and a release build of octray (OCTRAY names another one). Both
# make a picture of 1024x1024; octray with shadows, which f3d does not draw. Prints the median time of RUNS (5) from
# program start to end, and the peak memory as bytes per triangle if GNU time is installed.
set -euo pipefail
cd "$(dirname "$0")/../.."
octray=${OCTRAY:-target/release/octray}
runs=${RUNS:-5}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
[ $# -gt 0 ] || set -- 1000000 10000000
for tool in f3d xvfb-run "$octray"; do
    command -v "$tool" >/dev/null || { echo "$tool not found; see the head of this script" >&2; exit 1; }
done

# Seconds of a command that must write a picture.
seconds() {
    rm -f "$folder/picture.png"
    local start end
    start=$(date +%s.%N)
    if [ -x /usr/bin/time ]; then
        /usr/bin/time -q -f %M -o "$folder/memory" "$@" >/dev/null 2>&1
    else
        "$@" >/dev/null 2>&1
    fi
    end=$(date +%s.%N)
    [ -s "$folder/picture.png" ] || { echo "no picture: $*" >&2; exit 1; }
    awk "BEGIN { print $end - $start }"
}

median() {
    sort -n | awk '{ all[NR] = $1 } END { print all[int((NR + 1) / 2)] }'
}

# Keeps the largest peak of a program, KiB.
keep_most() {
    [ ! -e "$folder/memory" ] || cat "$folder/memory" >>"$folder/memory-$1"
}

# That as bytes a triangle.
each() {
    if [ -e "$folder/memory-$1" ]; then
        awk -v count="$2" '$1 > most { most = $1 } END { printf "%.0f", most * 1024 / count }' "$folder/memory-$1"
    else
        printf -- -
    fi
}

# One server for all runs, so that its start is not counted.
xvfb-run --auto-servernum --server-args "-screen 0 1280x1280x24" bash -c '
    set -euo pipefail
    '"$(declare -f seconds median keep_most each)"'
    folder=$1 octray=$2 runs=$3
    shift 3
    printf "%12s %10s %10s %8s %12s %12s\n" triangles octray f3d ratio "octray B/tri" "f3d B/tri"
    for count in "$@"; do
        "$octray" generate terrain --count "$count" -o "$folder" >/dev/null
        mesh=$(ls "$folder"/*.ply)
        : >"$folder/ours"
        : >"$folder/theirs"
        rm -f "$folder"/memory*
        for _ in $(seq "$runs"); do
            seconds "$octray" "$mesh" --size 1024x1024 --quiet -o "$folder/picture.png" >>"$folder/ours"
            keep_most ours
            seconds f3d "$mesh" --resolution 1024,1024 --output "$folder/picture.png" >>"$folder/theirs"
            keep_most theirs
        done
        ours=$(median <"$folder/ours")
        theirs=$(median <"$folder/theirs")
        printf "%12s %8.2f s %8.2f s %7.2fx %12s %12s\n" "$count" "$ours" "$theirs" \
            "$(awk "BEGIN { print $theirs / $ours }")" "$(each ours "$count")" "$(each theirs "$count")"
        rm -f "$folder"/*.ply "$folder"/*.scn
    done
' bash "$folder" "$octray" "$runs" "$@"
