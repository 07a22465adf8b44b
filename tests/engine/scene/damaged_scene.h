#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

namespace aula::test {

/// A scene with most keys, which is valid.
inline constexpr const char* kValid = R"({
  "aula": 1,
  "geometry": [
    {"name": "room", "box": [10, 8, 3.5], "min": [0, 0, 0], "material": "plaster"},
    {"name": "door", "vertices": [[0,0,0],[1,0,0],[1,0,2],[0,0,2]], "faces": [[0,1,2,3]],
     "material": "wood", "scale": 1, "up": "z"}
  ],
  "materials": {"plaster": {"absorption": [0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1], "scattering": 0.3}},
  "medium": {"temperature_c": 20},
  "sources": [{"name": "a", "position": [1, 1, 1], "signal": "noise"},
              {"name": "b", "position": [2, 1, 1],
               "path": {"points": [{"t": 0, "position": [1,1,1]}, {"t": 2, "position": [2,1,1]}]}}],
  "listener": {"position": [8, 5, 1.7], "yaw_deg": 180},
  "simulation": {"estimator": "patch", "rays": 1000, "ir_length_s": 1}
})";

/// The message of loading kValid with one part of its text replaced, without the file's name.
inline std::string error_after(const std::string& part, const std::string& replacement) {
    std::string text = kValid;
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    text.replace(at, part.size(), replacement);
    const TemporaryFolder folder;
    const auto file = folder.write("scene.json", text);
    try {
        load_scene(file);
    } catch (const InputError& error) {
        const std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        const std::string prefix = file.string() + ": ";
        REQUIRE(message.substr(0, prefix.size()) == prefix);
        return message.substr(prefix.size());
    }
    return "no error";
}

}  // namespace aula::test
