#!/bin/sh
# The exported data package as the frictionless package sees it, and the snippet of docs/export.md under pandas.
# Usage: check.sh PROGRAM BIN, where BIN is the folder of a Python environment with pandas and frictionless.
set -eu
program=$(realpath "$1")
bin=$(realpath -s "$2")
page=$(realpath docs/export.md)
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$folder"
"$program" simulate my-session --seed 4 --quiet
"$program" export my-session --out my-tables --quiet
"$bin/frictionless" validate my-tables/datapackage.json
sed -n '/^```python$/,/^```$/p' "$page" | sed '1d;$d' > snippet.py
"$bin/python" snippet.py
