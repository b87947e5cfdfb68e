//! The MEKF on a run of an independent simulator, and beside an independent filter.
//!
//! `cargo test --release -p adcs-core --test mekf_reference -- --nocapture` prints every figure. Where the
//! values come from stands in `tests/data/mekf/README.md`.

mod mekf_support;

use adcs_core::attitude::mekf::{Event, GyroSampling, MekfParameters, MekfState, Source};
use mekf_support::reference_run::{
    REFERENCE_FILTER, Table, Worst, attitude, given_sigma_deg, given_start, measured_again,
    moments, parameters,
};
use mekf_support::{Figures, outputs};

/// What the filter has to keep after its transient. The angles are those of the independent filter with
/// room for the draw of the noise; NIS are its degrees of freedom within what 4,000 to 11,000 samples scatter.
struct Bars;

impl Bars {
    const SUNLIT_DEG: f64 = 0.66;
    const ECLIPSE_DEG: f64 = 5.9;
    const WHOLE_DEG: f64 = 3.6;
    const BIAS_DEG_S: f64 = 0.0095;
    const NIS: f64 = 0.15;

    fn hold(name: &str, figures: &Figures) {
        println!("{name}\n{}\n{}", Figures::HEADER, figures.line());
        assert_eq!(figures.without, 0, "{name}: an estimate at every second");
        assert!(figures.sunlit_deg() <= Self::SUNLIT_DEG, "{name}");
        assert!(figures.eclipse_deg() <= Self::ECLIPSE_DEG, "{name}");
        assert!(figures.whole_deg() <= Self::WHOLE_DEG, "{name}");
        assert!(figures.bias_deg_s() <= Self::BIAS_DEG_S, "{name}");
        assert!((figures.nis_field.value() - 3.0).abs() <= Self::NIS, "{name}");
        assert!((figures.nis_sun.value() - 2.0).abs() <= Self::NIS, "{name}");
    }
}

#[test]
fn from_the_given_start_the_figures_hold_after_600_s_in_both_precisions() {
    let run = moments();
    let single = outputs::<f32>(&parameters(), given_start(0.0, given_sigma_deg()), &run);
    let single = Figures::of(&run, &single, 600);
    Bars::hold("given start, f32, after 600 s", &single);
    let double = outputs::<f64>(&parameters(), given_start(0.0, given_sigma_deg()), &run);
    let double = Figures::of(&run, &double, 600);
    Bars::hold("given start, f64, after 600 s", &double);
    // f32 keeps 7 digits of quaternion and covariance; the errors agree to 4.
    assert!((single.whole_deg() - double.whole_deg()).abs() < 1e-4 * double.whole_deg());
}

#[test]
fn starting_by_itself_the_figures_hold_after_900_s() {
    let run = moments();
    let outputs = outputs::<f32>(&parameters(), MekfState::default(), &run);
    assert_eq!(outputs[0].event, Some(Event::Started));
    assert_eq!(outputs[0].estimate.unwrap().source, Source::TwoVectors);
    assert!(outputs[1..].iter().all(|output| output.event.is_none()));
    Bars::hold("automatic start, f32, after 900 s", &Figures::of(&run, &outputs, 900));
}

#[test]
fn from_120_deg_wrong_the_figures_hold_after_900_s_whatever_the_start_claims() {
    let run = moments();
    for (sigma_deg, event) in [(90.0, Event::Realigned), (5.0, Event::Restarted)] {
        let outputs = outputs::<f32>(&parameters(), given_start(120.0, sigma_deg), &run);
        let (second, output) =
            outputs.iter().enumerate().find(|(_, output)| output.event == Some(event)).unwrap();
        assert!(second < 5, "five contradictions in a row");
        assert_eq!(output.estimate.unwrap().source, Source::TwoVectors);
        let name = format!("120 deg wrong, sigma {sigma_deg} deg, f32, after 900 s");
        Bars::hold(&name, &Figures::of(&run, &outputs, 900));
    }
}

#[test]
fn with_the_reference_filters_equations_its_estimates_come_out() {
    // The one difference left is second order: the Sun's innovation across the line of sight instead of
    // all three components, θ²/2 of which is 1 % of σ at 1 σ and more while the start converges.
    const ANGLE_RAD: f64 = 2e-5;
    const BIAS_RAD_S: f64 = 3e-6;
    const SIGMA_RELATIVE: f64 = 5e-6;
    let run = moments();
    let parameters =
        MekfParameters::<f64> { gyro_sampling: GyroSampling::Interval, ..parameters() };
    let outputs = outputs(&parameters, given_start(0.0, given_sigma_deg()), &run);
    let mut angle = Worst::new("attitude beside the reference filter, rad");
    let mut bias = Worst::new("bias, rad/s");
    let mut sigma = Worst::new("sigma of the attitude, relative");
    for row in Table::parse(REFERENCE_FILTER).rows() {
        let t_s = row.text("t_s");
        let estimate = outputs[t_s.parse::<usize>().unwrap()].estimate.unwrap();
        angle.see((estimate.r_bi * attitude(&row).inverse()).angle_rad(), t_s);
        let theirs = row.vector(["bias_x_rad_s", "bias_y_rad_s", "bias_z_rad_s"]);
        bias.see((estimate.gyro_bias.xyz - theirs).norm(), t_s);
        let theirs = row.vector(["sigma_att_x_rad", "sigma_att_y_rad", "sigma_att_z_rad"]);
        let ours = estimate.attitude_sigma_rad.xyz;
        sigma.see((ours - theirs).component_div(&theirs).amax(), t_s);
    }
    angle.report(ANGLE_RAD);
    bias.report(BIAS_RAD_S);
    sigma.report(SIGMA_RELATIVE);
}

#[test]
fn over_other_draws_of_the_noise_errors_are_as_large_as_the_covariance_says() {
    const DRAWS: u64 = 20;
    // NEES of 3 and 6 degrees of freedom. In eclipse errors last for minutes and are tied to one axis, so
    // that a run of two orbits holds a few tens of independent samples and twenty hold some hundreds.
    const NEES_ATTITUDE: core::ops::RangeInclusive<f64> = 2.6..=3.5;
    const NEES: core::ops::RangeInclusive<f64> = 5.3..=6.9;
    let run = moments();
    let (mut nees_attitude, mut nees) = (0.0, 0.0);
    println!("other draws of the noise, automatic start, f32, after 600 s\n{}", Figures::HEADER);
    for seed in 1..=DRAWS {
        let again = measured_again(&run, seed);
        let outputs = outputs::<f32>(&parameters(), MekfState::default(), &again);
        let figures = Figures::of(&again, &outputs, 600);
        println!("{}", figures.line());
        assert_eq!(figures.without, 0);
        assert!(figures.eclipse_deg() <= Bars::ECLIPSE_DEG && figures.bias_deg_s() <= 0.011);
        assert!((figures.nis_field.value() - 3.0).abs() <= Bars::NIS);
        assert!((figures.nis_sun.value() - 2.0).abs() <= Bars::NIS);
        nees_attitude += figures.nees_attitude.value() / DRAWS as f64;
        nees += figures.nees.value() / DRAWS as f64;
    }
    println!("mean NEES {nees_attitude:.2} of 3, {nees:.2} of 6");
    assert!(NEES_ATTITUDE.contains(&nees_attitude) && NEES.contains(&nees));
}
