#!/bin/sh
# Checks the files of this archive and installs them: into ~/.local, or into the folder that is given.
# ./install.sh [PREFIX]
set -eu
prefix=${1:-$HOME/.local}
cd "$(dirname "$0")"
if ! sha256sum --quiet -c SHA256SUMS; then
    echo "install.sh: a file of the archive is damaged, nothing was installed; download the archive again" >&2
    exit 1
fi
mkdir -p "$prefix/bin"
# A new file in place of the old one, also while the old one runs.
install -m 755 bin/stiffbench "$prefix/bin/.stiffbench.new"
mv "$prefix/bin/.stiffbench.new" "$prefix/bin/stiffbench"
cp -r share "$prefix/"
echo "installed: $prefix/bin/stiffbench"
case :$PATH: in
    *:"$prefix/bin":*) ;;
    *) echo "add it to the PATH of your shell: export PATH=\"$prefix/bin:\$PATH\"" ;;
esac
