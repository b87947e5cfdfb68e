//! What many guarded flights and checks come to.

use adcs_core::polarity::{CheckReport, SignedPermutation, Suspect};

use super::super::closed_loop::{Device, Fault};
use super::super::despin::{quantile, share};
use super::{Checked, Guarded};

/// Guarded flights with one device wired wrongly in ways that are harmful.
#[derive(Debug, Clone)]
pub struct GuardFigures<'a> {
    harmful: Vec<&'a Guarded>,
    /// How many of the flights were not.
    pub harmless: usize,
}

impl<'a> GuardFigures<'a> {
    /// Of the flights with a fault in this device.
    pub fn of(device: Device, flights: &'a [Guarded]) -> Self {
        let at_fault = |flight: &&Guarded| flight.fault.is_some_and(|it| it.device == device);
        let (harmful, harmless): (Vec<_>, Vec<_>) =
            flights.iter().filter(at_fault).partition(|flight| flight.is_harmful());
        Self { harmful, harmless: harmless.len() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.harmful.len()
    }

    /// Share that was stopped within this time of the loop being closed.
    pub fn stopped_within(&self, t_s: f64) -> f64 {
        share(self.harmful.iter().map(|it| it.stop.is_some_and(|(at_s, _)| at_s <= t_s)))
    }

    /// Largest energy of any flight until control was stopped, over that at closing.
    pub fn largest_controlled(&self) -> f64 {
        self.harmful.iter().map(|it| it.controlled).fold(0.0, f64::max)
    }

    /// Largest energy of any flight to its end: after the stop it is the residual dipole's doing.
    pub fn largest(&self) -> f64 {
        self.harmful.iter().map(|it| it.largest).fold(0.0, f64::max)
    }

    /// Share of flights whose energy stayed below 1.3 times that at closing until the stop.
    pub fn within_bounds(&self) -> f64 {
        share(self.harmful.iter().map(|it| it.controlled <= 1.3))
    }
}

/// Flights and checks of a satellite with dead torquers.
#[derive(Debug, Clone)]
pub struct DeadFigures<'a> {
    flights: &'a [Guarded],
    checks: &'a [Checked],
}

impl<'a> DeadFigures<'a> {
    /// Of flights and checks that all have the same ones dead.
    pub fn of(flights: &'a [Guarded], checks: &'a [Checked]) -> Self {
        Self { flights, checks }
    }

    /// Share of the flights that the guard stopped within this time of the loop being closed.
    pub fn stopped_within(&self, t_s: f64) -> f64 {
        share(self.flights.iter().map(|it| it.stop.is_some_and(|(at_s, _)| at_s <= t_s)))
    }

    /// Share of the stopped ones in which it named what is dead.
    pub fn named_by_guard(&self) -> f64 {
        let suspects = self.flights.iter().filter_map(|it| Some((it.stop?.1, it.dead)));
        share(suspects.map(|(suspect, dead)| suspect == Suspect::DeadTorquers(dead)))
    }

    /// Quantile of the energy at the end of the flight over that at closing when nobody stops it.
    pub fn left_over(&self, share: f64) -> f64 {
        quantile(self.flights.iter().filter_map(|it| it.unguarded).collect(), share)
    }

    /// Share of the checks that named what is dead.
    pub fn named_by_check(&self) -> f64 {
        let right = |it: &Checked| CheckReport::Wrong(Suspect::DeadTorquers(it.dead));
        share(self.checks.iter().map(|it| it.report == right(it)))
    }

    /// Share of the checks that said something else than that or nothing.
    pub fn misnamed_by_check(&self) -> f64 {
        let right = |it: &Checked| CheckReport::Wrong(Suspect::DeadTorquers(it.dead));
        let decided = |it: &Checked| !matches!(it.report, CheckReport::Undecided(_));
        share(self.checks.iter().map(|it| decided(it) && it.report != right(it)))
    }

    /// Quantile of how long a check took, s.
    pub fn lasted_s(&self, share: f64) -> f64 {
        quantile(self.checks.iter().map(|it| it.t_s).collect(), share)
    }
}

/// Active checks of one device, or of a satellite that is wired well.
#[derive(Debug, Clone)]
pub struct CheckFigures<'a> {
    checks: Vec<&'a Checked>,
}

impl<'a> CheckFigures<'a> {
    /// Of the checks with a fault in this device; without one for `None`.
    pub fn of(device: Option<Device>, checks: &'a [Checked]) -> Self {
        Self { checks: checks.iter().filter(|it| it.fault.map(|f| f.device) == device).collect() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.checks.len()
    }

    /// Share that named the device, or found nothing where there is nothing.
    pub fn device_named(&self) -> f64 {
        share(self.checks.iter().map(|it| named(it).is_some()))
    }

    /// Share that named the wiring.
    pub fn wiring_named(&self) -> f64 {
        let wiring = |it: &Checked| it.fault.map_or(SignedPermutation::IDENTITY, |f| f.wiring);
        share(self.checks.iter().map(|it| named(it) == Some(wiring(it))))
    }

    /// Share that could not tell.
    pub fn undecided(&self) -> f64 {
        share(self.checks.iter().map(|it| matches!(it.report, CheckReport::Undecided(_))))
    }

    /// Quantile of how long it took, s.
    pub fn lasted_s(&self, share: f64) -> f64 {
        quantile(self.checks.iter().map(|it| it.t_s).collect(), share)
    }

    /// Largest energy over that at the start.
    pub fn largest(&self) -> f64 {
        self.checks.iter().map(|it| it.largest).fold(0.0, f64::max)
    }
}

/// The wiring that was named, if it was the right device's. That torquers or magnetometer are reversed,
/// without saying which, names neither.
fn named(check: &Checked) -> Option<SignedPermutation> {
    let device = check.fault.map(|Fault { device, .. }| device);
    match (check.report, device) {
        (CheckReport::Sound, None) => Some(SignedPermutation::IDENTITY),
        (CheckReport::Wrong(Suspect::Gyro(wiring)), Some(Device::Gyro))
        | (CheckReport::Wrong(Suspect::Magnetometer(wiring)), Some(Device::Magnetometer))
        | (CheckReport::Wrong(Suspect::Torquers(wiring)), Some(Device::Torquers)) => Some(wiring),
        _ => None,
    }
}
