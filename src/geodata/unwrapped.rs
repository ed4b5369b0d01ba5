//! GDAL functions that the gdal crate does not wrap: warping by `gdalwarp` arguments, the horizontal part of a CRS,
//! what a band of a picture is for, the files of a dataset, and its reader of XML.
#![expect(
    unsafe_code,
    reason = "these functions have no safe wrapper in the gdal crate, and that of the colour panics at new ones"
)]

use std::cell::RefCell;
use std::ffi::{CStr, CString, OsStr, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;

use gdal::Dataset;
use gdal::raster::RasterBand;
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};

/// Warps a raster with the arguments of the `gdalwarp` program into a new raster in memory.
///
/// # Errors
/// GDAL's reason, as far as it gives one; the rest goes to [`super::capture`].
pub fn warp_to_memory(source: &Dataset, arguments: &[&str]) -> Result<Dataset, String> {
    let all: Result<Vec<CString>, _> =
        ["-of", "MEM"].iter().chain(arguments).map(|argument| CString::new(*argument)).collect();
    let all = all.map_err(|error| error.to_string())?;
    let mut pointers: Vec<*mut c_char> = all.iter().map(|argument| argument.as_ptr().cast_mut()).collect();
    pointers.push(std::ptr::null_mut());
    // SAFETY: `pointers` is a null-terminated list of strings that live until the end of this function, and GDAL copies
    // what it keeps. `source` is an open dataset. The result is a new dataset that nobody else owns.
    unsafe {
        let options = gdal_sys::GDALWarpAppOptionsNew(pointers.as_mut_ptr(), std::ptr::null_mut());
        if options.is_null() {
            return Err("the warp options were refused".to_string());
        }
        let mut handle = source.c_dataset();
        let mut usage_error = 0;
        let result =
            gdal_sys::GDALWarp(c"".as_ptr(), std::ptr::null_mut(), 1, &raw mut handle, options, &raw mut usage_error);
        gdal_sys::GDALWarpAppOptionsFree(options);
        if result.is_null() {
            Err("the raster could not be warped".to_string())
        } else {
            Ok(Dataset::from_c_dataset(result))
        }
    }
}

/// The horizontal part of a CRS, with x to the east as first axis: what two files must share.
pub fn horizontal_part(crs: &SpatialRef) -> SpatialRef {
    let mut flat = crs.clone();
    // SAFETY: `flat` is a valid object that only this function holds; a null name keeps the name.
    // A failure leaves it as it was, which the comparison then treats as what it is.
    unsafe {
        gdal_sys::OSRDemoteTo2D(flat.to_c_hsrs(), std::ptr::null());
    }
    flat.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
    flat
}

/// Whether a band says of each cell how opaque it is: at 0 there is nothing, as beside a raster that `gdalwarp -dstalpha` turned.
pub fn is_alpha(band: &RasterBand) -> bool {
    // SAFETY: the band is open as long as it is borrowed, and the handle goes no further.
    let colour = unsafe { gdal_sys::GDALGetRasterColorInterpretation(band.c_rasterband()) };
    colour == gdal_sys::GDALColorInterp::GCI_AlphaBand
}

