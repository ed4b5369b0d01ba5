#!/bin/sh
# Installs the programs that read the outputs back in the tests (tests/readers): GDAL's command line tools from the system,
# xarray, rioxarray and the CF checker from PyPI into target/readers-venv. Does nothing when they are there already.
set -eu
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}
venv=$target/readers-venv
wanted=tests/readers/requirements.txt

need=""
command -v gdalinfo >/dev/null || need="$need gdal-bin"
command -v python3 >/dev/null || need="$need python3"
python3 -c "import ensurepip" 2>/dev/null || need="$need python3-venv"
if [ -n "$need" ]; then
    command -v apt-get >/dev/null || { echo "please install:$need" >&2; exit 1; }
    sudo=""; [ "$(id -u)" = 0 ] || sudo=sudo
    echo "installing:$need" >&2
    # The words of $need are separate packages.
    # shellcheck disable=SC2086
    $sudo apt-get update -qq && $sudo apt-get install -y --no-install-recommends $need
fi

if ! cmp -s "$wanted" "$venv/installed.txt"; then
    echo "installing the readers into $venv" >&2
    mkdir -p "$target"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$wanted"
    cp "$wanted" "$venv/installed.txt"
fi
