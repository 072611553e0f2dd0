#!/bin/sh
# What is written for others, as others read it: the data package by frictionless, the snippet of docs/export.md by pandas, the research object by
# rocrate, the report by Typst.
# Usage: check.sh PROGRAM BIN, where BIN is the folder of a Python environment with these four.
set -eu
program=$(realpath "$1")
bin=$(realpath -s "$2")
page=$(realpath docs/export.md)
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$folder"
"$program" simulate my-session --seed 4 --quiet
"$program" export my-session --out my-tables --ro-crate --quiet
"$program" report my-session --format typst --quiet > report.txt
"$bin/frictionless" validate my-tables/datapackage.json
sed -n '/^```python$/,/^```$/p' "$page" | sed '1d;$d' > snippet.py
"$bin/python" snippet.py
"$bin/python" - << 'END'
import os
import rocrate.rocrate
import typst

files = rocrate.rocrate.ROCrate("my-tables").data_entities
assert {file.id for file in files} == set(os.listdir("my-tables")) - {"ro-crate-metadata.json"}
typst.compile("my-session/report.typ", output="report.pdf")
assert open("report.pdf", "rb").read(5) == b"%PDF-"
END
