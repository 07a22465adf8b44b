// As <mach/mach.h> of macOS, for ../../for_macos.
#pragma once

#include <cstdint>

#define MACH_TASK_BASIC_INFO 20
#define MACH_TASK_BASIC_INFO_COUNT (sizeof(mach_task_basic_info) / sizeof(std::uint32_t))

using mach_msg_type_number_t = std::uint32_t;
using task_info_t = int*;
struct mach_task_basic_info {
    std::uint64_t virtual_size;
    std::uint64_t resident_size;
};

extern "C" unsigned mach_task_self();
extern "C" int task_info(unsigned task, unsigned flavor, task_info_t info,
                         mach_msg_type_number_t* size);
