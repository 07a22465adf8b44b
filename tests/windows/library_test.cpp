// libaula.dll, and the readers of untrusted files beside it, under names in UTF-8.

#include <aula.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "audio/spatial/sofa_file.h"
#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "engine/process/files.h"
#include "tests/support/temporary_folder.h"

namespace library_test {

namespace fs = std::filesystem;
using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;

const std::string kName = "K\303\274che";  // Küche, in UTF-8

/// A box of 4 x 3 x 2.5 m.
const std::string kBox =
    "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2.5\nv 4 0 2.5\nv 4 3 2.5\nv 0 3 2.5\n"
    "usemtl brick\nf 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

std::string scene_of(const std::string& more) {
    return R"({"aula": 1, "geometry": [{"file": ")" + kName + R"(.obj"}],
               "sources": [{"name": "s", "position": [1, 1, 1.5])" +
           more + R"(}],
               "listener": {"position": [3, 2, 1.6]}})";
}

void write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Loads a file by the C interface. Returns the result.
int load(const fs::path& file) {
    aula_scene* scene = nullptr;
    const int result = aula_scene_load(file.string().c_str(), &scene);
    aula_scene_destroy(scene);
    return result;
}

/// What reading a file says that is refused; empty if it is read.
template <typename Read>
std::string refusal(const fs::path& file, const Read& read_file) {
    try {
        read_file(file);
        return {};
    } catch (const aula::InputError& error) {
        return error.what();
    }
}

/// Variants of a file that are cut off or changed, as a pseudo-random generator draws them.
std::vector<std::string> damaged(const std::string& bytes, int count) {
    std::minstd_rand random(1);
    std::vector<std::string> variants;
    for (int i = 0; i < count; ++i) {
        std::string variant = bytes;
        if (i % 2 == 0) variant.resize(random() % bytes.size());
        for (int n = 0; n < 20 && !variant.empty(); ++n)
            variant[random() % std::min<std::size_t>(variant.size(), 4096)] =
                static_cast<char>(random() % 256);
        variants.push_back(variant);
    }
    return variants;
}

TEST_CASE("a scene, its mesh and a model open under names in UTF-8") {
    const aula::test::TemporaryFolder folder;
    const fs::path here = folder.path() / aula::utf8_path(kName);
    fs::create_directory(here);
    const fs::path scene = here / aula::utf8_path(kName + ".json");
    const fs::path model = here / aula::utf8_path(kName + ".obj");
    write(model, kBox);
    write(scene, scene_of(""));
    CHECK(load(scene) == AULA_OK);
    CHECK(load(model) == AULA_OK);
    fs::remove(model);
    CHECK(load(scene) == AULA_INPUT_ERROR);
    CHECK_THAT(aula_message(), Contains(kName + ".obj"));
    CHECK(load(model) == AULA_INPUT_ERROR);
    CHECK_THAT(aula_message(), Contains("no such file"));
}

TEST_CASE("a SOFA file of a directivity is refused in one line that says why") {
    const aula::test::TemporaryFolder folder;
    write(folder.path() / aula::utf8_path(kName + ".obj"), kBox);
    write(folder.path() / "horn.sofa", "\x89HDF\r\n\x1a\n");
    write(folder.path() / "scene.json", scene_of(R"(, "directivity": "horn.sofa")"));
    CHECK(load(folder.path() / "scene.json") == AULA_INPUT_ERROR);
    CHECK_THAT(aula_message(), Contains("horn.sofa: needs HDF5 to be read, which Aula has not"));
    CHECK(std::string(aula_message()).find('\n') == std::string::npos);
}

TEST_CASE("a sound file is written and read, and a damaged one is read or refused in one line") {
    const aula::test::TemporaryFolder folder;
    const fs::path file = folder.path() / aula::utf8_path(kName + ".wav");
    const std::vector<float> samples{0, 0.5F, -0.5F, 0.25F};
    for (int i = 0; i < 2; ++i) {  // also replaces
        aula::WavWriter writer(file, 48000, 1, aula::SampleFormat::float32);
        writer.write(samples);
        writer.commit();
    }
    CHECK(aula::read_sound(file, 48000).samples == samples);
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    const std::string bytes = read(file);
    const auto read_file = [](const fs::path& name) { aula::read_sound(name, 48000); };
    for (const std::string& variant : damaged(bytes, 20)) {
        write(file, variant);
        const std::string problem = refusal(file, read_file);
        if (problem.empty()) continue;
        CHECK_THAT(problem, StartsWith(file.string() + ": "));
        CHECK(problem.find('\n') == std::string::npos);
    }
    write(file, "fLaC of no use");
    CHECK_THAT(refusal(file, read_file),
               EndsWith(": cannot be read as sound; expected WAV, RF64, W64, AIFF, AU, CAF or NIST "
                        "SPHERE"));
}

