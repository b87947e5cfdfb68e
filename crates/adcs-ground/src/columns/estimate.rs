//! Attitude and gyro bias from gyro, field and Sun over time.

use adcs_core::attitude::dynamic::DynamicInputs;
use adcs_core::attitude::mekf::{FieldPair, Innovation, Inputs, Source, SunPair};
use adcs_core::attitude::selection::{AttitudeSource, Determination, Estimator, EstimatorState};
use adcs_core::frames::Vector;
use adcs_core::reading::{MissingReason, Reading};
use nalgebra::convert;

use super::attitude::Precision;
use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};

/// Instants that differ by less are the same, s: what decimal fractions of a second lose when they are
/// read.
const SAME_INSTANT_S: f64 = 1e-6;
/// Tesla in a nanotesla.
const T_PER_NT: f64 = 1e-9;
/// Metres in a kilometre.
const M_PER_KM: f64 = 1e3;

/// What the models say for one instant, in Eci.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    t_s: f64,
    position_km: Option<[f64; 3]>,
    field_nt: Option<[f64; 3]>,
    sun: Option<[f64; 3]>,
    eclipse: bool,
}

impl Reference {
    /// Finds the columns, and reads rows whose instants increase.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(
        header: &Header,
    ) -> Result<impl FnMut(Row<'_>) -> Result<Self, Problem> + use<>, Failure> {
        let mut clock = Clock::bind(header)?;
        let field = header.columns(["B_teme_x_nT", "B_teme_y_nT", "B_teme_z_nT"])?;
        let sun = header.columns(["sun_teme_x", "sun_teme_y", "sun_teme_z"])?;
        let position = header.optional_columns(["r_teme_x_km", "r_teme_y_km", "r_teme_z_km"])?;
        let eclipse = header.optional("eclipse")?;
        Ok(move |row: Row<'_>| {
            let reference = Self {
                t_s: clock.read(row)?,
                position_km: match position {
                    Some(position) => reading(row, position)?,
                    None => None,
                },
                field_nt: reading(row, field)?,
                sun: reading(row, sun)?,
                eclipse: flag(row, eclipse)?.unwrap_or(false),
            };
            clock.advance(reference.t_s);
            Ok(reference)
        })
    }
}

/// [`RowCommand`] of `adcs estimate`, in the precision `T`.
#[derive(Debug)]
pub struct Estimate<T: Precision> {
    clock: Clock,
    gyro: [Column; 3],
    field: [Column; 3],
    sun: [Column; 3],
    sun_valid: Option<Column>,
    left_out: Vec<Column>,
    references: Vec<Reference>,
    torquers: Option<[Column; 3]>,
    estimator: Estimator<T>,
    state: EstimatorState<T>,
}

impl<T: Precision> Estimate<T> {
    /// Finds the columns.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(
        header: &Header,
        references: Vec<Reference>,
        (estimator, state): (Estimator<T>, EstimatorState<T>),
    ) -> Result<Self, Failure> {
        let gyro = header.columns(["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"])?;
        let field = header.columns(["mag_x_nT", "mag_y_nT", "mag_z_nT"])?;
        let sun = header.columns(["sun_x", "sun_y", "sun_z"])?;
        let sun_valid = header.optional("sun_valid")?;
        let face = header.optional("sun_face_0px_1mx_2py_3my_4pz_5mz")?;
        let left_out =
            [gyro, field, sun].into_iter().flatten().chain(sun_valid).chain(face).collect();
        let torquers =
            header.optional_columns(["torquer_x_am2", "torquer_y_am2", "torquer_z_am2"])?;
        let clock = Clock::bind(header)?;
        Ok(Self {
            clock,
            gyro,
            field,
            sun,
            sun_valid,
            left_out,
            references,
            torquers,
            estimator,
            state,
        })
    }

    /// What the models say for this instant.
    fn reference(&self, t_s: f64) -> Option<&Reference> {
        let at = self.references.partition_point(|it| it.t_s < t_s - SAME_INSTANT_S);
        self.references.get(at).filter(|it| it.t_s <= t_s + SAME_INSTANT_S)
    }

    fn inputs(&self, row: Row<'_>, t_s: f64) -> Result<DynamicInputs<T>, Problem> {
        let gyro = match reading(row, self.gyro)? {
            Some(rate) => Reading::Fresh(vector(rate)),
            None => Reading::Missing(MissingReason::NotFinite),
        };
        let field_b = reading(row, self.field)?;
        let valid = flag(row, self.sun_valid)?.unwrap_or(true);
        let sun_b = reading(row, self.sun)?.filter(|_| valid);

        let reference = self.reference(t_s);
        let field = field_b.zip(reference.and_then(|it| it.field_nt));
        let lit = reference.filter(|it| !it.eclipse);
        let sun = sun_b.zip(lit.and_then(|it| it.sun));
        let sensors = Inputs {
            dt_s: convert(self.clock.since_last(t_s)),
            gyro,
            field: field.map(|(body, eci)| FieldPair {
                body: vector(body.map(|nt| nt * T_PER_NT)),
                eci: vector(eci.map(|nt| nt * T_PER_NT)),
            }),
            sun: sun.and_then(|(body, eci)| {
                Some(SunPair { body: vector(body).direction()?, eci: vector(eci).direction()?, sigma_rad: None })
            }),
        };
        let torquers = match self.torquers {
            Some(columns) => reading(row, columns)?.unwrap_or_default(),
            None => [0.0; 3],
        };
        Ok(DynamicInputs {
            sensors,
            reference_field: reference
                .and_then(|it| it.field_nt)
                .map(|field| vector(field.map(|nt| nt * T_PER_NT))),
            position: reference
                .and_then(|it| it.position_km)
                .map(|position| vector(position.map(|km| km * M_PER_KM))),
            torquer_dipole: vector(torquers),
            sunlit: reference.map(|it| !it.eclipse),
        })
    }
}

