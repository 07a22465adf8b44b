#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <regex>
#include <thread>

#include "tests/aula/aula_program.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;

std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

std::string report(const std::string& scene, const std::filesystem::path& out,
                   const std::vector<std::string>& options) {
    std::vector<std::string> command{AULA_PROGRAM, "report", scene, "--html", out};
    command.insert(command.end(), options.begin(), options.end());
    const ProgramResult result = run_program(command);
    INFO(result.err);
    REQUIRE(result.status == 0);
    REQUIRE(result.out.empty());
    return read_file(out);
}

/// The tags of a document that are not closed in order; empty for a well-formed one.
std::string open_tags(const std::string& html) {
    static const std::regex tag("<(/?)([a-z0-9]+)[^>]*?(/?)>");
    std::vector<std::string> open;
    for (std::sregex_iterator it(html.begin(), html.end(), tag), end; it != end; ++it) {
        const std::string name = (*it)[2];
        if ((*it)[3].length() > 0 || name == "meta") continue;
        if ((*it)[1].length() == 0) {
            open.push_back(name);
        } else if (open.empty() || open.back() != name) {
            return "</" + name + "> without <" + name + ">";
        } else {
            open.pop_back();
        }
    }
    return open.empty() ? "" : "<" + open.back() + "> is open";
}

}  // namespace

TEST_CASE("A report has all pairs, is one well-formed file, and the same again") {
    const TemporaryFolder folder;
    const std::string text =
        with(kSmallRoom, "\"sources\": [",
             R"("sources": [{"name": "<i>\"bell\" & co", "position": [4, 1, 1.5]}, )");
    const std::string scene = folder.write("room & hall.json", text);
    const std::vector<std::string> options{
        "--rays",     "50",       "--receiver", "<seat>=3,3,1.2", "--receiver",
        "back=2,2,1", "--frames", "3",          "--noise-level",  "35"};
    const std::filesystem::path out = folder.path() / "out.html";
    folder.write("out.html", "replaced");
    const std::string html = report(scene, out, options);
    CHECK(open_tags(html) == "");
    CHECK(count_of(html, "<section>") == 4);
    CHECK(count_of(html, "<svg xmlns") == 10);  // the plan, T30, two plots for each pair
    for (const char* const part :
         {"room &amp; hall", "&lt;i&gt;&quot;bell&quot; &amp; co at &lt;seat&gt;", "hiss at back",
          "aula " AULA_VERSION, "60.0 m³", "343.2 m/s", "<td>35.0</td>", ">wall<",
          "standard errors"})
        CHECK(html.find(part) != std::string::npos);
    for (const char* const part : {"<i>", "<script", "href=", "src=", "url(", "nan", ">inf"})
        CHECK(html.find(part) == std::string::npos);
    const std::vector<std::string> one{"--rays", "50", "--frames", "2"};
    const std::string first = report(scene, out, one);
    std::vector<std::string> again = one;
    again.insert(again.end(), {"--threads", "2"});
    CHECK((report(scene, out, again) == first));
}

TEST_CASE("A report without a number of frames has the standard errors of its values") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField);
    const std::string html = report(scene, folder.path() / "out.html", {});
    CHECK(html.find("jackknife") != std::string::npos);
    CHECK(html.find("click at listener") != std::string::npos);
    CHECK(html.find("unknown: the room is not closed") != std::string::npos);
    // G of a free field at 3.432 m: 20 log10(10 / 3.432) = 9.29 dB.
    CHECK(html.find("<td>9.3<small>&lt; 0.1</small></td>") != std::string::npos);
    CHECK(open_tags(html) == "");
}

