// As <libproc.h> of macOS, for ../for_macos.
#pragma once

#include <cstdint>

#define RUSAGE_INFO_V0 0

using rusage_info_t = void*;
struct rusage_info_v0 {
    std::uint8_t ri_uuid[16];
    std::uint64_t ri_user_time;
    std::uint64_t ri_system_time;
};

extern "C" int proc_pid_rusage(int id, int flavor, rusage_info_t* usage);
