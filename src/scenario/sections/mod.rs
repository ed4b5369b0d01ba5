//! The sections of a scenario. Each file declares its keys (from which come the reader, the JSON Schema and
//! `docs/scenario-format.md`), checks what must go together, resolves them to the types of `model` with every default filled in,
//! and writes them back for `scenario.resolved.yaml`. A new key is a line in a file here and a field in one of `model`.

mod boundaries;
mod breach;
mod channel;
mod channels_alone;
mod ground;
mod initial;
mod limits;
mod moving_bed;
mod numerics;
mod outputs;
mod rain;
mod resolution;
mod roughness;
mod scenario;
mod sources;
mod terrain;
#[cfg(test)]
mod tests;
mod tracers;

pub(super) use resolution::open_length;
pub use scenario::ScenarioFile;
pub(super) use scenario::fill_in;