TEST_CASE("A report compares measured values, and has the speech of each pair") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string csv = folder.write("m.csv",
                                         "response,parameter,500,1000,mean\nseat,T30,0.5,0.4,"
                                         "\nother,T30,0.6,0.6,\nother,STI,,,0.7\n");
    const std::string ir = folder.path() / "hiss at back.wav";
    REQUIRE(aula_with({scene, "--ir", ir, "--output", "mono", "--frames", "4"}).status == 0);
    const std::string html =
        report(scene, folder.path() / "out.html",
               {"--frames", "4", "--receiver", "seat=3.7,2.9,1.2", "--receiver", "back=4.5,3.5,1.2",
                "--measured", csv, "--measured", ir, "--noise-level", "30"});
    CHECK(open_tags(html) == "");
    CHECK(count_of(html, "<h3>hiss at seat</h3>") == 2);  // compared, and the octaves of the pair
    CHECK(count_of(html, "<h3>hiss at back</h3>") == 2);
    CHECK(count_of(html,
                   "<h3>Mean of 1 measured response (other) and of 2 simulated "
                   "pairs</h3>") == 1);
    CHECK(html.find("<td>difference in JND</td>") != std::string::npos);
    // The measured mean of 500 and 1000 Hz.
    CHECK(html.find("<td>0.50</td><td>0.40</td><td>-</td><td>-</td><td>-</td><td>0.45</td>") !=
          std::string::npos);
    CHECK(count_of(html, ">measured</text>") == 3);  // plots
    CHECK(html.find("No values of ISO 3382-3") != std::string::npos);
    CHECK(count_of(html, "<td>good") + count_of(html, "<td>excellent") +
              count_of(html, "<td>fair to good") ==
          2);
    CHECK(html.find("noise of 37 dB(A)") != std::string::npos);
    // Of rays alone, below the Schroeder frequency.
    CHECK(html.find("<th>63 *</th>") != std::string::npos);

    const std::string none = report(scene, folder.path() / "out.html", {"--frames", "2"});
    CHECK(none.find("measured values") == std::string::npos);
}

TEST_CASE("A measured response at a receiver is compared with the mean of the sources there") {
    const TemporaryFolder folder;
    const std::string scene = folder.write(
        "room.json", R"({"aula": 1, "geometry": [{"box": [5, 4, 3], "material": "plaster"}],
                         "sources": [{"name": "left", "position": [1, 1, 1]},
                                     {"name": "right", "position": [4, 1, 1]}],
                         "listener": {"position": [3, 3, 1]}})");
    const std::string csv =
        folder.write("m.csv", "response,parameter,500\nseat,T30,0.5\nnowhere,T30,0.5\n");
    const std::string html = report(scene, folder.path() / "out.html",
                                    {"--frames", "2", "--receiver", "seat=3.7,2.9,1.2",
                                     "--receiver", "back=4.5,3.5,1.2", "--measured", csv});
    CHECK(count_of(html, "<h3>Mean of 2 sources at seat</h3>") == 1);
    // A name that nothing has is seen.
    CHECK(count_of(html,
                   "<h3>Mean of 1 measured response (nowhere) and of 4 simulated "
                   "pairs</h3>") == 1);
}

TEST_CASE("A line of receivers from 2 to 16 m has the numbers of ISO 3382-3") {
    const TemporaryFolder folder;
    // A free field: 6 dB per doubled distance, and 57.4 dB(A) - 12 dB at 4 m, whatever the speech.
    const std::string scene = folder.write("room.json", kFreeField);
    std::vector<std::string> options{"--frames",       "1", "--noise-level", "35",
                                     "--speech-level", "70"};
    for (const int x : {2, 4, 8, 16})
        options.insert(options.end(), {"--receiver", "r" + std::to_string(x) + "=" +
                                                         std::to_string(3.432 + x) + ",0,0"});
    const std::string html = report(scene, folder.path() / "out.html", options);
    std::smatch found;
    REQUIRE(std::regex_search(
        html, found,
        std::regex("<td>click</td><td>r2, r4, r8, r16</td><td>6.0</td><td>45.4</td>"
                   "<td>([0-9.]+)</td><td>([0-9.]+)</td>")));
    CHECK(std::stod(found[1]) < std::stod(found[2]));
    CHECK(html.find("Speech of 70 dB(A) at 1 m") != std::string::npos);
    CHECK(html.find("omnidirectional source.") == std::string::npos);
    options[3] = "-100";  // Errors that are known are those of all receivers.
    options.erase(options.begin(), options.begin() + 2);
    const std::string with_errors = report(scene, folder.path() / "out.html", options);
    CHECK(with_errors.find("<td>6.0<small>&lt; 0.1</small></td><td>45.4<small>") !=
          std::string::npos);

    std::vector<std::string> around{"--frames", "1"};
    for (const char* const place : {"a=6.432,0,0", "b=0.432,0,0", "c=3.432,3,0", "d=3.432,0,3"})
        around.insert(around.end(), {"--receiver", place});
    CHECK(report(scene, folder.path() / "out.html", around)
              .find("at least 4 receivers in one direction from a talker, within ±15°, on one "
                    "floor (±0.5 m), at distances of 2 to 16 m") != std::string::npos);
    // A loudspeaker is no talker, and a directed talker is not what the standard asks for.
    const auto with_directivity = [&](const std::string& name) {
        const std::string directed = folder.write(
            "directed.json", with(kFreeField, "\"position\": [3.432, 0, 0]",
                                  "\"position\": [3.432, 0, 0], \"directivity\": \"" + name + '"'));
        return report(directed, folder.path() / "out.html", options);
    };
    CHECK(with_directivity("loudspeaker").find("No values of ISO 3382-3") != std::string::npos);
    CHECK(with_directivity("talker").find("asks for an omnidirectional source.") !=
          std::string::npos);
}

