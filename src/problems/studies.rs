//! Studies: many runs of one scenario.

use super::{Group, error};

pub(super) const GROUP: Group = Group {
    title: "Studies",
    problems: &[
        error(
            "member-refused",
            "A key that the study varies cannot be set in the base scenario.",
            "Correct the key in the study file: it is the path that `--set` takes.",
        ),
        error(
            "no-members",
            "No member of the study is done, so that there is nothing to reduce.",
            "Run them first: `floodsim matrix` with the folder of the study.",
        ),
        error(
            "no-study",
            "A folder holds no `study.json`, or none that can be read. It is not the folder of a study.",
            "Name a folder that `floodsim matrix STUDY.yaml` made.",
        ),
        error(
            "not-a-distribution",
            "The numbers of a distribution do not go together: their order, their sign or their units.",
            "Write the least value first, all numbers in the same unit, and factors above 1.",
        ),
        error(
            "not-an-amount",
            "A value with a distribution is not one number with at most one unit, or a factor has a unit.",
            "Write `90 min` for `1 h 30 min`; names of files go under `values`.",
        ),
        error(
            "nothing-to-multiply",
            "A study multiplies a value (`times: true`) that the base scenario does not have.",
            "Write the key into the base with a number, or give values without `times`.",
        ),
        error(
            "nothing-varies",
            "A study has neither values that vary nor two variants.",
            "Add `vary` with a key and its values, or `variants`.",
        ),
        error(
            "study-changed",
            "The folder of a study holds members that are others now. Old and new runs would be mixed.",
            "Choose another `folder`, or add `--overwrite` to run the members again that differ.",
        ),
        error(
            "too-many-members",
            "A study has more than 10000 members: lists multiply each other, the samples and the variants.",
            "Draw values by `range` in place of lists, or take fewer samples.",
        ),
        error(
            "variant-name",
            "The name of a variant has other characters than letters, digits, `_` and `-`, or stands twice.",
            "Give each variant its own plain name; it becomes that of a folder.",
        ),
    ],
};
