//! The guard while the satellite points: whether it lets a sound satellite point, and what it does about
//! a device that turns wrong, or a torquer that dies, on the way.

use adcs_app::parameters::{FlightParameters, FlownParameters, ModesParameters};
use adcs_core::modes::{Cause, Mode, ModeParameters, Transition};
use adcs_core::pipeline::SteeringParameters;
use adcs_core::polarity::{LONGEST_CYCLES, PolarityParameters, SignedPermutation, Suspect};
use adcs_core::schedule::Phase;
use anyhow::{Context as _, Result};

use super::super::closed_loop::{ClosedLoop, Conditions, Device, Fault, StartingRate, b_dot};
use super::super::pointing::case::Case;
use super::super::pointing::flight::angle_deg;
use super::super::sprout::ORBIT_S;
use super::DEAD;

/// How long a flight may take until it points, s: some orbits of despin and acquisition.
const LONGEST_UNTIL_POINTING_S: f64 = 8.0 * ORBIT_S;

/// What happens to a satellite that points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// A device turns wrong.
    Turned(Fault),
    /// Torquers die: they obey and do nothing.
    Dead([bool; 3]),
}

/// How well a suspect fits what has happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// Device and what is wrong with it, or that among what looks the same.
    Right,
    /// The device, what is wrong with it being left open or named wrong.
    Device,
    /// Another, or nobody.
    Wrong,
}

impl Trouble {
    fn device(self) -> Device {
        match self {
            Self::Turned(fault) => fault.device,
            Self::Dead(_) => Device::Torquers,
        }
    }

    /// How well `suspect` names it.
    pub fn naming(self, suspect: Suspect) -> Naming {
        use Device::{Gyro, Magnetometer, Torquers};
        let is = |device, wiring| self == Self::Turned(Fault { device, wiring });
        let reversed = is(Magnetometer, SignedPermutation::REVERSED);
        let (right, devices): (bool, &[Device]) = match suspect {
            Suspect::Gyro(wiring) => (is(Gyro, wiring), &[Gyro]),
            Suspect::Magnetometer(wiring) => (is(Magnetometer, wiring), &[Magnetometer]),
            Suspect::Torquers(wiring) => (is(Torquers, wiring), &[Torquers]),
            Suspect::DeadTorquers(dead) => (self == Self::Dead(dead), &[Torquers]),
            Suspect::GyroOrMagnetometer(wiring) => {
                let other = wiring.inverse();
                let either = is(Magnetometer, other) || is(Magnetometer, other.negated());
                (is(Gyro, wiring) || either, &[Gyro, Magnetometer])
            }
            Suspect::ReversedTorquersOrMagnetometer => {
                (reversed || is(Torquers, SignedPermutation::REVERSED), &[Torquers])
            }
            Suspect::TorquersOrReversedMagnetometer if reversed => (false, &[Magnetometer]),
            Suspect::TorquersOrReversedMagnetometer => (false, &[Torquers]),
            _ => (false, &[]),
        };
        match (right, devices.contains(&self.device())) {
            (true, _) => Naming::Right,
            (false, true) => Naming::Device,
            (false, false) => Naming::Wrong,
        }
    }
}

/// One flight from power-on to the end of pointing.
#[derive(Debug, Clone, Copy)]
pub struct Pointed {
    /// What happened one orbit after pointing began.
    pub trouble: Option<Trouble>,
    /// From power-on until it pointed, s; `None` when it never did.
    pub began_s: Option<f64>,
    /// When it was switched off, s since it pointed, since the trouble, or since power-on when it never
    /// did, and why.
    pub ended: Option<(f64, Cause)>,
    /// The first time that pointing was given up since then, s, and what for.
    pub left: Option<(f64, Transition)>,
    /// What the active check said that the ground commanded after the guard had stopped it.
    pub checked: Option<Cause>,
    /// Mean angle to the Orbit frame until then, deg.
    pub mean_deg: f64,
    /// Largest rate until then, rad/s.
    pub fastest_rad_s: f64,
}

