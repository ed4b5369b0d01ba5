//! What a VRT, a file of HDF5, and the side file of a raster name: other files and code. Read before GDAL opens the file, XML with GDAL's own reader.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::hdf5;
use super::unwrapped::{Element, elements};
use crate::plain_file;

/// Bytes of a VRT, at most.
const MOST: u64 = 256 << 20;
/// In the first so many bytes a VRT says that it is one.
const BEGIN: usize = 1 << 16;

/// Elements that hold the name of a file.
const OF_FILES: [&str; 4] = ["SourceFilename", "SourceDataset", "SrcDataSource", "DEMPath"];
/// Keys of metadata that hold one.
const KEYS_OF_FILES: [&str; 3] = ["OVERVIEW_FILE", "X_DATASET", "Y_DATASET"];
/// What stands before the name of a file of which one part is meant.
const OF_PARTS: [&str; 3] = ["NETCDF:", "GPKG:", "GTIFF_DIR:"];

/// What a file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Named {
    /// A file.
    File(PathBuf),
    /// What is no file of this machine, as it stands there: a path of the network or in an archive, a database, another format in the text itself.
    Elsewhere(String),
    /// Code.
    Code,
}

/// What a VRT names, or a file of HDF5, and what the side file of a raster does; nothing where there is none.
///
/// # Errors
/// When it cannot be read, or is larger than any VRT.
pub fn named_by(path: &Path) -> std::io::Result<Vec<Named>> {
    let mut named = if is_vrt(path)? { of_xml(path)? } else { of_hdf5(path) };
    let mut side_file = path.as_os_str().to_owned();
    side_file.push(".aux.xml");
    if Path::new(&side_file).exists() {
        named.extend(of_xml(Path::new(&side_file))?);
    }
    Ok(named)
}

/// Every local file that a VRT names, and that the VRTs among those do.
pub fn sources(path: &Path) -> Vec<PathBuf> {
    let (mut found, mut seen) = (vec![path.to_owned()], BTreeSet::from([path.to_owned()]));
    let mut next = 0;
    while let Some(file) = found.get(next).cloned() {
        next += 1;
        for named in named_by(&file).unwrap_or_default() {
            if let Named::File(source) = named
                && seen.insert(source.clone())
            {
                found.push(source);
            }
        }
    }
    found.split_off(1)
}

/// Whether a file is the side file of a raster and holds statistics and histograms alone, as those do that a viewer of maps leaves behind: it
/// changes no value.
pub fn is_of_statistics(path: &Path) -> bool {
    const PLAIN: [&str; 4] = ["PAMDataset", "PAMRasterBand", "Metadata", "Histograms"];
    const OF_HISTOGRAMS: [&str; 8] =
        ["HistItem", "HistMin", "HistMax", "BucketCount", "IncludeOutOfRange", "Approximate", "HistCounts", "Overview"];
    if !path.to_string_lossy().ends_with(".aux.xml") {
        return false;
    }
    let bytes = plain_file::open(path).and_then(|file| plain_file::read_at_most(file, MOST)).unwrap_or_default();
    let of_statistics = |element: &Element| {
        let is_statistic = |(name, value): &(String, String)| name == "key" && value.starts_with("STATISTICS_");
        match element.name.as_str() {
            "MDI" => element.attributes.iter().any(is_statistic),
            name => PLAIN.contains(&name) || OF_HISTOGRAMS.contains(&name),
        }
    };
    let elements = elements(&bytes);
    !elements.is_empty() && elements.iter().all(of_statistics)
}

fn is_vrt(path: &Path) -> std::io::Result<bool> {
    use std::io::Read;
    const SIGN: &[u8] = b"<VRTDataset";
    if path.is_dir() {
        return Ok(false);
    }
    let mut begin = Vec::new();
    plain_file::open(path)?.take(BEGIN as u64).read_to_end(&mut begin)?;
    Ok(begin.windows(SIGN.len()).any(|window| window == SIGN))
}

/// The files that one of HDF5 names. It looks for them in its own folder and in that of the program.
fn of_hdf5(path: &Path) -> Vec<Named> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let names = if path.is_dir() { Vec::new() } else { hdf5::names_in(path) };
    let found = names.into_iter().flat_map(|name| {
        let here = Some(PathBuf::from(&name)).filter(|file| file.exists()).map(Named::File);
        let beside = Named::File(folder.join(name));
        here.into_iter().filter(|here| *here != beside).chain([beside.clone()]).collect::<Vec<_>>()
    });
    found.collect()
}

fn of_xml(path: &Path) -> std::io::Result<Vec<Named>> {
    let bytes = plain_file::read_at_most(plain_file::open(path)?, MOST)?;
    // GDAL, too, follows a link before it looks for what is relative to the file.
    let real = if path.is_symlink() { path.canonicalize()? } else { path.to_owned() };
    let folder = real.parent().unwrap_or(Path::new(""));
    Ok(elements(&bytes).iter().filter_map(|element| of_element(element, folder)).collect())
}

