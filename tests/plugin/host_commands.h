#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace aula::test {

/// Whether a program is installed; without it the test is skipped.
bool has(const std::string& program);

/// Runs a command of the shell with the built bundle, in a scratch folder that is the home, too.
ProgramResult run_host(const TemporaryFolder& folder, const std::string& command);

/// The samples of a float WAV file as they are on the disk, interleaved.
std::vector<float> wav_samples(const std::filesystem::path& file);

/// Writes a mono float WAV file at 48 kHz.
void write_mono(const std::filesystem::path& file, const std::vector<float>& samples);

}  // namespace aula::test
