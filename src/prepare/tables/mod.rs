//! Tables over time: series of values, rating curves, and their times and dates.

pub mod dates;
pub mod rows;
pub mod series;
pub mod times;
