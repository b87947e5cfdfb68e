//! What the ladder found, how well it is known, and whether that is good enough.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::polarity::{Suspect, Undecided};
use crate::sensing::TriadParameters;

/// A rung of the ladder, in the order in which they are climbed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rung {
    /// Scale, bias and cross-axis terms of the magnetometer.
    Magnetometer,
    /// How gyro, magnetometer and torquers are wired.
    Polarity,
    /// The torquers' field at the magnetometer.
    Coupling,
    /// Alignment of the Sun sensors to the magnetometer.
    Sun,
    /// Gyro bias.
    Gyro,
    /// Residual dipole.
    Dipole,
    /// Inertia ratios.
    Inertia,
}

impl Rung {
    /// All of them, in order.
    pub const ALL: [Self; RUNGS] = [
        Self::Magnetometer,
        Self::Polarity,
        Self::Coupling,
        Self::Sun,
        Self::Gyro,
        Self::Dipole,
        Self::Inertia,
    ];

    /// Its place, from 0.
    pub fn number(self) -> usize {
        self as usize
    }
}

/// How many rungs there are.
pub const RUNGS: usize = 7;

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Magnetometer => "magnetometer",
            Self::Polarity => "polarity",
            Self::Coupling => "torquer coupling",
            Self::Gyro => "gyro bias",
            Self::Sun => "Sun sensors",
            Self::Dipole => "residual dipole",
            Self::Inertia => "inertia ratios",
        })
    }
}

/// How a rung ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// The result is as good as its gate asks for.
    Passed,
    /// It is not, in the time that there was.
    Failed(Shortfall),
}

impl Outcome {
    /// Whether the result may fly.
    pub fn passed(self) -> bool {
        self == Self::Passed
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Passed => write!(f, "passed"),
            Self::Failed(why) => write!(f, "failed: {why}"),
        }
    }
}

/// Why a rung failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Shortfall {
    /// There is a result, but its σ is larger than the gate.
    Uncertain,
    /// The readings do not tell the unknowns apart, or are too few: the satellite hardly turned, the
    /// Sun was not seen, a model was missing.
    NotSupported,
    /// What it rests upon has failed.
    RestsOnFailed,
    /// The active check could not tell.
    Undecided(Undecided),
    /// A device is wired wrongly, or torquers are dead.
    Miswired(Suspect),
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uncertain => write!(f, "known too badly in the time there was"),
            Self::NotSupported => write!(f, "the readings do not tell"),
            Self::RestsOnFailed => write!(f, "what it rests upon has failed"),
            Self::Undecided(why) => write!(f, "undecided: {why}"),
            Self::Miswired(suspect) => write!(f, "{suspect}"),
        }
    }
}

/// Three numbers and their standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Three {
    /// The numbers.
    pub value: [f32; 3],
    /// Their σ.
    pub sigma: [f32; 3],
}

impl Three {
    /// σ of the number that is known worst.
    pub fn worst_sigma(&self) -> f32 {
        worst(&self.sigma)
    }
}

/// The magnetometer's correction, as [`crate::sensing::TriadParameters`] means it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MagnetometerFound {
    /// s, no unit.
    pub scale: Three,
    /// c_xy, c_xz, c_yz, no unit: zero where the readings do not ask for them.
    pub cross_axis: Three,
    /// b, T, to be subtracted.
    pub bias_t: Three,
    /// Root mean square of what is left of |B| − |B_IGRF|, T.
    pub norm_error_t: f32,
}

impl MagnetometerFound {
    /// The correction with this in it; the alignment stays.
    pub fn correction(&self, told: &TriadParameters) -> TriadParameters {
        TriadParameters {
            scale: self.scale.value,
            cross_axis: self.cross_axis.value,
            bias: self.bias_t.value,
            ..*told
        }
    }
}

