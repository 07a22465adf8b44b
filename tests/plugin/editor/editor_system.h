#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/plugin/editor/editor_format.h"

namespace aula::test {

/// True if there is a display, which stays until the program ends; otherwise it warns, with the
/// reason.
bool has_display();

/// The formats that have an editor on this system.
std::vector<std::string> editor_formats();
std::unique_ptr<EditorFormat> editor_host(const std::string& format);

/// The folder in which an editor opens files first.
void set_home(const std::string& folder);

/// What the process holds.
struct HeldResources {
    double memory_mb = 0;
    std::size_t files = 0;  ///< on Windows: handles
    std::size_t threads = 0;
};
HeldResources held_resources();

}  // namespace aula::test
