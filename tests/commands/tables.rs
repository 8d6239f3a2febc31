//! `history.csv` and `summary.json`.
use sinew::output::history::{Cell, Column, History, Table};
use sinew::output::summary::{FirstFailure, MaterialSummary, Status, Summary, hex};
use std::path::Path;

fn columns() -> [Column; 4] {
    [
        Column::global("time", "s"),
        Column::of("tissue", "mean_velocity_x", "m_s"),
        Column::of("tissue", "failed_total", ""),
        Column::global("limit", ""),
    ]
}

#[test]
fn a_row_reads_back_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path, &columns()).unwrap();
    let third = 1.0 / 3.0;
    history.row(&[1.25e-7.into(), (-third).into(), 12u64.into(), "sound, \"lead\"".into()]).unwrap();
    history.row(&[0.5.into(), f64::NAN.into(), 0u64.into(), Cell::Text("end")]).unwrap();
    // On the disk before the writer is gone.
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], "time_s,tissue.mean_velocity_x_m_s,tissue.failed_total,limit");
    assert_eq!(lines[1], "1.25e-7,-0.3333333333333333,12,\"sound, \"\"lead\"\"\"");
    assert_eq!(lines[2], "0.5,,0,end");
    assert_eq!(lines[1].split(',').nth(1).unwrap().parse(), Ok(-third));
    let table = Table::read(&path).unwrap();
    assert_eq!(table.rows[0][3], "sound, \"lead\"");
    let velocity = table.column("tissue.mean_velocity_x_m_s").unwrap();
    assert!(velocity[0] == -third && velocity[1].is_nan() && table.column("nothing").is_none());
    // half a row, of a run that was killed, is passed over
    std::fs::write(&path, format!("{text}0.75,1,2,h")).unwrap();
    assert_eq!(Table::read(&path).unwrap(), table);

    drop(history);
    let mut history = History::resume(&path, &columns(), 0.1).unwrap();
    history.row(&[0.2.into(), 1.0.into(), 3u64.into(), "end".into()]).unwrap();
    let resumed = std::fs::read_to_string(&path).unwrap();
    assert_eq!(resumed.lines().collect::<Vec<_>>(), [lines[0], lines[1], "0.2,1,3,end"]);
}

#[test]
fn a_full_disk_is_an_error() {
    let full = Path::new("/dev/full");
    if full.exists() {
        let message = History::create(full, &columns()).unwrap_err().to_string();
        assert!(message.contains("/dev/full") && message.contains("free some space"), "{message}");
    }
    let message = History::create(Path::new("/no/history.csv"), &columns()).unwrap_err().to_string();
    assert!(message.contains("/no/history.csv") && message.contains("is not there"), "{message}");
}

#[test]
fn a_summary_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("summary.json");
    let mut summary =
        Summary { status: Status::Completed, steps: 7, time_s: 1.0 / 3.0, ..Summary::default() };
    summary.state_hash = hex(0xff);
    summary.patches = [2, 1, 3];
    let failure = FirstFailure { time_s: 1e-5, position_m: [0.1, 0.2, 0.3], particle: 1 << 60 };
    summary.first_failure.insert("matrix".into(), failure);
    let tissue = MaterialSummary { mean_velocity_m_s: [0.0, -50.0, 1e-300], ..MaterialSummary::default() };
    summary.materials.insert("tissue".into(), tissue);
    summary.more.insert("rates".into(), serde_json::json!({ "lead": 16 }));
    summary.write(&path).unwrap();
    summary.write(&path).unwrap();
    assert_eq!(Summary::read(&path).unwrap(), summary);

    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"status\": \"completed\"") && text.contains("\"00000000000000ff\""), "{text}");
    assert!(text.find("\"status\"") < text.find("\"steps\""));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left aside");
}

#[test]
fn a_summary_that_cannot_be_written_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("summary.json");
    Summary::default().write(&path).unwrap();
    std::fs::create_dir(folder.path().join("summary.json.part")).unwrap();
    let message = Summary { steps: 9, ..Summary::default() }.write(&path).unwrap_err().to_string();
    assert!(message.contains("summary.json"), "{message}");
    assert_eq!(Summary::read(&path).unwrap().steps, 0);

    std::fs::write(&path, "{}").unwrap();
    assert!(Summary::read(&path).unwrap_err().to_string().contains("not a summary"));
}
