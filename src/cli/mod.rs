//! The command line: arguments, dispatch, messages, exit codes.

mod adaptive;
mod arguments;
mod exit;
mod export;
mod friction_law;
mod generated;
mod init;
mod override_scene;
mod progress;
mod run;
mod stability;
mod status;
mod studies;
mod sweep;
mod terminal;

use std::thread;

use clap::Parser;

pub use arguments::Arguments;
pub use exit::Exit;

use arguments::Command;

/// Parses the command line, does what it asks, and says how it went.
#[must_use]
pub fn main() -> Exit {
    // Before anything calls HDF5, as `--version` does.
    if let Err(error) = runfile::require_plain_hdf5() {
        return terminal::close(exit::refuse(&error.to_string()));
    }
    // The stack of the first thread is as large as the shell allows, and a command that overflows it ends midway.
    let work = || match Arguments::try_parse() {
        Ok(arguments) => perform(&arguments),
        Err(error) => exit::explain_usage(error),
    };
    let worker = thread::Builder::new().stack_size(STACK_BYTES).spawn(work);
    terminal::close(match worker {
        Ok(worker) => worker
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        Err(error) => refuse_limits(&error),
    })
}

/// The stack of the thread that does the work; what Linux gives a first thread.
const STACK_BYTES: usize = 8 << 20;

fn refuse_limits(error: &std::io::Error) -> Exit {
    exit::refuse(&format!(
        "the system gives no threads or handlers of signals ({error}); raise the limits of the shell (`ulimit -a`)"
    ))
}

fn perform(arguments: &Arguments) -> Exit {
    let threads = arguments.thread_count();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global();
    let handlers = runfile::install_signal_handlers(progress::farewell);
    if let Err(error) = pool.map_err(std::io::Error::other).and(handlers) {
        return refuse_limits(&error);
    }
    let output = arguments.output;
    let outcome = match &arguments.command {
        Command::Run(run) => run::run(run, &output, threads),
        Command::Mesh { scene, file } => run::mesh(scene, file, &output, threads),
        Command::Assemble {
            file,
            overrides,
            assembly,
            engine,
        } => run::assemble(file, overrides, assembly, engine, &output, threads),
        Command::Solve {
            file,
            overrides,
            engine,
        } => run::solve(file, overrides, engine, &output, threads),
        Command::Post { file, figures } => run::post(file, figures, &output, threads),
        Command::Status { file } => status::status(file, &output),
        Command::Check { file } => status::check(file, &output),
        Command::FrictionLaw { scene, figures } => {
            friction_law::friction_law(scene, figures, &output)
        }
        Command::Study(study) => study.perform(&output, threads),
        Command::Stability(suite) => stability::stability(suite, &output, threads),
        Command::Report {
            input,
            page,
            interactive,
        } => export::report_page(input, page, *interactive, &output),
        Command::Export { file, target, kind } => export::export(file, target, *kind, &output),
        Command::Schema { folder, check } => generated::schema(folder, *check, &output),
        Command::Init { scene, kind } => init::init(scene, *kind, &output),
        Command::Inspect(mesh) => init::inspect(mesh, &output),
        Command::Completions { shell } => Ok(generated::completions(*shell)),
        Command::Help { topic } => generated::help(topic),
        Command::Man { folder } => generated::man(folder, &output),
        Command::Sweep(arguments) => sweep::sweep(arguments, &output, threads),
    };
    outcome.unwrap_or_else(|error| exit::explain(error, &output))
}
