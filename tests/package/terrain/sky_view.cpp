// SPDX-License-Identifier: Apache-2.0
// How much of the sky the floor of a street canyon sees, in C++.
#include <cellwalk_terrain.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
    const std::size_t side = 257;
    std::vector<float> samples(side * side);
    for (std::size_t k = 0; k < samples.size(); k++) samples[k] = k / side < 124 || k / side > 132 ? 20.0f : 0.0f;
    cw_field_desc field_desc = cw_field_desc();
    field_desc.samples = &samples[0];
    field_desc.nx = field_desc.ny = side;
    cw_field *field = NULL;
    cw_terrain *terrain = NULL;
    cw_terrain_desc desc = cw_terrain_desc();
    cw_status status = cw_field_create(&field_desc, NULL, &field);
    desc.field = field;
    if (status == CW_OK) status = cw_terrain_create(&desc, NULL, &terrain);
    cw_horizon horizon = cw_horizon();
    horizon.count = 360;
    cw_area middle = cw_area(); // of the street
    middle.at.i = middle.at.j = 128;
    middle.at.nx = middle.at.ny = 1;
    float share = 0;
    if (status == CW_OK) status = cw_sky_view(terrain, NULL, &horizon, middle, &share);
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
    if (status != CW_OK) return std::fprintf(stderr, "%s\n", cw_last_error()), 1;
    // Of an endless canyon 10 m wide and 20 m high: cos of the angle of its walls, 1 / sqrt(1 + (20 / 5)^2).
    const double endless = 1 / std::sqrt(1 + 16.0);
    std::printf("sky view %.4f, of an endless canyon %.4f\n", double(share), endless);
    return std::fabs(double(share) - endless) < 0.005 ? 0 : 1;
}
