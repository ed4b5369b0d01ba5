#!/bin/sh
# Installs the system packages that are missing (Debian, Ubuntu). With the argument `test`, also what the tests call.
# Where nothing is missing it needs neither root nor a network and says nothing.
set -eu

missing=""
need() { missing="$missing $1"; }

command -v cc >/dev/null 2>&1 || need build-essential
command -v pkg-config >/dev/null 2>&1 || need pkg-config
pkg-config --exists 'gdal >= 3.4' 2>/dev/null || need libgdal-dev
pkg-config --exists netcdf 2>/dev/null || need libnetcdf-dev
if [ "${1:-}" = test ]; then
    command -v gdalinfo >/dev/null 2>&1 || need gdal-bin
    # Debian's python3 comes without the parts that make a virtual environment.
    python3 -c 'import ensurepip, venv' 2>/dev/null || need python3-venv
fi

if [ -n "$missing" ]; then
    if ! command -v apt-get >/dev/null 2>&1; then
        echo "please install the equivalents of these Debian packages:$missing" >&2
        exit 1
    fi
    as_root=""
    if [ "$(id -u)" != 0 ]; then
        if ! command -v sudo >/dev/null 2>&1; then
            echo "please install as root: apt-get install$missing" >&2
            exit 1
        fi
        as_root=sudo
    fi
    echo "installing:$missing" >&2
    $as_root apt-get update -qq
    # shellcheck disable=SC2086 # the names are to be split
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
    if ! pkg-config --exists 'gdal >= 3.4' 2>/dev/null; then
        echo "this system's GDAL ($(pkg-config --modversion gdal 2>/dev/null || echo none)) is older than 3.4" >&2
        exit 1
    fi
fi

if ! command -v cargo >/dev/null 2>&1; then
    echo "no Rust toolchain found: install rustup from https://rustup.rs; it fetches the version that this project pins" >&2
    exit 1
fi
