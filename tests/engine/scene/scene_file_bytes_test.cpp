// Scene files of any bytes, of excessive size, and files that are not regular.

#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <random>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "tests/engine/scene/damaged_scene.h"
#include "tests/support/cpu_time.h"
#include "tests/support/temporary_folder.h"

using aula::test::error_after;
using aula::test::kValid;
using aula::test::TemporaryFolder;
using Catch::Contains;

TEST_CASE("a NUL byte is refused with its place, also after the end of the scene") {
    const TemporaryFolder folder;
    const auto error_of = [&](const std::string& text) -> std::string {
        try {
            aula::load_scene(folder.write("nul.json", text));
        } catch (const aula::InputError& error) {
            return error.what();
        }
        return {};
    };
    const std::string nul(1, '\0');
    CHECK_THAT(error_of(kValid + nul), Contains("line 15, column 2: a NUL byte; expected text"));
    CHECK_THAT(error_of(kValid + nul + "text"), Contains("a NUL byte"));
    CHECK_THAT(error_of(nul + kValid), Contains("line 1, column 1: a NUL byte"));
}

TEST_CASE("the error for a signal that is not a regular file names its type") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "folder");
    REQUIRE(mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    const auto error_of = [&](const std::string& signal) -> std::string {
        std::string text = kValid;
        text.replace(text.find("noise"), 5, signal);
        try {
            aula::load_scene(folder.write("scene.json", text));
        } catch (const aula::InputError& error) {
            return error.what();
        }
        return {};
    };
    CHECK_THAT(error_of("folder"), Contains("/sources/0/signal: a folder, \""));
    CHECK_THAT(error_of("pipe"), Contains("/sources/0/signal: not a regular file, \""));
    CHECK_THAT(error_of("none"), Contains("/sources/0/signal: no such file, \""));
}

TEST_CASE("excessive nesting is refused before it exhausts the stack") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(aula::load_scene(folder.write("deep.json", std::string(100000, '['))),
                      Contains("nested too deeply"));
}

TEST_CASE("a scene file that cannot be read is named") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(aula::load_scene(folder.path() / "none.json"),
                      Contains("none.json: no such file; expected a scene file"));
    CHECK_THROWS_WITH(aula::load_scene(folder.path()),
                      Contains(": is a folder, not a regular file; expected a scene file"));
    // Nothing waits for the other end of a pipe.
    const auto pipe = folder.path() / "pipe.json";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    CHECK_THROWS_WITH(aula::load_scene(pipe),
                      Contains("pipe.json: is not a regular file; expected a scene file"));
    CHECK_THROWS_WITH(aula::load_scene("/dev/zero"), Contains("is not a regular file"));
}

TEST_CASE("with any bytes changed in a scene file, loading succeeds or throws InputError") {
    const TemporaryFolder folder;
    const std::string valid = kValid;
    std::mt19937 random(20240601);
    const auto below = [&](std::size_t n) { return random() % n; };
    const std::string likely = "{}[]\",:0123456789.eE+-/*ntfu\\ \n";
    int loaded = 0;
    int refused = 0;
    for (int round = 0; round < 2000; ++round) {
        std::string text = valid;
        for (std::size_t change = 0; change <= below(4); ++change) {
            const std::size_t at = below(text.size());
            const char byte =
                below(2) == 0 ? likely[below(likely.size())] : static_cast<char>(below(256));
            switch (below(4)) {
                case 0:
                    text[at] = byte;
                    break;
                case 1:
                    text.insert(at, 1, byte);
                    break;
                case 2:
                    text.erase(at, 1 + below(8));
                    break;
                default:
                    text.insert(at, text.substr(below(text.size()), below(40)));
                    break;
            }
        }
        try {
            aula::load_scene(folder.write("scene.json", text));
            ++loaded;
        } catch (const aula::InputError& error) {
            ++refused;
            CHECK(std::string(error.what()).find('\n') == std::string::npos);
        }
    }
    // Both cases occur, or the test would prove nothing.
    CHECK(loaded > 20);
    CHECK(refused > 1000);
}

