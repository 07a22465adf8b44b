#pragma once

#include <cstdlib>
#include <filesystem>

namespace aula::test {

/// A file of the reference data that are not part of the project: looked for in the folder that the
/// environment variable AULA_SHARED_DATA names, else in shared/data beside the project's own.
/// Empty where it is absent; a test that needs it says so and is skipped.
inline std::filesystem::path shared_data(const std::filesystem::path& file) {
    const char* given = std::getenv("AULA_SHARED_DATA");
    const std::filesystem::path folder =
        given ? std::filesystem::path(given)
              : std::filesystem::path(AULA_SOURCE_DIR) / ".." / "shared" / "data";
    std::error_code error;
    const std::filesystem::path path = folder / file;
    return std::filesystem::exists(path, error) ? path : std::filesystem::path();
}

}  // namespace aula::test
