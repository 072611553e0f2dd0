#!/bin/sh
# Manual pages and completions of the program, in the folders where a Linux looks for them.
# packaging/pages.sh PROGRAM FOLDER
set -eu
program=$1
folder=$2
mkdir -p "$folder/man/man1"
"$program" man --out "$folder/man/man1" > /dev/null
gzip -9n "$folder"/man/man1/*.1
complete() {
    mkdir -p "$(dirname "$folder/$2")"
    "$program" completions "$1" > "$folder/$2"
}
complete bash bash-completion/completions/stiffbench
complete zsh zsh/site-functions/_stiffbench
complete fish fish/vendor_completions.d/stiffbench.fish
