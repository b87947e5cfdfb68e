//! What holds for any input.

mod common;

use common::with_checksum;
use proptest::prelude::*;
use sgp4_lite::{
    Classification, Elements, Epoch, InternationalDesignator, MinutesSinceEpoch,
    PlausibilityLimits, Propagator, check_plausibility,
};

/// The integers that a TLE prints; elements follow from them without a parser.
#[derive(Debug, Clone)]
struct Printed {
    norad_id: u32,
    designator: [u8; 8],
    year: u16,
    day: u16,
    day_e8: i64,
    dot_e8: i32,
    ddot: (i32, i32),
    bstar: (i32, i32),
    inclination_e4: u32,
    raan_e4: u32,
    eccentricity_e7: u32,
    perigee_e4: u32,
    anomaly_e4: u32,
    mean_motion_e8: u64,
    set_number: u16,
    revolution: u32,
}

fn printed() -> impl Strategy<Value = Printed> {
    let exponential = || (-99_999..=99_999, -9..=9);
    let designator = prop_oneof![
        Just(*b"        "),
        "[0-9]{5}[A-Z]{1,3}".prop_map(|text| {
            let mut columns = [b' '; 8];
            columns[..text.len()].copy_from_slice(text.as_bytes());
            columns
        }),
    ];
    let names = (0..340_000_u32, designator);
    let epoch = (1957..=2056_u16, 1..=365_u16, 0..100_000_000_i64);
    let drag = (-99_999_999..=99_999_999, exponential(), exponential());
    let plane = (0..=1_800_000_u32, 0..=3_600_000_u32, 0..=9_999_999_u32);
    let motion = (0..=3_600_000_u32, 0..=3_600_000_u32, 1..=1_800_000_000_u64);
    let counters = (0..=9999_u16, 0..=99_999_u32);
    (names, epoch, drag, plane, motion, counters).prop_map(
        |(names, epoch, drag, plane, motion, counters)| Printed {
            norad_id: names.0,
            designator: names.1,
            year: epoch.0,
            day: epoch.1,
            day_e8: epoch.2,
            dot_e8: drag.0,
            ddot: drag.1,
            bstar: drag.2,
            inclination_e4: plane.0,
            raan_e4: plane.1,
            eccentricity_e7: plane.2,
            perigee_e4: motion.0,
            anomaly_e4: motion.1,
            mean_motion_e8: motion.2,
            set_number: counters.0,
            revolution: counters.1,
        },
    )
}

/// A number as the standard library reads its decimal form.
fn decimal(digits: impl std::fmt::Display, exponent: i32) -> f64 {
    format!("{digits}e{exponent}").parse().unwrap()
}

impl Printed {
    fn elements(&self) -> Elements {
        Elements {
            norad_id: self.norad_id,
            classification: Classification::Secret,
            international_designator: InternationalDesignator::from_columns(self.designator)
                .unwrap(),
            epoch: Epoch::from_day_of_year(self.year, self.day, self.day_e8 * 864).unwrap(),
            mean_motion_dot_over_2_rev_per_day2: decimal(self.dot_e8, -8),
            mean_motion_ddot_over_6_rev_per_day3: decimal(self.ddot.0, self.ddot.1 - 5),
            bstar_per_earth_radius: decimal(self.bstar.0, self.bstar.1 - 5),
            inclination_deg: decimal(self.inclination_e4, -4),
            raan_deg: decimal(self.raan_e4, -4),
            eccentricity: decimal(self.eccentricity_e7, -7),
            argument_of_perigee_deg: decimal(self.perigee_e4, -4),
            mean_anomaly_deg: decimal(self.anomaly_e4, -4),
            mean_motion_rev_per_day: decimal(self.mean_motion_e8, -8),
            element_set_number: self.set_number,
            revolution_number: self.revolution,
        }
    }

    fn tle(&self) -> [String; 2] {
        let number = match self.norad_id {
            plain @ ..100_000 => format!("{plain:5}"),
            alpha5 => {
                let letters = b"ABCDEFGHJKLMNPQRSTUVWXYZ";
                let letter = char::from(letters[alpha5 as usize / 10_000 - 10]);
                format!("{letter}{:04}", alpha5 % 10_000)
            }
        };
        let sign = |value: i32| if value < 0 { '-' } else { ' ' };
        let exponential = |(digits, exponent): (i32, i32)| {
            format!("{}{:05}{exponent:+}", sign(digits), digits.abs())
        };
        let angle = |e4: u32| format!("{:3}.{:04}", e4 / 10_000, e4 % 10_000);
        let line1 = format!(
            "1 {number}S {} {:02}{:3}.{:08} {}.{:08} {} {} 0 {:4}",
            std::str::from_utf8(&self.designator).unwrap(),
            self.year % 100,
            self.day,
            self.day_e8,
            sign(self.dot_e8),
            self.dot_e8.abs(),
            exponential(self.ddot),
            exponential(self.bstar),
            self.set_number
        );
        let line2 = format!(
            "2 {number} {} {} {:07} {} {} {:2}.{:08}{:5}",
            angle(self.inclination_e4),
            angle(self.raan_e4),
            self.eccentricity_e7,
            angle(self.perigee_e4),
            angle(self.anomaly_e4),
            self.mean_motion_e8 / 100_000_000,
            self.mean_motion_e8 % 100_000_000,
            self.revolution
        );
        [with_checksum(&line1), with_checksum(&line2)]
    }

