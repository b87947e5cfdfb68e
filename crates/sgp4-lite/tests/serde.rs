//! Elements and epochs in `serde` formats.
#![cfg(feature = "serde")]

mod common;

use common::GOOD;
use sgp4_lite::{Elements, Epoch, InternationalDesignator};

#[test]
fn elements_come_back_from_json_as_they_went() {
    let elements = Elements::from_tle(GOOD[0], GOOD[1]).unwrap();
    let json = serde_json::to_string(&elements).unwrap();
    assert!(json.contains(r#""international_designator":"24001BC""#), "{json}");
    assert!(json.contains(r#""inclination_deg":98.325"#), "{json}");
    assert_eq!(serde_json::from_str::<Elements>(&json).unwrap(), elements);
}

#[test]
fn values_that_no_constructor_makes_are_refused() {
    let epoch = |text: &str| serde_json::from_str::<Epoch>(text);
    assert!(epoch(r#"{"days_since_j2000_midnight":0,"micros_of_day":86399999999}"#).is_ok());
    assert!(epoch(r#"{"days_since_j2000_midnight":0,"micros_of_day":86400000000}"#).is_err());
    assert!(epoch(r#"{"days_since_j2000_midnight":99999999,"micros_of_day":0}"#).is_err());
    let designator = |text: &str| serde_json::from_str::<InternationalDesignator>(text);
    assert_eq!(designator(r#""""#).unwrap(), InternationalDesignator::BLANK);
    assert!(designator(r#""98067A""#).is_ok());
    assert!(designator(r#""98067ABCD""#).is_err());
    assert!(designator(r#""98067 A""#).is_err());
}
