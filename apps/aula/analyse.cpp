#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "apps/aula/commands.h"
#include "apps/aula/terminal/interrupt.h"
#include "apps/output/output_file.h"
#include "apps/room/offline/analysis_text.h"
#include "apps/room/offline/measured_values.h"
#include "aula/exception.h"

namespace aula {

int analyse(const Arguments& arguments) {
    AnalysisOptions options{.third_octaves = arguments.third_octaves};
    if (arguments.speech_db)
        options.speech = {.speech_db = *arguments.speech_db, .noise_db = arguments.noise_db};
    std::optional<OutputFile> out;
    if (!arguments.out.empty()) {
        std::error_code error;
        std::set<std::filesystem::path> names;
        for (const std::filesystem::path& file : arguments.responses) {
            if (!names.insert(file.stem()).second)
                throw InputError("--out", "",
                                 "two files have the name " + file.stem().string() +
                                     "; expected different names of responses");
            if (std::filesystem::equivalent(file, arguments.out, error))
                throw InputError(
                    "--out", "",
                    arguments.out.string() + " is the input; expected the name of another file");
        }
        out.emplace(arguments.out);
    }
    std::vector<ResponseAnalysis> all;
    for (const std::filesystem::path& file : arguments.responses) {
        for (std::optional<ResponseAnalysis>& analysis : analyse_file(file, options)) {
            if (!analysis) continue;
            std::printf("%s%s", all.empty() ? "" : "\n", analysis_table(*analysis).c_str());
            std::fflush(stdout);
            warn(analysis->warnings, arguments.quiet);
            all.push_back(std::move(*analysis));
        }
        if (interrupt_signal() != 0) return interrupted_status();
    }
    if (out) {
        out->write(arguments.out.extension() == ".json" ? analysis_json(all) : measured_csv(all));
        out->commit();
    }
    return 0;
}

}  // namespace aula