    fn omm(&self) -> String {
        let elements = self.elements();
        let designator = match elements.international_designator.as_str() {
            "" => "UNKNOWN".to_owned(),
            text => {
                let century = if &text[..2] < "57" { 20 } else { 19 };
                format!("{century}{}-{}", &text[..2], &text[2..])
            }
        };
        let micros = elements.epoch.micros_of_day();
        let seconds = micros / 1_000_000;
        format!(
            "CCSDS_OMM_VERS = 2.0\nOBJECT_ID = {designator}\nCENTER_NAME = EARTH\n\
             REF_FRAME = TEME\nTIME_SYSTEM = UTC\nMEAN_ELEMENT_THEORY = SGP4\n\
             EPOCH = {}-{:03}T{:02}:{:02}:{:02}.{:06}\nMEAN_MOTION = {:?}\nECCENTRICITY = {:?}\n\
             INCLINATION = {:?}\nRA_OF_ASC_NODE = {:?}\nARG_OF_PERICENTER = {:?}\n\
             MEAN_ANOMALY = {:?}\nCLASSIFICATION_TYPE = S\nNORAD_CAT_ID = {}\n\
             ELEMENT_SET_NO = {}\nREV_AT_EPOCH = {}\nBSTAR = {:?}\nMEAN_MOTION_DOT = {:?}\n\
             MEAN_MOTION_DDOT = {:?}\n",
            self.year,
            self.day,
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60,
            micros % 1_000_000,
            elements.mean_motion_rev_per_day,
            elements.eccentricity,
            elements.inclination_deg,
            elements.raan_deg,
            elements.argument_of_perigee_deg,
            elements.mean_anomaly_deg,
            elements.norad_id,
            elements.element_set_number,
            elements.revolution_number,
            elements.bstar_per_earth_radius,
            elements.mean_motion_dot_over_2_rev_per_day2,
            elements.mean_motion_ddot_over_6_rev_per_day3,
        )
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_tle_that_can_be_printed_is_read_exactly(printed in printed()) {
        let [line1, line2] = printed.tle();
        prop_assert_eq!(Elements::from_tle(&line1, &line2), Ok(printed.elements()));
        let text = format!("0 NAME\r\n{line1}\r\n{line2}\r\n");
        prop_assert_eq!(Elements::from_tle_text(text), Ok(printed.elements()));
    }

    #[test]
    fn every_omm_with_the_same_elements_is_read_exactly(printed in printed()) {
        prop_assert_eq!(Elements::from_omm(printed.omm()), Ok(printed.elements()));
    }

    #[test]
    fn any_orbit_at_any_time_has_a_finite_state_above_the_surface_or_an_error(
        printed in printed(),
        minutes in prop_oneof![-1e5..1e5, any::<f64>()],
    ) {
        if let Ok(propagator) = Propagator::new(&printed.elements())
            && let Ok(state) = propagator.propagate(MinutesSinceEpoch(minutes))
        {
            let [x, y, z] = state.position_km;
            let radius_km = (x * x + y * y + z * z).sqrt();
            prop_assert!(radius_km.is_finite() && radius_km > 6378.1, "{} km", radius_km);
            prop_assert!(state.velocity_km_s.into_iter().all(f64::is_finite));
        }
    }

    #[test]
    fn hand_made_elements_never_panic(
        values in any::<[f64; 9]>(),
        days in any::<i32>(),
        micros in any::<i64>(),
    ) {
        let elements = Elements {
            epoch: Epoch::from_days(days, micros).unwrap_or(Epoch::J2000_MIDNIGHT),
            bstar_per_earth_radius: values[0],
            inclination_deg: values[1],
            raan_deg: values[2],
            eccentricity: values[3],
            argument_of_perigee_deg: values[4],
            mean_anomaly_deg: values[5],
            mean_motion_rev_per_day: values[6],
            ..common::satellites(common::LEO_TLE)[0].elements
        };
        let _ = check_plausibility(&elements, values[7], &PlausibilityLimits::within_days(values[8]));
        if let Ok(propagator) = Propagator::new(&elements) {
            let _ = propagator.propagate(MinutesSinceEpoch(values[7]));
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in any::<Vec<u8>>(), at in any::<usize>()) {
        let _ = Elements::from_tle_text(&bytes);
        let _ = Elements::from_omm(&bytes);
        let (line1, line2) = bytes.split_at(at % (bytes.len() + 1));
        let _ = Elements::from_tle(line1, line2);
    }

    #[test]
    fn spoilt_texts_are_read_or_refused(
        printed in printed(),
        spoils in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
    ) {
        let [line1, line2] = printed.tle();
        for mut text in [format!("{line1}\n{line2}").into_bytes(), printed.omm().into_bytes()] {
            for (index, byte) in &spoils {
                let index = index.index(text.len());
                text[index] = *byte;
            }
            let _ = Elements::from_tle_text(&text);
            let _ = Elements::from_omm(&text);
        }
    }
}