TEST_CASE(
    "a scene of a hundred thousand keys, names, materials or vertices is read in linear time") {
    const TemporaryFolder folder;
    const auto numbered = [](int count, const char* prefix, const std::string& value) {
        std::string members;
        for (int i = 0; i < count; ++i) {
            members +=
                (i > 0 ? ", \"" : "\"") + std::string(prefix) + std::to_string(i) + "\": " + value;
        }
        return members;
    };
    const auto unknown_keys = [&](int count) {
        CHECK_THAT(error_after(R"("yaw_deg": 180)", numbered(count, "key", "1")),
                   Contains("/listener/key0: unknown key"));
    };
    const auto all_materials = [&](int count) {
        return R"("materials": {)" + numbered(count, "m", R"({"absorption": 0.1})") + ", ";
    };
    const auto materials = [&](int count) {
        CHECK(error_after(R"("materials": {)", all_materials(count)) == "no error");
    };
    const auto unknown_material = [&](int count) {
        std::string text = kValid;
        text.replace(text.find(R"("materials": {)"), 14, all_materials(count));
        text.replace(text.find("\"wood\""), 6, "\"nougat\"");
        try {
            aula::load_scene(folder.write("scene.json", text));
            FAIL("no error");
        } catch (const aula::InputError& unknown) {
            // The error does not list all materials.
            CHECK(std::string(unknown.what()).size() < 300);
            CHECK_THAT(unknown.what(), Contains("unknown material \"nougat\""));
        }
    };
    const auto keys_of_geometry = [&](int count) {
        CHECK(error_after(R"("faces": [[0,1,2,3]])",
                          R"("faces": [[0,1,2,3]], )" + numbered(count, "key", "1"))
                  .find("unknown key") != std::string::npos);
    };
    const auto names = [&](int count) {
        std::string objects;
        for (int i = 0; i < count / 10; ++i) {
            objects += R"({"name": "n)" + std::to_string(i) +
                       R"(", "box": [1, 1, 1], "material": "wood"}, )";
        }
        CHECK(error_after(R"("geometry": [)", R"("geometry": [)" + objects) == "no error");
    };
    for (const std::function<void(int)>& read :
         {std::function<void(int)>(unknown_keys), std::function<void(int)>(materials),
          std::function<void(int)>(unknown_material), std::function<void(int)>(keys_of_geometry),
          std::function<void(int)>(names)}) {
        const auto cpu_s = [&](int count) { return test::cpu_time_s([&] { read(count); }); };
        // Ten times the values: linear time is ten times as long, more where they no longer fit in
        // the processor's caches; quadratic time is a hundred times as long.
        CHECK(cpu_s(100'000) < 50 * std::min(cpu_s(10'000), cpu_s(10'000)));
    }
}

TEST_CASE("too many values, and faces with too many corners, are refused") {
    std::string values = "0";
    for (int i = 0; i < 10'000'000; ++i) values += ",0";
    CHECK_THAT(error_after(R"("aula": 1)", R"("aula": 1, "expect": [)" + values + "]"),
               Contains("/expect/") && Contains("too many values; expected at most 10000000"));
    std::string face = "0";
    for (int i = 0; i < 4096; ++i) face += ",1";
    CHECK_THAT(error_after("[[0,1,2,3]]", "[[" + face + "]]"),
               Contains("/geometry/1/faces/0: a face of 4097 corners; expected at most 4096"));
}

TEST_CASE("a device as a scene file is refused") {
    CHECK_THROWS_WITH(aula::load_scene("/dev/zero"), Contains("/dev/zero: is not a regular file"));
}

TEST_CASE("a scene has at most 1024 sources") {
    const TemporaryFolder folder;
    const auto load = [&](int sources) {
        std::string text = R"({"aula": 1, "listener": {"position": [3, 2, 1]}, "sources": [)";
        for (int i = 0; i < sources; ++i)
            text += (i > 0 ? "," : "") + std::string(R"({"position": [1, 1, 1]})");
        return aula::load_scene(folder.write("scene.json", text + "]}")).scene.sources.size();
    };
    CHECK(load(1024) == 1024);
    CHECK_THROWS_WITH(load(1025), Contains("/sources: 1025 sources; expected at most 1024"));
}
