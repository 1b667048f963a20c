//! The messages of `engines/protocol.md`: requests and answers, little-endian.

use std::io::{self, Read, Write};

use super::{Asked, CscMatrix, Engine, EngineReport};

/// The first bytes of an engine.
const GREETING: &[u8; 8] = b"C3DENG01";

impl Engine {
    /// Request 1 of the protocol.
    pub(super) fn factorise(
        &mut self,
        order: &[usize],
        lower: &CscMatrix,
        transposed: &CscMatrix,
        unit: f64,
    ) -> Result<(EngineReport, Vec<f32>), Asked> {
        let (n, m) = (lower.cols, transposed.cols);
        let counts = [1, n, lower.data.len(), m, transposed.data.len()];
        self.send_integers(&counts.map(|count| count as u64))?;
        self.send_matrix(lower, 1.0)?;
        self.send_indices(order)?;
        self.send_matrix(transposed, unit)?;
        self.answered()?;
        let report = EngineReport {
            coefficients: self.integer()?,
            largest_process: self.integer()?,
            bytes: self.integer()?,
        };
        Ok((report, finite(self.numbers(m * m)?)?))
    }

    /// Request 2.
    pub(super) fn solve(&mut self, rhs: &[f32], n: usize) -> Result<Vec<f32>, Asked> {
        self.send_integers(&[2, (rhs.len() / n.max(1)) as u64])?;
        for part in rhs.chunks(1 << 16) {
            let bytes: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
            self.send(&bytes)?;
        }
        self.answered()?;
        let answer = self.numbers(rhs.len())?;
        // A right-hand side that is no number has no other answer.
        if rhs.iter().all(|value| value.is_finite()) {
            finite(answer)
        } else {
            Ok(answer)
        }
    }

    /// Request 3.
    pub(super) fn compliance(
        &mut self,
        selection: &CscMatrix,
        unit: f64,
        length: usize,
    ) -> Result<Vec<f32>, Asked> {
        let (c, entries) = (selection.cols as u64, selection.data.len() as u64);
        self.send_integers(&[3, c, entries])?;
        self.send_matrix(selection, unit)?;
        self.answered()?;
        finite(self.numbers(length)?)
    }

    /// Sends what is left of a request and reads how the answer begins.
    fn answered(&mut self) -> Result<(), Asked> {
        if let Some(requests) = &mut self.requests {
            requests.flush()?;
        }
        match self.integer()? {
            0 => Ok(()),
            1 => {
                self.integer()?;
                Err(Asked::Indefinite)
            }
            2 | 3 => Err(Asked::Refused(self.text()?)),
            other => {
                let expected = "expected 0, 1, 2 or 3 of engines/protocol.md";
                Err(Asked::Refused(format!(
                    "its answer begins with {other}, {expected}"
                )))
            }
        }
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match &mut self.requests {
            Some(requests) => requests.write_all(bytes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn send_integers(&mut self, values: &[u64]) -> io::Result<()> {
        values
            .iter()
            .try_for_each(|value| self.send(&value.to_le_bytes()))
    }

    fn send_indices(&mut self, values: &[usize]) -> io::Result<()> {
        values.iter().try_for_each(|value| {
            let value = u32::try_from(*value).map_err(io::Error::other)?;
            self.send(&value.to_le_bytes())
        })
    }

    /// The offsets, indices and values of the columns of a matrix, in units of a number.
    fn send_matrix(&mut self, matrix: &CscMatrix, unit: f64) -> io::Result<()> {
        let offsets = matrix.indptr.iter();
        offsets
            .copied()
            .try_for_each(|offset| self.send(&(offset as u64).to_le_bytes()))?;
        self.send_indices(&matrix.indices)?;
        let mut values = matrix.data.iter();
        values.try_for_each(|value| self.send(&(value / unit).to_le_bytes()))
    }

    fn integer(&mut self) -> io::Result<u64> {
        read_integer(&mut self.answers)
    }

    fn text(&mut self) -> io::Result<String> {
        read_text(&mut self.answers)
    }

    fn numbers(&mut self, count: usize) -> io::Result<Vec<f32>> {
        let mut numbers = vec![0.0; count];
        let mut bytes = vec![0; 4 << 16];
        for part in numbers.chunks_mut(1 << 16) {
            let bytes = &mut bytes[..4 * part.len()];
            self.answers.read_exact(bytes)?;
            for (number, bytes) in part.iter_mut().zip(bytes.chunks_exact(4)) {
                *number = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
        }
        Ok(numbers)
    }
}

/// The name of an engine that greets.
pub(super) fn greeting(answers: &mut impl Read) -> io::Result<String> {
    let mut greeting = [0; 8];
    answers.read_exact(&mut greeting)?;
    if greeting != *GREETING {
        return Err(io::ErrorKind::InvalidData.into());
    }
    read_text(answers)
}

fn read_integer(answers: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    answers.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn read_text(answers: &mut impl Read) -> io::Result<String> {
    let length = read_integer(answers)?;
    // No engine has so much to say.
    if length > 1 << 16 {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut bytes = vec![0; length as usize];
    answers.read_exact(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn finite(numbers: Vec<f32>) -> Result<Vec<f32>, Asked> {
    if numbers.iter().all(|value| value.is_finite()) {
        Ok(numbers)
    } else {
        Err(Asked::Refused(
            "its answer holds numbers that are not finite".into(),
        ))
    }
}
