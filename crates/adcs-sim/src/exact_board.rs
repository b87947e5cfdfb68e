//! A board that hands the truth over: for checking everything above it against independent
//! solutions, and for telling what a converter costs.

use core::cell::RefCell;

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::reading::Reading;
use adcs_core::time::Utc;
use adcs_hal::board::{Board, Samples, TorquerFault};

use crate::world::World;

/// Readings and dipoles without converter, noise, errors or steps; only rounded to f32.
#[derive(Debug)]
pub struct ExactBoard<'w> {
    world: &'w RefCell<World>,
}

impl<'w> ExactBoard<'w> {
    /// The board in this world.
    pub fn new(world: &'w RefCell<World>) -> Self {
        Self { world }
    }
}

impl Board for ExactBoard<'_> {
    fn now(&mut self) -> Utc {
        self.world.borrow().now()
    }

    fn sample(&mut self) -> Samples {
        let world = self.world.borrow();
        Samples {
            rate_rad_s: world.exact_rate().to_f32().to_array().map(Reading::Fresh),
            field_t: world.exact_field().to_f32().to_array().map(Reading::Fresh),
            sun_a: world.exact_sun_currents().map_or(Samples::NO_SUN_SENSORS, |currents| {
                currents.map(|face| Reading::Fresh(face.map(|current_a| current_a as f32)))
            }),
        }
    }

    fn drive(&mut self, dipole: Vector<TorquerAxes>) -> Result<Vector<TorquerAxes>, TorquerFault> {
        let mut world = self.world.borrow_mut();
        if !dipole.is_finite() {
            world.set_torquer_dipole(Vector::zero());
            return Err(TorquerFault::NotFinite);
        }
        world.set_torquer_dipole(dipole.to_f64());
        Ok(dipole)
    }
}
