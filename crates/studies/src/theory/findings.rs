//! What the measured theory means, in sentences.

use std::fmt;

use super::{Theory, TheoryLevel};

/// A rate and an eigenvalue that differ by less than this agree.
const AGREE: f64 = 0.02;

/// Rates outside of this range are too fast or too slow to observe.
const OBSERVABLE: [f64; 2] = [0.02, 0.98];

/// What the measured theory means for its finest mesh, and how far bound and truth are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// n_div of the mesh; 0 for a mesh file.
    pub n_div: usize,
    /// Scale of the law up to which HKL's bound is below 1, in the energy norm with the best weight.
    pub proved: f64,
    /// The same with composed constants, which is a proof of uniqueness.
    pub proved_sharply: f64,
    /// Whether HKL's bound uses c_tr⁽⁴⁾, which is known from below only: then it is no proof.
    pub is_lower: bool,
    /// Whether constants of the law are estimates: then nothing is a proof.
    pub is_estimated: bool,
    /// Scale up to which successive approximations contract near the solutions followed from the smallest scale; `None` where they do near
    /// every one found up to 1e6.
    pub contracts: Option<f64>,
    /// The spectral radius near the solution that was followed to the law itself.
    pub followed: Option<f64>,
    /// Exponents p of H^p of the scale proved and of the one observed between the two finest meshes.
    pub exponents: [Option<f64>; 2],
    /// The spectral radius and the rate observed.
    pub rates: Option<[f64; 2]>,
    /// Whether a value of Ψ left the set of HKL Lemma 3.3, which would be an error of this program.
    pub lemma_fails: bool,
}

impl Findings {
    pub(super) fn new(theory: &Theory) -> Self {
        let finest = theory.levels.last();
        let before = theory.levels.iter().rev().nth(1);
        let exponent = |of: &dyn Fn(&TheoryLevel) -> Option<f64>| {
            let (fine, coarse) = (finest?, before?);
            let sizes = (fine.face.pane_size / coarse.face.pane_size).ln();
            let power = (of(fine)? / of(coarse)?).ln() / sizes;
            Some(power).filter(|power| power.is_finite())
        };
        let proved = |level: &TheoryLevel| level.thresholds.weighted[1];
        let contracts = |level: &TheoryLevel| level.thresholds.spectral_radius;
        let levels = theory.levels.iter();
        let lemma = levels.flat_map(|l| l.observed.lemma.iter().flatten());
        Self {
            n_div: finest.map_or(0, |level| level.n_div),
            proved: finest.map_or(f64::NAN, proved),
            proved_sharply: finest.map_or(f64::NAN, |level| level.thresholds.sharp[1]),
            is_lower: theory.law.lipschitz > 0.0,
            is_estimated: theory.law.estimated,
            contracts: finest.and_then(contracts),
            followed: finest.and_then(|level| {
                let mut points = level.scaled.iter();
                let itself = points.find(|point| point.solved && point.scale == 1.0);
                itself.map(|point| point.spectral_radius)
            }),
            exponents: [exponent(&|level| Some(proved(level))), exponent(&contracts)],
            rates: finest.and_then(|level| {
                Some([level.local.as_ref()?.spectral_radius, level.observed.rate])
            }),
            lemma_fails: lemma.copied().any(|share| share.is_nan() || share > 1.0),
        }
    }

    /// The spectral radius at the solution followed to the law itself, where it tells that from the solution found without following.
    #[must_use]
    pub fn other_followed(&self) -> Option<f64> {
        let ([radius, _], followed) = (self.rates?, self.followed?);
        let apart = (radius - followed).abs() > AGREE * radius.max(followed).max(AGREE);
        apart.then_some(followed)
    }

    /// Whether the rate that was observed is the spectral radius to 2 %; `None` where it is too fast or too slow to be
    /// observed.
    #[must_use]
    pub fn rates_agree(&self) -> Option<bool> {
        let [radius, rate] = self.rates?;
        let observable = OBSERVABLE[0] < radius && radius < OBSERVABLE[1];
        observable.then(|| (rate / radius - 1.0).abs() <= AGREE)
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mesh = match self.n_div {
            0 => "On the finest mesh".to_owned(),
            n => format!("At n_div = {n}"),
        };
        write!(
            f,
            "{mesh} uniqueness {} for this law scaled by less than {:.2e}, by the bound with composed constants; that of HKL (3.13) gives {:.2e}{}; near the solutions followed from the smallest scale successive approximations contract ",
            if self.is_estimated {
                "would follow, were the estimated constants of the law bounds,"
            } else {
                "is proven"
            },
            self.proved_sharply,
            self.proved,
            if self.is_lower {
                ", with c_tr(4) from an ascent, so no proof"
            } else {
                ""
            }
        )?;
        match self.contracts {
            Some(scale) => write!(
                f,
                "up to {scale:.3}, {:.1e} times as far",
                scale / self.proved_sharply
            )?,
            None => f.write_str("at every scale solved, up to 1e6")?,
        }
        if let [Some(proved), observed] = self.exponents {
            write!(
                f,
                ". Between the two finest meshes the scale of (3.13) goes like H^{proved:.2}"
            )?;
            if let Some(observed) = observed {
                write!(f, ", the true one like H^{observed:.2}")?;
            }
        }
        if let Some([radius, rate]) = self.rates {
            write!(
                f,
                ". At the solution of the law itself the spectral radius is {radius:.4}, "
            )?;
            if rate.is_nan() {
                f.write_str("and no rate is observed")?
            } else {
                write!(f, "the observed rate {rate:.4}")?
            }
            if let Some(followed) = self.other_followed() {
                write!(
                    f,
                    "; another solution, the one followed to it, has {followed:.4}"
                )?;
            }
        }
        f.write_str(".")
    }
}
