#!/usr/bin/env bash
# Measures the frames per second of the live window on a virtual display (Xvfb). Prints a table in Markdown.
#
#   bash benches/viewer/run.sh [SCENE ...]     (the shipped scenes by default)
#
# Needs xvfb (Debian: apt-get install xvfb), jq and a release build of octray (OCTRAY names another one).
# Orbits every scene for SECONDS_EACH (5) seconds in 512x512 and 1280x720, then a generated mesh of TRIANGLES (a million)
# triangles in 1280x720. All of it is repeated RUNS (3) times; each row is the median by full-quality frames per second, in
# which every pixel of the window was traced.
set -euo pipefail
here=$PWD
cd "$(dirname "$0")/../.."
root=$PWD
octray=$(realpath "${OCTRAY:-target/release/octray}")
seconds=${SECONDS_EACH:-5}
runs=${RUNS:-3}
triangles=${TRIANGLES:-1000000}
for tool in xvfb-run jq "$octray"; do
    command -v "$tool" >/dev/null || { echo "$tool is missing: see the head of this script" >&2; exit 1; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if [ $# -eq 0 ]; then
    set -- "$root"/scenes/{silhouette,matte,blinn_phong,reflections}.scn
else
    cd "$here"
    set -- $(realpath "$@")
fi
"$octray" generate terrain --count "$triangles" -o "$folder" >/dev/null
mesh=$(ls "$folder"/*.ply)

# Scene and size of every row.
for scene in "$@"; do
    printf '%s 512x512\n%s 1280x720\n' "$scene" "$scene"
done >"$folder/rows"
printf '%s 1280x720\n' "$mesh" >>"$folder/rows"

# One server for all of them.
xvfb-run --auto-servernum --server-args "-screen 0 1400x900x24" bash -c '
    set -euo pipefail
    for _ in $(seq "$4"); do
        row=0
        while read -r scene size; do
            row=$((row + 1))
            "$1" view "$scene" --size "$size" --benchmark "$3" --json - </dev/null >>"$2/$row.json"
        done <"$2/rows"
    done
' bash "$octray" "$folder" "$seconds" "$runs"

echo "| scene | window | frames a second | of full quality | full-quality frames a second | a frame, median | 99 of 100 |"
echo "|---|---|---|---|---|---|---|"
row=0
while read -r scene size; do
    row=$((row + 1))
    jq -rs --arg scene "$(basename "$scene")" --arg size "$size" '
        sort_by([.fps * .full_quality_share, .fps]) | .[length / 2 | floor]
        | "| `\($scene)` | \($size) | \(.fps | round) | \(.full_quality_share * 100 | round) % | "
          + "\(.fps * .full_quality_share | round) | \(.frame_ms_p50 * 10 | round / 10) ms | \(.frame_ms_p99 * 10 | round / 10) ms |"
    ' "$folder/$row.json"
done <"$folder/rows"
