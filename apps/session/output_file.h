#pragma once

#include <filesystem>
#include <string_view>

namespace aula {

/// A text file that is written under a temporary name beside it and renamed in commit(); without
/// commit() nothing is left behind.
class OutputFile {
 public:
    /// Throws Error if the place cannot be written to.
    explicit OutputFile(std::filesystem::path file);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws AudioFailure if writing fails (disk full).
    void write(std::string_view text);
    void commit();

 private:
    std::filesystem::path file_;
    std::filesystem::path temporary_;
    int descriptor_;
    bool in_place_ = false;
    bool committed_ = false;
};

}  // namespace aula
