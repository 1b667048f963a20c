//! A factor that lives in the processes of another program, perhaps on several machines.
//!
//! The program is started once for each matrix and spoken to through its standard input and output, in the little-endian messages of
//! `engines/protocol.md`. It gets D A D with powers of two D that make the diagonal nearly one, an order of elimination and B D, and
//! answers in single precision: solves are preconditioners, as those of a factor in single precision are.

mod protocol;

use std::{
    fmt,
    io::{self, BufReader, BufWriter},
    process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{self, RecvTimeoutError},
    },
    thread,
    time::Duration,
};

use thiserror::Error;

use super::{sparse::CscMatrix, structure::FactorStructure, vector::power_of_two_near_largest};
use protocol::greeting;

/// Right-hand sides that are sent together.
const SENT_COLUMNS: usize = 64;

/// What an engine may take to start on many machines, and beside the operations of any answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// Operations in a second that no machine stays below which has the memory: a single core makes ten times as many without vectors.
const LEAST_RATE: f64 = 1e8;

/// What goes wrong between this program and an engine.
#[derive(Debug, Clone, Error, PartialEq, Eq)]
pub enum EngineError {
    /// It was not started.
    #[error("the engine `{command}` was not started: {reason}")]
    NotStarted {
        /// Its command line.
        command: String,
        /// What the system says.
        reason: String,
    },
    /// It does not speak the protocol.
    #[error(
        "`{command}` is no engine: expected the greeting C3DENG01 and a name within a minute; see engines/protocol.md"
    )]
    NoEngine {
        /// Its command line.
        command: String,
    },
    /// It does not answer.
    #[error(
        "the engine {name} did not answer within {limit:.0?}, and no machine takes so long for what it was asked: look at what it waits for"
    )]
    Late {
        /// Its name.
        name: String,
        /// How long an answer may take.
        limit: Duration,
    },
    /// It ended, or its answers did.
    #[error("the engine {name} ended in the middle of its work: {reason}")]
    Ended {
        /// Its name.
        name: String,
        /// What the system says.
        reason: String,
    },
    /// It found a pivot that is not positive.
    #[error(
        "the engine {name} finds the stiffness matrix not positive definite in single precision; run without --engine to learn where"
    )]
    Indefinite {
        /// Its name.
        name: String,
    },
    /// It refuses, for want of memory or for another reason.
    #[error("the engine {name} refuses: {reason}")]
    Refused {
        /// Its name.
        name: String,
        /// What it says.
        reason: String,
    },
    /// Its answers are of no use.
    #[error(
        "the factor of the engine {name} leaves more than a tenth of an error at each step: expected single precision; with block low-rank fronts ask it for smaller errors"
    )]
    TooInexact {
        /// Its name.
        name: String,
    },
    /// The factor is not in the file.
    #[error(
        "the factor stayed in the processes of an engine: run the stage assemble without --engine"
    )]
    NotAtHand,
}

/// What an engine says of a factor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EngineReport {
    /// Coefficients in all processes.
    pub coefficients: u64,
    /// Bytes of memory of the process that has most.
    pub largest_process: u64,
    /// Bytes of memory of all.
    pub bytes: u64,
}

/// The Cholesky factor of a matrix in the processes of an engine, which end with the last clone.
#[derive(Clone)]
pub struct RemoteFactor {
    structure: FactorStructure,
    /// D.
    scale: Vec<f64>,
    /// Bᵀ of S, with the unit of B D.
    transposed: CscMatrix,
    unit: f64,
    /// S of B D in its unit, `[rows, rows]`.
    operator: Arc<Vec<f32>>,
    report: EngineReport,
    engine: Arc<Mutex<Engine>>,
}

/// An engine at work.
struct Engine {
    name: String,
    child: Child,
    /// Ends all processes of the engine once this program is gone or closes its input.
    watcher: Child,
    requests: Option<BufWriter<ChildStdin>>,
    answers: BufReader<ChildStdout>,
    /// What an answer may take beside its operations.
    patience: Duration,
    /// What ended it.
    failure: Option<EngineError>,
}

