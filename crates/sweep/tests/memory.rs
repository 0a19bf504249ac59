//! The memory of a sweep does not grow with the number of its variants beyond what its documentation says. A process of its own: the
//! most memory that it took is measured.
#![cfg(target_os = "linux")]

use greenstick::geometry::Context;
use greenstick_sweep::table::{TABLE_FILE, write_table};
use greenstick_sweep::{Journal, Sweep, Worker};
use std::fs;

const VARIANTS: u64 = 1_000_000;
/// Bytes of a variant: a bit while it is made, 16 bytes while the table is written; and what the group of rows takes at a time.
const LARGEST: u64 = VARIANTS * 17 + (100 << 20);

/// The most memory that this process has taken, bytes.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    let number = line.split_whitespace().nth(1).unwrap();
    number.parse::<u64>().unwrap() << 10
}

#[test]
#[ignore = "writes 360 MB"]
fn a_table_of_a_million_rows_takes_little_memory() {
    let folder = std::env::temp_dir().join(format!("greenstick-million-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let text = format!(
        "[break]\nrings = 10\nsectors = 12\n[sweep]\ntextures = false\nfile = 'none'\nsheet = 0\nsamples = {VARIANTS}\n\
         [vary]\nmoisture = {{ between = [8, 30] }}\nhigh.height = {{ between = [0.5, 2] }}"
    );
    let sweep = Sweep::read(&text, &folder).unwrap();
    assert_eq!(sweep.count(), VARIANTS);
    let record = Worker::new(&sweep, &folder)
        .make(0, &Context::quiet())
        .unwrap();
    assert!(record.figures.is_some(), "{:?}", record.error);
    let mut journal = Journal::open(&folder, &sweep).unwrap();
    for variant in 0..VARIANTS {
        let mut record = record.clone();
        record.variant = variant;
        journal.add(&record).unwrap();
    }
    // As a sweep that is started again.
    drop(journal);
    let journal = Journal::open(&folder, &sweep).unwrap();
    assert_eq!(journal.done().count(), VARIANTS);
    write_table(&sweep, &journal, &folder, &Context::quiet()).unwrap();
    let (taken, table) = (peak(), fs::metadata(folder.join(TABLE_FILE)).unwrap().len());
    fs::remove_dir_all(&folder).unwrap();
    assert!(table > VARIANTS * 8, "{table} bytes");
    assert!(taken < LARGEST, "{} MiB", taken >> 20);
    assert!(taken < 500 << 20, "{} MiB", taken >> 20);
}
