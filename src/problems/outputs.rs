//! Outputs, gauges and cross-sections, reports and validations.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Outputs and reports",
    problems: &[
        error(
            "bad-gauge-line",
            "A line of the gauges does not give a gauge with two numbers x and y.",
            "Correct the line: separate its columns, and write decimal points.",
        ),
        error(
            "checkpoint-of-another-program",
            "A run is to go on that another version of the program began. Half of its maps would be of each.",
            "Go on with the program that began it, or run the scenario again with `--overwrite`.",
        ),
        error("duplicate-gauge", "Two gauges have the same `id`.", "Give each gauge its own `id`."),
        error("duplicate-section", "Two cross-sections have the same `id`.", "Give each cross-section its own `id`."),
        warning(
            "finer-than-resolution",
            "The cells of the maps are finer than the resolution. They show no more than was computed.",
            "Leave `outputs.cell` out, or choose a finer `resolution`.",
        ),
        warning(
            "gauge-on-nodata",
            "A gauge lies on nodata, in a building or in a cell without terrain. It stays dry.",
            "Move it to ground that water can reach, or take it out.",
        ),
        warning(
            "gauge-outside-terrain",
            "A gauge lies outside the terrain. It stays dry.",
            "Correct its coordinates, take it out, or enlarge the terrain.",
        ),
        error(
            "gauges-outside-terrain",
            "Every gauge of a file lies outside the terrain.",
            "Check the reference system of the gauges and the order of their coordinates.",
        ),
        error(
            "input-in-output-folder",
            "An input lies in the output folder. A run that replaces an earlier one would delete it.",
            "Choose another folder by `outputs.folder` or `--out`, or move the input.",
        ),
        error(
            "inputs-changed",
            "An input is not as it was when the run began: the checksums differ, or it is not there.",
            "Bring the file back as it was, or run the scenario again with `--overwrite`.",
        ),
        warning(
            "longer-than-run",
            "An output interval is longer than the run. Only the start and the end are written.",
            "Give a shorter interval, or leave it out.",
        ),
        error(
            "no-checkpoint",
            "A run is to go on, and its folder holds no whole checkpoint.",
            "Run the scenario again; a run that is done keeps none, and `limits.checkpoint: off` writes none.",
        ),
        error(
            "no-data",
            "The measurements of the laboratory or field cases are not there. No case was run.",
            "Set `FLOODSIM_DATA` to the folder of the data.",
        ),
        warning(
            "no-error-estimate",
            "The error of the maps is not estimated: the scenario cannot be run on cells twice as wide, or that run breaks down.",
            "Take a finer `resolution`, or leave `outputs.error_estimate` out.",
        ),
        warning(
            "no-finer-raster",
            "No raster of the terrain is finer than the resolution. Maps on the terrain add no detail.",
            "Leave `outputs.cell` out, or choose a coarser `resolution`.",
        ),
        error(
            "no-gauges",
            "A file of gauges has no gauge.",
            "Give it points, or lines with id, x and y, or take the key out.",
        ),
        error(
            "no-maps",
            "The run has channels alone. A report shows maps.",
            "Draw its profiles from `channels.nc` or `tables/channels.csv`.",
        ),
        error(
            "not-a-run",
            "The folder cannot be read as the result of a run.",
            "Name the folder of a finished run, which has `maps.nc`.",
        ),
        error(
            "not-comparable",
            "Two runs are of different places, or in different reference systems. Their maps cannot be compared.",
            "Name two runs of the same place, in one reference system.",
        ),
        either(
            "not-written",
            "`outputs.write` leaves out a file that is needed: isochrones then have no file (warning). A report or a hot start fails.",
            "Add the missing part to `outputs.write`, and run the scenario again.",
        ),
        error(
            "output-folder-in-use",
            "Another run writes to the output folder. Their files would be mixed.",
            "Wait for its end, or choose another folder by `--out`.",
        ),
        error(
            "output-folder-not-empty",
            "The output folder has files already. Results of two runs would be mixed.",
            "Choose another folder by `--out`, or add `--overwrite`.",
        ),
        error(
            "output-folder-unwritable",
            "The output folder cannot be written.",
            "Choose a folder by `--out` in which you may write.",
        ),
        error(
            "outputs-changed",
            "A result of a run is not as the run wrote it: its checksum differs, or it is not there.",
            "Take it from a copy that is whole, or run the scenario again.",
        ),
        warning(
            "run-too-short",
            "The flood still grows when the run ends. Its maps show no more than was reached by then.",
            "Let the run last longer, by `time.end`, until the flood has passed.",
        ),
        error(
            "section-on-edge",
            "A cross-section separates no two cells. It would measure nothing.",
            "Draw it inside the terrain, at least a cell from the edge.",
        ),
        either(
            "section-outside",
            "A cross-section lies on no terrain or in a building: all of it (error) or in part (warning).",
            "Check its reference system, or draw it where water can pass.",
        ),
        warning(
            "section-short",
            "A cross-section is shorter than two cells. It may measure nothing.",
            "Draw it from bank to bank, or choose a finer `resolution`.",
        ),
        error(
            "table",
            "A row of the table of other codes cannot be read.",
            "Write numbers above 0, and put texts with commas in quotes.",
        ),
        error(
            "too-many-outputs",
            "Frames, or rows of the series of gauges and cross-sections, are more than there can be. They would fill memory and disk.",
            "Give a longer `outputs.every` or `outputs.gauges_every`, or fewer gauges.",
        ),
        error(
            "unfinished-run",
            "The run has not ended, or it was killed. Its last frame may be incomplete.",
            "Wait for its end; where it was killed, go on with `floodsim resume`, or run the scenario again with `--overwrite`.",
        ),
    ],
};
