//! The image on the emulated STM32F405: boots, refuses nonsense, and dies properly.
//!
//! `cargo xtask test` builds the image, names it in `ADCS_IMAGE` and the emulator in `ADCS_QEMU`.

use std::{
    env,
    process::{Command, Stdio},
};

struct Run {
    code: Option<i32>,
    text: String,
}

/// Runs the image with a command line.
fn run(words: &[&str]) -> Run {
    let image = env::var_os("ADCS_IMAGE").expect("no image is named: use `cargo xtask test`");
    let emulator = env::var_os("ADCS_QEMU").unwrap_or_else(|| "qemu-system-arm".into());
    let words: String = words.iter().map(|word| format!(",arg={word}")).collect();
    let output = Command::new(emulator)
        .args(["-machine", "netduinoplus2", "-nographic", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", &format!("enable=on,target=native,arg=adcs{words}")])
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .output()
        .expect("the emulator starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    Run { code: output.status.code(), text }
}

/// Dies in the way `word` asks for, with the torquers on, and gives what the next boot reports.
fn epitaph(word: &str) -> String {
    let Run { code, text } = run(&[word]);
    assert_eq!(code, Some(101), "{text}");
    assert!(
        text.contains("torquer duties [1000, 2000, 3000] -> [0, 0, 0]"),
        "the torquers were on and must be off: {text}"
    );
    assert!(text.contains("death 1 since power-on"), "{text}");
    text
}

/// The version of scenarios that the image says it flies.
fn scenario_version() -> u8 {
    let text = run(&["version"]).text;
    let (_, after) = text.split_once(" scenario ").expect(&text);
    let number = after.split_whitespace().next().expect("a number behind it");
    number.parse().expect("a number")
}

#[test]
fn the_image_boots_and_says_what_it_is() {
    let Run { code, text } = run(&["version"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(concat!("adcs-firmware ", env!("CARGO_PKG_VERSION"))), "{text}");
}

#[test]
fn a_panic_leaves_its_place_and_message_and_dead_torquers() {
    let text = epitaph("panic");
    assert!(text.contains("epitaph: panic at crates/adcs-firmware/src/rehearsal.rs:"), "{text}");
    assert!(text.contains("asked to panic"), "{text}");
}

#[test]
fn a_fault_leaves_its_address_and_dead_torquers() {
    let text = epitaph("fault");
    assert!(text.contains("epitaph: fault: precise data bus error"), "{text}");
    assert!(text.contains("address 0xb0000000"), "{text}");
}

#[test]
fn a_stack_overflow_leaves_an_epitaph_and_dead_torquers() {
    let text = epitaph("overflow");
    assert!(text.contains("epitaph: stack overflow"), "{text}");
}

#[test]
fn wrong_command_lines_are_refused() {
    for words in [&["bogus"][..], &[], &["fly"], &["fly", "one"], &["fly", "1", "2", "3"]] {
        let Run { code, text } = run(words);
        assert_eq!(code, Some(2), "{words:?}: {text}");
        assert!(text.starts_with("error: "), "{words:?}: {text}");
    }
}

#[test]
fn a_scenario_that_is_missing_or_none_is_refused() {
    let folder = env::temp_dir().join(format!("adcs-emulated-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = |name: &str| folder.join(name).display().to_string();
    std::fs::write(path("empty"), []).unwrap();
    // The version that this image flies, and nothing behind it.
    std::fs::write(path("short"), [scenario_version()]).unwrap();
    std::fs::write(path("other"), [99, 1, 2, 3]).unwrap();
    std::fs::write(path("long"), vec![1; 10_000]).unwrap();
    let records = path("records");
    for (name, reason) in [
        ("missing", "cannot be opened"),
        ("empty", "not a scenario"),
        ("short", "not a scenario"),
        ("other", "version 99"),
        ("long", "longer than"),
    ] {
        let Run { code, text } = run(&["fly", &path(name), &records]);
        assert_eq!(code, Some(1), "{name}: {text}");
        assert!(text.contains("error: ") && text.contains(reason), "{name}: {text}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
