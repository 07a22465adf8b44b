#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "tests/engine/scene/damaged_scene.h"
#include "tests/support/temporary_folder.h"

using aula::test::error_after;
using aula::test::kValid;
using aula::test::TemporaryFolder;
using Catch::Contains;

namespace {

struct Mistake {
    const char* part;
    const char* replacement;
    const char* place;    // start of the message
    const char* problem;  // text in the message
};

void check(const std::vector<Mistake>& mistakes) {
    for (const Mistake& m : mistakes) {
        INFO(m.part << " replaced by " << m.replacement);
        const std::string message = error_after(m.part, m.replacement);
        CHECK_THAT(message, Catch::StartsWith(std::string(m.place) + ": "));
        CHECK_THAT(message, Contains(m.problem) && Contains("; expected "));
    }
}

}  // namespace

TEST_CASE("a wrong directivity or orientation of a source has its message") {
    const char* const source = R"("signal": "noise")";
    check({
        {source, R"("directivity": "talkr")", "/sources/0/directivity",
         R"(unknown directivity "talkr", did you mean "talker"?; expected one of "omni", )"},
        {source, R"("directivity": "horn.sofa")", "/sources/0/directivity", "no such file, "},
        {source, R"("directivity": "")", "/sources/0/directivity", R"(unknown directivity "";)"},
        {source, R"("directivity": "./")", "/sources/0/directivity", "a folder, "},
        {source, R"("directivity": "scene.json")", "/sources/0/directivity",
         "cannot use the directivity: "},
        {source, R"("directivity": 1)", "/sources/0/directivity",
         "expected the name of a directivity or a file"},
        {source, R"("yaw_deg": "left")", "/sources/0/yaw_deg", "wrong type"},
        {source, R"("pitch_deg": 1e7)", "/sources/0/pitch_deg", "out of range"},
        {source, R"("directivty": "omni")", "/sources/0/directivty",
         R"(did you mean "directivity")"},
    });
}

TEST_CASE("invalid surfaces are refused with their place") {
    const char* const box = R"("min": [0, 0, 0])";
    check({
        {box, R"("surfaces": {})", "/geometry/0/surfaces", "wrong type, an object"},
        {box, R"("surfaces": [{"triangles": [[0, 1]]}])", "/geometry/0/surfaces/0/material",
         "missing"},
        {box, R"("surfaces": [{"material": "wood"}])", "/geometry/0/surfaces/0/triangles",
         "missing"},
        {box, R"("surfaces": [{"material": "woot", "triangles": []}])",
         "/geometry/0/surfaces/0/material", "did you mean \"wood\"?"},
        {box, R"("surfaces": [{"material": "wood", "triangles": [[0]]}])",
         "/geometry/0/surfaces/0/triangles/0", "expected [first, last]"},
        {box, R"("surfaces": [{"material": "wood", "triangles": [[0, 12]]}])",
         "/geometry/0/surfaces/0/triangles/0/1", "expected a whole number from 0 to 11"},
        {box, R"("surfaces": [{"material": "wood", "triangles": [[5, 4]]}])",
         "/geometry/0/surfaces/0/triangles/0/1", "expected a whole number from 5 to 11"},
        {box, R"("surfaces": [{"material": "wood", "triangles": [[0, 1]], "area": 1}])",
         "/geometry/0/surfaces/0/area", "unknown key"},
    });
}

