//! The field between two readings, turned on by the gyros.

use nalgebra::{RealField, Rotation3, Vector3};

use super::{Recorded, number};

/// A field that was turned on for longer is too old, s: it turns by 0.1 deg/s along the orbit.
const MAX_AGE_S: f64 = 60.0;

/// The last reading, turned on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FieldTrack<T: RealField + Copy> {
    field: Option<Vector3<T>>,
    age_s: T,
    last_rate: Option<Vector3<T>>,
}

/// What there is at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tracked<T: RealField + Copy> {
    pub rate: Vector3<T>,
    pub field: Option<Vector3<T>>,
}

impl<T: RealField + Copy> Default for FieldTrack<T> {
    fn default() -> Self {
        Self { field: None, age_s: T::zero(), last_rate: None }
    }
}

impl<T: RealField + Copy> FieldTrack<T> {
    /// Forgets, and says nothing, when the instant is not finite.
    pub fn advance(&mut self, recorded: &Recorded<T>) -> Option<Tracked<T>> {
        if !recorded.is_finite() {
            *self = Self::default();
            return None;
        }
        let rate = Vector3::from(recorded.rate_rad_s);
        let mean_rate = self.last_rate.map_or(rate, |last| (last + rate) * number::<T>(0.5));
        self.last_rate = Some(rate);
        self.age_s += recorded.dt_s;
        let fresh_enough = self.age_s <= number(MAX_AGE_S);
        if let Some(reading) = recorded.field_t {
            self.field = Some(Vector3::from(reading));
            self.age_s = T::zero();
        } else {
            let turn = Rotation3::new(-mean_rate * recorded.dt_s);
            self.field = self.field.filter(|_| fresh_enough).map(|field| turn * field);
        }
        Some(Tracked { rate, field: self.field })
    }
}
