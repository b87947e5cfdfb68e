//! Of random satellites, 95 in 100 truths lie within two of the reported sigmas: in single precision, one
//! instant after the other, as on board.

mod tumble_support;

use adcs_core::identification::coupling::{CouplingSample, TorquerCoupling};
use adcs_core::identification::gyro::GyroBias;
use adcs_core::identification::momentum::MomentumFit;
use adcs_core::identification::{Noise, Recorded, Solution};
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};
use tumble_support::{FIELD_NOISE_T, GYRO_NOISE, INERTIA, Random, Satellite};

/// The bar, of all truths of a quantity.
const INSIDE: std::ops::RangeInclusive<f64> = 0.92..=0.98;

/// Of a coarse attitude, each axis, rad: 3 deg.
const ATTITUDE_ERROR: f64 = 0.052;

/// What calibration leaves of the magnetometer's bias, each axis, T.
const FIELD_OFFSET_T: f64 = 200e-9;

/// A satellite, and how it is recorded.
struct Case {
    random: Random,
    satellite: Satellite,
    dt_s: f64,
    duration_s: f64,
    gyro_bias: Vector3<f64>,
    field_offset: Vector3<f64>,
    /// Of the gyros, rad/s per degree.
    gyro_slope: Vector3<f64>,
    /// Of the torquers at the magnetometer, T for 1 A·m².
    coupling: Matrix3<f64>,
    /// What a commanded dipole becomes.
    gains: Matrix3<f64>,
    /// Of the pulses, A·m²; zero for none.
    pulse_am2: f64,
}

/// An instant of it.
struct Instant {
    recorded: Recorded<f32>,
    /// As read, whatever the torquers do.
    reading: [f32; 3],
    temperature_c: f32,
    /// Of the field in inertial space since the instant before, by an attitude that is askew.
    change: [f32; 3],
}

impl Case {
    /// Tumbles at 2 to 10 deg/s for 10 to `longest_min` minutes.
    fn new(seed: u64, longest_min: f64) -> Self {
        let mut random = Random::new(1000 + seed);
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        let speed = between(2.0, 10.0).to_radians();
        let duration_s = 60.0 * between(10.0, longest_min);
        let dt_s = if between(0.0, 1.0) < 0.5 { 0.5 } else { 1.0 };
        let pulse_am2 = between(0.3, 0.5);
        let residual = between(0.05, 0.4);
        let direction = random.vector(1.0).normalize();
        let mut satellite = Satellite::new(&mut random, direction * speed);
        satellite.residual = random.vector(1.0).normalize() * residual;
        satellite.disturbed = true;
        let off = random.vector(0.05);
        let products = random.vector(0.02 * 0.055);
        let mut tensor = Matrix3::from(INERTIA);
        for axis in 0..3 {
            tensor[(axis, axis)] *= 1.0 + off[axis];
        }
        for (axis, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
            tensor[(i, j)] = products[axis];
            tensor[(j, i)] = products[axis];
        }
        satellite.inertia = tensor;
        let gains = Matrix3::identity() + Matrix3::from_fn(|_, _| 0.1 * random.gaussian());
        Self {
            field_offset: random.vector(FIELD_OFFSET_T),
            gyro_bias: random.vector(0.3_f64.to_radians()),
            gyro_slope: random.vector(0.01_f64.to_radians()),
            coupling: Matrix3::from_fn(|_, _| 20e-6 * random.gaussian()),
            gains,
            random,
            satellite,
            dt_s,
            duration_s,
            pulse_am2,
        }
    }

    /// Torquers 10 s on and 2.5 s off, full dipoles of random signs.
    fn record(&mut self, mut each: impl FnMut(&Instant)) {
        let single = |v: Vector3<f64>| -> [f32; 3] { v.map(|x| x as f32).into() };
        let mut told = Vector3::zeros();
        let askew = Rotation3::new(self.random.vector(ATTITUDE_ERROR));
        let mut last_field = self.satellite.field_inertial(0.0);
        let steps = (self.duration_s / self.dt_s) as u32;
        for step in 0..=steps {
            let t_s = f64::from(step) * self.dt_s;
            let warm = 10.0 * (t_s * std::f64::consts::TAU / 5800.0).sin();
            let rate = self.satellite.rate
                + self.gyro_bias
                + self.gyro_slope * warm
                + self.random.vector(GYRO_NOISE);
            let field =
                self.satellite.field() + self.coupling * told + self.random.vector(FIELD_NOISE_T);
            let now = self.satellite.field_inertial(self.satellite.seconds);
            let change = now - std::mem::replace(&mut last_field, now);
            each(&Instant {
                recorded: Recorded {
                    dt_s: if step == 0 { 0.0 } else { self.dt_s as f32 },
                    rate_rad_s: single(rate),
                    field_t: (told == Vector3::zeros()).then(|| single(field)),
                    dipole_am2: single(told),
                },
                reading: single(field),
                temperature_c: (20.0 + warm) as f32,
                change: single(askew * (self.satellite.q.inverse() * change)),
            });
            if self.pulse_am2 > 0.0 {
                let (before, after) = (t_s % 12.5, (t_s + self.dt_s) % 12.5);
                if before < 2.5 && after >= 2.5 {
                    let pulse = self.pulse_am2;
                    let random = &mut self.random;
                    told = Vector3::from_fn(
                        |_, _| {
                            if random.uniform() < 0.5 { -pulse } else { pulse }
                        },
                    );
                } else if after < before {
                    told = Vector3::zeros();
                }
            }
            self.satellite.advance(self.dt_s, self.gains * told);
        }
    }
}

