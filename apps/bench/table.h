#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace aula::bench {

/// A figure of a row; without a value it is null in JSON and "-" in the table.
using Value =
    std::variant<std::monostate, double, std::int64_t, std::string, std::array<double, 3>>;

/// One result: figures by the names they have in JSON, in order.
struct Row {
    std::vector<std::pair<std::string, Value>> figures;

    const Value& at(const std::string& name) const;
};

/// A column of the printed table.
struct Column {
    std::string figure;  ///< name in Row
    std::string heading;
    int decimals = 0;
};

/// Rows aligned under their headings, text to the left and numbers to the right.
std::string format_table(const std::vector<Column>& columns, const std::vector<Row>& rows);

/// Processor, number of processors, compiler and build type, in one line.
std::string machine();

/// Writes {"machine": .., "rows": [..]}. Throws Error if the file cannot be written.
void write_json(const std::filesystem::path& file, const std::vector<Row>& rows);

}  // namespace aula::bench
