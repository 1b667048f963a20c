//! The `contact3d-pipe` program.

fn main() -> contact3d_pipe::Exit {
    contact3d_pipe::main()
}
