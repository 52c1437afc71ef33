/* SPDX-License-Identifier: Apache-2.0 */

/* Cellwalk's terrain library, libcellwalk_terrain, computes coarser fields, shadow and sunlight, horizons, sky views,
 * viewsheds, lines of sight and how much each place sees. It requires libcellwalk and libm.
 *
 * The rules of cellwalk.h hold. Functions return a cw_status and leave a sentence for cw_last_error. Structs that the
 * caller fills end in reserved members, which must be 0, and zero is the default. Records (cw_area, cw_sight,
 * cw_sight_answer) never change. No output is valid after an error. Of cw_run, pool and watch are used; the answers
 * have the same bits for any pool, instruction set and part of the field.
 *
 * Words. The *map* has x and y, and heights in metres; azimuths are degrees from the map's y axis over its x axis: from
 * north over east where y grows northward. The *surface* is the field's: two triangles a cell, without interpolation of
 * another kind. What hides are its edges, also those between two samples that holes leave without a triangle, and
 * single samples; holes hide nothing. Lines are straight on the map.
 *
 * Threads. Any number of threads may use one terrain. Samples must not change while they do, and after a
 * cw_field_update or cw_field_move a new terrain is needed. Functions allocate. A call takes at most 48 KiB of stack.
 *
 * Errors. CW_ERROR_ARGUMENT: an argument or member is NULL, out of range or not 0 where it must be. CW_ERROR_MEMORY,
 * CW_ERROR_CANCELLED, and CW_ERROR_BUSY during an update of the field.
 *
 * Curvature. A place at distance d lies lower by curvature d² / 2 R, R being the ellipsoid's radius at the equator. 0:
 * the earth is flat; 1: it is round and has no air; 6/7: with the refraction that surveyors reckon with. */

#ifndef CELLWALK_TERRAIN_H
#define CELLWALK_TERRAIN_H

#include "cellwalk.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- coarser fields ---------------------------------------------------------------------------------------------- */

/* How the height at each place of a coarser field follows from the samples around it. */
enum {
    /* The mean of the samples less than factor away along x and along y, weighted by a tent: for views and most
     * products. A hole where holes have more than half of the weight. */
    CW_FILTER_MEAN = 0,
    /* The highest sample at most factor away: the coarser surface is nowhere below the full one, so no obstacle is
     * missed. A hole where all of these samples are holes: no triangle is lost. */
    CW_FILTER_HIGHEST = 1,
    /* The lowest one: nowhere above the full surface, so no obstacle is invented. A hole where one of these samples
     * is a hole: no triangle is made. */
    CW_FILTER_LOWEST = 2
};

/* How far a coarser surface lies from the full one: heights in field space, over the full field's triangles where
 * both have a surface. */
typedef struct cw_difference {
    double above, below; /* no point lies farther above or below the full surface; 0: none lies there at all */
    double rms;          /* root mean square over the area */
    /* Triangles of the full field where only the full one has a surface, and where only the coarser one has. */
    uint64_t lost, made;
} cw_difference;

/* Makes a field of every factor-th place, factor from 2 to CW_SIDE_MAX: sample (i, j) stands at (factor i, factor j)
 * of the full field. It has ceil((nx - 1) / factor) + 1 samples a row, and rows alike. Where factor does not divide
 * nx - 1, the last samples stand less than factor cells beyond the full field's border, and samples within the field
 * determine them. Both maps lead to the same user space, so t of a user-space ray means the same on both.
 *
 * filter is one of CW_FILTER_…. The caller owns the coarser field, which has a copy of its samples, in memory of the
 * library's own. The first size bytes of a cw_difference go to difference, which may be NULL. On failure *coarser is
 * NULL. */
CW_API cw_status cw_field_coarser(const cw_field *field, const cw_run *run, size_t factor, int32_t filter,
                                  cw_field **coarser, cw_difference *difference, size_t size);

/* ---- terrains ---------------------------------------------------------------------------------------------------- */

