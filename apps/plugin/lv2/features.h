#pragma once

#include <lv2/core/lv2.h>

#include <cstring>

namespace aula::plugin {

/// The data of a host's feature, or null.
inline void* find_feature(const LV2_Feature* const* features, const char* uri) {
    for (; features != nullptr && *features != nullptr; ++features)
        if (std::strcmp((*features)->URI, uri) == 0) return (*features)->data;
    return nullptr;
}

}  // namespace aula::plugin
