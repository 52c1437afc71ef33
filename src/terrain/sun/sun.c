/* SPDX-License-Identifier: Apache-2.0 */
/* The sun by the theory of lower accuracy in J. Meeus, Astronomical Algorithms (2nd ed., 1998), chapters 12, 13, 22,
 * 25: mean longitude and anomaly, three terms of the equation of the centre, aberration and nutation's largest term;
 * good to 0.01 degrees, a fiftieth of the sun's disc. Refraction by Saemundsson's formula (the same, 16.4). The full
 * theory of the planets (VSOP87, as in NREL's SPA) is good to 0.0003 degrees, too fine for a terrain of metres. */

#include "sun.h"

#include "fpenv.h"

#include <math.h>

static const double degree = 0.017453292519943295;

static double turn(double degrees) { return degrees - 360 * floor(degrees / 360); }

/* Refraction: the rise of a true altitude by the air, in degrees, at 1010 hPa and 10 degrees Celsius. None below -1
 * degree, where nothing is seen. */
static double refraction_at(double altitude) {
    if (altitude < -1) return 0;
    const double seen = 1.02 / (60 * tan((altitude + 10.3 / (altitude + 5.11)) * degree));
    return seen > 0 ? seen : 0;
}

sun_position cw_sun_at(double seconds, double longitude, double latitude) {
    FPENV_HERE;
    const double days = seconds / 86400 + (2440587.5 - 2451545); /* since 2000-01-01 12:00 UT */
    /* Dynamical time runs ahead of universal time by about 70 seconds, in which the sun moves by 0.0008 degrees. */
    const double c = (days + 70.0 / 86400) / 36525;
    const double mean = 280.46646 + c * (36000.76983 + c * 0.0003032);
    const double anomaly = (357.52911 + c * (35999.05029 - c * 0.0001537)) * degree;
    const double eccentricity = 0.016708634 - c * (0.000042037 + c * 0.0000001267);
    const double centre = (1.914602 - c * (0.004817 + c * 0.000014)) * sin(anomaly) +
                          (0.019993 - c * 0.000101) * sin(2 * anomaly) + 0.000289 * sin(3 * anomaly);
    const double node = (125.04 - 1934.136 * c) * degree;
    const double place = (mean + centre - 0.00569 - 0.00478 * sin(node)) * degree;
    const double tilt = (23.4392911 - 0.0130042 * c + 0.00256 * cos(node)) * degree;
    const double ascension = atan2(cos(tilt) * sin(place), cos(place)), declination = asin(sin(tilt) * sin(place));
    const double distance =
        1.000001018 * (1 - eccentricity * eccentricity) / (1 + eccentricity * cos(anomaly + centre * degree));

    /* Sidereal time at Greenwich, with the nutation in longitude that is in the sun's place. */
    const double sidereal =
        280.46061837 + 360.98564736629 * days + c * c * 0.000387933 - 0.00478 * sin(node) * cos(tilt);
    const double hour = turn(sidereal + longitude) * degree - ascension, phi = latitude * degree;
    const double up = sin(phi) * sin(declination) + cos(phi) * cos(declination) * cos(hour);
    const double south = sin(phi) * cos(declination) * cos(hour) - cos(phi) * sin(declination);
    const double west = cos(declination) * sin(hour);
    /* Seen from the surface and not from the earth's centre it stands lower, by 8.794 seconds of arc at the horizon. */
    const double level = sqrt(south * south + west * west);
    const double altitude = atan2(up, level) / degree - 8.794 / 3600 * level / distance;
    const double refraction = refraction_at(altitude);
    return (sun_position){
        .azimuth = turn(180 + atan2(west, south) / degree),
        .altitude = altitude + refraction,
        .refraction = refraction,
        .radius = 0.266563 / distance,
        .distance = distance,
    };
}

sun_position cw_sun_at_place(double seconds, const sun_place *place) {
    sun_position p = cw_sun_at(seconds, place->longitude, place->latitude);
    p.azimuth = fmod(p.azimuth + place->turned + 360, 360);
    return p;
}

/* Days from 1970-01-01 to a day of the Gregorian calendar: years begin in March, so that the leap day is the last. */
static double days_since_1970(int year, int month, int day) {
    const long y = month > 2 ? year : year - 1L, m = month > 2 ? month - 3 : month + 9;
    const long era = (y >= 0 ? y : y - 399) / 400, of_era = y - era * 400;
    const long days = of_era * 365 + of_era / 4 - of_era / 100 + (153 * m + 2) / 5 + day - 1;
    return (double)(era * 146097 + days - 719468);
}