TEST_CASE("A report compares STI under the conditions of the scene") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string ir = folder.path() / "listener.wav";
    REQUIRE(aula_with({scene, "--ir", ir, "--output", "mono", "--frames", "4"}).status == 0);
    // Noise as loud as the speech.
    const std::string html = report(scene, folder.path() / "out.html",
                                    {"--frames", "4", "--measured", ir, "--noise-level", "60"});
    std::smatch found;
    REQUIRE(std::regex_search(
        html, found,
        std::regex("<td>STI</td><td>simulated</td><td colspan=\"8\"></td><td>([0-9.]+)</td></tr>\n"
                   "<tr><td></td><td>measured</td><td colspan=\"8\"></td><td>([0-9.]+)</td>")));
    CHECK(std::stod(found[1]) < 0.6);
    CHECK(std::stod(found[2]) == Approx(std::stod(found[1])).margin(0.05));
}

TEST_CASE("Bad options of a report are refused with one line and status 2") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = folder.path() / "out.html";
    // Scenes may play a sound inside a model.
    folder.write("model.gltf", "{}");
    std::string text = kSmallRoom;
    text.replace(text.find("\"noise\""), 7, "\"model.gltf#0\"");
    const std::string sounding = folder.write("sounding.json", text);
    const std::vector<Refused> all = {
        {{"report", sounding, "--html", folder.path() / "model.gltf"}, {"would replace the input"}},
        {{"report"}, {"SCENE"}},
        {{"report", scene}, {"--html"}},
        {{"report", scene, "--html", folder.path()}, {"is a directory"}},
        {{"report", scene, "--html", folder.path() / "none/out.html"}, {"none/out.html"}},
        {{"report", scene, "--html", scene}, {"would replace the input"}},
        {{"report", scene, "--html", out, "--report=r.json"}, {"--report", "aula report"}},
        {{"report", scene, "--html", out, "--hrtf", "h.sofa"}, {"--hrtf", "aula report"}},
        {{"report", scene, "--html", out, "--osc", "9000"}, {"--osc", "aula report"}},
        {{"report", scene, "--html", out, "--receiver", "seat"}, {"--receiver", "NAME=x,y,z"}},
        {{"report", scene, "--html", out, "--receiver", "a=1,nan,1"}, {"--receiver"}},
        {{"report", scene, "--html", out, "--receiver", "a=1,1,1", "--receiver", "a=2,1,1"},
         {"--receiver", "given twice"}},
        {{"report", scene, "--html", out, "--spacing", "1"}, {"--spacing", "aula map"}},
        {{"report", scene, "--html", out, "--measured", "none.csv"}, {"none.csv"}},
        {{"report", scene, "--html", out, "--measured", scene}, {"room.json", "format"}},
        {{scene, "--measured", "m.csv"}, {"--measured", "aula report"}},
        {{scene, "--html", out}, {"--html", "aula report"}},
        {{scene, "--project", "hall"}, {"--project", "aula report"}},
        {{"map", scene, "--out", out, "--json", out}, {"--json", "aula report"}},
        {{"report", scene, "--html", out, "--json", out}, {"is the file of two outputs"}},
        {{"report", scene, "--html", out, "--json", scene}, {"would replace the input"}},
        {{"map", scene, "--out", out, "--receiver", "a=1,1,1"}, {"--receiver", "aula report"}},
    };
    for (const Refused& bad : all) require_refused(folder, bad.arguments, bad.parts);
}

