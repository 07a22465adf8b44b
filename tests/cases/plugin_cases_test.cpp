#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "tests/plugin/plugin_host.h"
#include "tests/support/temporary_folder.h"

using namespace aula;
using namespace aula::test;

TEST_CASE("A pipe as the scene or the HRTF is refused, and delays neither restore nor cleanup") {
    const TemporaryFolder folder;
    const std::string pipe = folder.path() / "pipe";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    const std::vector<char> bytes(pipe.c_str(), pipe.c_str() + pipe.size() + 1);
    for (const std::string& property : {kScene, kHrtf}) {
        const auto is_refused = [&](const PluginHost& host) {
            return host.received(kStatus).find("pipe: is not a regular file") != std::string::npos;
        };
        PluginHost restored(OutputFormat::binaural);
        restored.activate();
        restored.restore({{property, {LV2_ATOM__Path, bytes}}});
        CHECK(run_until(restored, [&] { return is_refused(restored); }));
        PluginHost patched(OutputFormat::binaural);
        patched.activate();
        patched.send_path(property, pipe);
        CHECK(run_until(patched, [&] { return is_refused(patched); }));
    }
}
