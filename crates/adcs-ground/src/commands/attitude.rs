//! `adcs attitude`: attitude from pairs of vectors.

use std::process::ExitCode;

use adcs_core::attitude::Method;
use adcs_ground::columns::attitude::Attitude;
use adcs_ground::table;

use super::files::{TableArgs, exit_code, table_help};

const HELP: &str = table_help!(
    "\
Reads the columns
  n_vectors                how many pairs the row has, 2 or more
  r1_x, r1_y, r1_z         reference direction of the first pair, any length
  b1_x, b1_y, b1_z         the same direction measured in body axes, any length
  sigma1_rad               standard deviation of the angle between the two about
                           each axis across them, rad
  r2_x ... sigma16_rad     the other pairs
and writes the columns of the input but these, and behind them
  status                   unique, nonunique (the pairs leave a rotation open, as
                           parallel ones do) or invalid (the row has no pairs that
                           can be used)
  q_x, q_y, q_z, q_w       attitude quaternion, v_body = A(q) v_reference, q_w >= 0
  loss                     1/2 sum a |b - A r|^2, a = sigma^-2 / sum sigma^-2
  margin                   curvature of the loss about the axis known least; 0 is
                           not unique
  sigma_x_rad .. _z_rad    standard deviation of the attitude error about each
                           body axis
  error                    empty, or why the row has no attitude

A nonunique row is a result: it is not named on standard error and does not change
the exit code.

foam, q-method and quest find the attitude of least loss. triad keeps the direction
of the first pair and turns the second as near as it goes; loss and margin are of
these two.

Example
  $ adcs attitude pairs.csv --method foam -o attitudes.csv"
);

/// Attitude from pairs of vectors, measured and known, for a table of problems
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    #[command(flatten)]
    table: TableArgs,

    /// How the attitude is found
    #[arg(long, value_enum, value_name = "METHOD")]
    method: MethodName,

    /// Compute in single precision (f32), as on a microcontroller
    #[arg(long)]
    single: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum MethodName {
    /// From two pairs, the first trusted completely
    Triad,
    /// Markley's fast optimal attitude matrix
    Foam,
    /// Davenport's q-method
    #[value(name = "q-method")]
    QMethod,
    /// Shuster's quaternion estimator
    Quest,
}

impl MethodName {
    fn method(self) -> Method {
        match self {
            Self::Triad => Method::Triad,
            Self::Foam => Method::Foam,
            Self::QMethod => Method::QMethod,
            Self::Quest => Method::Quest,
        }
    }
}

pub fn run(args: &Args) -> ExitCode {
    let TableArgs { input, output } = &args.table;
    let method = args.method.method();
    exit_code(table::run(input, &output.path, |header| {
        Ok(if args.single {
            Box::new(Attitude::<f32>::bind(header, method)?)
        } else {
            Box::new(Attitude::<f64>::bind(header, method)?)
        })
    }))
}
