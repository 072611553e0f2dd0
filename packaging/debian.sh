#!/bin/sh
# A Debian package of the program, with manual pages and completions; needs dpkg-deb and nothing else.
# packaging/debian.sh target/x86_64-unknown-linux-musl/dist/stiffbench FOLDER
set -eu
program=$1
folder=$2
here=$(cd "$(dirname "$0")/.." && pwd)
version=$("$program" --version | cut -d ' ' -f 2)
architecture=$(dpkg --print-architecture)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

install -D -m 755 "$program" "$root/usr/bin/stiffbench"
"$here/packaging/pages.sh" "$program" "$root/usr/share"
# Debian has a folder of its own for what packages bring for zsh.
mv "$root/usr/share/zsh/site-functions" "$root/usr/share/zsh/vendor-completions"
documents=$root/usr/share/doc/stiffbench
mkdir -p "$documents"
cp "$here/README.md" "$here/CHANGELOG.md" "$here/LICENSE-APACHE" "$documents"
cp "$here/LICENSE-MIT" "$documents/copyright"
cp -r "$here/docs" "$documents/docs"

mkdir "$root/DEBIAN"
size=$(du -sk "$root/usr" | cut -f1)
cat > "$root/DEBIAN/control" << END
Package: stiffbench
Version: $version
Architecture: $architecture
Section: science
Priority: optional
Installed-Size: $size
Maintainer: the authors of stiffbench
Description: stiffness of a robot from two gauges on a bench
 Guided sessions with a force gauge and a displacement gauge, stiffness with
 its uncertainty, fitted beam models, and what a model leaves out.
END
chmod -R u=rwX,go=rX "$root"
mkdir -p "$folder"
dpkg-deb --root-owner-group --build "$root" "$folder/stiffbench_${version}_$architecture.deb"
