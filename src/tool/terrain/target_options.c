/* SPDX-License-Identifier: Apache-2.0 */
#include "target.h"

#include "command.h"

#include <math.h>
#include <string.h>

void target_rows(target_options *t, option_spec rows[TARGET_OPTION_COUNT]) {
    t->limits.farthest = NAN;
    const option_spec own[TARGET_OPTION_COUNT] = {
        option_number("target-height", "T", &t->height,
                      "height of the target above ground, in metres (default: 0, the ground)"),
        option_number("max-distance", "D", &t->limits.farthest,
                      "samples farther away than D metres are not seen, nor read and written (default: no limit)"),
        option_number("min-distance", "D", &t->limits.nearest,
                      "samples nearer than D metres are not seen, but block the view (default: 0)"),
        option_text("azimuth", "A,B", &t->azimuth,
                    "only samples in directions from azimuth A clockwise to B, in degrees from the map's north: 350,10 "
                    "are 20 degrees"),
        option_text("vertical", "LO,HI", &t->vertical,
                    "only targets at angles from LO to HI degrees above the eye's horizontal, from -90 to 90; below it "
                    "they are negative"),
    };
    memcpy(rows, own, sizeof own);
}

bool target_options_read(target_options *t, const char *name) {
    sight_limits *l = &t->limits;
    l->has_sector = t->azimuth != NULL;
    l->has_verticals = t->vertical != NULL;
    if (l->farthest <= 0)
        command_fail(name, "--max-distance takes metres above 0, not %g", l->farthest);
    else if (l->nearest < 0)
        command_fail(name, "--min-distance takes metres, not %g", l->nearest);
    else if (l->farthest > 0 && l->nearest > l->farthest)
        command_fail(name, "--min-distance %g is more than --max-distance %g", l->nearest, l->farthest);
    else if (t->azimuth && !(ground_numbers(t->azimuth, l->azimuths, 2, 2) > 0 && fabs(l->azimuths[0]) <= 360 &&
                             fabs(l->azimuths[1]) <= 360))
        command_fail(name, "--azimuth takes two angles from -360 to 360 degrees, as 350,10, not '%s'", t->azimuth);
    else if (t->vertical && !(ground_numbers(t->vertical, l->verticals, 2, 2) > 0 && l->verticals[0] >= -90 &&
                              l->verticals[0] <= l->verticals[1] && l->verticals[1] <= 90))
        command_fail(name, "--vertical takes two angles from -90 to 90 degrees, the lower one first, not '%s'",
                     t->vertical);
    else {
        if (isnan(l->farthest)) l->farthest = 0; /* no limit */
        return true;
    }
    return false;
}

void target_note(const target_options *t, ground_notes *notes) {
    const sight_limits *l = &t->limits;
    if (l->farthest > 0) ground_note(notes, "MAX_DISTANCE=%.9g", l->farthest);
    if (l->nearest > 0) ground_note(notes, "MIN_DISTANCE=%.9g", l->nearest);
    if (t->azimuth) ground_note(notes, "AZIMUTH=%s", t->azimuth);
    if (t->vertical) ground_note(notes, "VERTICAL=%s", t->vertical);
}
