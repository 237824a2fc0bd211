#!/usr/bin/env bash
# Fetches Embree's shared library into target/embree, for `cargo bench --bench embree --features embree-bench`.
# The library comes in a Python package, which is only unpacked. Linux on x86-64; needs pip to download and python3 to
# unpack.
set -euo pipefail
package=embreex==4.4.0.post1
cd "$(dirname "$0")/../.."
folder=target/embree
mkdir -p "$folder"
if compgen -G "$folder/embreex.libs/libembree4-*.so.4" >/dev/null; then
    echo "$folder already has $(basename "$folder"/embreex.libs/libembree4-*.so.4)"
    exit 0
fi
# The library is the same in the wheels for every Python.
python3 -m pip download --quiet --no-deps --only-binary=:all: --platform manylinux_2_28_x86_64 \
    --python-version 3.12 --dest "$folder" "$package"
python3 -m zipfile -e "$folder"/embreex-*.whl "$folder"
echo "unpacked $(ls "$folder"/embreex.libs/libembree4-*.so.4)"