fn of_element(element: &Element, folder: &Path) -> Option<Named> {
    let Element { name, text, attributes } = element;
    let attribute = |name: &str| attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
    let is_file = OF_FILES.iter().any(|known| known.eq_ignore_ascii_case(name))
        || KEYS_OF_FILES.iter().any(|known| attribute("key") == Some(known));
    let is_option = name == "OOI" && (text.contains("/vsi") || text.contains("://"));
    match () {
        () if name == "PixelFunctionCode" => Some(Named::Code),
        () if name == "PixelFunctionLanguage" && !text.trim().eq_ignore_ascii_case("C") => Some(Named::Code),
        () if is_option => Some(Named::Elsewhere(text.clone())),
        () if is_file && !text.trim().is_empty() => {
            let is_relative = attribute("relativeToVRT").is_some_and(|value| value.trim() != "0");
            Some(file_or_elsewhere(text.trim(), if is_relative { folder } else { Path::new("") }))
        }
        () => None,
    }
}

/// The file that a text names.
fn file_or_elsewhere(text: &str, folder: &Path) -> Named {
    // GDAL writes overviews beside a file so.
    let text = text.strip_prefix(":::BASE:::").unwrap_or(text);
    let whole = folder.join(text);
    if is_elsewhere(text) {
        return Named::Elsewhere(text.to_owned());
    }
    if whole.exists() {
        return Named::File(whole);
    }
    match OF_PARTS.iter().find_map(|prefix| text.strip_prefix(prefix)) {
        Some(rest) => match part_of(rest) {
            Some(file) if !is_elsewhere(file) => Named::File(folder.join(file)),
            _ => Named::Elsewhere(text.to_owned()),
        },
        None if text.contains(':') || text.starts_with('<') => Named::Elsewhere(text.to_owned()),
        None => Named::File(whole),
    }
}

/// Whether a name is one of the network, or of GDAL's own file systems.
pub fn is_elsewhere(name: &str) -> bool {
    name.contains("/vsi") || name.contains("://")
}

/// The file of `"FILE":PART`, `FILE:PART` and `NUMBER:FILE`.
fn part_of(rest: &str) -> Option<&str> {
    if let Some(quoted) = rest.strip_prefix('"') {
        return quoted.split_once('"').map(|(file, _)| file);
    }
    let (before, after) = rest.split_once(':').unwrap_or((rest, ""));
    let is_number = !before.is_empty() && before.chars().all(|c| c.is_ascii_digit());
    Some(if is_number { after } else { before })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_of_a_vrt_is_found() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.vrt");
        let named = |inner: &str| {
            std::fs::write(&path, format!("  \n<VRTDataset>{inner}</VRTDataset>")).unwrap();
            named_by(&path).unwrap()
        };
        let file = |name: &str| Named::File(place.path().join(name));
        let elsewhere = |name: &str| Named::Elsewhere(name.to_owned());
        for (inner, expected) in [
            ("<A><SourceFilename relativeToVRT=\"1\">t.tif</SourceFilename></A>", file("t.tif")),
            ("<SourceFilename relativeToVRT='0'>/etc/passwd</SourceFilename>", Named::File("/etc/passwd".into())),
            ("<SourceFilename><![CDATA[/vsizip/a.zip/b.tif]]></SourceFilename>", elsewhere("/vsizip/a.zip/b.tif")),
            ("<SourceDataset>http://a/b.tif</SourceDataset>", elsewhere("http://a/b.tif")),
            ("<SourceFilename>&lt;VRTDataset/&gt;</SourceFilename>", elsewhere("<VRTDataset/>")),
            ("<SourceFilename>PG:dbname=a</SourceFilename>", elsewhere("PG:dbname=a")),
            ("<SourceFilename relativeToVRT=\"1\">NETCDF:\"d.nc\":z</SourceFilename>", file("d.nc")),
            ("<SourceFilename relativeToVRT=\"1\">GTIFF_DIR:2:d.tif</SourceFilename>", file("d.tif")),
            ("<SourceFilename>NETCDF:\"/vsicurl/a.nc\":z</SourceFilename>", elsewhere("NETCDF:\"/vsicurl/a.nc\":z")),
            ("<OOI key=\"A\">/vsis3/b</OOI>", elsewhere("/vsis3/b")),
            ("<Metadata><MDI key=\"OVERVIEW_FILE\">/vsicurl/b</MDI></Metadata>", elsewhere("/vsicurl/b")),
            ("<PixelFunctionLanguage>Python</PixelFunctionLanguage>", Named::Code),
        ] {
            assert_eq!(named(inner), [expected], "{inner}");
        }
        assert_eq!(named("<Metadata><MDI key=\"SOFTWARE\">https://a</MDI></Metadata><SRS>EPSG:25832</SRS>"), []);
    }
}