/// How a quantity's errors compare to its sigma.
#[derive(Default)]
struct Coverage {
    inside: f64,
    total: f64,
    sum: f64,
    squares: f64,
    /// Of the errors themselves.
    error_squares: f64,
}

impl Coverage {
    fn add(&mut self, error: f64, sigma: f64) {
        let z = error / sigma;
        self.inside += f64::from(u8::from(z.abs() <= 2.0));
        self.total += 1.0;
        self.sum += z;
        self.squares += z * z;
        self.error_squares += error * error;
    }

    fn add_all<const N: usize>(
        many: &mut [Self],
        found: &Solution<f32, N>,
        truth: &SVector<f64, N>,
    ) {
        let sigma = found.sigma();
        for (axis, one) in many.iter_mut().enumerate() {
            one.add(f64::from(found.x[axis]) - truth[axis], f64::from(sigma[axis]));
        }
    }

    fn together(many: &[Self]) -> Self {
        many.iter().fold(Self::default(), |a, b| Self {
            inside: a.inside + b.inside,
            total: a.total + b.total,
            sum: a.sum + b.sum,
            squares: a.squares + b.squares,
            error_squares: a.error_squares + b.error_squares,
        })
    }

    fn share(&self) -> f64 {
        self.inside / self.total
    }

    fn show(&self, name: &str) {
        println!(
            "{name}: {:.1} % of {} inside; error/sigma mean {:+.2}, rms {:.2}; rms error {:.2e}",
            100.0 * self.share(),
            self.total,
            self.sum / self.total,
            (self.squares / self.total).sqrt(),
            (self.error_squares / self.total).sqrt(),
        );
    }
}

fn noise() -> Noise<f32> {
    Noise {
        rate_rad_s: GYRO_NOISE as f32,
        field_t: FIELD_NOISE_T as f32,
        field_offset_t: FIELD_OFFSET_T as f32,
    }
}

fn coupling(cases: std::ops::Range<u64>, longest_min: f64) -> Coverage {
    let mut coverage: [Coverage; 9] = Default::default();
    for seed in cases {
        let mut case = Case::new(seed, longest_min);
        let mut fit = TorquerCoupling::new(noise());
        case.record(|at| {
            fit.add(&CouplingSample {
                dt_s: at.recorded.dt_s,
                rate_rad_s: at.recorded.rate_rad_s,
                field_t: at.reading,
                dipole_am2: at.recorded.dipole_am2,
            });
        });
        let truth = SVector::from_iterator(case.coupling.iter().copied());
        Coverage::add_all(&mut coverage, &fit.solve().unwrap(), &truth);
    }
    Coverage::together(&coverage)
}

#[test]
fn the_torquers_field_lies_within_two_sigma() {
    let coverage = coupling(0..60, 20.0);
    coverage.show("coupling, T per A m²");
    assert!(INSIDE.contains(&coverage.share()));
}

#[test]
#[ignore = "takes minutes"]
fn the_torquers_field_lies_within_two_sigma_of_400_satellites() {
    let coverage = coupling(0..400, 90.0);
    coverage.show("coupling, T per A m²");
    assert!(INSIDE.contains(&coverage.share()));
}

/// M, five of the tensor in kg·m², G column by column.
fn truth_of(case: &Case) -> [f64; 17] {
    let off = case.satellite.inertia - told_inertia(case);
    let mut truth = [0.0; 17];
    truth[..3].copy_from_slice(case.satellite.residual.as_slice());
    truth[3..8].copy_from_slice(&[off.m11, off.m22, off.m12, off.m13, off.m23]);
    truth[8..].copy_from_slice(case.gains.as_slice());
    truth
}

/// The paper's, with the trace that is true.
fn told_inertia(case: &Case) -> Matrix3<f64> {
    let told = Matrix3::from(INERTIA);
    told * (case.satellite.inertia.trace() / told.trace())
}

