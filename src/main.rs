//! The `contact3d-pipe` program.

fn main() -> contact3d_pipe::cli::Exit {
    contact3d_pipe::cli::main()
}