TEST_CASE("a band that transmits more than it absorbs is refused with both numbers") {
    const char* const end = "\"scattering\": 0.3";
    check({
        {end, "\"sound_reduction_db\": 9.9", "/materials/plaster/sound_reduction_db",
         "transmits 0.11 of the energy, more than the absorption 0.1; expected at least 10.0 dB, "
         "or absorption of at least 0.11"},
        {end, "\"sound_reduction_db\": [30,30,30,30,30,30,30,5]",
         "/materials/plaster/sound_reduction_db/7",
         "transmits 0.32 of the energy, more than the absorption 0.1; expected at least 10.0 dB, "
         "or absorption of at least 0.32"},
        {end, "\"sound_reduction_db\": 121", "/materials/plaster/sound_reduction_db",
         "121 is out of range; expected decibels from 0 to 120"},
        {end, "\"sound_reduction_db\": [30]", "/materials/plaster/sound_reduction_db",
         "a list of 1"},
        {end, "\"sound_reduction\": 30", "/materials/plaster/sound_reduction",
         "did you mean \"sound_reduction_db\"?"},
        {"\"rays\": 1000", "\"transmission\": 1", "/simulation/transmission",
         "wrong type, a number; expected true or false"},
    });
    // One number for all bands: the error is that of the band that absorbs least.
    check({{R"([0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1], "scattering": 0.3)",
            R"([0.5,0.4,0.2,0.1,0.2,0.4,0.5,0.6], "sound_reduction_db": 5)",
            "/materials/plaster/sound_reduction_db",
            "more than the absorption 0.1; expected at least 10.0 dB, or absorption of at least "
            "0.32"}});
    // 0.1 and 10 dB are equal but for rounding.
    const TemporaryFolder folder;
    std::string valid = kValid;
    valid.replace(valid.find(end), std::string(end).size(), "\"sound_reduction_db\": 10");
    CHECK_NOTHROW(aula::load_scene(folder.write("scene.json", valid)));
}

TEST_CASE("the scene into which errors are inserted has none itself") {
    const TemporaryFolder folder;
    CHECK(aula::load_scene(folder.write("scene.json", kValid)).warnings.empty());
}

TEST_CASE("unknown keys are refused with a similar known key") {
    check({
        {"\"medium\"", "\"mdium\"", "/mdium", "did you mean \"medium\"?"},
        {"\"temperature_c\"", "\"temperature\"", "/medium/temperature", "\"temperature_c\""},
        {"\"yaw_deg\"", "\"yaw\"", "/listener/yaw", "unknown key \"yaw\""},
        {"\"signal\"", "\"sgnal\"", "/sources/0/sgnal", "did you mean \"signal\"?"},
        {"{\"t\": 2", "{\"speed\": 1, \"t\": 2", "/sources/1/path/points/1/speed", "unknown key"},
        {"{\"points\"", "{\"lop\": true, \"points\"", "/sources/1/path/lop", "\"loop\""},
        {"\"rays\"", "\"ray/s\"", "/simulation/ray~1s", "did you mean \"rays\"?"},
        {"\"scattering\"", "\"scatering\"", "/materials/plaster/scatering", "\"scattering\""},
        {"\"box\"", "\"bx\"", "/geometry/0/bx", "\"box\""},
        {"\"scale\"", "\"min\"", "/geometry/1/min", "unknown key \"min\""},
        {"\"min\": [0, 0, 0]", "\"a\\nb\": 0", "/geometry/0/a?b", "unknown key \"a?b\""},
    });
}

TEST_CASE("missing required keys are named") {
    check({
        {"\"aula\": 1,", "", "/aula", "missing"},
        {"\"aula\": 1", "\"aula\": 2", "/aula", "2 is out of range"},
        {"\"aula\": 1", "\"aula\": \"1\"", "/aula", "wrong type, a string"},
        {"\"listener\": {\"position\": [8, 5, 1.7], \"yaw_deg\": 180},", "", "/listener",
         "missing"},
        {"\"position\": [8, 5, 1.7], ", "", "/listener/position", "missing"},
        {"\"position\": [1, 1, 1], ", "", "/sources/0/position", "missing"},
        {", \"material\": \"plaster\"", "", "/geometry/0/material", "missing"},
        {"\"absorption\": [0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1], ", "", "/materials/plaster/absorption",
         "missing"},
        {"\"t\": 2, ", "", "/sources/1/path/points/1/t", "missing"},
        {", \"position\": [2,1,1]}", "}", "/sources/1/path/points/1/position", "missing"},
        {", \"faces\": [[0,1,2,3]]", "", "/geometry/1/faces", "missing"},
        {"\"box\": [10, 8, 3.5], \"min\": [0, 0, 0], ", "", "/geometry/0", "not one piece"},
        {"\"box\"", "\"vertices\": [], \"box\"", "/geometry/0", "not one piece"},
    });
}

