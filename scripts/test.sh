#!/bin/sh
# Everything that must hold: format, lints, docs, tests, schemas, one pipeline, the Python checks.
. "$(dirname "$0")/prepare.sh"
bring checks scripts/build-requirements.txt python-checks/requirements.txt
# What the tests compile serves `cargo build` and the wheel only while all want the same features of the same crates.
# $features are words for cargo.
# shellcheck disable=SC2086
wanted() {
    cargo tree --locked --prefix none --format '{p} [{f}]' $features "$@" | sed 's/ (\*)$//' | sort -u
}
mkdir -p target
wanted -e normal,build > target/wanted
other=$(wanted --workspace -e normal,build,dev | comm -23 target/wanted -)
[ -z "$other" ] || { echo "error: tests switch on more features, name them in Cargo.toml: $other" >&2; exit 1; }
cargo fmt --check
cargo package --workspace --locked --no-verify --allow-dirty --quiet
cargo clippy --release --locked --workspace --all-targets $features -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --workspace --no-deps $features
cargo test --release --locked --workspace $features
# The tests have built the program.
target/release/contact3d-pipe schema --check
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
target/release/contact3d-pipe run pipelines/hkl2011_table1.toml "$scratch/table1.h5" \
    --set 'body.brick.cells=[12,4,4]'
# In the order of names: the file with the longest tests is not the last. Matrices are small and the processes two: a
# second thread of BLAS in each would wait for its turn at every product.
OPENBLAS_NUM_THREADS=1 python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder python-checks
sh scripts/wheel.sh
