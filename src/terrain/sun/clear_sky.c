/* SPDX-License-Identifier: Apache-2.0 */
#include "clear_sky.h"

#include <math.h>

static const double degree = 0.017453292519943295;

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

/* The light with the sun in the zenith, times a function of the sun's altitude. Its least value is the one that r.sun has. */
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
