use super::*;
use std::os::unix::fs::{FileTypeExt, symlink};

fn write_text(path: &Path) -> Result<(), OutputError> {
    write_whole(path, |file| file.write_all(b"text"))
}

#[test]
fn a_device_and_a_pipe_are_written_to_and_stay() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read_to_string(pipe).unwrap()
    });
    write_text(&pipe).unwrap();
    assert_eq!(reader.join().unwrap(), "text");
    assert!(std::fs::metadata(&pipe).unwrap().file_type().is_fifo());
    assert!(matches!(write_text(Path::new("/dev/full")), Err(OutputError::Unwritable { .. })));
    assert!(std::fs::metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[test]
fn a_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    std::fs::write(&file, "before").unwrap();
    symlink(&file, &link).unwrap();
    write_text(&link).unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "text");
}

/// A folder that is being made must not pass for one that a dead program left.
#[test]
fn many_write_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let write = |thread: usize| {
        (0..200).for_each(|k| write_text(&folder.path().join(format!("{thread}-{k}"))).unwrap());
    };
    std::thread::scope(|scope| (0..8).for_each(|thread| drop(scope.spawn(move || write(thread)))));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1600);
}
