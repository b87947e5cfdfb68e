//! Where tables come from and go to.

use std::fs;
use std::io::Read as _;
use std::process::{Command, Stdio};

use crate::common::{adcs, folder};

const TABLE: &str = "utc_iso\n2015-03-27T02:00:00Z\n";

#[test]
fn files_and_pipes_give_the_same_table() {
    let folder = folder("files_and_pipes");
    let (input, output) = (folder.join("in.csv"), folder.join("out.csv"));
    fs::write(&input, TABLE).unwrap();
    let piped = adcs(["sun", "-"], TABLE).stdout;
    let run = adcs(["sun", input.to_str().unwrap(), "-o", output.to_str().unwrap()], "");
    assert_eq!((run.code, run.stdout.len(), run.stderr.as_str()), (Some(0), 0, ""));
    assert_eq!(fs::read(&output).unwrap(), piped);
    assert_eq!(adcs(["sun", input.to_str().unwrap(), "-o", "-"], "").stdout, piped);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "no partial file is left");
}

#[test]
fn a_table_may_be_written_over_itself() {
    let folder = folder("over_itself");
    let file = folder.join("table.csv");
    fs::write(&file, TABLE).unwrap();
    let name = file.to_str().unwrap();
    assert_eq!(adcs(["sun", name, "-o", name], "").code, Some(0));
    assert_eq!(fs::read(&file).unwrap(), adcs(["sun", "-"], TABLE).stdout);
}

#[test]
fn an_older_output_stays_when_the_input_is_no_table() {
    let folder = folder("older_output");
    let output = folder.join("out.csv");
    fs::write(&output, "older").unwrap();
    let run = adcs(["sun", "-", "-o", output.to_str().unwrap()], "no,table\n");
    assert_eq!(run.code, Some(2));
    assert_eq!(fs::read(&output).unwrap(), b"older");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn rows_are_rescued_from_a_partial_file_without_losing_it() {
    let folder = folder("partial");
    let partial = folder.join("out.csv.partial");
    fs::write(&partial, TABLE).unwrap();
    let output = folder.join("out.csv");
    let run = adcs(["sun", partial.to_str().unwrap(), "-o", output.to_str().unwrap()], "");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("would be overwritten"), "{}", run.stderr);
    assert_eq!(fs::read_to_string(&partial).unwrap(), TABLE);
}

#[test]
fn files_that_cannot_be_read_or_written_are_named() {
    let folder = folder("unreadable");
    let name = folder.to_str().unwrap();
    for (arguments, reason) in [
        (["sun", "/nonexistent/in.csv", "-o", "-"], "/nonexistent/in.csv: cannot be read"),
        (["sun", name, "-o", "-"], "cannot be read: is a directory"),
        (["sun", "-", "-o", "/nonexistent/out.csv"], "/nonexistent/out.csv: cannot be written"),
        (["sun", "-", "-o", name], "cannot be written"),
    ] {
        let run = adcs(arguments, TABLE);
        assert_eq!(run.code, Some(2), "{arguments:?}");
        assert!(run.stderr.contains(reason), "{}", run.stderr);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    for arguments in [
        &["sun", "-", "-o", "/dev/full"][..],
        &[
            "eclipse",
            "--tle",
            "-",
            "-o",
            "/dev/full",
            "--from",
            "2015-03-27T02:00:00Z",
            "--to",
            "2015-03-27T03:00:00Z",
        ],
    ] {
        let input = if arguments[0] == "sun" {
            TABLE
        } else {
            "1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990\n\
             2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450\n"
        };
        let run = adcs(arguments, input);
        assert_eq!(run.code, Some(2));
        assert!(run.stderr.contains("/dev/full: cannot be written"), "{}", run.stderr);
    }
}

#[test]
fn a_reader_that_has_had_enough_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_adcs"))
        .args(["sun", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // More than fits into pipes and buffers.
    let table = TABLE.to_owned() + &"2015-03-27T02:00:00Z\n".repeat(20_000);
    let mut input = child.stdin.take().unwrap();
    let writer =
        std::thread::spawn(move || std::io::Write::write_all(&mut input, table.as_bytes()));
    let mut first = [0; 7];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    assert_eq!(&first, b"utc_iso");
    let output = child.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}
