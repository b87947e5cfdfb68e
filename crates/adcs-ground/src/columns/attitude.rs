//! Attitude from pairs of vectors.

use adcs_core::attitude::{Estimate, Method, NoAttitude, Observation, ObservationError, Side};
use adcs_core::frames::{Body, Eci, Vector};
use nalgebra::RealField;

use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};

/// A precision to compute in.
pub trait Precision: RealField + Copy {
    /// Writes a number with as many digits as it takes to read it back.
    fn write(self, cells: &mut Cells);
}

impl Precision for f64 {
    fn write(self, cells: &mut Cells) {
        cells.number(self);
    }
}

impl Precision for f32 {
    fn write(self, cells: &mut Cells) {
        cells.single(self);
    }
}

/// The columns of the pair with this number: reference, measurement, standard deviation.
macro_rules! pair {
    ($($number:literal)*) => {
        [$(PairNames {
            reference: [
                concat!("r", $number, "_x"), concat!("r", $number, "_y"), concat!("r", $number, "_z"),
            ],
            body: [
                concat!("b", $number, "_x"), concat!("b", $number, "_y"), concat!("b", $number, "_z"),
            ],
            sigma_rad: concat!("sigma", $number, "_rad"),
        }),*]
    };
}

struct PairNames {
    reference: [&'static str; 3],
    body: [&'static str; 3],
    sigma_rad: &'static str,
}

/// The most pairs that a row can hold.
pub const MAX_PAIRS: usize = 16;
const PAIRS: [PairNames; MAX_PAIRS] = pair!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16);

#[derive(Debug)]
struct Pair {
    reference: [Column; 3],
    body: [Column; 3],
    sigma_rad: Column,
}

/// [`RowCommand`] of `adcs attitude`, in the precision `T`.
#[derive(Debug)]
pub struct Attitude<T: Precision> {
    method: Method,
    n_vectors: Column,
    pairs: Vec<Pair>,
    /// Of the row at hand.
    observations: Vec<Observation<T>>,
}

impl<T: Precision> Attitude<T> {
    /// Finds the columns of as many pairs as there are, without a gap.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(header: &Header, method: Method) -> Result<Self, Failure> {
        let mut pairs = Vec::new();
        for names in &PAIRS {
            let [first, ..] = names.reference;
            if !pairs.is_empty() && header.optional(first)?.is_none() {
                break;
            }
            pairs.push(Pair {
                reference: header.columns(names.reference)?,
                body: header.columns(names.body)?,
                sigma_rad: header.column(names.sigma_rad)?,
            });
        }
        let n_vectors = header.column("n_vectors")?;
        Ok(Self { method, n_vectors, pairs, observations: Vec::new() })
    }

    /// The pairs that the row counts; those behind are not looked at.
    fn pairs_of(&self, row: Row<'_>) -> Result<&[Pair], Problem> {
        let number = row.number(self.n_vectors)?;
        let wanted = number as usize;
        if number < 0.0 || number.fract() != 0.0 {
            return Err(Problem::of_column(self.n_vectors, format!("'{number}' is no count")));
        }
        self.pairs.get(..wanted).ok_or_else(|| {
            let message = format!("'{number}', but the table has columns for {}", self.pairs.len());
            Problem::of_column(self.n_vectors, message)
        })
    }

    fn observation(pair: &Pair, row: Row<'_>) -> Result<Observation<T>, Problem> {
        let body: Vector<Body, T> =
            Vector::from_xyz(row.numbers(pair.body)?.map(nalgebra::convert).into());
        let eci: Vector<Eci, T> =
            Vector::from_xyz(row.numbers(pair.reference)?.map(nalgebra::convert).into());
        let sigma_rad = nalgebra::convert(row.number(pair.sigma_rad)?);
        Observation::new(body, eci, sigma_rad).map_err(|error| {
            let ([body, ..], [reference, ..]) = (pair.body, pair.reference);
            let column = match error {
                ObservationError::NotFinite(Side::Body)
                | ObservationError::ZeroLength(Side::Body) => body,
                ObservationError::NotFinite(Side::Eci)
                | ObservationError::ZeroLength(Side::Eci) => reference,
                _ => pair.sigma_rad,
            };
            Problem::of_column(column, error)
        })
    }
}

impl<T: Precision> RowCommand for Attitude<T> {
    fn computed(&self) -> &'static [&'static str] {
        &[
            "status",
            "q_x",
            "q_y",
            "q_z",
            "q_w",
            "loss",
            "margin",
            "sigma_x_rad",
            "sigma_y_rad",
            "sigma_z_rad",
            "error",
        ]
    }

    fn left_out(&self) -> Vec<Column> {
        let columns = |pair: &Pair| {
            pair.reference.into_iter().chain(pair.body).chain([pair.sigma_rad]).collect::<Vec<_>>()
        };
        self.pairs.iter().flat_map(columns).chain([self.n_vectors]).collect()
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let mut observations = std::mem::take(&mut self.observations);
        observations.clear();
        for pair in self.pairs_of(row)? {
            observations.push(Self::observation(pair, row)?);
        }
        match self.method.solve(&observations) {
            Ok(estimate) => write_estimate(&estimate, cells),
            Err(reason) => write_not_unique(reason, cells),
        }
        self.observations = observations;
        Ok(())
    }

    fn bad_row(&self, problem: &Problem, cells: &mut Cells) {
        cells.text("invalid");
        for _ in 2..self.computed().len() {
            cells.nan();
        }
        cells.text(&problem.to_string());
    }
}

fn write_estimate<T: Precision>(estimate: &Estimate<T>, cells: &mut Cells) {
    cells.text("unique");
    for part in estimate.attitude.attitude_quaternion() {
        part.write(cells);
    }
    estimate.loss.write(cells);
    estimate.margin.write(cells);
    for variance in estimate.covariance_rad2.diagonal().iter() {
        variance.sqrt().write(cells);
    }
    cells.text("");
}

/// That the pairs leave a rotation open is a result, not a mistake of the table.
fn write_not_unique(reason: NoAttitude, cells: &mut Cells) {
    cells.text("nonunique");
    for _ in 0..5 {
        cells.nan();
    }
    match reason {
        NoAttitude::NotUnique { margin } => cells.single(margin),
        _ => cells.nan(),
    }
    for _ in 0..3 {
        cells.nan();
    }
    cells.text(&reason.to_string());
}
