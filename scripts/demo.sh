#!/bin/sh
# Solves the published problem at n_div = 16: demo/table1.h5, its pictures, and a printed table.
. "$(dirname "$0")/prepare.sh"
cargo build --release --locked $features
mkdir -p demo
exec target/release/contact3d-pipe run pipelines/hkl2011_table1.toml demo/table1.h5
