//! Files that older builds wrote, as `tests/fixtures/README.md` tells: they are read, checked and
//! gone on with.

mod accuracy;
mod digests;
mod outputs;
mod program;
mod run_files;
mod sweep;
