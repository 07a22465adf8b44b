// As <mach-o/dyld.h> of macOS, for ../../for_macos.
#pragma once

#include <cstdint>

extern "C" int _NSGetExecutablePath(char* name, std::uint32_t* size);
