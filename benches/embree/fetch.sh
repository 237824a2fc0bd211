#!/usr/bin/env bash
# Fetches Embree's shared library into target/embree, for `cargo bench --bench embree --features embree-bench`.
# It comes inside a Python package, which is only unpacked: nothing is installed. Linux on x86-64; needs pip for
# the download and python3 to unpack.
set -euo pipefail
package=embreex==4.4.0.post1
cd "$(dirname "$0")/../.."
folder=target/embree
mkdir -p "$folder"
if compgen -G "$folder/embreex.libs/libembree4-*.so.4" >/dev/null; then
    echo "$folder already has $(basename "$folder"/embreex.libs/libembree4-*.so.4)"
    exit 0
fi
# Which Python the wheel is for does not matter here; the library inside is the same. Any that is published will do.
python3 -m pip download --quiet --no-deps --only-binary=:all: --platform manylinux_2_28_x86_64 \
    --python-version 3.12 --dest "$folder" "$package"
python3 -m zipfile -e "$folder"/embreex-*.whl "$folder"
echo "unpacked $(ls "$folder"/embreex.libs/libembree4-*.so.4)"
