#include <catch2/catch.hpp>
#include <string>

#include "apps/plugin/controls.h"
#include "tests/support/program.h"

namespace qtractor_test {

using namespace aula;
using namespace aula::test;

TEST_CASE("Qtractor lists the plugins with their ports and parameters") {
    const ProgramResult result =
        run_program({"sh", "-c",
                     "scan=$(ls /usr/lib/*/qtractor/qtractor_plugin_scan) || exit 77;"
                     " echo 'clap:" AULA_CLAP_BINARY "' | QT_QPA_PLATFORM=offscreen $scan"});
    if (result.status == 77) {
        WARN("skipped: qtractor is missing (packages-test.txt)");
        return;
    }
    INFO(result.out << result.err);
    CHECK(result.status == 0);
    const std::string parameters = "|0:0|" + std::to_string(plugin::kControls) + ":0|";
    for (const plugin::Kind& kind : plugin::kKinds) {
        const std::string ports =
            std::to_string(kind.sources) + ":" + std::to_string(channel_count(kind.output));
        CHECK(result.out.find("CLAP|" + std::string(kind.name) + "|" + ports + parameters) !=
              std::string::npos);
    }
}

}  // namespace qtractor_test