impl RemoteFactor {
    /// Starts an engine by its command line, such as `mpirun -n 4 contact3d-mumps`, and has it factorise A, with S = B A⁻¹Bᵀ for a Bᵀ that may have no columns.
    ///
    /// # Errors
    /// [`EngineError`].
    pub fn new(
        command: &str,
        structure: FactorStructure,
        a: &CscMatrix,
        transposed: CscMatrix,
    ) -> Result<Self, EngineError> {
        let mut engine = Engine::start(command)?;
        let scale: Vec<f64> = (0..a.cols)
            .map(|i| (-0.5 * a.diagonal(i).log2()).round().exp2())
            .collect();
        let rows = scaled_columns(&transposed, &scale);
        let unit = power_of_two_near_largest(&rows.data).unwrap_or(1.0);
        let lower = lower_triangle(a, &scale);
        let operations = structure.operations() + solves(&structure, rows.cols);
        let asked = engine.within(operations, |engine| {
            engine.factorise(&structure.permutation, &lower, &rows, unit)
        });
        let (report, operator) = asked.map_err(|error| engine.fail(error))?;
        Ok(Self {
            structure,
            scale,
            transposed,
            unit,
            operator: Arc::new(operator),
            report,
            engine: Arc::new(Mutex::new(engine)),
        })
    }

    /// Where the coefficients of a factor on this machine would stand.
    #[must_use]
    pub fn structure(&self) -> &FactorStructure {
        &self.structure
    }

    /// What the engine said of the factor.
    #[must_use]
    pub fn report(&self) -> EngineReport {
        self.report
    }

    /// The name of the engine.
    #[must_use]
    pub fn name(&self) -> String {
        self.engine().name.clone()
    }

    /// What ended the engine; answers after it are no numbers.
    #[must_use]
    pub fn failure(&self) -> Option<EngineError> {
        self.engine().failure.clone()
    }

    /// Solves A x = b in place for several right-hand sides, to single precision.
    pub(super) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        for block in rhs.chunks_mut(SENT_COLUMNS) {
            self.solve_block(block);
        }
    }

    /// S, and H = C A⁻¹Bᵀ where a selection Cᵀ is given, for some Bᵀ: the one that it was started with, or another by solves.
    pub(crate) fn formed(
        &self,
        transposed: &CscMatrix,
        selection: Option<&CscMatrix>,
    ) -> (Vec<f64>, Option<Vec<f64>>) {
        if *transposed == self.transposed {
            let unit = self.unit * self.unit;
            let operator = self.operator.iter().map(|s| f64::from(*s) * unit);
            return (operator.collect(), selection.map(|by| self.compliance(by)));
        }
        let (n, m) = (self.scale.len(), transposed.cols);
        let (mut operator, mut matrix) = (Vec::new(), Vec::new());
        for first in (0..m).step_by(SENT_COLUMNS) {
            let last = (first + SENT_COLUMNS).min(m);
            let mut moved = vec![vec![0.0; n]; last - first];
            for (moved, j) in moved.iter_mut().zip(first..last) {
                transposed
                    .entries(j)
                    .for_each(|(i, value)| moved[i] = value);
            }
            let mut block: Vec<&mut [f64]> = moved.iter_mut().map(Vec::as_mut_slice).collect();
            self.solve_block(&mut block);
            for moved in &moved {
                let along = |by: &CscMatrix| -> Vec<f64> {
                    let entries = |j| by.entries(j).map(|(i, value)| value * moved[i]);
                    (0..by.cols).map(|j| entries(j).sum()).collect()
                };
                operator.extend(along(transposed));
                selection.iter().for_each(|by| matrix.extend(along(by)));
            }
        }
        symmetrise(&mut operator, m);
        (operator, selection.map(|_| matrix))
    }

    /// C A⁻¹Bᵀ for the columns Cᵀ of a selection and the B that the engine has.
    fn compliance(&self, selection: &CscMatrix) -> Vec<f64> {
        let scaled = scaled_columns(selection, &self.scale);
        let unit = power_of_two_near_largest(&scaled.data).unwrap_or(1.0);
        let (m, c) = (self.transposed.cols, selection.cols);
        let asked = |engine: &mut Engine| engine.compliance(&scaled, unit, m * c);
        let answer = self.ask(m + c, asked, m * c);
        let unit = unit * self.unit;
        answer.into_iter().map(|g| f64::from(g) * unit).collect()
    }

    fn solve_block(&self, block: &mut [&mut [f64]]) {
        let n = self.scale.len();
        let mut sent = Vec::with_capacity(n * block.len());
        let mut units = Vec::new();
        for rhs in block.iter() {
            let scaled: Vec<f64> = rhs.iter().zip(&self.scale).map(|(b, d)| b * d).collect();
            let unit = power_of_two_near_largest(&scaled).unwrap_or(1.0);
            sent.extend(scaled.iter().map(|b| (b / unit) as f32));
            units.push(unit);
        }
        let asked = |engine: &mut Engine| engine.solve(&sent, n);
        let answer = self.ask(block.len(), asked, sent.len());
        for ((rhs, answer), unit) in block.iter_mut().zip(answer.chunks_exact(n)).zip(units) {
            for ((x, y), d) in rhs.iter_mut().zip(answer).zip(&self.scale) {
                *x = f64::from(*y) * d * unit;
            }
        }
    }

    /// An answer of so many numbers that takes some solves; after a failure, none of them is one.
    fn ask(
        &self,
        columns: usize,
        request: impl FnOnce(&mut Engine) -> Result<Vec<f32>, Asked>,
        length: usize,
    ) -> Vec<f32> {
        let mut engine = self.engine();
        if engine.failure.is_none() {
            match engine.within(solves(&self.structure, columns), request) {
                Ok(answer) => return answer,
                Err(error) => {
                    engine.fail(error);
                }
            }
        }
        vec![f32::NAN; length]
    }

    fn engine(&self) -> MutexGuard<'_, Engine> {
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PartialEq for RemoteFactor {
    /// Whether both are the factor of one engine.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.engine, &other.engine)
    }
}

