//! What is wrong with the scenario file itself: its text, its keys, its values.

use super::{Group, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Scenario file",
    problems: &[
        error("bad-resolution", "The resolution is not a positive length.", "Give a positive length, such as `20 m`."),
        error(
            "conflict",
            "Two keys exclude each other, or a value contradicts another one. The program does not choose between them.",
            "Keep the one that is meant, and take the other out.",
        ),
        error(
            "date",
            "The value is not a date and time. This date is the start from which dated series count.",
            "Write it in quotes, such as `2026-06-01 06:00:00`, in UTC or with an offset such as `+02:00`.",
        ),
        error(
            "duplicate-key",
            "A key stands twice in the same section. The program does not choose between the two values.",
            "Keep one of the two.",
        ),
        error("empty-list", "A list that needs an entry is empty.", "Give at least one entry, or leave the key out."),
        error("encoding", "The scenario file is not UTF-8 text.", "Save the file as UTF-8 in the editor."),
        error("folder", "The path names a folder, not a scenario file.", "Name the scenario file in the folder."),
        error(
            "levels-for-eulerian",
            "Levels of cells are for Eulerian particles. Particles that move have one spacing.",
            "Give one length as `resolution`, or leave `numerics.motion` and `numerics.formulation` out.",
        ),
        error(
            "levels-not-nested",
            "The coarsest spacing is not the finest one times a power of two, 64 at most. Cells of different levels would not fit together.",
            "Give one of the lengths that the message names, or leave `coarsest` out.",
        ),
        error(
            "method-combination",
            "A numerical method does not go with another method, or with something else in the scenario. The result would be wrong or undefined.",
            "Leave the method out to take its default, or take out what does not go with it.",
        ),
        error(
            "missing-key",
            "A required key is missing, or a key that another key needs.",
            "Add the key as in the example of the message.",
        ),
        error(
            "needs-terrain",
            "A key acts on terrain, and this scenario has channels alone.",
            "Take the key out, or add `terrain`.",
        ),
        error(
            "no-such-entry",
            "A tracer names a boundary, a source or rain that the scenario does not have, or by which no water comes in.",
            "Give the number of an entry of that list; the first is 1.",
        ),
        error(
            "no-terrain",
            "The scenario names neither terrain nor channels. There is no ground for the water.",
            "Add `terrain` with at least one layer, or `channels`.",
        ),
        error(
            "not-a-quantity",
            "The value is not a number, or not a number with a unit.",
            "Write a number with a decimal point and its unit, such as `1.5 m`.",
        ),
        warning(
            "nothing-moves",
            "Cells are to move with their water, and none does: all are near to walls, edges or other places where cells rest.",
            "Leave `numerics.motion` out, or choose a finer `resolution`.",
        ),
        error(
            "range",
            "The value is outside the range of this key.",
            "Give a value within the range that the message states.",
        ),
        warning(
            "roughness",
            "The Manning roughness is smoother than glass. The water would run too fast and arrive too early.",
            "Check the value: natural ground has 0.02 to 0.15, smooth concrete 0.012.",
        ),
        error(
            "syntax",
            "The scenario file is not valid YAML.",
            "Check indentation, brackets and quotes at this place and in the line above.",
        ),
        error(
            "too-complex",
            "The scenario is too large or too deeply nested.",
            "Write the scenario out plainly, without YAML aliases.",
        ),
        error(
            "too-large",
            "The scenario file is larger than 1 MiB. Data belongs in files of its own.",
            "Move rasters, polygons and tables into files, and name these in the scenario.",
        ),
        error(
            "tracer-name",
            "The name of a tracer cannot be part of that of a variable, or two tracers have the same.",
            "Begin with a letter, and take letters, digits and underscores.",
        ),
        error("unit", "The unit is not one of this quantity.", "Use one of the units that the message lists."),
        error(
            "unknown-key",
            "The key is not known at this place. Without this error a misspelt key would leave its default in force.",
            "Correct the key; the message suggests the nearest one.",
        ),
        error(
            "unknown-name",
            "The name is not one of the choices of this key.",
            "Use one of the names that the message lists.",
        ),
        error(
            "unset-variable",
            "A path uses an environment variable that is not set.",
            "Set the variable, or write the path itself.",
        ),
        error(
            "version",
            "The scenario has a version of the format that this program does not know.",
            "Write `floodsim: 1`, or use a newer program.",
        ),
        error(
            "wrong-type",
            "The value has another form than this key expects, such as a text in place of a section.",
            "Check the indentation, and write the value as in the example of the message.",
        ),
    ],
};