/* Of a month up to 12. */
static bool is_date(int year, int month, int day) {
    static const int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    if (month < 1 || day < 1) return false;
    const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    return day <= days[month - 1] + (month == 2 && leap);
}

/* count digits, as a number that is not above most. */
static bool digits(const char **at, int count, int most, int *value) {
    *value = 0;
    for (int k = 0; k < count; k++, ++*at) {
        if (**at < '0' || **at > '9') return false;
        *value = 10 * *value + (**at - '0');
    }
    return *value <= most;
}

static bool take(const char **at, char wanted) {
    if (**at != wanted) return false;
    ++*at;
    return true;
}

bool cw_sun_parse_time(const char *text, double *seconds) {
    const char *at = text;
    int year, month, day, hour, minute, whole = 0, hours = 0, minutes = 0;
    double second = 0, sign = 1;
    if (!digits(&at, 4, 9999, &year)) return false;
    const bool dashes = take(&at, '-');
    if (!digits(&at, 2, 12, &month) || dashes != take(&at, '-') || !digits(&at, 2, 31, &day)) return false;
    if (!is_date(year, month, day) || !(take(&at, 'T') || take(&at, 't') || take(&at, ' '))) return false;
    if (!digits(&at, 2, 24, &hour)) return false;
    const bool colons = take(&at, ':');
    if (!digits(&at, 2, 59, &minute)) return false;
    if (colons ? take(&at, ':') : *at >= '0' && *at <= '9') {
        if (!digits(&at, 2, 60, &whole)) return false;
        second = whole;
        if (take(&at, '.'))
            for (double part = 0.1; *at >= '0' && *at <= '9'; at++, part /= 10) second += part * (*at - '0');
    }
    if (*at == '+' || *at == '-') {
        sign = *at++ == '+' ? 1 : -1;
        if (!digits(&at, 2, 14, &hours)) return false;
        take(&at, ':');
        if (*at && !digits(&at, 2, 59, &minutes)) return false;
    } else if (!take(&at, 'Z') && !take(&at, 'z')) {
        return false;
    }
    const double offset = sign * (hours * 3600 + minutes * 60);
    *seconds = days_since_1970(year, month, day) * 86400 + hour * 3600 + minute * 60 + second - offset;
    return *at == '\0';
}

/* ---- light ---- */

/* F. Kasten and A. T. Young (1989), with the pressure of an atmosphere whose scale height is 8434.5 m. */
double cw_clear_sky_air_mass(double altitude, double height) {
    return exp(-height / 8434.5) / (sin(altitude * degree) + 0.50572 * pow(altitude + 6.07995, -1.6364));
}

/* The Rayleigh optical thickness of one air mass, by Kasten (1996). */
static double rayleigh(double m) {
    if (m > 20) return 1 / (10.4 + 0.718 * m);
    return 1 / (6.6296 + m * (1.7513 + m * (-0.1202 + m * (0.0065 - m * 0.00013))));
}

double cw_clear_sky_direct(double linke, double distance, double altitude, double height) {
    if (!(altitude > 0)) return 0;
    const double m = cw_clear_sky_air_mass(altitude, height);
    return CLEAR_SKY_CONSTANT / (distance * distance) * exp(-0.8662 * linke * m * rayleigh(m));
}

/* The light with the sun in the zenith, times a function of the sun's altitude. Its least value is that of r.sun. */
double cw_clear_sky_diffuse(double linke, double distance, double altitude) {
    if (!(altitude > 0)) return 0;
    const double zenith = -0.015843 + linke * (0.030543 + linke * 0.0003797);
    double a = 0.26463 + linke * (-0.061581 + linke * 0.0031408);
    if (a * zenith < 0.0022) a = 0.0022 / zenith;
    const double b = 2.04020 + linke * (0.018945 - linke * 0.011161);
    const double c = -1.3025 + linke * (0.039231 + linke * 0.0085079);
    const double sine = sin(altitude * degree);
    const double light = CLEAR_SKY_CONSTANT / (distance * distance) * zenith * (a + sine * (b + sine * c));
    return light > 0 ? light : 0;
}