impl fmt::Debug for RemoteFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.name();
        f.debug_struct("RemoteFactor")
            .field("name", &name)
            .finish_non_exhaustive()
    }
}

/// Why an answer did not come.
#[derive(Debug)]
enum Asked {
    Io(io::Error),
    Late(Duration),
    Indefinite,
    Refused(String),
}

impl From<io::Error> for Asked {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Engine {
    fn start(command: &str) -> Result<Self, EngineError> {
        let text = command.to_owned();
        let not_started = |reason: String| EngineError::NotStarted {
            command: text.clone(),
            reason,
        };
        if text.trim().is_empty() {
            return Err(not_started("the command is empty".into()));
        }
        let started =
            |command: &str| shell(command).map_err(|error| not_started(error.to_string()));
        let mut child = started(&format!("exec {text}"))?;
        let group = child.id();
        let end = format!("read -r _; kill -TERM -{group}; sleep 5; kill -KILL -{group}");
        let mut engine = Self {
            name: text.clone(),
            watcher: started(&format!("exec 2>/dev/null; {end}"))?,
            requests: child.stdin.take().map(BufWriter::new),
            answers: BufReader::new(child.stdout.take().expect("asked for a pipe")),
            patience: PATIENCE,
            child,
            failure: None,
        };
        // A program that waits for input never greets.
        let greeted = engine.within(0.0, |engine| Ok(greeting(&mut engine.answers)?));
        engine.name = greeted.map_err(|asked| {
            engine.fail(asked);
            EngineError::NoEngine { command: text }
        })?;
        Ok(engine)
    }