/* A field on the earth. Immutable. It keeps the field, whose samples are not copied. */
typedef struct cw_terrain cw_terrain;

/* Nodes of cw_terrain_desc.scale: the first and the last stand at the corner samples, others at equal distances. */
enum { CW_SCALE_ROWS = 65, CW_SCALE_COLUMNS = 9 };

typedef struct cw_terrain_desc {
    /* Its map leads to the map's x and y and to height, which is a positive multiple of the sample: map[0][2],
     * map[1][2], map[2][0], map[2][1] and map[2][3] are 0. Must stay until cw_terrain_destroy. */
    const cw_field *field;
    /* The point scale of a projected map: two positive numbers for each node, row by row, metres of ground in one of x
     * and in one of y. They are interpolated by cubics. Copied. NULL: unit everywhere. Must be NULL if geographic. */
    const double *scale;
    /* Metres in one of x and y and of height; if geographic, radians in one of x and y. 0: a metre, a degree. */
    double unit;
    double semi_major;         /* the ellipsoid's radius at the equator in metres; 0: WGS 84 */
    double inverse_flattening; /* of that ellipsoid; 0: a sphere. With semi_major 0 it is ignored */
    uint32_t geographic;       /* 1: x is longitude and y latitude, and heights are in metres; else 0 */
    uint32_t zero;             /* 0 */
    uint64_t reserved[8];      /* 0 */
} cw_terrain_desc;

/* The caller owns the terrain, and destroys it before the field. On failure *terrain is NULL. */
CW_API cw_status cw_terrain_create(const cw_terrain_desc *desc, const cw_run *run, cw_terrain **terrain);
/* NULL is allowed. Nothing may be running on the terrain. */
CW_API void cw_terrain_destroy(cw_terrain *terrain);

/* Where the answers go: that of sample (at.i + x, at.j + y) to [y * stride + x]. */
typedef struct cw_area {
    cw_rectangle at; /* all zero: the whole field; else one without columns or rows is nothing */
    size_t stride;   /* numbers from one row to the next, at least at.nx; 0: at.nx */
} cw_area;

/* ---- sun --------------------------------------------------------------------------------------------------------- */

typedef struct cw_light {
    double azimuth;       /* degrees */
    double altitude;      /* degrees, -90 to 90 */
    double radius;        /* of the disc, 0 to 10 degrees; 0: a point. The sun's is 0.2666. cw_shadow ignores it */
    double curvature;     /* 0 to 1e9 */
    uint32_t strips;      /* upright ones that the disc is cut into, up to 64; 0: 16 */
    uint32_t hillshade;   /* 1: times the cosine of the angle between light and normal; else 0. cw_shadow ignores it */
    uint64_t reserved[8]; /* 0 */
} cw_light;

/* lit: 1 where the middle of the light is seen, 0 where the terrain hides it or it is below a free horizon at the
 * sample's height, 255 at a hole. Rays start on the samples; one that touches the surface is in shadow. */
CW_API cw_status cw_shadow(const cw_terrain *terrain, const cw_run *run, const cw_light *light, cw_area area,
                           uint8_t *lit);
/* share: of the light, 0 to 1; NaN at a hole. Each strip of the disc is cut exactly at the horizon along its middle
 * line; one that reaches the zenith is never hidden. Normals are Phong's (1975): the area-weighted mean of the
 * triangles at the sample; with hillshade, one without triangles has NaN too. */
CW_API cw_status cw_sunlight(const cw_terrain *terrain, const cw_run *run, const cw_light *light, cw_area area,
                             float *share);

/* ---- horizon ----------------------------------------------------------------------------------------------------- */

/* Flags. */
enum {
    CW_HORIZON_TILTED = 1, /* of cw_sky_view: for the ground as it leans; cw_openness ignores it */
    /* Of cw_openness: of the terrain upside down, which is held meanwhile. Only with curvature 0. */
    CW_HORIZON_BELOW = 2
};

