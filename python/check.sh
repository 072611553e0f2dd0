#!/bin/sh
# Builds the wheel, installs it in a fresh environment, and runs its tests, its examples and the comparison with Rust:
# check.sh PROGRAM [RATIO]. PROGRAM is the command whose JSON the results must equal, RATIO the largest of the times that passes.
set -eu
program=$(realpath "$1")
cd "$(dirname "$0")"
folder=target/check
rm -rf "$folder"
python3 -m venv "$folder/build"
"$folder/build/bin/pip" install --quiet 'maturin>=1.9,<2'
"$folder/build/bin/maturin" build --release --locked --out "$folder/wheel"
python3 -m venv "$folder/fresh"
"$folder/fresh/bin/pip" install --quiet "$folder"/wheel/stiffbench-*.whl
# NumPy is all that a user needs; pandas comes with the tests.
(cd "$folder" && fresh/bin/python -c "import stiffbench; stiffbench.Robot().compliance(stiffbench.Robot().limits.T.copy())")
"$folder/fresh/bin/pip" install --quiet pandas pytest
STIFFBENCH=$program "$folder/fresh/bin/python" -m pytest --quiet tests
ls -l "$folder"/wheel
bytes=$(wc -c < "$(ls "$folder"/wheel/stiffbench-*.whl)")
echo "wheel: $bytes bytes"
test "$bytes" -le 15000000
"$folder/fresh/bin/python" bench.py --most "${2:-1.05}"
