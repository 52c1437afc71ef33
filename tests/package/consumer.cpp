// SPDX-License-Identifier: Apache-2.0
// A consumer in C++: what the header defines itself, rather than declares, has to be C++ too.
#include "cellwalk_expert.h"

#include <vector>

static_assert(CW_OK == 0 && CW_ISA_ANY == 0, "zero is the default");

std::vector<cw_hit> closest(const std::vector<float> &z, std::size_t nx, const std::vector<cw_ray> &rays) {
    cw_field_desc desc = {};
    desc.samples = z.data();
    desc.nx = nx;
    desc.ny = z.size() / nx;
    cw_field *field = nullptr;
    std::vector<cw_hit> hits(rays.size());
    if (cw_field_create(&desc, nullptr, &field) != CW_OK) return {};
    if (cw_closest(field, nullptr, rays.data(), rays.size(), hits.data()) != CW_OK) hits.clear();
    cw_field_destroy(field);
    return hits;
}
