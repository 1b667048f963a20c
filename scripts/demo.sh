#!/bin/sh
# Solves the published problem at n_div = 16: demo/table1.h5, its pictures, and a printed table.
. "$(dirname "$0")/prepare.sh"
cargo build --release --locked $features
exec python pipelines/hkl2011_demo.py demo