TEST_CASE("An interrupted report leaves no file") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    Program program({AULA_PROGRAM, "report", scene, "--html", folder.path() / "out.html",
                     "--frames", "1000000"});
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program.signal(SIGTERM);
    const ProgramResult result = program.wait();
    INFO(result.err);
    CHECK(result.status == 143);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"room.json"});
}

TEST_CASE("A report has its head, averages over positions, distances and sources of coefficients") {
    const TemporaryFolder folder;
    folder.write("room.obj", R"(v 0 0 0
v 5 0 0
v 5 4 0
v 0 4 0
v 0 0 3
v 5 0 3
v 5 4 3
v 0 4 3
usemtl Floor_Oak
f 1 2 3 4
usemtl Walls
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
)");
    const std::string scene = folder.write("room.json", R"({"aula": 1, "geometry": [
        {"file": "room.obj", "materials": {"Floor_Oak": "wood", "Walls": "painted"}},
        {"name": "panel", "vertices": [[2, 2, 0], [2, 3, 0], [2, 3, 1]], "faces": [[0, 1, 2]],
         "material": "felt"}],
        "materials": {"painted": {"absorption": 0.2},
                      "felt": {"absorption": 0.4, "source": "data sheet <F1>"}},
        "sources": [{"name": "voice", "position": [1, 1, 1.5], "yaw_deg": 30, "gain_db": -6}],
        "listener": {"position": [3, 3, 1.2]}})");
    const std::filesystem::path out = folder.path() / "out.html";
    const std::filesystem::path json = folder.path() / "out.json";
    const std::string html = report(
        scene, out,
        {"--rays", "50", "--receiver", "front=3,1,1", "--receiver", "back=4,1,2", "--json", json,
         "--project", "Hall <1>", "--client", "City", "--author", "A. B.", "--date", "2026-11-28"});
    for (const char* const part : {"<h1>Room acoustics: Hall &lt;1&gt;</h1>",
                                   "<td>scene</td><td>room</td>",
                                   "<td>client</td><td>City</td>",
                                   "<td>Sabine in s</td><td>estimate</td>",
                                   "<td>Eyring in s</td><td>estimate</td>",
                                   "<td>size of patches</td><td>0.5 m</td>",
                                   "<td>author</td><td>A. B.</td>",
                                   "<td>date</td><td>2026-11-28</td>",
                                   "<td>front</td><td>2.06</td>",
                                   "<td>back</td><td>3.04</td>",
                                   "<td>30°, 0°</td><td>-6</td>",
                                   "Plan at the height of 1.50 m",
                                   "mean over positions",
                                   "standard deviation",
                                   "<td>wood</td><td>Aula&#39;s library. absorption: 16 mm wood",
                                   "<td>painted</td><td>given by the scene</td>",
                                   "<td>felt</td><td>data sheet &lt;F1&gt;</td>",
                                   "<td>room.obj</td><td>Floor_Oak</td><td>wood</td><td>20.0</td>",
                                   "<td>room.obj</td><td>Walls</td><td>painted</td><td>74.0</td>",
                                   "T30, mean and standard deviation",
                                   "Schroeder frequency",
                                   "The values contain the modes of the room below",
                                   "<th>63</th>",
                                   "<th>1000</th>"})
        CHECK((html.find(part) != std::string::npos ? "" : part) == std::string());
    CHECK(open_tags(html) == "");
    // No error is written as zero: digits follow it.
    CHECK_FALSE(std::regex_search(html, std::regex("± 0\\.?0*<")));
    const std::string values = read_file(json);
    for (const char* const part :
         {R"("receiver":"back","bands":{)", R"("standard_errors":{"bands":{)",
          R"("positions":{"count":2,)", R"("standard_deviation":{"bands":{)",
          R"("counts":{"bands":{)", R"("schroeder_frequency_hz":)"})
        CHECK((values.find(part) != std::string::npos ? "" : part) == std::string());
    // Companion: a scene without these, and a model, whose guesses are in the document.
    const std::string model = report(folder.path() / "room.obj", out, {"--frames", "1"});
    for (const char* const part : {"<td>client</td>", "<td>date</td>", "mean over positions"})
        CHECK(model.find(part) == std::string::npos);
    CHECK(model.find("<h1>Room acoustics: room</h1>") != std::string::npos);
    CHECK(model.find("<td>room.obj</td><td>Floor_Oak</td><td>wood</td>") != std::string::npos);
    CHECK(model.find("material &quot;Walls&quot;: plaster") != std::string::npos);
}

