//! `--omm` beside `--tle`: the same orbit in another notation.

use std::fs;
use std::path::Path;

use crate::common::{Run, adcs, folder};

/// SPROUT, with its name.
const TLE: &str = "SPROUT\n\
    1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990\n\
    2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450\n";

/// The same elements; the epoch is day 86 of the year and 0.04060623 of it.
const OMM: &str = "CCSDS_OMM_VERS = 2.0
COMMENT written by hand from the two lines
CREATION_DATE = 2015-03-27T12:00:00
ORIGINATOR = TEST

OBJECT_NAME = SPROUT
OBJECT_ID = 2014-029E
CENTER_NAME = EARTH
REF_FRAME = TEME
TIME_SYSTEM = UTC
MEAN_ELEMENT_THEORY = SGP4
EPOCH = 2015-03-27T00:58:28.378272
MEAN_MOTION = 14.83565425 [rev/day]
ECCENTRICITY = .0011259
INCLINATION = 97.8670 [deg]
RA_OF_ASC_NODE = 184.0112 [deg]
ARG_OF_PERICENTER = 108.3774 [deg]
MEAN_ANOMALY = 251.8661 [deg]
EPHEMERIS_TYPE = 0
CLASSIFICATION_TYPE = U
NORAD_CAT_ID = 39770
ELEMENT_SET_NO = 999
REV_AT_EPOCH = 4545
BSTAR = .25056E-3 [1/ER]
MEAN_MOTION_DOT = .00002013 [rev/day**2]
MEAN_MOTION_DDOT = 0 [rev/day**3]
";

const PROPAGATE: [&str; 7] =
    ["propagate", "--from", "2015-03-27T02:00:00Z", "--to", "2015-03-27T08:00:00Z", "--step", "60"];
const ECLIPSE: [&str; 5] =
    ["eclipse", "--from", "2015-03-27T02:00:00Z", "--to", "2015-03-27T08:00:00Z"];

fn run(command: &[&str], more: &[&str], stdin: &str) -> Run {
    adcs(command.iter().chain(more), stdin)
}

fn write(path: &Path, text: impl AsRef<[u8]>) -> &str {
    fs::write(path, text).unwrap();
    path.to_str().unwrap()
}

#[test]
fn an_omm_and_a_tle_with_the_same_elements_give_the_same_bytes() {
    let folder = folder("omm_same");
    let (tle, omm) = (folder.join("sprout.tle"), folder.join("sprout.omm"));
    let (tle, omm) = (write(&tle, TLE), write(&omm, OMM.replace('\n', "\r\n")));
    for (command, rows) in [(&PROPAGATE[..], 361), (&ECLIPSE[..], 16)] {
        let by_tle = run(command, &["--tle", tle], "");
        assert_eq!((by_tle.code, by_tle.stderr.as_str()), (Some(0), ""));
        assert_eq!(by_tle.table().rows.len(), rows);
        let by_omm = run(command, &["--omm", omm], "");
        assert_eq!((by_omm.code, by_omm.stderr.as_str()), (Some(0), ""));
        assert_eq!(by_omm.stdout, by_tle.stdout);
        assert_eq!(run(command, &["--omm", "-"], OMM).stdout, by_tle.stdout, "standard input");
    }
}

#[test]
fn an_error_in_an_omm_is_shown_with_file_and_line() {
    let folder = folder("omm_wrong");
    for (wrong, message) in [
        (
            OMM.replace("97.8670 [deg]", "197.8670 [deg]"),
            "line 15: INCLINATION is out of range: 197.867\n  INCLINATION = 197.8670 [deg]\n",
        ),
        (
            OMM.replace("SGP4", "DSST"),
            "line 11: MEAN_ELEMENT_THEORY has to be SGP4\n  MEAN_ELEMENT_THEORY = DSST\n",
        ),
        (OMM.replace("BSTAR", "COMMENT BSTAR"), "BSTAR is missing\n"),
        (TLE.to_owned(), "line 1: neither KEY = VALUE nor a comment\n  SPROUT\n"),
        (OMM.repeat(100), "longer than 65536 bytes; a file with one OMM is wanted\n"),
    ] {
        let file = folder.join("wrong.omm");
        let file = write(&file, wrong);
        for command in [&PROPAGATE[..], &ECLIPSE[..]] {
            let run = run(command, &["--omm", file], "");
            assert_eq!((run.code, run.stdout.as_slice()), (Some(2), &b""[..]));
            assert_eq!(run.stderr, format!("error: {file}: {message}"));
        }
    }
    let absent = run(&ECLIPSE, &["--omm", folder.join("absent").to_str().unwrap()], "");
    assert_eq!(absent.code, Some(2));
    assert!(absent.stderr.contains("absent: cannot be read"), "{}", absent.stderr);
}

#[test]
fn one_orbit_is_asked_for_and_no_checksum_of_an_omm() {
    for (command, more, message) in [
        (&PROPAGATE[..], &["--omm", "a", "--tle", "b"][..], "cannot be used with"),
        (&PROPAGATE[..], &["--omm", "a", "in.csv"], "cannot be used with"),
        (&PROPAGATE[..], &["--omm", "a", "--lenient"], "cannot be used with"),
        (&PROPAGATE[..], &[], "--omm <FILE>"),
        (&["propagate"], &[], "<IN.csv>"),
        (&["propagate", "--omm", "a"], &[], "--from <UTC>"),
        (&ECLIPSE, &["--omm", "a", "--tle", "b"], "cannot be used with"),
        (&ECLIPSE, &["--omm", "a", "--lenient"], "cannot be used with"),
        (&ECLIPSE, &[], "--omm <FILE>"),
    ] {
        let run = run(command, more, "");
        assert_eq!(run.code, Some(2));
        assert!(run.stderr.contains(message), "{command:?} {more:?}: {}", run.stderr);
    }
}
