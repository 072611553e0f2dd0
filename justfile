# Recipes for daily work; `.ci/run` does all that must pass before a change goes in.

# What there is
default:
    @just --list

# Format, lints and documentation
check:
    cargo fmt --check
    cargo clippy --release --all-targets --all-features --locked -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --release --no-deps --locked

# All tests; arguments go to cargo test, for example `just test -p stiffbench cli::map`
test *arguments:
    cargo test --release --locked {{arguments}}

# Build and test one crate: numeric, units-and-text, document, beams, gauges, measurement, figures, session, simulation, diagnosis or validation
quick crate *arguments:
    cargo test --release --locked -p stiffbench-{{crate}} {{arguments}}

# What takes too long for every change, all parts (the whole proof is `just prove`)
nightly: ci nightly-engine nightly-exports nightly-sessions nightly-robots nightly-packages peers mutants

# Ignored tests, the quick proof, and the beam model beside solids of CalculiX (needs ccx)
nightly-engine:
    cargo test --release --locked -- --ignored
    cargo run --release --locked --bin stiffbench-validate -- prove --quick --out target/nightly/prove
    cargo run --release --locked --bin stiffbench-validate -- reference export --pose P1 --load=-50 --size 40 --out target/nightly/solids
    cargo run --release --locked --bin stiffbench-validate -- reference run target/nightly/solids
    cargo run --release --locked --bin stiffbench-validate -- reference compare target/nightly/solids
    cargo run --release --locked --bin stiffbench-validate -- reference export --robot serial-arm --size 40 --out target/nightly/solids-of-arm
    cargo run --release --locked --bin stiffbench-validate -- reference run target/nightly/solids-of-arm
    cargo run --release --locked --bin stiffbench-validate -- reference compare target/nightly/solids-of-arm

# Tables in pandas and Frictionless, reports in Typst, meshes in VTK and meshio, points as Parquet
nightly-exports: parquet
    cargo build --release --locked
    python3 -m venv target/nightly/exports
    target/nightly/exports/bin/pip install --quiet pandas frictionless rocrate typst
    sh tests/export/check.sh target/release/stiffbench target/nightly/exports/bin
    PATH="{{justfile_directory()}}/target/nightly/exports/bin:$PATH" cargo test --release --locked --test stiffbench -- export::

# Every fault in every phase of a session, and shards with GNU parallel and a Slurm cluster of one machine (needs parallel, slurm-wlm, munge)
nightly-sessions:
    cargo run --release --locked --bin stiffbench-validate -- faults
    timeout 600 examples/shards/check.sh target/release/stiffbench || test $? = 77

# Exported models in MuJoCo, PyBullet and URDF readers, compliance and sag in OpenSees (needs libblas3, liblapack3)
nightly-robots:
    cargo build --release --locked
    python3 -m venv target/nightly/robots
    target/nightly/robots/bin/pip install --quiet mujoco yourdfpy pin example-robot-data pybullet openseespy
    target/nightly/robots/bin/python tests/mujoco/check.py target/release/stiffbench
    target/nightly/robots/bin/python tests/urdf/check.py target/release/stiffbench
    target/nightly/robots/bin/python tests/opensees/check.py target/release/stiffbench

# The wheel, the book, other systems, the oldest Rust, licences and the packages
nightly-packages: wheel book systems msrv deny package
    if tag=$(git describe --tags --abbrev=0 2> /dev/null); then just semver "$tag"; else echo "semver: not run, there is no tag"; fi

# The main job: stiffness, fit, validation and figures of the shipped session
demo:
    cargo run --release --locked -- demo

# The proof that diagnoses can be trusted, whole (an hour or so on two cores); the result is kept in the repository
prove *arguments:
    cargo run --release --locked --bin stiffbench-validate -- prove --out data/concealed/results {{arguments}}

# Points of maps as Parquet: the test of the feature, and a map read back by Apache Arrow (another build, so no part of `ci`)
parquet:
    cargo test --release --locked --features parquet -p stiffbench --lib report::map::parquet
    cargo run --release --locked --features parquet -- robot map --samples 2000 --out target/parquet-check --quiet
    python3 -m venv target/parquet-check/venv
    target/parquet-check/venv/bin/pip install --quiet pyarrow==26.0.1
    target/parquet-check/venv/bin/python fixtures/parquet/check.py target/parquet-check

# The Python wheel in python/target/check/wheel: built, installed in a fresh environment, tested, its size and its time for 50,000 poses against Rust
wheel:
    cargo build --release --locked
    python/check.sh target/release/stiffbench

# Write what every command prints into fixtures/goldens and fixtures/goldens-validate again, and the schemas of results, and show every byte that has changed
goldens:
    STIFFBENCH_GOLDENS=write cargo test --release --locked --test stiffbench --test validation -- goldens schemas::the_schemas
    git status --short fixtures docs/schemas
    git diff --stat fixtures docs/schemas

# Attacks on whole sessions by gauges and an operator written apart from the program (eight minutes; Python 3.11); `just attacks --quick` for one
attacks *arguments:
    cargo build --release --locked
    python3 tests/attacks/attack.py target/release/stiffbench {{arguments}}

# Benchmarks; arguments go to cargo bench
bench *arguments:
    cargo bench --locked {{arguments}}

