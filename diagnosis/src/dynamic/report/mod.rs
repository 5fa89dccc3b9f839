//! The report of a dynamic recording: one self-contained HTML page, in the design of the static one.