typedef struct cw_horizon {
    double start;         /* azimuth of direction 0 in degrees; that of direction k is start + k 360 / count */
    double max_distance;  /* metres: terrain farther away does not count; 0: no limit */
    double curvature;     /* 0 to 1e9 */
    uint32_t count;       /* directions, up to 3600; 0: 32 */
    uint32_t flags;       /* CW_HORIZON_…, or 0. cw_horizon_angles ignores them */
    uint64_t reserved[8]; /* 0 */
} cw_horizon;

/* azimuths: of each direction, in degrees, less than a round from 0. */
CW_API cw_status cw_horizon_azimuths(const cw_terrain *terrain, const cw_horizon *horizon, double *azimuths);

/* degrees: the angle of the highest point of the terrain in direction number, from 0 to count - 1, over the level of
 * the sample; negative below it. On a map in degrees it is within 0.003 (1 + s) degrees, s being the steepest rise of
 * the ground. metres: how far that point is; the nearest of several. NaN at a hole, and where the terrain ends at the
 * sample or nothing of it is within max_distance. Either may be NULL. */
CW_API cw_status cw_horizon_angles(const cw_terrain *terrain, const cw_run *run, const cw_horizon *horizon,
                                   uint32_t number, cw_area area, float *degrees, float *metres);

/* share: of the light of an evenly bright sky that reaches level ground, 0 to 1: the mean over directions of cos² of
 * the horizon's angle, where that is above the level (ambient occlusion, open sky weighted by cosine; Steyn 1980). With
 * CW_HORIZON_TILTED, that reaches the ground as it leans (Dozier and Frew 1990); a free tilted plane has
 * (1 + cos tilt) / 2, the sum over few directions may leave 0 to 1, and a sample without triangles has NaN too. NaN at
 * a hole. */
CW_API cw_status cw_sky_view(const cw_terrain *terrain, const cw_run *run, const cw_horizon *horizon, cw_area area,
                             float *share);

/* degrees: openness (Yokoyama, Shirasawa and Pike 2002), the mean over the directions in which there is terrain of the
 * angle between the zenith and the horizon: 90 on a plane, more on a summit. With CW_HORIZON_BELOW the negative one,
 * between the nadir and the lowest point: more at the bottom of a pit. NaN at a hole and where there is no terrain. */
CW_API cw_status cw_openness(const cw_terrain *terrain, const cw_run *run, const cw_horizon *horizon, cw_area area,
                             float *degrees);

/* ---- sight ------------------------------------------------------------------------------------------------------- */

/* Limits of targets. CW_OBSERVER_VERTICALS does not go with needed. */
enum { CW_OBSERVER_AZIMUTHS = 1, CW_OBSERVER_VERTICALS = 2 };

/* Who looks, and which targets count. */
typedef struct cw_observer {
    double x, y;        /* on the map. A place within 1 mm of a sample is on it */
    double height;      /* of the eye in metres above the ground; must not be below it */
    double target;      /* metres above the ground that must be seen; any number */
    double curvature;   /* 0 to 1e9 */
    double nearest;     /* metres on the map, at most farthest if that is not 0 */
    double farthest;    /* metres on the map, 0: no limit */
    double azimuths[2]; /* with CW_OBSERVER_AZIMUTHS: degrees, clockwise from the first to the second */
    /* With CW_OBSERVER_VERTICALS: degrees over the horizontal, -90 to 90, the first not above the second. */
    double verticals[2];
    uint32_t absolute;    /* 1: height is absolute, and x and y may lie outside the field or at a hole; else 0 */
    uint32_t limits;      /* CW_OBSERVER_…, added */
    uint64_t reserved[8]; /* 0 */
} cw_observer;

/* Outputs, of which those that are not NULL are computed. */
typedef struct cw_view {
    uint16_t *seen; /* grows by 1 where the target is seen: a count of observers over several calls, 0 after 65535 */
    double *sum;    /* grows by weight there */
    double weight;  /* any number; 0: 1 */
    float *angle;   /* of the target over the eye's horizontal in degrees; NaN where it is not seen */
    /* Metres above the ground from which on nothing rises above the line; NaN at a hole and beyond limits. */
    float *needed;
    uint64_t reserved[8]; /* 0 */
} cw_view;

