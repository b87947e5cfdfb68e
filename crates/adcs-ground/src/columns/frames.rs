//! From TEME to Earth-fixed axes and to the map.

use adcs_core::environment::earth::{EcefState, ecef_from_eci_at_ut1};
use adcs_core::environment::geodetic::Geodetic;
use adcs_core::frames::Vector;
use adcs_core::orbit::OrbitState;
use adcs_core::time::{JulianDate, gmst82_rad};

use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};

/// Metres in a kilometre.
const M_PER_KM: f64 = 1e3;
/// Julian date of the year 10000, beyond which a day number is taken for a mistake.
const LAST_JULIAN_DATE: f64 = 5_373_484.5;

#[derive(Debug, Clone, Copy)]
enum Time {
    Ut1 { day: Column, fraction: Column },
    Utc(Column),
}

/// [`RowCommand`] of `adcs frames`.
#[derive(Debug)]
pub struct Frames {
    time: Time,
    position: [Column; 3],
    velocity: [Column; 3],
    note: Option<&'static str>,
}

impl Frames {
    /// Finds the columns.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(header: &Header) -> Result<Self, Failure> {
        let day = header.optional("ut1_jd_day")?;
        let fraction = header.optional("ut1_jd_fraction")?;
        let utc = header.optional("utc_iso")?;
        let (time, note) = match (day, fraction, utc) {
            (Some(day), Some(fraction), utc) => (
                Time::Ut1 { day, fraction },
                utc.map(|_| "the time is taken from ut1_jd_day and ut1_jd_fraction, not utc_iso"),
            ),
            (None, None, Some(utc)) => (Time::Utc(utc), None),
            (_, _, Some(utc)) => {
                let note = "the time is taken from utc_iso: one of ut1_jd_day and ut1_jd_fraction is missing";
                (Time::Utc(utc), Some(note))
            }
            (Some(_), None, None) => return Err(header.missing("ut1_jd_fraction")),
            (None, Some(_), None) => return Err(header.missing("ut1_jd_day")),
            (None, None, None) => {
                return Err(header.missing("utc_iso (or ut1_jd_day and ut1_jd_fraction)"));
            }
        };
        // As `adcs propagate` calls them.
        let of_propagate = header.optional("x_teme_km")?.is_some();
        let (position, velocity) = if of_propagate && header.optional("teme_x_km")?.is_none() {
            (
                header.columns(["x_teme_km", "y_teme_km", "z_teme_km"])?,
                header.columns(["vx_teme_km_s", "vy_teme_km_s", "vz_teme_km_s"])?,
            )
        } else {
            (
                header.columns(["teme_x_km", "teme_y_km", "teme_z_km"])?,
                header.columns(["teme_vx_km_s", "teme_vy_km_s", "teme_vz_km_s"])?,
            )
        };
        Ok(Self { time, position, velocity, note })
    }

    fn ut1(&self, row: Row<'_>) -> Result<JulianDate, Problem> {
        match self.time {
            Time::Utc(column) => Ok(row.utc(column)?.julian_date()),
            Time::Ut1 { day: day_column, fraction } => {
                let [day, fraction] = row.numbers([day_column, fraction])?;
                let is_date = |days: f64| (0.0..=LAST_JULIAN_DATE).contains(&days);
                if !is_date(day) || !is_date(day + fraction) {
                    let message = format!("{day} + {fraction} is no Julian date before year 10000");
                    return Err(Problem::of_column(day_column, message));
                }
                Ok(JulianDate { day, fraction })
            }
        }
    }
}

impl RowCommand for Frames {
    fn computed(&self) -> &'static [&'static str] {
        &[
            "gmst82_rad",
            "pef_x_km",
            "pef_y_km",
            "pef_z_km",
            "pef_vx_km_s",
            "pef_vy_km_s",
            "pef_vz_km_s",
            "geodetic_lat_deg",
            "lon_east_deg",
            "height_wgs84_km",
            "error",
        ]
    }

    fn note(&self) -> Option<&'static str> {
        self.note
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let ut1 = self.ut1(row)?;
        let [x, y, z] = row.numbers(self.position)?;
        let [vx, vy, vz] = row.numbers(self.velocity)?;
        let teme = OrbitState {
            position: Vector::new(x, y, z) * M_PER_KM,
            velocity: Vector::new(vx, vy, vz) * M_PER_KM,
        };
        let pef = EcefState::from_eci(ecef_from_eci_at_ut1(ut1), &teme);
        let [first_column, ..] = self.position;
        let place = Geodetic::from_position(pef.position)
            .map_err(|error| Problem::of_column(first_column, error))?;
        cells.number(gmst82_rad(ut1));
        cells.numbers(pef.position.to_array().map(|x| x / M_PER_KM));
        cells.numbers(pef.velocity.to_array().map(|v| v / M_PER_KM));
        cells.number(place.latitude_rad.to_degrees());
        cells.number(place.longitude_east_rad.to_degrees());
        cells.number(place.height_m / M_PER_KM);
        cells.text("");
        Ok(())
    }
}
