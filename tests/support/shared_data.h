#pragma once

#include <cstdlib>
#include <filesystem>

namespace aula::test {

/// Path of a reference data file, which is not part of the project. The folder is that of the
/// environment variable AULA_SHARED_DATA, else shared/data beside the project's folder. Empty if
/// the file is absent; the test is then skipped.
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