    /// Performs a request of some operations, and ends an engine that takes longer than any machine would.
    fn within<R>(
        &mut self,
        operations: f64,
        request: impl FnOnce(&mut Self) -> Result<R, Asked>,
    ) -> Result<R, Asked> {
        let limit = self.patience + Duration::from_secs_f64(operations / LEAST_RATE);
        let end = self.watcher.stdin.take();
        let (answered, waiting) = mpsc::channel::<()>();
        let waiter = thread::spawn(move || {
            let is_late = waiting.recv_timeout(limit) == Err(RecvTimeoutError::Timeout);
            (end.filter(|_| !is_late), is_late)
        });
        let answer = request(self);
        drop(answered);
        let (end, is_late) = waiter.join().unwrap_or_default();
        self.watcher.stdin = end;
        let late = is_late.then_some(Err(Asked::Late(limit)));
        late.unwrap_or(answer)
    }

    /// Remembers why an answer did not come.
    fn fail(&mut self, asked: Asked) -> EngineError {
        let name = self.name.clone();
        let failure = match asked {
            Asked::Indefinite => EngineError::Indefinite { name },
            Asked::Refused(reason) => EngineError::Refused { name, reason },
            Asked::Late(limit) => EngineError::Late { name, limit },
            Asked::Io(error) => EngineError::Ended {
                name,
                reason: match self.ended_within(Duration::from_secs(1)) {
                    Some(status) => status.to_string(),
                    None => error.to_string(),
                },
            },
        };
        self.failure = Some(failure.clone());
        failure
    }

    /// How it ended, if it does so within some time.
    fn ended_within(&mut self, time: Duration) -> Option<ExitStatus> {
        let pause = Duration::from_millis(2);
        let mut looks = (0..=time.as_millis() / pause.as_millis()).map(|_| {
            thread::sleep(pause);
            self.child.try_wait().ok().flatten()
        });
        looks.find_map(|ended| ended)
    }
}

/// Operations of some solves, forward and back.
fn solves(structure: &FactorStructure, columns: usize) -> f64 {
    4.0 * structure.value_count() as f64 * columns as f64
}

impl Drop for Engine {
    /// Closes its input, at which an engine ends; one that failed or does not end within ten seconds is killed.
    fn drop(&mut self) {
        self.requests = None;
        if self.failure.is_none() && self.ended_within(Duration::from_secs(10)).is_some() {
            let _ = self.watcher.kill();
            let _ = self.watcher.wait();
        } else {
            self.watcher.stdin = None;
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Starts a command of the shell with pipes, in a process group of its own where there are such.
fn shell(command: &str) -> io::Result<Child> {
    let mut shell = Command::new("sh");
    shell.args(["-c", command]);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut shell, 0);
    shell.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()
}

/// The lower triangle of D A D by columns.
fn lower_triangle(a: &CscMatrix, scale: &[f64]) -> CscMatrix {
    let columns = (0..a.cols).map(|j| {
        let below = a.entries(j).filter(move |(i, _)| *i >= j);
        below.map(move |(i, value)| (i, scale[i] * value * scale[j]))
    });
    CscMatrix::of_columns(a.rows, columns)
}

/// D times a matrix.
fn scaled_columns(columns: &CscMatrix, scale: &[f64]) -> CscMatrix {
    let mut scaled = columns.clone();
    for (value, i) in scaled.data.iter_mut().zip(&columns.indices) {
        *value *= scale[*i];
    }
    scaled
}

/// The mean of a square matrix and its transpose.
fn symmetrise(matrix: &mut [f64], n: usize) {
    for j in 0..n {
        for i in 0..j {
            let mean = f64::midpoint(matrix[j * n + i], matrix[i * n + j]);
            (matrix[j * n + i], matrix[i * n + j]) = (mean, mean);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_engine_that_does_not_answer_is_ended() {
        let command = r#"sh -c "printf 'C3DENG01\1\0\0\0\0\0\0\0x'; exec sleep 600""#;
        let mut engine = Engine::start(command).expect("a greeting");
        engine.patience = Duration::from_millis(100);
        let asked = engine.within(0.0, |engine| engine.solve(&[1.0], 1));
        let failure = engine.fail(asked.expect_err("no answer"));
        assert!(matches!(failure, EngineError::Late { .. }), "{failure}");
        assert!(engine.ended_within(Duration::from_secs(60)).is_some());
    }
}