fn momentum<const N: usize>(
    cases: std::ops::Range<u64>,
    longest_min: f64,
    name: &str,
    pulses: bool,
    knows_tensor: bool,
    knows_gains: bool,
    pick: [usize; N],
    fit: impl Fn([[f32; 3]; 3], Noise<f32>) -> MomentumFit<f32, N>,
) -> Coverage {
    let mut coverage: [Coverage; N] = core::array::from_fn(|_| Coverage::default());
    for seed in cases {
        let mut case = Case::new(seed, longest_min);
        if knows_gains {
            case.gains = Matrix3::identity();
        }
        if !pulses {
            case.pulse_am2 = 0.0;
        }
        let told = if knows_tensor { case.satellite.inertia } else { told_inertia(&case) };
        let mut all = truth_of(&case);
        if knows_tensor {
            all[3..8].fill(0.0);
        }
        let truth = SVector::from(pick.map(|index| all[index]));
        let mut fit = fit(told.map(|x| x as f32).into(), noise());
        let duration = case.duration_s;
        case.record(|at| fit.add(&at.recorded));
        match fit.solve() {
            Ok(found) => Coverage::add_all(&mut coverage, &found, &truth),
            Err(error) => println!("{name} {seed} {duration}: {error}"),
        }
    }
    for (index, one) in coverage.iter().enumerate() {
        one.show(&format!("{name} {index}"));
    }
    let all = Coverage::together(&coverage);
    all.show(name);
    all
}

#[test]
#[ignore = "takes minutes"]
fn momentum_of_400_satellites() {
    for (longest, n) in [(20.0, 200), (90.0, 100)] {
        println!("== {longest}");
        let tensor = core::array::from_fn(|index| index);
        let gains = core::array::from_fn(|index| if index < 3 { index } else { index + 5 });
        let all = core::array::from_fn(|index| index);
        momentum(0..n, longest, "dipole quiet", false, true, true, [0, 1, 2], |j, n| {
            MomentumFit::dipole(j, n).unwrap()
        });
        momentum(0..n, longest, "dipole pulses", true, true, true, [0, 1, 2], |j, n| {
            MomentumFit::dipole(j, n).unwrap()
        });
        momentum(0..n, longest, "ratios", true, false, true, tensor, |j, n| {
            MomentumFit::ratios(j, n).unwrap()
        });
        momentum(0..n, longest, "ratios quiet", false, false, true, tensor, |j, n| {
            MomentumFit::ratios(j, n).unwrap()
        });
        momentum(0..n, longest, "gains", true, true, false, gains, |j, n| {
            MomentumFit::gains(j, n).unwrap()
        });
        momentum(0..n, longest, "all", true, false, false, all, |j, n| {
            MomentumFit::ratios_and_gains(j, n).unwrap()
        });
    }
}

fn gyro<const N: usize>(
    cases: std::ops::Range<u64>,
    longest_min: f64,
    name: &str,
    attitude: bool,
    pulses: bool,
    new: impl Fn() -> GyroBias<f32, N>,
) -> Coverage {
    let mut coverage: [Coverage; N] = core::array::from_fn(|_| Coverage::default());
    for seed in cases {
        let mut case = Case::new(seed, longest_min);
        if N == 3 {
            case.gyro_slope = Vector3::zeros();
        }
        if !pulses {
            case.pulse_am2 = 0.0;
        }
        let mut fit = new();
        let duration = case.duration_s;
        case.record(|at| fit.add(&at.recorded, at.temperature_c, attitude.then_some(at.change)));
        let truth = case.gyro_bias.iter().chain(&case.gyro_slope).copied().take(N);
        match fit.solve() {
            Ok(found) => {
                Coverage::add_all(&mut coverage, &found, &SVector::from_iterator(truth));
            }
            Err(error) => println!("{name} {seed} {duration}: {error}"),
        }
    }
    for (index, one) in coverage.iter().enumerate() {
        one.show(&format!("{name} {index}"));
    }
    let all = Coverage::together(&coverage);
    all.show(name);
    all
}

#[test]
#[ignore = "takes minutes"]
fn gyro_of_400_satellites() {
    for (longest, n) in [(20.0, 200), (90.0, 100)] {
        println!("== {longest}");
        for attitude in [false, true] {
            for pulses in [false, true] {
                println!("== attitude {attitude} pulses {pulses}");
                gyro(0..n, longest, "constant", attitude, pulses, || GyroBias::constant(noise()));
                gyro(0..n, longest, "slope", attitude, pulses, || {
                    GyroBias::with_temperature(noise(), 20.0)
                });
            }
        }
    }
}
