//! `record` and `excite` from outside: files, messages and exit codes.

mod moving;
mod still;
