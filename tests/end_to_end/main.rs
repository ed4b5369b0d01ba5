//! The program as its users meet it: files in, messages, exit codes and files out.

mod bad_scenarios;
mod commands;
