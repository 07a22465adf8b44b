// As <sandbox.h> of macOS, for ../for_macos.
#pragma once

#include <cstdint>

#define SANDBOX_NAMED 0x0001

extern "C" const char kSBXProfilePureComputation[];
extern "C" int sandbox_init(const char* profile, std::uint64_t flags, char** error);
extern "C" void sandbox_free_error(char* error);
