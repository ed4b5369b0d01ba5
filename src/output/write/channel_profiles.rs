//! `channels.nc`: depth, level, velocity and discharge along all channels of one dimension over time.
//!
//! The particles of all channels, one after another, are the stations of the file; `channel_index(station)` says which channel a
//! station belongs to, `distance(station)` where it lies there. Stations of channels with a line on the map have places, too; where all
//! have, the file is a set of time series as CF describes them (discrete sampling geometries).
//!
//! As `fields.nc`, it grows during the run under another name in the classic format, flushed at every moment, and becomes a compressed
//! NetCDF-4 file at the end. The classic format has no text of its own: there the names of the channels are `flag_meanings` alone.

use std::fs;
use std::path::Path;

use netcdf::{FileMut, Options};

use super::super::channel_profile::{ChannelFrame, ChannelProfile, ChannelWater};
use super::super::folder::{RunFolder, output_error};
use super::super::grid::FILL;
use super::super::{OutputCrs, WET_DEPTH};
use super::crs::WritableCrs;
use super::netcdf_file::{Written, define_crs, put_texts, put_time_attributes, variable};
use super::read_back::ReadBack;
use super::{FileHead, Provenance};
use crate::error::Error;
use crate::math::Vec2;

const PARTIAL: &str = "channels.partial.nc";

/// Greatest number of moments and of stations in a chunk of the compressed file.
const CHUNK: usize = 512;

/// A quantity over time: name, standard name, long name, unit, comment, value.
struct Profile {
    name: &'static str,
    standard_name: &'static str,
    long_name: &'static str,
    units: &'static str,
    comment: &'static str,
    value: fn(&ChannelWater) -> f64,
}

const TOWARDS_THE_NEAR_END: &str = "positive towards the near end of the channel";

/// What the file has at every station and moment.
const PROFILES: [Profile; 4] = [
    Profile {
        name: "depth",
        standard_name: "",
        long_name: "water depth above the lowest bed of the section",
        units: "m",
        comment: "",
        value: |water| water.depth,
    },
    Profile {
        name: "water_level",
        standard_name: "water_surface_height_above_reference_datum",
        long_name: "water level above the datum of the sections",
        units: "m",
        comment: "no value where dry",
        value: |water| if water.depth > WET_DEPTH { water.level } else { f64::from(FILL) },
    },
    Profile {
        name: "velocity",
        standard_name: "",
        long_name: "mean velocity of the section",
        units: "m s-1",
        comment: TOWARDS_THE_NEAR_END,
        value: |water| water.velocity,
    },
    Profile {
        name: "discharge",
        standard_name: "water_volume_transport_in_river_channel",
        long_name: "discharge through the section",
        units: "m3 s-1",
        comment: TOWARDS_THE_NEAR_END,
        value: |water| water.discharge,
    },
];

/// What the file says besides the water.
#[derive(Clone, Debug)]
struct Description {
    profiles: Vec<ChannelProfile>,
    crs: OutputCrs,
    provenance: Provenance,
}

/// Writes the profiles of all channels while a run goes on. Dropped without [`finish`](Self::finish), it leaves
/// `channels.partial.nc`, closed and readable.
#[derive(Debug)]
pub struct ChannelsWriter {
    folder: RunFolder,
    description: Description,
    file: Written,
    moments: usize,
}

impl ChannelsWriter {
    /// Creates `channels.partial.nc`, or goes on with one that has so many moments or more.
    ///
    /// # Errors
    /// When the file cannot be created or opened.
    pub fn start(
        folder: &RunFolder,
        profiles: &[ChannelProfile],
        FileHead { crs, provenance }: FileHead<'_>,
        moments: usize,
    ) -> Result<ChannelsWriter, Error> {
        let description = Description { profiles: profiles.to_vec(), crs: crs.clone(), provenance: provenance.clone() };
        let path = folder.file(PARTIAL);
        let crs = WritableCrs::new(&description.crs, &path)?;
        let begin = || -> netcdf::Result<Written> {
            let mut file = Written::create(&path, Options::_64BIT_OFFSET)?;
            file.add_unlimited_dimension("time")?;
            description.define(&mut file, crs.as_ref(), None)?;
            file.enddef()?;
            description.write_stations(&mut file)?;
            file.sync()?;
            Ok(file)
        };
        let file = if moments > 0 { Written::append(&path) } else { begin() };
        let file = file.map_err(|cause| output_error(&path, cause))?;
        Ok(ChannelsWriter { folder: folder.clone(), description, file, moments })
    }

