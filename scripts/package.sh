#!/bin/sh
# Makes what others install without a toolchain, in dist/: an archive, and on Debian and Ubuntu a package for this release of them.
#
#   scripts/package.sh             builds the program without debug information, then both files
#   scripts/package.sh stage DIR   lays the files of the archive into DIR, no more
#
# FLOODSIM_BINARY=FILE takes a program that is built already. DEBFULLNAME and DEBEMAIL name who answers for the package.
# The same commit and tools give the same bytes: dates are that of the last commit, or SOURCE_DATE_EPOCH where it is set.
set -eu
export LC_ALL=C
umask 022
root=$(cd "$(dirname "$0")/.." && pwd)
# A path as the caller means it.
absolute() { case $1 in /*) echo "$1" ;; *) echo "$PWD/$1" ;; esac; }

# What goes along beside the program, its manual page and its completions: all pages, without the figures and tables of the studies
# but for those that the guide shows; the scenarios whose data the project makes itself.
files="README.md CHANGELOG.md CONTRIBUTING.md LICENSE-MIT LICENSE-APACHE docs/tutorial data
    docs/figures/cells.svg docs/performance/cells.csv
    docs/validation/analytic/chart.csv docs/validation/methods/chart.csv docs/validation/stability/map.csv
    scenarios/demo scenarios/tutorial scenarios/breach scenarios/river_flood scenarios/spill scenarios/lake_at_rest scenarios/ritter
    scenarios/malpasset/README.md"

# Lays the program and all that goes along into a folder, as the archive has it.
stage() {
    mkdir -p "$1/completions"
    install -m 755 "$binary" "$1/floodsim"
    "$binary" man >"$1/floodsim.1"
    "$binary" completions bash >"$1/completions/floodsim.bash"
    "$binary" completions zsh >"$1/completions/_floodsim"
    "$binary" completions fish >"$1/completions/floodsim.fish"
    # Files that git knows, so that no leftover of this checkout travels; without git, all. Git's star passes over folders.
    # shellcheck disable=SC2086 # the names are to be split
    (
        cd "$root"
        git ls-files --error-unmatch -- $files 'docs/*.md' 2>/dev/null || { find $files -type f && find docs -name '*.md'; }
    ) |
        tar --create --directory "$root" --files-from=- --mode=u=rw,go=r | tar --extract --no-same-owner --directory "$1"
}

# The version of this folder; the one place that has it.
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")
binary=$(absolute "${FLOODSIM_BINARY:-$root/target/dist/floodsim}")
if [ -z "${FLOODSIM_BINARY:-}" ]; then
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}"
    binary=$(absolute "$CARGO_TARGET_DIR")/dist/floodsim
    # Messages of a breakdown name source files: by their place in the project, not by that on this machine.
    RUSTFLAGS="${RUSTFLAGS:-} --remap-path-prefix=$root=. --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo" \
        cargo build --manifest-path "$root/Cargo.toml" --profile dist --locked
fi
"$binary" --version | grep -q "^floodsim $version " || { echo "$binary is not version $version" >&2; exit 1; }

case "${1:-}" in
    "") ;;
    stage) [ $# = 2 ] || { echo "usage: scripts/package.sh stage DIR" >&2; exit 2; }; stage "$(absolute "$2")"; exit ;;
    *) echo "usage: scripts/package.sh [stage DIR]" >&2; exit 2 ;;
esac

SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH
mkdir -p "$root/dist"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The archive.
name=floodsim-$version-$(uname -m)-linux
stage "$work/$name"
tar --create --directory "$work" --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --format=gnu "$name" |
    gzip --no-name --best >"$root/dist/$name.tar.gz"
echo "dist/$name.tar.gz"

# The Debian package: the same files where Debian has them.
if ! command -v dpkg-deb >/dev/null || ! command -v dpkg-shlibdeps >/dev/null; then
    echo "no .deb: that takes dpkg-deb and dpkg-shlibdeps (Debian's dpkg-dev)" >&2
    exit
fi
architecture=$(dpkg --print-architecture)
maintainer="${DEBFULLNAME:-The floodsim developers} <${DEBEMAIL:-floodsim@example.org}>"
from=$work/$name
deb=$work/deb
share=$deb/usr/share
doc=$share/doc/floodsim
install -D -m 755 "$from/floodsim" "$deb/usr/bin/floodsim"
install -D -m 644 "$from/floodsim.1" "$share/man/man1/floodsim.1"
install -D -m 644 "$from/completions/floodsim.bash" "$share/bash-completion/completions/floodsim"
install -D -m 644 "$from/completions/_floodsim" "$share/zsh/vendor-completions/_floodsim"
install -D -m 644 "$from/completions/floodsim.fish" "$share/fish/vendor_completions.d/floodsim.fish"
mkdir -p "$share/floodsim" "$doc"
cp -R "$from/scenarios" "$from/data" "$share/floodsim/"
cp -R "$from/README.md" "$from/CHANGELOG.md" "$from/CONTRIBUTING.md" "$from/docs" "$doc/"
# Links of README and tutorial to scenarios hold here, too.
ln -s ../../floodsim/scenarios "$doc/scenarios"
ln -s ../../floodsim/data "$doc/data"
{
    echo "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/"
    echo "Upstream-Name: floodsim"
    echo
    echo "Files: *"
    echo "Copyright: $(sed -n 's/^Copyright (c) //p' "$from/LICENSE-MIT")"
    echo "License: Expat or Apache-2.0"
    echo
    echo "License: Expat"
    sed -e '1,/^Copyright/d' -e 's/^$/./' -e 's/^/ /' "$from/LICENSE-MIT" | sed 1d
    echo
    echo "License: Apache-2.0"
    echo " The text is in /usr/share/common-licenses/Apache-2.0."
} >"$doc/copyright"
{
    echo "floodsim ($version) stable; urgency=medium"
    echo
    echo "  * What changed is in CHANGELOG.md beside this file."
    echo
    echo " -- $maintainer  $(date --utc --date="@$SOURCE_DATE_EPOCH" --rfc-email)"
} >"$doc/changelog"
gzip --no-name --best "$doc/changelog" "$share/man/man1/floodsim.1"

# The libraries that the program calls, by the packages that have them here; they bring the data of GDAL and PROJ along.
mkdir -p "$work/source/debian" "$deb/DEBIAN"
printf 'Source: floodsim\n\nPackage: floodsim\nArchitecture: any\n' >"$work/source/debian/control"
depends=$(cd "$work/source" && dpkg-shlibdeps -O "$deb/usr/bin/floodsim" | sed -n 's/^shlibs:Depends=//p')
[ -n "$depends" ] || { echo "no dependencies found for the .deb" >&2; exit 1; }
(cd "$deb" && find usr -type f -print0 | sort -z | xargs -0 md5sum) >"$deb/DEBIAN/md5sums"
cat >"$deb/DEBIAN/control" <<END
Package: floodsim
Version: $version
Architecture: $architecture
Maintainer: $maintainer
Installed-Size: $(du -k -s --apparent-size "$deb/usr" | cut -f1)
Depends: $depends
Section: science
Priority: optional
Description: inundation maps of dam failures and floods
 Floodsim computes where water goes when a dam fails or a river floods. It
 takes terrain rasters, reservoir polygons and hydrographs, and writes depth,
 velocity, arrival time and hazard as maps for QGIS and as NetCDF.
 .
 It solves the shallow-water equations with particles: by default ones that
 are fixed on the terrain (a finite-volume scheme of second order), or ones
 that move with the water (SPH).
END
package=floodsim_${version}_$architecture.deb
dpkg-deb --root-owner-group -Zxz --build "$deb" "$root/dist/$package" >/dev/null
echo "dist/$package"
