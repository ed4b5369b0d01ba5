//! The version of the program and the commit it was built from.

/// The version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Both.
pub fn with_commit() -> String {
    format!("{VERSION} ({COMMIT})")
}

/// The first twelve letters of the commit; `unknown` when built outside the repository.
pub const COMMIT: &str = match option_env!("FLOODSIM_COMMIT") {
    Some(commit) => commit,
    None => "unknown",
};
