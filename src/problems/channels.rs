//! Channels of one dimension.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Channels",
    problems: &[
        error(
            "channel-short",
            "A channel is too short for the particle spacing.",
            "Make it longer, choose a finer `resolution`, or leave it to the terrain.",
        ),
        warning(
            "channel-step",
            "The bed of a channel ends far above or below the ground of its opening. The water falls over a step or stands before it.",
            "Let the channel end at the level of the ground.",
        ),
        error(
            "channel-width",
            "A channel is wider or narrower than its opening by more than a cell.",
            "Give `from` and `to` so that the opening is as wide as the channel.",
        ),
        error(
            "channels-overlap",
            "Two channels join the terrain at the same faces.",
            "Give each channel its own part of the edge.",
        ),
        error("duplicate-channel", "Two channels have the same `id`.", "Give each channel its own `id`."),
        error(
            "gauge-outside",
            "A gauge lies beyond the length of its channel.",
            "Give a distance from the far end, within `length`.",
        ),
        either(
            "line-beside-opening",
            "The line of a channel ends beside its opening. Further than the length of the channel is an error.",
            "Let the line end at the opening, and check its reference system.",
        ),
        either(
            "line-length",
            "The line of a channel is longer or shorter than its `length`. Another order of magnitude is an error.",
            "Correct `length`, or draw the line from the far to the near end.",
        ),
        error(
            "line-reversed",
            "The line of a channel begins at its opening. Results would be shown at the wrong end.",
            "Turn the line round: it goes from the far to the near end.",
        ),
        error(
            "section-closed",
            "A section of a channel has no width in its last row.",
            "Give the last row of the section a width above 0.",
        ),
        error(
            "section-not-rising",
            "A section of a channel gets lower or narrower from row to row. Channels do not close above.",
            "Sort the rows by elevation, and give an overhang the width below it.",
        ),
        error(
            "section-rows",
            "The sections of a channel have different numbers of rows. They are interpolated row by row.",
            "Give every section the same number of rows.",
        ),
        warning(
            "sections-beyond",
            "Sections lie beyond the length of the channel. They are left out.",
            "Correct `length` or the distances, or take these sections out.",
        ),
        error(
            "sections-short",
            "The sections do not reach from end to end of the channel.",
            "Add a section at either end, or correct `length`.",
        ),
        warning(
            "water-beyond",
            "Water of a channel reaches beyond its length. That part is left out.",
            "Correct `to` or `length`, or leave `to` out.",
        ),
        error(
            "water-outside",
            "Between these distances the channel has no particle. No water would be placed.",
            "Correct `from` and `to`; they count from the far end.",
        ),
    ],
};