TEST_CASE("the error for a wrong type names the type found and the type expected") {
    check({
        {"[1, 1, 1]", "\"here\"", "/sources/0/position", "wrong type, a string"},
        {"[1, 1, 1]", "[1, 1]", "/sources/0/position", "a list of 2"},
        {"[1, 1, 1]", "[1, null, 1]", "/sources/0/position/1", "wrong type, null"},
        {"\"noise\"", "3", "/sources/0/signal", "wrong type, a number"},
        {"{\"temperature_c\": 20}", "[]", "/medium", "wrong type, a list"},
        {"{\"temperature_c\": 20}", "{\"air_absorption\": 1}", "/medium/air_absorption",
         "wrong type, a number; expected true or false"},
        {"\"rays\": 1000", "\"rays\": true", "/simulation/rays", "wrong type, true or false"},
        {"\"rays\": 1000", "\"rays\": 10.5", "/simulation/rays", "10.5 is not whole"},
        {"\"scattering\": 0.3", "\"scattering\": {}", "/materials/plaster/scattering",
         "wrong type, an object"},
        {"\"scattering\": 0.3", "\"scattering\": [0.1]", "/materials/plaster/scattering",
         "a list of 1"},
        {"\"name\": \"a\"", "\"name\": \"\"", "/sources/0/name", "empty"},
        {"\"noise\"", "\"a\\u0000.wav\"", "/sources/0/signal", "NUL"},
    });
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(aula::load_scene(folder.write("s.json", "[]")),
                      Contains("s.json: wrong type, a list; expected an object"));
}

TEST_CASE("numbers that JSON cannot represent are refused with their place") {
    check({
        {"[1, 1, 1]", "[1, NaN, 1]", "/sources/0/position/1", "NaN is not a JSON number"},
        {"[1, 1, 1]", "[1, 1, nan]", "/sources/0/position/2", "nan is not"},
        {"\"yaw_deg\": 180", "\"yaw_deg\": -Infinity", "/listener/yaw_deg", "-Infinity is not"},
        {"\"yaw_deg\": 180", "\"yaw_deg\": inf", "/listener/yaw_deg", "inf is not a JSON number"},
        {"0.1,0.1,", "0.1,1e999,", "/materials/plaster/absorption/1", "1e999 is too large"},
        {"[1, 1, 1]", "[1e39, 1, 1]", "/sources/0/position/0", "1e+39 is out of range"},
    });
}