TEST_CASE("A report says where the field is far from diffuse") {
    const TemporaryFolder folder;
    const auto html = [&](const char* soft) {
        const std::string scene = folder.write("room.json", std::string(R"({"aula": 1,
            "geometry": [{"box": [6, 5, 3], "material": "hard",
                          "surfaces": [{"material": ")") + soft +
                                                                R"(", "triangles": [[0, 3]]}]}],
            "materials": {"hard": {"absorption": 0.05, "scattering": 0.02},
                          "soft": {"absorption": 0.9, "scattering": 0.1}},
            "sources": [{"name": "voice", "position": [1, 1, 1.5]}],
            "listener": {"position": [4, 3, 1.2]}})");
        return report(scene, folder.path() / "out.html", {"--frames", "8", "--rays", "200"});
    };
    // Floor and ceiling absorb: sound stays between the walls.
    const std::string soft = html("soft");
    CHECK(std::regex_search(soft, std::regex("is [0-9.]+ times Eyring's: the field")));
    // At 125 Hz: the more the walls scatter, the sooner it reaches floor and ceiling.
    const auto t30_s = [&](const std::string& row) {
        std::smatch found;
        REQUIRE(std::regex_search(soft, found,
                                  std::regex("<td>" + row + "</td>" +
                                             "<td[^>]*>[^<]*</td>"
                                             "<td[^>]*>([0-9.]+)</td>")));
        return std::stod(found[1]);
    };
    CHECK(t30_s("scattering x 0.5") > 1.02 * t30_s("scattering x 2"));
    CHECK(html("hard").find("times Eyring's") == std::string::npos);
}

TEST_CASE("A report names positions outside the room and in closed bodies") {
    const TemporaryFolder folder;
    const std::string scene =
        folder.write("room.json", with(kSmallRoom, "\"geometry\": [",
                                       R"("geometry": [{"box": [0.6, 0.6, 0.6], "min": [1, 3, 0.5],
                                           "material": "wood"}, )"));
    const auto written = [&](const std::vector<std::string>& options) {
        std::vector<std::string> command{
            AULA_PROGRAM,  "report", scene,    "--html", folder.path() / "out.html",
            "--frames",    "2",      "--rays", "50",     "--receiver",
            "seat=3,3,1.2"};
        command.insert(command.end(), options.begin(), options.end());
        const ProgramResult result = run_program(command);
        REQUIRE(result.status == 0);
        return std::pair(result.err, read_file(folder.path() / "out.html"));
    };
    const auto [lines, html] =
        written({"--receiver", "yard=3,9,1.2", "--receiver", "box=1.3,3.3,0.8"});
    for (const bool is_html : {false, true}) {
        const std::string& text = is_html ? html : lines;
        const std::string quote = is_html ? "&quot;" : "\"";
        CHECK(text.find("receiver " + quote + "yard" + quote +
                        " is outside the room, at (3, 9, 1.2); its pairs are not averaged") !=
              std::string::npos);
    }
    CHECK(lines.find(
              "receiver \"box\" is inside a closed body or another room, at (1.3, 3.3, 0.8)") !=
          std::string::npos);
    CHECK(lines.find("at \"box\": not audible") != std::string::npos);
    // Companion: positions in the room, of which one is too near.
    const auto [none, all_inside] = written({"--receiver", "near=1.3,1.5,1.5"});
    CHECK(std::regex_search(
        all_inside, std::regex("Nearer than [^=]+= [0-9.]+ m, the least distance of ISO 3382-2: "
                               "hiss at near\\.")));
    CHECK(html.find("Nearer than") == std::string::npos);
    CHECK(none.find("outside") == std::string::npos);
    CHECK(none.find("closed body") == std::string::npos);
    CHECK(all_inside.find("closed body") == std::string::npos);
}

