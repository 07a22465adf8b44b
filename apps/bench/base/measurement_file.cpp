#include "apps/bench/base/measurement_file.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "apps/bench/base/machine.h"

namespace aula::bench {

namespace {

std::string utc_date() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &parts);
    return text.data();
}

/// Mean number of running threads in the last minute, of all programs.
std::string load_average() {
    double load = 0;
    if (getloadavg(&load, 1) != 1) return "unknown";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f", load);
    return text.data();
}

}  // namespace

MeasurementFile::MeasurementFile(const std::string& command) {
    const Machine m = machine();
    text_ = "# Measurements by `" + command + "`\n\n| | |\n|---|---|\n";
    const auto fact = [&](const std::string& name, const std::string& value) {
        text_ += "| " + name + " | " + value + " |\n";
    };
    fact("processor", m.processor);
    fact("processors", std::to_string(m.processors));
    fact("instruction set", m.instruction_set);
    fact("compiler", m.compiler);
    fact("commit", m.revision);
    fact("date", utc_date());
    fact("load average before", load_average());
    text_ +=
        "\nThis file is generated: do not edit it. [README.md](README.md) explains the columns.\n";
}

void MeasurementFile::add(const std::string& title, const std::vector<Column>& columns,
                          const std::vector<Row>& rows) {
    text_ += "\n## " + title + "\n\n" + format_markdown(columns, rows);
}

}  // namespace aula::bench
