// As <mach/mach_time.h> of macOS, for ../../for_macos.
#pragma once

#include <cstdint>

struct mach_timebase_info_data_t {
    std::uint32_t numer;
    std::uint32_t denom;
};

extern "C" int mach_timebase_info(mach_timebase_info_data_t* unit);
