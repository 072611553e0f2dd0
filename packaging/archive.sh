#!/bin/sh
# An archive of the program for any Linux, with manual pages, completions and an installer, and its SHA-256; needs tar and sha256sum.
# packaging/archive.sh target/x86_64-unknown-linux-musl/dist/stiffbench FOLDER
set -eu
program=$1
folder=$2
here=$(cd "$(dirname "$0")/.." && pwd)
name=stiffbench-$("$program" --version | cut -d ' ' -f 2)-linux-$(uname -m)
parent=$(mktemp -d)
trap 'rm -rf "$parent"' EXIT
root=$parent/$name

install -D -m 755 "$program" "$root/bin/stiffbench"
"$here/packaging/pages.sh" "$program" "$root/share"
mkdir -p "$root/share/doc/stiffbench"
cp -r "$here/README.md" "$here/CHANGELOG.md" "$here"/LICENSE-* "$here/docs" "$root/share/doc/stiffbench"
install -m 755 "$here/packaging/install.sh" "$root/install.sh"
(cd "$root" && find . -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs sha256sum > SHA256SUMS)

mkdir -p "$folder"
# The same files give the same archive.
tar -C "$parent" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 -c "$name" | gzip -9n > "$folder/$name.tar.gz"
(cd "$folder" && sha256sum "$name.tar.gz" > "$name.tar.gz.sha256")
