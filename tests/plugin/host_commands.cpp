#include "tests/plugin/host_commands.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>

#include "aula/audio/sound_file.h"

namespace aula::test {

bool has(const std::string& program) {
    if (are_installed(program)) return true;
    WARN("skipped: " << program << " is missing (packages-test.txt)");
    return false;
}

ProgramResult run_host(const TemporaryFolder& folder, const std::string& command) {
    const std::string home = folder.path();
    return run_program({"env", "LV2_PATH=" AULA_BUNDLES ":/usr/lib/lv2", "HOME=" + home,
                        "XDG_CONFIG_HOME=" + home, "XDG_CACHE_HOME=" + home, "sh", "-c",
                        "cd " + home + " && " + command});
}

std::vector<float> wav_samples(const std::filesystem::path& file) {
    const std::string bytes = read_file(file);
    const std::size_t data = bytes.find("data");
    REQUIRE(data != std::string::npos);
    // Some writers append other chunks.
    std::uint32_t size = 0;
    REQUIRE(bytes.size() >= data + 8);
    std::memcpy(&size, bytes.data() + data + 4, sizeof size);
    const std::size_t present = std::min<std::size_t>(size, bytes.size() - data - 8);
    std::vector<float> samples(present / sizeof(float));
    std::memcpy(samples.data(), bytes.data() + data + 8, samples.size() * sizeof(float));
    return samples;
}

void write_mono(const std::filesystem::path& file, const std::vector<float>& samples) {
    WavWriter writer(file, 48000, 1, SampleFormat::float32);
    writer.write(samples);
    writer.commit();
}

}  // namespace aula::test
