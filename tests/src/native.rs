//! The generated sources, compiled to shared objects and called on many inputs at once.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use codegen::certificate::Entry;
use codegen::options::OutOfRange;
use libloading::Library;

use crate::inputs::Words;
use crate::toolchain::C_FLAGS;

/// What a routine gave for one input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Given {
    /// The bits of the result.
    pub bits: u32,
    /// Whether the reading was said to lie inside the range; always, where the routine does not flag.
    pub inside: bool,
}

/// A loaded routine.
pub struct Native {
    library: Library,
    // Holds the shared object while it is loaded; dropped after the library.
    _folder: tempfile::TempDir,
}

type Batch = unsafe extern "C" fn(usize, *const u32, *const u32, *mut u32, *mut u8);

impl Native {
    /// Compiles the C of a generation with `compiler`, every warning an error, and loads the routine of `entry`.
    ///
    /// # Panics
    /// Where the sources do not compile: that is what is tested.
    pub fn c(files: &BTreeMap<PathBuf, String>, entry: &Entry, flags: OutOfRange, compiler: &str) -> Native {
        let folder = unpacked(files);
        let object = folder.path().join("routine.o");
        let source = only(files, "c");
        run(Command::new(compiler)
            .args(C_FLAGS)
            .args(["-O2", "-fPIC", "-c", "-o"])
            .arg(&object)
            .arg(folder.path().join(&source)));
        let library = folder.path().join("routine.so");
        let header = source.with_extension("h");
        let header = header.file_name().unwrap_or_default().to_string_lossy().into_owned();
        run(Command::new(compiler)
            .args(C_FLAGS)
            .args(["-O2", "-fPIC", "-shared", "-o"])
            .arg(&library)
            .arg(format!("-DHEADER=\"{header}\""))
            .arg(format!("-DROUTINE={}", entry.routine))
            .arg(format!("-DARGUMENT={}", c_type(&entry.input[0].ty)))
            .arg(format!("-DARGUMENTS={}", entry.input.len()))
            .arg(format!("-DRESULT={}", c_type(&entry.output.ty)))
            .arg(format!("-DFLAG={}", u8::from(flags == OutOfRange::Flag)))
            .arg("-I")
            .arg(folder.path().join("c"))
            .arg(shim("batch.c"))
            .arg(&object));
        Native::load(folder, &library)
    }

    /// Compiles the Rust crate of a generation, warnings being errors, and loads the routine of `entry`.
    ///
    /// # Panics
    /// As [`Native::c`].
    pub fn rust(files: &BTreeMap<PathBuf, String>, entry: &Entry) -> Native {
        let folder = unpacked(files);
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let common = ["--edition=2021", "-Copt-level=2", "-Dwarnings"];
        run(Command::new(&rustc)
            .args(common)
            .args(["--crate-type=rlib", "--crate-name=angle", "--out-dir"])
            .arg(folder.path())
            .arg(folder.path().join("src/lib.rs")));
        let text = fs::read_to_string(shim("batch.rs")).unwrap_or_default();
        let caller = folder.path().join("batch.rs");
        fs::write(&caller, text.replace("angle::ROUTINE", &format!("angle::{}", entry.routine)))
            .unwrap_or_else(|e| panic!("{}: {e}", caller.display()));
        let library = folder.path().join("routine.so");
        run(Command::new(&rustc)
            .args(common)
            .args(["--crate-type=cdylib", "--crate-name=batch", "-o"])
            .arg(&library)
            .arg(format!("--extern=angle={}", folder.path().join("libangle.rlib").display()))
            .arg(&caller));
        Native::load(folder, &library)
    }

    fn load(folder: tempfile::TempDir, library: &Path) -> Native {
        // SAFETY: the library was compiled just now from this project's sources and runs nothing on loading.
        let library = unsafe { Library::new(library) }.unwrap_or_else(|e| panic!("{e}"));
        Native { library, _folder: folder }
    }

    /// Calls the routine on every input.
    ///
    /// # Panics
    /// Where the shim is not in the library.
    pub fn run(&self, inputs: &[Words]) -> Vec<Given> {
        let first: Vec<u32> = inputs.iter().map(|words| words[0]).collect();
        let second: Vec<u32> = inputs.iter().map(|words| words[1]).collect();
        let mut result = vec![0u32; inputs.len()];
        let mut inside = vec![0u8; inputs.len()];
        // SAFETY: `batch` of tests/shim has this signature, and every slice has `inputs.len()` elements.
        unsafe {
            let batch = self
                .library
                .get::<Batch>(b"batch\0")
                .unwrap_or_else(|e| panic!("the shim has no batch: {e}"));
            batch(inputs.len(), first.as_ptr(), second.as_ptr(), result.as_mut_ptr(), inside.as_mut_ptr());
        }
        result.into_iter().zip(inside).map(|(bits, inside)| Given { bits, inside: inside == 1 }).collect()
    }
}

/// A type in C's words.
fn c_type(rust: &str) -> &'static str {
    match rust {
        "u16" => "uint16_t",
        "u32" => "uint32_t",
        "i32" => "int32_t",
        "f32" => "float",
        other => panic!("{other} is no type of a routine"),
    }
}

fn shim(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("shim").join(name)
}

/// The one file with this extension.
fn only(files: &BTreeMap<PathBuf, String>, extension: &str) -> PathBuf {
    let mut found = files.keys().filter(|path| path.extension().is_some_and(|e| e == extension));
    match (found.next(), found.next()) {
        (Some(path), None) => path.clone(),
        _ => panic!("expected one .{extension} file among {:?}", files.keys()),
    }
}

/// A folder that holds the files.
pub fn unpacked(files: &BTreeMap<PathBuf, String>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("no temporary folder: {e}"));
    codegen::files::write(folder.path(), files).unwrap_or_else(|e| panic!("{e}"));
    folder
}

/// Runs a compiler; what it complains about is the test's failure.
fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{command:?}:\n{text}");
}
