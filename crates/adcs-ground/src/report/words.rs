//! What one sees, in sentences made from the numbers.

use super::pointing::CAPTURED_DEG;
use super::summary::{Summary, Torquers};

/// Below this ratio of the rates a tumble counts as decaying, above its counterpart as growing.
/// Without control the disturbances alone move it by 1 or 2 percent in 1200 s.
const DECAYS_BELOW: f64 = 0.9;
const GROWS_ABOVE: f64 = 1.1;

/// The flight in one sentence.
pub fn verdict(summary: &Summary) -> String {
    let rates = &summary.rates;
    let (start, end) = (rates.start_norm_deg_s, rates.end_norm_deg_s);
    let after = format!("{:.0} s", summary.flown_s);
    match rates.ratio {
        None => format!("The satellite starts at rest and turns at {end:.2} deg/s after {after}."),
        Some(ratio) => {
            let what = match ratio {
                ..DECAYS_BELOW => "The tumble decays",
                GROWS_ABOVE.. => "The tumble grows",
                _ => "The tumble neither decays nor grows",
            };
            format!(
                "{what}: {start:.2} deg/s at the start, {end:.2} deg/s after {after}, a ratio of \
                 {ratio:.2}."
            )
        }
    }
}

/// About the rates.
pub fn rates(summary: &Summary) -> String {
    let swings = ["x", "y", "z"].into_iter().zip(summary.damping);
    let swings = swings.filter_map(|(axis, damping)| {
        let damping = damping?;
        Some(format!(
            "{axis} swings from {:.2} deg/s (at {:.0} s) to {:.2} deg/s (at {:.0} s), a damping \
             ratio of {:.3}",
            damping.first_peak_deg_s,
            damping.first_peak_s,
            damping.second_peak_deg_s,
            damping.second_peak_s,
            damping.ratio
        ))
    });
    let swings = match swings.collect::<Vec<_>>() {
        none if none.is_empty() => {
            "No axis has two negative peaks, from which a damping ratio could be taken.".to_owned()
        }
        some => format!("Its negative peaks: {}.", some.join("; ")),
    };
    format!("{} {swings}", verdict(summary))
}

/// About the modes.
pub fn modes(summary: &Summary) -> String {
    let all = summary
        .transitions
        .iter()
        .map(|at| format!("{} at {:.0} s ({})", at.to, at.time_ms as f64 / 1e3, at.cause));
    format!("The satellite's own decisions: {}.", all.collect::<Vec<_>>().join("; "))
}

/// About the angle to the target.
pub fn pointing(summary: &Summary) -> String {
    let Some(pointing) = &summary.pointing else {
        return "Nothing was pointed at.".to_owned();
    };
    let captured = match pointing.captured_s {
        Some(captured_s) => {
            format!("Below {CAPTURED_DEG:.0} deg for good from {captured_s:.0} s on.")
        }
        None => format!("Not below {CAPTURED_DEG:.0} deg at the end."),
    };
    format!(
        "The whole turn between where Body is and where it should be, by the truth. {captured} From          {:.0} s on {:.2} deg mean, {:.2} deg for 95 % of the time, {:.2} deg at most.",
        pointing.settled_s, pointing.mean_deg, pointing.p95_deg, pointing.largest_deg
    )
}

/// About the same, settled.
pub fn pointing_settled() -> String {
    "Dots are the angle as the satellite believed it when it decided. Where the black line is above \
     the dots and the blue one, the attitude is wrong and not only the pointing."
        .to_owned()
}

/// About the same, round by round.
pub fn pointing_rounds() -> String {
    "Each command is decided at a dot and held while the ground is grey; in between the satellite \
     drifts."
        .to_owned()
}

/// About the field.
pub fn field(summary: &Summary) -> String {
    match &summary.field {
        None => "The field was not measured once; without it the torquers stay off.".to_owned(),
        Some(field) => format!(
            "Dots are the instants at which the torquers had rested long enough to measure. Their \
             strength is off the model by {:+.0} to {:+.0} nT ({:.0} nT rms); their direction is off \
             the true one by {:.1} to {:.1} deg.",
            field.min_norm_error_nt,
            field.max_norm_error_nt,
            field.rms_norm_error_nt,
            field.min_angle_deg,
            field.max_angle_deg
        ),
    }
}

