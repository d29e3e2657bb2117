//! Standard output that may be gone: `fissure run … | head` and a full disk must not end a week of work, and
//! `println!` panics there.

/// As `println!`; what nobody can hear is lost.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($part)*);
    }};
}

/// As `eprintln!`; what nobody can hear is lost.
macro_rules! complain {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

pub(crate) use {complain, say};

/// `1 frame`, `2 frames`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