TEST_CASE("numbers out of range are refused with their place") {
    check({
        {"0.1,0.1,", "0.1,1.5,", "/materials/plaster/absorption/1", "1.5 is out of range"},
        {"0.1,0.1,", "-0.1,0.1,", "/materials/plaster/absorption/0", "-0.1 is out of range"},
        {"\"scattering\": 0.3", "\"scattering\": 2", "/materials/plaster/scattering",
         "from 0 to 1"},
        {"[10, 8, 3.5]", "[10, 0, 3.5]", "/geometry/0/box", "sizes above 0"},
        {"[10, 8, 3.5]", "[10, 8, -3.5]", "/geometry/0/box", "sizes above 0"},
        {"\"scale\": 1", "\"scale\": 0", "/geometry/1/scale", "0 is out of range"},
        {"\"up\": \"z\"", "\"up\": \"x\"", "/geometry/1/up", "unknown axis \"x\""},
        {"\"temperature_c\": 20", "\"temperature_c\": -300", "/medium/temperature_c", "-300"},
        {"\"temperature_c\": 20", "\"humidity_percent\": 101", "/medium/humidity_percent", "101"},
        {"\"temperature_c\": 20", "\"pressure_kpa\": 0", "/medium/pressure_kpa", "0 is out"},
        {"\"name\": \"a\"", "\"gain_db\": 1000", "/sources/0/gain_db", "1000 is out of range"},
        {"\"t\": 0", "\"t\": -1", "/sources/1/path/points/0/t", "-1 is out of range"},
        {"\"t\": 0", "\"t\": 3", "/sources/1/path/points/1/t", "the time decreases"},
        {"[{\"t\": 0, \"position\": [1,1,1]}, {\"t\": 2, \"position\": [2,1,1]}]", "[]",
         "/sources/1/path/points", "empty path"},
        {"\"patch\"", "\"path\"", "/simulation/estimator",
         "\"pt\", \"dpc-published\", \"dpc\", \"patch\""},
        {"\"rays\": 1000", "\"rays\": 0", "/simulation/rays", "0 is out of range"},
        {"\"rays\": 1000", "\"order\": -1", "/simulation/order", "-1"},
        {"\"rays\": 1000", "\"specular_order\": -1", "/simulation/specular_order", "-1"},
        {"\"rays\": 1000", "\"diffraction_order\": 5", "/simulation/diffraction_order",
         "5 is out of range; expected a whole number from 0 to 4"},
        {"\"rays\": 1000", "\"waves\": 5", "/simulation/waves",
         "5 is out of range; expected \"auto\", false, or Hz from 20 to 500"},
        {"\"rays\": 1000", "\"response_time_s\": -0.1", "/simulation/response_time_s", "-0.1"},
        {"\"rays\": 1000", "\"patch_size_m\": 0", "/simulation/patch_size_m", "0 is out"},
        {"\"rays\": 1000", "\"patch_size_m\": 1e-60", "/simulation/patch_size_m", "1e-60 is out"},
        {"\"rays\": 1000", "\"listener_radius_m\": 0", "/simulation/listener_radius_m", "0 is"},
        {"\"rays\": 1000", "\"frame_rate_hz\": 0", "/simulation/frame_rate_hz", "0 is out"},
        {"\"rays\": 1000", "\"seed\": -1", "/simulation/seed", "-1 is out of range"},
        {"\"rays\": 1000", "\"threads\": 0", "/simulation/threads", "0 is out of range"},
        {"\"aula\": 1", R"("aula": 1, "speech": {"level_db": 201})", "/speech/level_db",
         "201 is out of range; expected decibels from -200 to 200"},
        {"\"aula\": 1", R"("aula": 1, "speech": {"noise_level_db": [0, 0]})",
         "/speech/noise_level_db", "a list of 2; expected a number or a list of 8"},
        {"\"ir_length_s\": 1", "\"ir_length_s\": 0", "/simulation/ir_length_s", "0 is out"},
        {"\"ir_length_s\": 1", "\"ir_length_s\": 10.5", "/simulation/ir_length_s", "10.5"},
        {"\"ir_length_s\": 1", "\"ir_length_s\": \"long\"", "/simulation/ir_length_s",
         "expected \"auto\", or seconds above 0"},
    });
}

TEST_CASE("invalid meshes are refused with the place of the error") {
    check({
        {"[0,1,2,3]", "[0,1,2,4]", "/geometry/1/faces/0/3", "index 4 is out of range"},
        {"[0,1,2,3]", "[0,1,2,-1]", "/geometry/1/faces/0/3", "-1 is out of range"},
        {"[0,1,2,3]", "[0,1]", "/geometry/1/faces/0", "a face of 2"},
        {"[0,1,2,3]", "[0,1,1]", "/geometry/1/faces/0", "no area"},
        {"[[0,1,2,3]]", "[]", "/geometry/1/faces", "an empty mesh"},
        {"[[0,0,0],[1,0,0],[1,0,2],[0,0,2]]", "[]", "/geometry/1/vertices", "an empty mesh"},
    });
}