impl<T: Precision> RowCommand for Estimate<T> {
    fn computed(&self) -> &'static [&'static str] {
        &[
            "q_x",
            "q_y",
            "q_z",
            "q_w",
            "bias_x_rad_s",
            "bias_y_rad_s",
            "bias_z_rad_s",
            "sigma_att_x_rad",
            "sigma_att_y_rad",
            "sigma_att_z_rad",
            "nis_mag",
            "nis_sun",
            "source",
            "error",
        ]
    }

    fn left_out(&self) -> Vec<Column> {
        self.left_out.clone()
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let t_s = self.clock.read(row)?;
        let inputs = self.inputs(row, t_s)?;
        self.clock.advance(t_s);
        let determination = self.estimator.cycle(&mut self.state, &inputs);
        Chosen::of(&determination).write(cells);
        cells.text("");
        Ok(())
    }

    fn bad_row(&self, problem: &Problem, cells: &mut Cells) {
        (0..12).for_each(|_| cells.nan());
        cells.text("none");
        cells.text(&problem.to_string());
    }
}

/// What the satellite would believe, and the innovations of the filter that it comes from.
struct Chosen<T: Precision> {
    /// q, bias, σ.
    numbers: Option<([T; 4], [T; 3], [T; 3])>,
    innovations: [Option<Innovation<T>>; 2],
    source: &'static str,
}

impl<T: Precision> Chosen<T> {
    fn of(determination: &Determination<T>) -> Self {
        let Determination { attitude, mekf, dynamic, .. } = determination;
        let is_dynamic = attitude.is_some_and(|it| it.source == AttitudeSource::Dynamic);
        if let Some(estimate) = dynamic.estimate.as_ref().filter(|_| is_dynamic) {
            let sigma = estimate.attitude_covariance.diagonal().map(|it| it.sqrt());
            return Self {
                numbers: Some((
                    estimate.r_bi.attitude_quaternion(),
                    estimate.gyro_bias.to_array(),
                    sigma.into(),
                )),
                innovations: [dynamic.field, dynamic.sun],
                source: "dynamic",
            };
        }
        let numbers = mekf.estimate.as_ref().map(|estimate| {
            (
                estimate.r_bi.attitude_quaternion(),
                estimate.gyro_bias.to_array(),
                estimate.attitude_sigma_rad.to_array(),
            )
        });
        let source = mekf.estimate.as_ref().map_or("none", |estimate| source_name(estimate.source));
        Self { numbers, innovations: [mekf.field, mekf.sun], source }
    }

    fn write(&self, cells: &mut Cells) {
        match &self.numbers {
            Some((q, bias, sigma)) => {
                q.iter().chain(bias).chain(sigma).for_each(|value| value.write(cells));
            }
            None => (0..10).for_each(|_| cells.nan()),
        }
        for innovation in self.innovations {
            match innovation {
                Some(Innovation { nis, .. }) => nis.write(cells),
                None => cells.nan(),
            }
        }
        cells.text(self.source);
    }
}

fn source_name(source: Source) -> &'static str {
    match source {
        Source::TwoVectors => "two-vectors",
        Source::FieldAndSun => "field+sun",
        Source::Field => "field",
        Source::Sun => "sun",
        Source::Gyro => "gyro",
        Source::HeldRate => "held-rate",
        // A source that is younger than this table.
        _ => "other",
    }
}

/// Reads instants that increase.
#[derive(Debug, Clone, Copy)]
struct Clock {
    column: Column,
    last_s: Option<f64>,
}

impl Clock {
    fn bind(header: &Header) -> Result<Self, Failure> {
        Ok(Self { column: header.column("t_s")?, last_s: None })
    }

    fn read(&self, row: Row<'_>) -> Result<f64, Problem> {
        let t_s = row.number(self.column)?;
        match self.last_s {
            Some(last_s) if t_s <= last_s => {
                let message = format!("'{t_s}' is not after the '{last_s}' of the row before");
                Err(Problem::of_column(self.column, message))
            }
            _ => Ok(t_s),
        }
    }

    fn since_last(&self, t_s: f64) -> f64 {
        self.last_s.map_or(0.0, |last_s| t_s - last_s)
    }

    fn advance(&mut self, t_s: f64) {
        self.last_s = Some(t_s);
    }
}

/// Three fields as a vector; `None` when one of them says `nan` or nothing: it was not measured.
fn reading(row: Row<'_>, columns: [Column; 3]) -> Result<Option<[f64; 3]>, Problem> {
    let is_absent = |column: &Column| {
        let text = row.bytes(*column).trim_ascii();
        text.is_empty() || text.eq_ignore_ascii_case(b"nan")
    };
    if columns.iter().any(is_absent) { Ok(None) } else { row.numbers(columns).map(Some) }
}

/// A field that says 0 or 1.
fn flag(row: Row<'_>, column: Option<Column>) -> Result<Option<bool>, Problem> {
    let Some(column) = column else { return Ok(None) };
    match row.number(column)? {
        0.0 => Ok(Some(false)),
        1.0 => Ok(Some(true)),
        other => Err(Problem::of_column(column, format!("'{other}' is neither 0 nor 1"))),
    }
}

fn vector<F, T: Precision>(xyz: [f64; 3]) -> Vector<F, T> {
    let [x, y, z] = xyz.map(convert);
    Vector::new(x, y, z)
}