# The Rust benchmarks beside NumPy, SciPy, pandas, Numba and OpenSees, with ratios
peers:
    python3 -m venv target/peers
    target/peers/bin/pip install --quiet -r benches/peers/requirements.txt
    target/peers/bin/python benches/peers/compare.py

# How time and memory of diagnose grow with the readings; `just growth --most 27000` for longer sessions
growth *arguments:
    cargo build --release --locked
    python3 benches/growth.py {{arguments}} target/release/stiffbench

# A fuzz target (readings_csv, table_import, session_toml, instrument_bytes, instrument_description, journal) for a minute; needs nightly Rust and cargo-fuzz
fuzz target="readings_csv" seconds="60":
    cargo +nightly fuzz run {{target}} -- -max_total_time={{seconds}}

# The program as one static file for any Linux, without Parquet: target/x86_64-unknown-linux-musl/dist/stiffbench; target/archive for releases
dist:
    rustup target add x86_64-unknown-linux-musl
    RUSTFLAGS="-C relocation-model=static" cargo build --locked --profile dist --target x86_64-unknown-linux-musl --bin stiffbench
    strip -s target/x86_64-unknown-linux-musl/dist/stiffbench
    ! readelf -d target/x86_64-unknown-linux-musl/dist/stiffbench | grep NEEDED
    test "$(stat -c %s target/x86_64-unknown-linux-musl/dist/stiffbench)" -lt 20000000
    packaging/archive.sh target/x86_64-unknown-linux-musl/dist/stiffbench target/archive
    ls -l target/x86_64-unknown-linux-musl/dist/stiffbench target/archive

# Whether the program compiles for other systems
systems:
    rustup target add x86_64-pc-windows-gnu x86_64-apple-darwin
    cargo check --locked --target x86_64-pc-windows-gnu --bin stiffbench
    cargo check --locked --target x86_64-apple-darwin --bin stiffbench

# The pictures of the pages, made anew: a guided session, the figure of a found law, the first page of the demonstration's report (needs Chromium)
pictures:
    cargo build --release --locked
    rm -rf target/pictures && mkdir -p target/pictures
    STIFFBENCH_PICTURE={{justfile_directory()}}/docs/session.svg cargo test --release --locked --test stiffbench session_terminal::a_session_is_guided
    cd target/pictures && ../release/stiffbench simulate bench-3 --mechanism A --procedure load-unload --effect "joint-backlash@A3:play=30urad,seat_moment=9N*m" --seed 2
    cd target/pictures && ../release/stiffbench diagnose bench-3
    cp target/pictures/bench-3/diagnosis/found_law.png docs/figures/found-law.png
    cd target/pictures && ../release/stiffbench demo
    chromium --headless --no-sandbox --hide-scrollbars --window-size=980,1142 --screenshot=docs/figures/report.png target/pictures/stiffbench-demo/report.html

# The pages as a book, in target/book (needs mdbook)
book:
    mdbook build docs

# Everything that must pass
ci:
    .ci/run

# The packages as they would be published, each built from itself, and their size together
package:
    # What was packaged before under the same number would be checked in its place.
    rm -rf "${CARGO_HOME:-$HOME/.cargo}"/registry/*/-*/stiffbench-* target/package target/debug/.fingerprint/stiffbench-*
    cargo package --workspace --exclude stiffbench-validation --exclude stiffbench-test-files --locked
    du -cb target/package/*.crate | tail -n 1

# Licences, versions and sources of all dependencies (needs cargo-deny); advisories need the network
deny:
    cargo deny --all-features --locked check licenses bans sources
    cargo deny --all-features --locked check advisories || echo "advisories: not run, or see above"

# The oldest Rust that builds it
msrv:
    rustup toolchain install 1.89 --profile minimal
    cargo +1.89 check --release --locked --workspace

# Whether tests notice changed code: critical values, intervals, decoding (needs cargo-mutants; an hour)
mutants: (mutants-of "numeric" "statistics.rs reported.rs") (mutants-of "gauges" "number.rs")

# Nine in ten must be noticed, in time or by running out of it; the others are listed. Compiled in the quickest way: the time is the compiler's
[private]
mutants-of crate files:
    -CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 cargo mutants --package stiffbench-{{crate}} $(printf -- '--file crates/{{crate}}/src/%s ' {{files}}) --profile release --output target/mutants/{{crate}} -- --lib
    cat target/mutants/{{crate}}/mutants.out/missed.txt
    cd target/mutants/{{crate}}/mutants.out && noticed=$(cat caught.txt timeout.txt | wc -l) missed=$(wc -l < missed.txt) && echo "{{crate}}: $noticed noticed, $missed missed" && test $((9 * missed)) -le $noticed

# Whether the versions of the library crates say what changed for their users since a tag (needs cargo-semver-checks; a quarter of an hour)
semver tag:
    cargo semver-checks --workspace --exclude stiffbench-validation --exclude stiffbench-test-files --baseline-rev {{tag}}

# A Debian package of the static program, and the tutorial with that program alone in an empty root folder (needs root)
debian: dist
    packaging/debian.sh target/x86_64-unknown-linux-musl/dist/stiffbench target/debian
    python3 packaging/tutorial_in_chroot.py target/x86_64-unknown-linux-musl/dist/stiffbench
