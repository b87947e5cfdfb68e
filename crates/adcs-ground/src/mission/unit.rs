//! The units that stand at the end of keys.

/// Endings of keys and what they mean. Those that no key of ours ends in are here so that a value
/// in another unit is recognised as such.
const UNITS: &[(&str, &str)] = &[
    ("kg_m2", "kg·m²"),
    ("kg_cm2", "kg·cm²"),
    ("kg_mm2", "kg·mm²"),
    ("g_cm2", "g·cm²"),
    ("g_mm2", "g·mm²"),
    ("kg_m3", "kg/m³"),
    ("g_cm3", "g/cm³"),
    ("kg", "kilogram"),
    ("g", "gram"),
    ("m", "metre"),
    ("cm", "centimetre"),
    ("mm", "millimetre"),
    ("km", "kilometre"),
    ("h", "hours"),
    ("min", "minutes"),
    ("s", "seconds"),
    ("ms", "milliseconds"),
    ("us", "microseconds"),
    ("deg", "degrees"),
    ("rad", "radians"),
    ("deg_s", "degrees per second"),
    ("rad_s", "radians per second"),
    ("rpm", "revolutions per minute"),
    ("t", "tesla"),
    ("ut", "microtesla"),
    ("nt", "nanotesla"),
    ("gauss", "gauss"),
    ("am2", "A·m²"),
    ("mam2", "mA·m²"),
    ("am2_s_per_t", "A·m²·s/T"),
    ("am2_s_per_nt", "A·m²·s/nT"),
    ("n_m_s", "N·m·s"),
    ("n_m", "N·m"),
    ("deg_s_per_sqrt_s", "degrees per second per square root of a second"),
    ("um", "micrometre"),
    ("ma", "milliampere"),
    ("ua", "microampere"),
    ("na", "nanoampere"),
    ("ohm", "ohm"),
    ("kohm", "kiloohm"),
    ("v", "volt"),
    ("mv", "millivolt"),
    ("nt_per_v", "nanotesla per volt"),
    ("ut_per_v", "microtesla per volt"),
    ("v_per_t", "volt per tesla"),
    ("mv_per_deg_s", "millivolt per degree per second"),
    ("v_per_rad_s", "volt per radian per second"),
    ("codes", "converter codes"),
];

/// A key as what it measures and the meaning of its unit, if it ends in one.
pub(super) fn split(key: &str) -> (&str, Option<&'static str>) {
    UNITS
        .iter()
        .filter_map(|(ending, meaning)| {
            let stem = key.strip_suffix(ending)?.strip_suffix('_')?;
            Some((stem, Some(*meaning)))
        })
        // The longest ending: of `rate_deg_s` that is `deg_s`, not `s`.
        .min_by_key(|(stem, _)| stem.len())
        .unwrap_or((key, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_unit_counts() {
        assert_eq!(split("rate_deg_s"), ("rate", Some("degrees per second")));
        assert_eq!(split("gain_am2_s_per_t"), ("gain", Some("A·m²·s/T")));
        assert_eq!(split("inertia_kg_m2"), ("inertia", Some("kg·m²")));
        assert_eq!(split("title"), ("title", None));
    }
}