TEST_CASE("names must be known and unique, and files must exist") {
    check({
        {"\"name\": \"b\"", "\"name\": \"a\"", "/sources/1/name", "duplicate name \"a\""},
        {"\"name\": \"door\"", "\"name\": \"room\"", "/geometry/1/name", "duplicate name \"room\""},
        {"\"aula\": 1", "\"aula\": 1, \"aula\": 1", "/aula", "duplicate key"},
        // The elements before it are an object and lists.
        {"\"name\": \"b\"", "\"name\": \"b\", \"name\": \"c\"", "/sources/1/name", "duplicate key"},
        {"[0,0,0],[1,0,0],[1,0,2]", "[0,0,0],[1,0,0],[1,0,1e999]", "/geometry/1/vertices/2/2",
         "too large"},
        {"\"materials\": {", "\"materials\": {\"plaster\": {\"absorption\": 1}, ",
         "/materials/plaster", "duplicate key"},
        {"\"material\": \"wood\"", "\"material\": \"woot\"", "/geometry/1/material",
         "did you mean \"wood\"?"},
        {"\"material\": \"wood\"", "\"material\": \"cheese\"", "/geometry/1/material",
         "unknown material \"cheese\"; expected a material of the scene"},
        {"\"noise\"", "\"voice.wav\"", "/sources/0/signal", "no such file"},
        {"\"noise\"", "\"\"", "/sources/0/signal", "a folder"},
    });
    std::string text = kValid;
    const std::size_t begin = text.find("[{\"name\": \"a\"");
    text.replace(begin, text.find("\"listener\"") - begin, "[],");
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(aula::load_scene(folder.write("s.json", text)),
                      Contains("/sources: no source; expected"));
}

TEST_CASE("syntax errors contain line and column, the text found and the text expected") {
    const std::string first = "line 2, column 3";
    const std::string second = "line 2, column 11";
    check({
        {"\"aula\": 1,", "\"aula\": 1", "line 3, column 3", "found a string; expected ',' or '}'"},
        {"\"aula\": 1,", "\"aula\": 1 22", "line 2, column 13", "found a number; expected ','"},
        {"\"aula\": 1,", "\"aula\": ,", second.c_str(), "found \",\"; expected a value"},
        {"\"aula\": 1,", "\"aula\": truth,", second.c_str(), "found \"truth\"; expected a value"},
        {"\"aula\": 1,", "\"aula\" 1,", "line 2, column 10", "found a number; expected ':'"},
        {"\"aula\": 1,", "\"aula\": -,", "line 2, column 12", "an unfinished number; expected"},
        {"\"aula\"", "\"\xff\"", "line 2, column 4", "found a byte that is not UTF-8"},
        {"\"aula\"", "\"a\nb\"", "line 2, column 5", "found a control character in a string"},
        {"\"aula\"", "\"\\a\"", "line 2, column 5", "found an unknown escape in a string"},
        {"\"aula\"", "\"\\u12\"", "line 2, column 8", "found an unfinished \\u escape"},
        {"\"aula\": 1,", "aula: 1,", first.c_str(), "found \"aula\"; expected a key in double"},
        {"\"aula\": 1,", "\xe2\x80\x9c: 1,", first.c_str(),
         "found \"\xe2\x80\x9c\"; expected a key"},
        {"\"aula\": 1,", "} \"aula\"", "line 2, column 5", "found a string; expected the end"},
        {"\"aula\": 1,", "/* \"aula\": 1,", "line 15, column 2", "found a comment without its end"},
        {"180},", "180}},", "line 13, column 57", "found \",\"; expected the end of"},
        {"[10, 8, 3.5]", "[10 8, 3.5]", "line 4, column 33", "found a number; expected ',' or ']'"},
    });
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(
        aula::load_scene(folder.write("empty.json", "")),
        Contains("empty.json: line 1, column 1: found the end of the text; expected a value"));
}

TEST_CASE("the error for an unknown material suggests a similar name instead of listing all") {
    const std::string error = error_after("\"plaster\"}", "\"plastr\"}");
    CHECK(error ==
          "/geometry/0/material: unknown material \"plastr\", did you mean \"plaster\"?; expected "
          "a material of the scene, or one that \"aula materials\" lists");
    // No similar name: those whose names contain the word.
    CHECK_THAT(error_after("\"wood\"", "\"xyzzy\""), Contains("\"xyzzy\"; expected"));
    CHECK_THAT(error_after("\"wood\"", "\"chairs\""),
               Contains("did you mean \"plastic_chairs\" or \"wooden_chairs\"?"));
}