    /// Adds the profiles of a moment and flushes them to the disk.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn push(&mut self, frame: &ChannelFrame) -> Result<(), Error> {
        let moment = self.moments;
        let mut write = || -> netcdf::Result<()> {
            for profile in &PROFILES {
                let values: Vec<f64> = frame.water.iter().flatten().map(profile.value).collect();
                variable(&mut self.file, profile.name)?.put_values(&values, (moment, ..))?;
            }
            variable(&mut self.file, "time")?.put_value(frame.time, moment)?;
            self.file.sync()
        };
        write().map_err(|cause| output_error(&self.folder.file(PARTIAL), cause))?;
        self.moments += 1;
        Ok(())
    }

    /// Waits until all moments are on the disk, a power cut notwithstanding.
    ///
    /// # Errors
    /// When that cannot be done.
    pub fn settle(&self) -> Result<(), Error> {
        let path = self.folder.file(PARTIAL);
        fs::File::open(&path).and_then(|file| file.sync_all()).map_err(|cause| output_error(&path, cause))
    }

    /// Makes `channels.nc`; `channels.partial.nc` stays until the checkpoints that count on it are gone.
    ///
    /// # Errors
    /// When the conversion fails.
    pub fn finish(self) -> Result<(), Error> {
        let ChannelsWriter { folder, description, file, .. } = self;
        let partial = folder.file(PARTIAL);
        file.close().map_err(|cause| output_error(&partial, cause))?;
        folder.write_with("channels.nc", |path| description.convert(&partial, path))
    }
}

impl Description {
    fn stations(&self) -> usize {
        self.profiles.iter().map(|profile| profile.distance.len()).sum()
    }

    /// Whether some of the stations, and whether all of them have places on the map.
    fn have_places(&self) -> (bool, bool) {
        let has = |profile: &ChannelProfile| profile.places.is_some();
        (self.profiles.iter().any(has), self.profiles.iter().all(has))
    }

    /// Defines everything but the dimension of time; with moments and stations of a chunk the profiles are compressed.
    fn define(&self, file: &mut FileMut, crs: Option<&WritableCrs>, chunk: Option<[usize; 2]>) -> netcdf::Result<()> {
        let (some_places, all_places) = self.have_places();
        for (name, value) in self.provenance.global_attributes() {
            file.add_attribute(name, value)?;
        }
        if all_places {
            file.add_attribute("featureType", "timeSeries")?;
        }
        file.add_dimension("station", self.stations())?;
        file.add_variable::<f64>("time", &["time"])?;
        put_time_attributes(file, &self.provenance)?;
        self.define_stations(file, some_places)?;
        let crs = crs.filter(|_| some_places);
        if let Some(crs) = crs {
            define_crs(file, crs)?;
        }
        let coordinates = if some_places { "channel_index distance x y" } else { "channel_index distance" };
        for profile in &PROFILES {
            let mut variable = file.add_variable::<f64>(profile.name, &["time", "station"])?;
            if let Some(chunk) = chunk {
                variable.set_chunking(&chunk)?;
                variable.set_compression(1, true)?;
            }
            variable.put_attribute("_FillValue", f64::from(FILL))?;
            put_texts(
                &mut variable,
                &[
                    ("standard_name", profile.standard_name),
                    ("long_name", profile.long_name),
                    ("units", profile.units),
                    ("comment", profile.comment),
                    ("cell_methods", "time: point"),
                    ("coordinates", coordinates),
                    ("grid_mapping", if crs.is_some() { "crs" } else { "" }),
                ],
            )?;
        }
        Ok(())
    }

    /// Defines what a station has that does not change.
    fn define_stations(&self, file: &mut FileMut, with_places: bool) -> netcdf::Result<()> {
        let mut station = file.add_variable::<i32>("station", &["station"])?;
        station.put_attribute("long_name", "number of the particle, through all channels")?;
        if self.have_places().1 {
            station.put_attribute("cf_role", "timeseries_id")?;
        }
        let mut index = file.add_variable::<i32>("channel_index", &["station"])?;
        index.put_attribute("long_name", "channel of the station")?;
        let numbers: Vec<i32> = (0..).take(self.profiles.len()).collect();
        index.put_attribute("flag_values", numbers)?;
        let meanings: Vec<String> = self.profiles.iter().map(|profile| as_flag(&profile.id)).collect();
        index.put_attribute("flag_meanings", meanings.join(" "))?;
        let mut fixed = vec![
            ("distance", "", "distance of the station from the far end of its channel"),
            ("bed_elevation", "ground_level_altitude", "lowest bed of the section"),
        ];
        if with_places {
            fixed.push(("x", "projection_x_coordinate", "x coordinate of the station"));
            fixed.push(("y", "projection_y_coordinate", "y coordinate of the station"));
        }
        for (name, standard_name, long_name) in fixed {
            let mut variable = file.add_variable::<f64>(name, &["station"])?;
            variable.put_attribute("_FillValue", f64::NAN)?;
            put_texts(&mut variable, &[("standard_name", standard_name), ("long_name", long_name), ("units", "m")])?;
        }
        Ok(())
    }