thread_local! {
    static ASKED: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// What GDAL calls in place of fetching an address: the address, and options, progress and writer, which are not used here.
type Fetch = unsafe extern "C" fn(
    *const c_char,
    *const c_void,
    *const c_void,
    *mut c_void,
    *const c_void,
    *mut c_void,
    *mut c_void,
) -> *mut c_void;

unsafe extern "C" {
    fn CPLHTTPSetFetchCallback(fetch: Option<Fetch>, data: *mut c_void);
}

/// The first fields of what GDAL takes for the answer; the others, among them the data, are 0.
#[repr(C)]
struct Answer {
    status: i32,
    content_type: *mut c_char,
    error: *mut c_char,
    _others: [u64; 16],
}

/// Notes the address, and answers with an error. Without an answer GDAL would fetch it after all.
unsafe extern "C" fn note(
    address: *const c_char,
    _: *const c_void,
    _: *const c_void,
    _: *mut c_void,
    _: *const c_void,
    _: *mut c_void,
    _: *mut c_void,
) -> *mut c_void {
    if !address.is_null() {
        // SAFETY: GDAL hands over a text with its end.
        let address = unsafe { CStr::from_ptr(address) }.to_string_lossy().into_owned();
        let _ = ASKED.try_with(|asked| asked.replace(Some(address)));
    }
    // SAFETY: both are memory of GDAL, which it frees itself; an answer of zeros is one without data.
    unsafe {
        let answer = gdal_sys::CPLCalloc(1, std::mem::size_of::<Answer>()).cast::<Answer>();
        (*answer).status = 1;
        (*answer).error = gdal_sys::CPLStrdup(c"it is not fetched".as_ptr());
        answer.cast()
    }
}

/// Lets GDAL fetch addresses that files name, such as that of a reference system, or not.
pub fn let_fetch(is_allowed: bool) {
    // SAFETY: the function lives as long as the program, and needs no data.
    unsafe { CPLHTTPSetFetchCallback((!is_allowed).then_some(note as Fetch), std::ptr::null_mut()) }
}

/// The address that a file asked for on this thread since the last call, and did not get.
pub fn take_asked() -> Option<String> {
    ASKED.take()
}

/// The files that a dataset is read from, as far as its driver knows them.
pub fn files_of(dataset: &Dataset) -> Vec<PathBuf> {
    let mut files = Vec::new();
    // SAFETY: the dataset is open as long as it is borrowed. The list is one of strings with a null behind the last, which this function owns and
    // frees once.
    unsafe {
        let list = gdal_sys::GDALGetFileList(dataset.c_dataset());
        let mut entry = list;
        while !entry.is_null() && !(*entry).is_null() {
            files.push(PathBuf::from(OsStr::from_bytes(CStr::from_ptr(*entry).to_bytes())));
            entry = entry.add(1);
        }
        gdal_sys::CSLDestroy(list);
    }
    files
}

/// An element of XML: its name, the text that stands in itself, and its attributes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Element {
    /// The name.
    pub name: String,
    /// The text.
    pub text: String,
    /// Names and values of the attributes.
    pub attributes: Vec<(String, String)>,
}

/// All elements of an XML text, those within others too; none where it is no XML.
pub fn elements(text: &[u8]) -> Vec<Element> {
    let Ok(text) = CString::new(text) else { return Vec::new() };
    let mut found = Vec::new();
    let (_, _) = super::heard(|| {
        // SAFETY: `text` lives through the call. The tree is owned by this function, which reads it before it frees it once; its pointers are
        // null or lead to nodes of it.
        unsafe {
            let root = gdal_sys::CPLParseXMLString(text.as_ptr());
            let mut waiting = vec![root];
            while let Some(node) = waiting.pop() {
                if node.is_null() {
                    continue;
                }
                waiting.push((*node).psNext);
                if (*node).eType == gdal_sys::CPLXMLNodeType::CXT_Element {
                    found.push(element(node));
                    waiting.push((*node).psChild);
                }
            }
            gdal_sys::CPLDestroyXMLNode(root);
        }
    });
    found
}

/// # Safety
/// The node is one of a tree that lives.
unsafe fn element(node: *const gdal_sys::CPLXMLNode) -> Element {
    // SAFETY: as the caller promises; every node has a text, and null ends each list of nodes.
    unsafe {
        let value = |node: *const gdal_sys::CPLXMLNode| CStr::from_ptr((*node).pszValue).to_string_lossy().into_owned();
        let mut element = Element { name: value(node), ..Element::default() };
        let mut child = (*node).psChild;
        while !child.is_null() {
            if (*child).eType == gdal_sys::CPLXMLNodeType::CXT_Text {
                element.text += &value(child);
            } else if (*child).eType == gdal_sys::CPLXMLNodeType::CXT_Attribute {
                let text = (*child).psChild;
                let text = if text.is_null() { String::new() } else { value(text) };
                element.attributes.push((value(child), text));
            }
            child = (*child).psNext;
        }
        element
    }
}