TEST_CASE("a SOFA file of a head is read, and a damaged one is read or refused in one line") {
    const aula::test::TemporaryFolder folder;
    const fs::path file = folder.path() / aula::utf8_path(kName + ".sofa");
    fs::copy_file(AULA_SOFA_FILE, file);
    const aula::HeadMeasurements head = aula::read_sofa(file);
    CHECK(head.positions.size() == 710);  // MIT KEMAR
    CHECK(head.responses.size() == 2 * head.positions.size() * head.samples);
    float energy = 0;
    for (const float sample : head.responses) energy += std::abs(sample);
    CHECK(std::isfinite(energy));
    CHECK(energy > 0);
    const std::string bytes = read(file);
    int refused = 0;
    for (const std::string& variant : damaged(bytes, 20)) {
        write(file, variant);
        const std::string problem = refusal(file, [](const fs::path& f) { aula::read_sofa(f); });
        if (problem.empty()) continue;
        ++refused;
        CHECK_THAT(problem, StartsWith(file.string() + ": "));
        CHECK_THAT(problem, Contains("; expected "));
        CHECK(problem.find('\n') == std::string::npos);
    }
    CHECK(refused > 10);
}

TEST_CASE("a room with the head of a SOFA file is made, and with a damaged one is not") {
    const aula::test::TemporaryFolder folder;
    const fs::path model = folder.path() / aula::utf8_path(kName + ".obj");
    const fs::path head = folder.path() / aula::utf8_path(kName + ".sofa");
    write(model, kBox);
    aula_scene* scene = nullptr;
    REQUIRE(aula_scene_load(model.string().c_str(), &scene) == AULA_OK);
    aula_options options{};
    options.size = sizeof(options);
    const std::string name = head.string();
    options.hrtf = name.c_str();
    aula_room* room = nullptr;
    fs::copy_file(AULA_SOFA_FILE, head);
    CHECK(aula_room_create(scene, &options, &room) == AULA_OK);
    aula_room_destroy(room);
    write(head, read(head).substr(0, 1000));
    room = nullptr;
    CHECK(aula_room_create(scene, &options, &room) == AULA_INPUT_ERROR);
    CHECK_THAT(aula_message(), StartsWith(name + ": ") && Contains("expected a SOFA file"));
    CHECK(room == nullptr);
    aula_scene_destroy(scene);
}

TEST_CASE("a room renders the same samples again, and says what is wrong with an argument") {
    constexpr int kSamples = 24000;
    std::vector<float> rendered[2];
    for (std::vector<float>& samples : rendered) {
        aula_scene* scene = nullptr;
        const aula::test::TemporaryFolder folder;
        write(folder.path() / aula::utf8_path(kName + ".obj"), kBox);
        write(folder.path() / "scene.json", scene_of(""));
        const std::string file = (folder.path() / "scene.json").string();
        REQUIRE(aula_scene_load(file.c_str(), &scene) == AULA_OK);
        aula_options options{};
        options.size = sizeof(options);
        options.clock = AULA_EXACT;
        aula_source source = 0;
        REQUIRE(aula_scene_find_source(scene, "s", &source) == AULA_OK);
        aula_source nobody = 0;
        CHECK(aula_scene_find_source(scene, "nobody", &nobody) == AULA_INPUT_ERROR);
        CHECK_THAT(aula_message(), Contains("nobody"));
        aula_room* room = nullptr;
        REQUIRE(aula_room_create(scene, &options, &room) == AULA_OK);
        std::vector<float> click(kSamples);
        click[0] = 1;
        std::vector<float> left(kSamples);
        std::vector<float> right(kSamples);
        float* const outputs[] = {left.data(), right.data()};
        const aula_signal signal{source, click.data()};
        REQUIRE(aula_room_process_exactly(room, &signal, 1, outputs, 2, kSamples) == AULA_OK);
        aula_room_destroy(room);
        aula_scene_destroy(scene);
        samples = left;
        samples.insert(samples.end(), right.begin(), right.end());
    }
    CHECK(rendered[0] == rendered[1]);
    CHECK(std::any_of(rendered[0].begin(), rendered[0].end(), [](float x) { return x != 0; }));
}

}  // namespace library_test