/// About the error of the field's strength.
pub fn field_error() -> String {
    "A pattern here tells of scale, bias or axis errors, a cloud of noise. What it cannot show is a \
     wrong sign alone: that leaves the strength as it is."
        .to_owned()
}

/// About the error of the Sun sensors.
pub fn sun_error() -> String {
    "A cloud near the ground is noise. What stands above it for a while is a face that sees the \
     Earth beside the Sun. Where there is nothing, no face saw the Sun, as at night."
        .to_owned()
}

/// About the attitude.
pub fn attitude_error(summary: &Summary) -> String {
    let Some(attitude) = &summary.attitude else {
        return "No attitude was believed for a moment of this flight.".to_owned();
    };
    let part = |name: &str, rms: Option<f64>| {
        rms.map_or_else(String::new, |rms| format!(" {rms:.2} deg rms {name}."))
    };
    format!(
        "First believed after {:.1} s, and for {:.0} % of the time since; from the dynamics-aided \
         filter for {:.0} %.{}{} Shaded: eclipse, in which the field alone corrects the attitude. An \
         error that stays below the grey line is no larger than the filter promised.",
        attitude.first_s,
        100.0 * attitude.share,
        100.0 * attitude.dynamic_share,
        part("in sunlight", attitude.sunlit_rms_deg),
        part("in eclipse", attitude.eclipse_rms_deg),
    )
}

/// About the residual dipole.
pub fn residual_dipole() -> String {
    "What the satellite itself is as a magnet, learned from how it turns. It steps when the filter \
     starts anew and wanders when panels switch their currents in and out of the shadow."
        .to_owned()
}

/// About the torquers.
pub fn dipoles(summary: &Summary) -> String {
    let Torquers { duty, mean_dipole_am2, saturated, refused_cycles } = summary.torquers;
    let Some(mean) = mean_dipole_am2 else {
        return "The torquers stayed off for the whole flight.".to_owned();
    };
    let mut text = format!(
        "Each command is measured once, at the end of a rest, and held while the torquers act: {:.0} % \
         of the time, with a mean dipole of {mean:.3} A·m². {} of the commands stood at the limit.",
        duty * 100.0,
        percent(saturated)
    );
    if refused_cycles > 0 {
        text.push_str(&format!(" The torquers refused their command in {refused_cycles} cycles."));
    }
    text
}

/// About the close-up.
pub fn first_minute() -> String {
    "Measure, then act: while the ground is white the torquers rest and the field settles; the \
     command is constant on the grey."
        .to_owned()
}

/// About the energy.
pub fn energy(summary: &Summary) -> String {
    let energy = &summary.energy;
    let ratio = energy.ratio.map_or_else(String::new, |ratio| format!(", a ratio of {ratio:.3}"));
    let work = match summary.control.acting_cycles {
        0 => "All of the change is the disturbances'.".to_owned(),
        _ => format!(
            "The control torque did {:+.4} mJ of work; the rest is the disturbances'.",
            summary.control.work_j * 1e3
        ),
    };
    format!(
        "{:.4} mJ at the start, {:.4} mJ at the end{ratio}. {work}",
        energy.start_j * 1e3,
        energy.end_j * 1e3
    )
}

/// About the power.
pub fn power(summary: &Summary) -> String {
    let control = &summary.control;
    match (control.acting_cycles, control.driving_cycles) {
        (0, _) => "No control torque acted.".to_owned(),
        (_, 0) => "In no cycle did the control torque drive the tumble.".to_owned(),
        (acting, driving) => format!(
            "In {driving} of the {acting} cycles in which it acted, the control torque drove the \
             tumble, with {:.2} µW at most.",
            control.max_power_w.unwrap_or_default() * 1e6
        ),
    }
}

fn percent(fraction: f64) -> String {
    if fraction == 0.0 { "None".to_owned() } else { format!("{:.1} %", fraction * 100.0) }
}