    /// Writes what does not change; a classic file must have left its define mode.
    fn write_stations(&self, file: &mut FileMut) -> netcdf::Result<()> {
        let numbers: Vec<i32> = (0..).take(self.stations()).collect();
        variable(file, "station")?.put_values(&numbers, ..)?;
        let of_channel =
            |(number, profile): (i32, &ChannelProfile)| std::iter::repeat_n(number, profile.distance.len());
        let indices: Vec<i32> = (0..).zip(&self.profiles).flat_map(of_channel).collect();
        variable(file, "channel_index")?.put_values(&indices, ..)?;
        let distances: Vec<f64> = self.profiles.iter().flat_map(|profile| profile.distance.iter().copied()).collect();
        variable(file, "distance")?.put_values(&distances, ..)?;
        let beds: Vec<f64> = self.profiles.iter().flat_map(|profile| profile.bed.iter().copied()).collect();
        variable(file, "bed_elevation")?.put_values(&beds, ..)?;
        if self.have_places().0 {
            let nowhere = Vec2::new(f64::NAN, f64::NAN);
            let places: Vec<Vec2> = self
                .profiles
                .iter()
                .flat_map(|profile| profile.places.clone().unwrap_or_else(|| vec![nowhere; profile.distance.len()]))
                .collect();
            let (x, y): (Vec<f64>, Vec<f64>) = places.iter().map(|place| (place.x, place.y)).unzip();
            variable(file, "x")?.put_values(&x, ..)?;
            variable(file, "y")?.put_values(&y, ..)?;
        }
        if file.variable("crs").is_some() {
            variable(file, "crs")?.put_value(0_i32, ())?;
        }
        Ok(())
    }

    /// Makes the compressed file from the partial one.
    fn convert(&self, partial: &Path, path: &Path) -> Result<(), Error> {
        let crs = WritableCrs::new(&self.crs, path)?;
        let source = netcdf::open(partial).map_err(|cause| output_error(partial, cause))?;
        let copy = || -> netcdf::Result<()> {
            let moments = source.dimension_len("time").unwrap_or(0);
            let mut file = Written::create(path, Options::NETCDF4)?;
            file.add_dimension("time", moments)?;
            let chunk = [moments.clamp(1, CHUNK), self.stations().min(CHUNK)];
            self.define(&mut file, crs.as_ref(), Some(chunk))?;
            file.add_dimension("channel", self.profiles.len())?;
            let mut names = file.add_string_variable("channel_id", &["channel"])?;
            names.put_attribute("long_name", "name of the channel")?;
            for (index, profile) in self.profiles.iter().enumerate() {
                names.put_string(&profile.id, index)?;
            }
            self.write_stations(&mut file)?;
            for name in PROFILES.iter().map(|profile| profile.name).chain(["time"]) {
                let stored = source.variable(name).ok_or_else(|| netcdf::Error::NotFound(name.to_string()))?;
                variable(&mut file, name)?.put_values(&stored.get_values::<f64, _>(..)?, ..)?;
            }
            file.close()
        };
        copy().map_err(|cause| output_error(path, cause))?;
        let back = ReadBack::open(path)?;
        PROFILES.iter().map(|profile| profile.name).chain(["time"]).try_for_each(|name| {
            let stored = source.variable(name).map(|stored| stored.get_values::<f64, _>(..)).transpose();
            let stored = stored.map_err(|cause| output_error(partial, cause))?.unwrap_or_default();
            back.compare(name, .., &stored)
        })
    }
}

/// A name as a word of `flag_meanings`, which are letters, digits and a few signs between blanks.
fn as_flag(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "_-.+@".contains(c) { c } else { '_' }).collect()
}