TEST_CASE(
    "all errors of a scene are reported in the order of reading, without consequential errors") {
    const TemporaryFolder folder;
    const auto messages = [&](const std::string& text) {
        const auto file = folder.write("scene.json", text);
        std::vector<std::string> places;
        try {
            aula::load_scene(file);
        } catch (const aula::SceneErrors& errors) {
            CHECK(errors.what() == errors.messages().front());
            for (const std::string& message : errors.messages()) {
                const std::string part = message.substr(file.string().size() + 2);
                places.push_back(part.substr(0, part.find(": ")));
            }
        }
        return places;
    };
    CHECK(messages(R"({"aula": 2, "colour": 1, "size": 2,
        "materials": {"felt": {"absorption": [2, 0, 0, 0, 0, 0, 0, -1], "scattering": 3},
                      "cork": {}},
        "geometry": [{"box": [5, 0, 3], "material": "felt", "scale": -1},
                     {"box": [5, 4, 3], "material": "cork"},
                     {"box": [5, 4, 3], "material": "flt"},
                     {"bx": [5, 4, 3]},
                     {"file": "none.obj", "material": "felt", "translate": [1]},
                     {"vertices": [[0,0,0], [1,0,"x"], [1,1,0]], "faces": [[0,1,2], [0,1,9]],
                      "material": "felt"}],
        "medium": {"temperature_c": 900, "humidity_percent": -1},
        "sources": [{"name": "a", "position": [0, 1], "gain_db": "loud"},
                    {"name": "a", "path": {"points": [{"t": "x"}, {"t": 1, "position": [1, 1, 1]}]}},
                    7],
        "listener": {"yaw_deg": true},
        "simulation": {"rays": 0, "estimator": "best", "speed": 1}})") ==
          std::vector<std::string>{"/colour",
                                   "/size",
                                   "/aula",
                                   "/materials/felt/absorption/0",
                                   "/materials/felt/absorption/7",
                                   "/materials/felt/scattering",
                                   "/materials/cork/absorption",
                                   "/geometry/0/box",
                                   "/geometry/0/scale",
                                   "/geometry/2/material",
                                   "/geometry/3/bx",
                                   "/geometry/4/file",
                                   "/geometry/4/translate",
                                   "/geometry/5/vertices/1/2",
                                   "/geometry/5/faces/1/2",
                                   "/medium/temperature_c",
                                   "/medium/humidity_percent",
                                   "/sources/0/position",
                                   "/sources/0/gain_db",
                                   "/sources/1/name",
                                   "/sources/1/path/points/0/t",
                                   "/sources/1/path/points/0/position",
                                   "/sources/2",
                                   "/listener/position",
                                   "/listener/yaw_deg",
                                   "/simulation/speed",
                                   "/simulation/estimator",
                                   "/simulation/rays"});
    // Of very many the first hundred and the number of the others.
    std::string faces;
    for (int i = 0; i < 250; ++i) faces += i ? ", [0, 1, 7]" : "[0, 1, 7]";
    const auto many = messages(R"({"aula": 1, "geometry": [{"vertices": [[0,0,0], [1,0,0], [1,1,0]],
        "material": "wood", "faces": [)" +
                               faces + R"(]}],
        "sources": [{"position": [0, 0, 0]}], "listener": {"position": [1, 1, 1]}})");
    REQUIRE(many.size() == 101);
    CHECK(many.back() == "150 more errors; expected none");
}

TEST_CASE("an order of image sources that would take minutes per frame is refused") {
    CHECK_THAT(error_after(R"("rays": 1000)", R"("specular_order": 101)"),
               Contains("/simulation/specular_order: 101 is out of range; expected a whole number "
                        "from 0 to 100"));
    CHECK(error_after(R"("rays": 1000)", R"("specular_order": 100)") == "no error");
}
