use super::*;

fn default() -> (Recording, Sensor) {
    let (recording, mirror) = crate::default_recording().unwrap();
    (recording, mirror.sensor)
}

#[test]
fn a_clean_recording_loses_nothing() {
    let (recording, sensor) = default();
    let screened = screen(&recording, &sensor).unwrap();
    assert_eq!(screened.bad_rows, []);
    assert_eq!(screened.recording, recording);
    assert!(screened.notes.is_empty(), "{:?}", screened.notes);
}