/// One axis turned round, or all three, of each device; one torquer dead, or all three.
pub fn troubles() -> Vec<Trouble> {
    let of = |device| {
        let wirings = [1, 2, 4, 7].into_iter().filter_map(SignedPermutation::new);
        wirings.map(move |wiring| Trouble::Turned(Fault { device, wiring }))
    };
    Device::ALL.into_iter().flat_map(of).chain(DEAD.map(Trouble::Dead)).collect()
}

/// What the flight is told: the pointing of a case under the mode machine, which knows of the wiring what
/// the filters know.
fn parameters(case: &Case) -> Result<FlightParameters> {
    let flight = case.parameters()?;
    let told = flight.attitude.context("stage II")?.dynamics;
    let polarity = PolarityParameters::of(&told, flight.torquers.max_dipole_am2);
    let steering = SteeringParameters { cut_hold: true, ..SteeringParameters::default() };
    let modes = ModesParameters {
        table: ModeParameters::default(),
        despin: FlownParameters { law: b_dot(), steering },
        experiment: None,
        polarity: Some(polarity),
        commissioning: None,
    };
    Ok(FlightParameters { modes: Some(modes), ..flight })
}

/// Flies number `seed` of the pointing study's case `everything` from separation at `rate` until it has
/// pointed for `orbits`, or for as long since the trouble that comes after one.
///
/// # Errors
/// When the orbit or the field model ends.
pub fn fly_pointing(
    rate: StartingRate,
    orbits: f64,
    trouble: Option<Trouble>,
    seed: u64,
) -> Result<Pointed> {
    let case = Case::named("everything").context("the case")?;
    let conditions = Conditions { rate, start_in_sunlight: false, ..case.conditions };
    let mut flight = ClosedLoop::new(&conditions, &parameters(&case)?, seed)?;
    let mut pointed = Pointed {
        trouble,
        began_s: None,
        ended: None,
        left: None,
        checked: None,
        mean_deg: 0.0,
        fastest_rad_s: 0.0,
    };
    let (mut counts_from_s, mut angles) = (f64::INFINITY, 0_u32);
    loop {
        let moment = flight.step()?;
        let t_s = moment.truth.t_s;
        let report = moment.thoughts.mode.context("the mode machine flies")?;
        if pointed.began_s.is_none() && report.mode == Mode::Point {
            pointed.began_s = Some(t_s);
            counts_from_s = if trouble.is_some() { t_s + ORBIT_S } else { t_s };
        }
        let since_s = t_s - counts_from_s;
        if (0.0..0.25).contains(&since_s) {
            match trouble {
                Some(Trouble::Turned(fault)) => flight.rewire(Some(fault)),
                Some(Trouble::Dead(dead)) => flight.kill(dead),
                None => {}
            }
        }
        if let Some(transition) = report.transition {
            let counts = since_s >= 0.0 && transition.from == Mode::Point;
            if counts && pointed.left.is_none() {
                pointed.left = Some((since_s, transition));
            }
            if transition.to == Mode::Safe {
                let at_s = if since_s.is_finite() { since_s } else { t_s };
                pointed.ended = Some((at_s, transition.cause));
                if trouble.is_some() && matches!(transition.cause, Cause::Miswired(_)) {
                    pointed.checked = Some(check(&mut flight)?);
                }
                break;
            }
        }
        if since_s >= 0.0 {
            pointed.fastest_rad_s = pointed.fastest_rad_s.max(moment.truth.omega_bi.norm());
            if moment.phase == Phase::Measuring {
                angles += 1;
                let angle = angle_deg(&moment.truth)?;
                pointed.mean_deg += (angle - pointed.mean_deg) / f64::from(angles);
            }
        }
        let never = pointed.began_s.is_none() && t_s > LONGEST_UNTIL_POINTING_S;
        if never || since_s >= orbits * ORBIT_S {
            break;
        }
    }
    Ok(pointed)
}

/// What the active check says when the ground commands it.
fn check(flight: &mut ClosedLoop) -> Result<Cause> {
    flight.command(Mode::Commissioning);
    for _ in 0..=LONGEST_CYCLES {
        let report = flight.step()?.thoughts.mode.context("the mode machine flies")?;
        if let Some(over) = report.transition.filter(|it| it.from == Mode::Commissioning) {
            return Ok(over.cause);
        }
    }
    anyhow::bail!("the active check did not end")
}