TEST_CASE("The information on a room has its Schroeder frequency, and how the bass is computed") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    ProgramResult result = run_program({AULA_PROGRAM, "info", scene});
    CHECK(result.status == 0);
    std::smatch found;
    REQUIRE(
        std::regex_search(result.out, found, std::regex("Schroeder +(\\d+) Hz by Eyring's time")));
    // 60 m3; the reverberation time is between 0.1 and 2 s: 2000 sqrt(T / V).
    CHECK(std::stoi(found[1]) > 80);
    CHECK(std::stoi(found[1]) < 370);
    CHECK(result.out.find("off: rays at all frequencies") != std::string::npos);

    const std::string off = R"("waves": false)";
    const auto info = [&](std::string_view waves) {
        std::string text = kSmallRoom;
        text.replace(text.find(off), off.size(), waves);
        return run_program({AULA_PROGRAM, "info", folder.write("waves.json", text)}).out;
    };
    REQUIRE(std::regex_search(result.out = info(R"("waves": "auto")"), found,
                              std::regex("modes +below (\\d+) Hz, rays above")));
    CHECK(std::stoi(found[1]) > 80);
    CHECK(info(R"("waves": 60)").find("modes           below 59 Hz") != std::string::npos);
    CHECK(info(R"("waves": "auto", "direct": false)")
              .find("waves: not with limits of direct sound") != std::string::npos);
}

TEST_CASE("A report without a terminal writes its progress as lines") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto started = [&](const std::vector<std::string>& options) {
        std::vector<std::string> command{
            AULA_PROGRAM, "report", scene, "--html", folder.path() / "out.html",
            "--frames",   "1000000"};
        command.insert(command.end(), options.begin(), options.end());
        return command;
    };
    Program loud(started({}));
    Program quiet(started({"--quiet"}));
    while (loud.running() && loud.err().find("aula: measuring: 0 % after") == std::string::npos)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    quiet.signal(SIGTERM);
    loud.signal(SIGTERM);
    CHECK(loud.wait().status == 143);
    CHECK(quiet.wait().err == "");
}

TEST_CASE("A browser shows a report within the width of a page") {
    if (!std::filesystem::exists("/usr/bin/chromium")) {
        WARN("skipped: chromium is not installed");
        return;
    }
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::filesystem::path out = folder.path() / "out.html";
    std::string html = report(scene, out, {"--frames", "2", "--rays", "50"});
    // The test adds a script, which writes what the browser has laid out into the document.
    html = with(html, "</body>",
                "<script>document.body.dataset.width = document.documentElement.scrollWidth;"
                "document.body.dataset.plots = [...document.querySelectorAll('svg polyline')]"
                ".filter(line => line.getBBox().width > 50).length;</script></body>");
    folder.write("out.html", html);
    const ProgramResult shown = run_program(
        {"/usr/bin/chromium", "--headless", "--no-sandbox", "--disable-gpu",
         "--disable-background-networking", "--user-data-dir=" + (folder.path() / "user").string(),
         "--window-size=1050,1400", "--dump-dom", "file://" + out.string()});
    INFO(shown.err);
    REQUIRE(shown.status == 0);
    std::smatch found;
    REQUIRE(std::regex_search(shown.out, found, std::regex("data-width=\"(\\d+)\"")));
    CHECK(std::stoi(found[1]) <= 1050);
    REQUIRE(std::regex_search(shown.out, found, std::regex("data-plots=\"(\\d+)\"")));
    // Eight decays, the echogram, T30 below and above the Schroeder frequency.
    CHECK(std::stoi(found[1]) == 11);
}
