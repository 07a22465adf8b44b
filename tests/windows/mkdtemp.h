#pragma once

#include <direct.h>
#include <io.h>

/// Creates a folder, as mkdtemp(3) of other systems.
inline char* mkdtemp(char* name) {
    return _mktemp(name) != nullptr && _mkdir(name) == 0 ? name : nullptr;
}
