#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
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

/// The columns of what is measured of the engine, by the names of the figures; a name that is not
/// known is a programmer's mistake.
std::vector<Column> columns_of(std::initializer_list<const char*> figures);

/// Rows aligned under their headings, text to the left and numbers to the right.
std::string format_table(const std::vector<Column>& columns, const std::vector<Row>& rows);

/// Processor, number of processors, compiler and build type, in one line.
std::string machine();

/// {"machine": .., "rows": [..]}
std::string to_json(const std::vector<Row>& rows);

}  // namespace aula::bench