/* Exact: for the samples, the eye and the target as numbers, each decision is that of real arithmetic; a line is
 * blocked if it touches or passes under an edge of the surface between eye and target, whatever it does within the
 * first and the last triangle. needed and angle are rounded. Terrain outside the limits hides targets too. */
CW_API cw_status cw_viewshed(const cw_terrain *terrain, const cw_run *run, const cw_observer *from, cw_area area,
                             const cw_view *view);

/* A line between two places: map x, y, and metres above the ground. */
typedef struct cw_sight {
    double from[3], to[3];
    uint32_t absolute; /* 1: from's height is absolute; 2: to's; 3: both */
    uint32_t zero;     /* 0 */
} cw_sight;

enum {
    CW_SIGHT_BLOCKED = 0,
    CW_SIGHT_SEEN = 1,
    /* The line cannot be: its end has no ground to stand on, is too far from the field to compute with or no number, or
     * is more than 1 mm under the ground. */
    CW_SIGHT_NO_GROUND = 2,
    CW_SIGHT_TOO_FAR = 3,
    CW_SIGHT_UNDER_GROUND = 4
};

typedef struct cw_sight_answer {
    double metres;     /* between the places on the map; NaN unless the state is seen or blocked */
    double blocked[3]; /* the first block: map x, y, and absolute height of the line; NaN: there is none */
    double distance;   /* of the block from the first place, in metres on the map; NaN: there is none */
    uint32_t state;    /* CW_SIGHT_… */
    uint32_t end;      /* of a line that cannot be: 0 from, 1 to */
} cw_sight_answer;

/* n lines of sight, in any order. state is exact, as in cw_viewshed, the place of a block is rounded. Where the map's
 * scale changes from row to row, a line has that of its middle, and the same answer from either end; a viewshed has
 * that of its observer. */
CW_API cw_status cw_lines_of_sight(const cw_terrain *terrain, const cw_run *run, double curvature,
                                   const cw_sight *lines, size_t n, cw_sight_answer *answers);

/* ---- visibility -------------------------------------------------------------------------------------------------- */

/* How much each place sees, along even directions. */
typedef struct cw_visibility_desc {
    double height;       /* of the eye in metres above the sample, not negative */
    double target;       /* metres above the ground that must be seen, not negative */
    double max_distance; /* metres: what is farther away does not count; 0: no limit */
    double curvature;    /* 0 to 1e9 */
    uint32_t directions; /* up to 3600, azimuths 0, 360 / directions, …; 0: 128 */
    /* Eyes at every so many columns and rows of the area, from its first ones on; 0: 1. A row takes room for 80 every
     * floats at least. */
    uint32_t every;
    uint64_t reserved[8]; /* 0 */
} cw_visibility_desc;

/* Outputs, of which those that are not NULL are computed: ceil(at.nx / every) eyes a row, NaN at holes. */
typedef struct cw_visibility_answers {
    float *area;     /* square kilometres in sight: the sum over directions of 2 π / directions ∫ t dt, t in sight */
    float *share;    /* that area as a share of all within the field and max_distance */
    float *farthest; /* metres to the farthest place in sight; 0: there is none. Together with azimuth */
    float *azimuth;  /* of that place, in degrees; NaN: there is none */
    uint64_t reserved[8]; /* 0 */
} cw_visibility_answers;

/* Along each direction the parts of the surface in sight are exact but for rounding: an eye of height h above a sample
 * of height z is a float, off by up to 2^-24 (|z| + h). area.stride counts eyes. */
CW_API cw_status cw_visibility(const cw_terrain *terrain, const cw_run *run, const cw_visibility_desc *desc,
                               cw_area area, const cw_visibility_answers *answers);

#ifdef __cplusplus
}
#endif

#endif