/// What the torquers do to the magnetometer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CouplingFound {
    /// Row by row: T along Body x, y, z for 1 A·m² along Body x, y, z.
    pub t_per_am2: [[f32; 3]; 3],
    /// σ of each.
    pub sigma_t_per_am2: [[f32; 3]; 3],
}

/// The inertia tensor, its trace being as told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InertiaFound {
    /// Row by row, Body, kg·m².
    pub tensor_kg_m2: [[f32; 3]; 3],
    /// σ of each entry, kg·m².
    pub sigma_kg_m2: [[f32; 3]; 3],
}

/// What a rung found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Finding {
    /// The magnetometer.
    Magnetometer(MagnetometerFound),
    /// The torquers' field at the magnetometer.
    Coupling(CouplingFound),
    /// Gyro bias, Body, rad/s: to be subtracted from what the gyros show now.
    Gyro(Three),
    /// Small turn that brings what the Sun sensors show to where it belongs, Body, rad.
    Sun(Three),
    /// Residual dipole, Body, A·m².
    Dipole(Three),
    /// Inertia ratios.
    Inertia(InertiaFound),
}

/// A rung that is over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ended {
    /// Which.
    pub rung: Rung,
    /// How.
    pub outcome: Outcome,
    /// What was found, good enough or not.
    pub finding: Option<Finding>,
}

/// What has been found so far: all that has to be kept over a reset. `Default` is nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// How each rung ended; `None` while it has not.
    pub outcomes: [Option<Outcome>; RUNGS],
    /// The magnetometer.
    pub magnetometer: Option<MagnetometerFound>,
    /// The torquers' field at it.
    pub coupling: Option<CouplingFound>,
    /// Gyro bias, Body, rad/s.
    pub gyro: Option<Three>,
    /// Turn of the Sun sensors, Body, rad.
    pub sun: Option<Three>,
    /// Residual dipole, Body, A·m².
    pub dipole: Option<Three>,
    /// Inertia ratios.
    pub inertia: Option<InertiaFound>,
    /// Whether they have been put in force.
    pub committed: bool,
}

impl Findings {
    /// How a rung ended.
    pub fn outcome(&self, rung: Rung) -> Option<Outcome> {
        self.outcomes.get(rung.number()).copied().flatten()
    }

    /// Whether a rung's result may fly.
    pub fn passed(&self, rung: Rung) -> bool {
        self.outcome(rung).is_some_and(Outcome::passed)
    }

    /// The first rung that has not ended.
    pub fn next(&self) -> Option<Rung> {
        Rung::ALL.into_iter().find(|rung| self.outcome(*rung).is_none())
    }

    /// Before another climb: keeps what passed, and forgets the rest; when all has passed, all of it.
    pub fn retry(&mut self) {
        let has_all = Rung::ALL.into_iter().all(|rung| self.passed(rung));
        if has_all {
            *self = Self::default();
        }
        for outcome in &mut self.outcomes {
            *outcome = outcome.filter(|outcome| outcome.passed());
        }
        // A climb begins with what was uplinked.
        self.committed = false;
    }

    /// Takes in a rung that has ended.
    pub fn take(&mut self, ended: &Ended) {
        if let Some(outcome) = self.outcomes.get_mut(ended.rung.number()) {
            *outcome = Some(ended.outcome);
        }
        match ended.finding {
            None => {}
            Some(Finding::Magnetometer(found)) => self.magnetometer = Some(found),
            Some(Finding::Coupling(found)) => self.coupling = Some(found),
            Some(Finding::Gyro(found)) => self.gyro = Some(found),
            Some(Finding::Sun(found)) => self.sun = Some(found),
            Some(Finding::Dipole(found)) => self.dipole = Some(found),
            Some(Finding::Inertia(found)) => self.inertia = Some(found),
        }
    }
}

/// The largest σ; a NaN is larger than any.
pub fn worst(sigma: &[f32]) -> f32 {
    sigma.iter().fold(0.0, |worst, &sigma| if sigma <= worst { worst } else { sigma })
}
