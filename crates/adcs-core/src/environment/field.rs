//! The geomagnetic field as a reference vector: IGRF in this crate's frames, units and time.

use igrf::{Coefficients, DecimalYear};
use nalgebra::RealField;

use super::earth::ecef_from_eci;
use crate::frames::{Ecef, Eci, Rotation, Vector};
use crate::time::{MICROS_PER_SECOND, Utc};

/// Metres in a kilometre: igrf speaks km.
const M_PER_KM: f64 = 1e3;
/// Tesla in a nanotesla: igrf speaks nT.
const T_PER_NT: f64 = 1e-9;
/// How long one set of coefficients serves, µs. The field changes by less than 200 nT a year, so by
/// 0.012 nT within the half hour to either side of the instant it was made for.
const VALIDITY_US: i64 = 3_600_000_000;

/// The field model, in the precision `T`, with the coefficients of the hour.
#[derive(Debug, Clone)]
pub struct FieldModel<T: igrf::Real> {
    coefficients: Coefficients<T>,
    hour: i64,
}

impl<T: igrf::Real + RealField + Copy> FieldModel<T> {
    /// Prepares the model for the hour of `now`.
    ///
    /// # Errors
    /// A date outside the model's range.
    pub fn new(now: Utc) -> Result<Self, igrf::Error> {
        let hour = now.micros_since_2000().div_euclid(VALIDITY_US);
        Ok(Self { coefficients: Coefficients::at(middle_of(hour)?)?, hour })
    }

    /// The field at `now` and `position` (Eci, m), Eci, T. In a new hour the coefficients are
    /// prepared anew, always for the same instants, so that the result does not depend on when the
    /// model was asked before.
    ///
    /// # Errors
    /// A date outside the model's range, a position that is not finite or too deep in the Earth.
    pub fn eci_t(
        &mut self,
        now: Utc,
        position: Vector<Eci, f64>,
    ) -> Result<Vector<Eci, T>, igrf::Error> {
        let hour = now.micros_since_2000().div_euclid(VALIDITY_US);
        if hour != self.hour {
            *self = Self::new(now)?;
        }
        let r_ei: Rotation<Ecef, Eci, f64> = ecef_from_eci(now);
        let position_km = (r_ei * position) * (1.0 / M_PER_KM);
        let [x, y, z] = position_km.to_array().map(nalgebra::convert::<f64, T>);
        let [b_x, b_y, b_z] = self.coefficients.field_ecef_nt([x, y, z])?;
        let field: Vector<Ecef, T> = Vector::new(b_x, b_y, b_z) * nalgebra::convert(T_PER_NT);
        let back = r_ei.inverse().hamilton().cast::<T>();
        Ok(Rotation::<Eci, Ecef, T>::from_hamilton(back) * field)
    }
}

/// The middle of an hour counted from 2000-01-01, as a decimal year.
fn middle_of(hour: i64) -> Result<DecimalYear, igrf::Error> {
    let utc = Utc::from_micros_since_2000(hour.saturating_mul(VALIDITY_US) + VALIDITY_US / 2);
    decimal_year(utc)
}

/// The year of `utc` and how much of it has gone by.
///
/// # Errors
/// Never for a year from 0 to 65535; other years are taken for the nearest of these, which the
/// model refuses.
pub fn decimal_year(utc: Utc) -> Result<DecimalYear, igrf::Error> {
    let civil = utc.civil();
    let year = civil.year.clamp(0, i32::from(u16::MAX)) as u16;
    let seconds_of_day = utc.micros_of_day() as f64 / MICROS_PER_SECOND as f64;
    DecimalYear::from_calendar(year, civil.month, civil.day, seconds_of_day)
}
